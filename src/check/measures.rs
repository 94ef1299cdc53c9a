//! What a check measures, and how it is told.

use glam::DVec3;
use serde::Serialize;

/// A kind of defect.
///
/// The five that HyperMesh's check of mid-surfaces knows come first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// Nodes off the middle of the wall; share of its thickness.
    NodesOffMiddle,
    /// Nodes of the free boundary off the sides of the part; share of its
    /// thickness.
    NodesOffSides,
    /// Nodes outside the part; share of its thickness.
    NodesOutside,
    /// Edges of the free boundary whose middle is off the sides; share of the
    /// thickness.
    EdgesOffSides,
    /// Centres of elements off the middle; share of the thickness.
    CentresOffMiddle,
    /// Wall of the part with no mid-surface beside it; distance over thickness.
    Uncovered,
    /// Elements where no mid-surface should be: outside, or between two faces
    /// of one wall; share of the thickness that they are away, 1 for the latter.
    Excess,
    /// Edges of the free boundary that lie on other elements without sharing
    /// their nodes; gap as a share of the thickness.
    Unwelded,
    /// Pieces beyond those of the part.
    Pieces,
    /// Seam edges where no third wall is near; how much farther it is, as a
    /// share of the thickness.
    SeamsOff,
    /// Nodes whose thickness is not the wall's; share of the wall's.
    ThicknessOff,
    /// Elements with an angle below [`LEAST_ANGLE`]; degrees missing.
    SmallAngles,
    /// Neighbours in a sheet that fold back on each other; degrees of the fold.
    Folds,
    /// Elements that run through one another.
    Crossings,
}

/// Angle of a triangle, degrees, below which it is listed.
pub const LEAST_ANGLE: f64 = 5.0;

impl Measure {
    /// All of them, in order.
    pub const ALL: [Measure; 14] = [
        Measure::NodesOffMiddle,
        Measure::NodesOffSides,
        Measure::NodesOutside,
        Measure::EdgesOffSides,
        Measure::CentresOffMiddle,
        Measure::Uncovered,
        Measure::Excess,
        Measure::Unwelded,
        Measure::Pieces,
        Measure::SeamsOff,
        Measure::ThicknessOff,
        Measure::SmallAngles,
        Measure::Folds,
        Measure::Crossings,
    ];

    /// Name in reports and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Measure::NodesOffMiddle => "nodes_off_middle",
            Measure::NodesOffSides => "nodes_off_sides",
            Measure::NodesOutside => "nodes_outside",
            Measure::EdgesOffSides => "edges_off_sides",
            Measure::CentresOffMiddle => "centres_off_middle",
            Measure::Uncovered => "uncovered",
            Measure::Excess => "excess",
            Measure::Unwelded => "unwelded",
            Measure::Pieces => "pieces",
            Measure::SeamsOff => "seams_off",
            Measure::ThicknessOff => "thickness_off",
            Measure::SmallAngles => "small_angles",
            Measure::Folds => "folds",
            Measure::Crossings => "crossings",
        }
    }

    /// Bit in the painted file.
    pub fn bit(self) -> u32 {
        1 << self as u32
    }
}

/// A place where something is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Defect {
    /// Where.
    pub at: DVec3,
    /// How bad, as the measure says.
    pub value: f64,
    /// Triangle of the surface, where there is one.
    #[serde(skip)]
    pub triangle: Option<u32>,
}

/// What came of one measure.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// What was measured.
    pub measure: Measure,
    /// Places looked at; 0 where the surface or part tells nothing of it.
    pub checked: usize,
    /// Places that are worse than the limit.
    pub count: usize,
    /// Worst of all places looked at.
    pub worst: f64,
    /// Mean of them.
    pub mean: f64,
    /// What is let pass.
    pub limit: f64,
    /// Places that are worse, the worst first.
    #[serde(skip)]
    pub defects: Vec<Defect>,
}

impl Outcome {
    /// Of all places looked at, in an order that does not depend on threads.
    pub(super) fn of(measure: Measure, all: Vec<Defect>, limit: f64) -> Outcome {
        let checked = all.len();
        let mean = all.iter().map(|d| d.value).sum::<f64>() / checked.max(1) as f64;
        let worst = all.iter().map(|d| d.value).fold(0.0, f64::max);
        let mut defects: Vec<Defect> = all.into_iter().filter(|d| d.value > limit).collect();
        // Stable, so that equal ones keep their order.
        defects.sort_by(|a, b| b.value.total_cmp(&a.value));
        Outcome {
            measure,
            checked,
            count: defects.len(),
            worst,
            mean,
            limit,
            defects,
        }
    }
}
