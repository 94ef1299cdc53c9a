//! Flags for the elements of a shell model.

use midsurf::reshape::ElementSettings;
use midsurf::reshape::remesh::{Junctions, Settings};
use midsurf::settings::cell::CellSize;

use super::numbers::positive;

/// What elements are wanted.
#[derive(clap::Args, Clone, Copy, Debug)]
pub(crate) struct ElementArgs {
    /// Remesh to this edge length: a length, `2t` (wall thicknesses) or `1%` (of the diagonal)
    #[arg(long, value_name = "SIZE", allow_negative_numbers = true)]
    pub(crate) element_size: Option<CellSize>,
    /// How far edges may run beside curved walls and borders, as --element-size
    #[arg(
        long,
        value_name = "LENGTH",
        default_value_t = CellSize::Thicknesses(Settings::SAG),
        requires = "element_size",
        allow_negative_numbers = true
    )]
    pub(crate) sag: CellSize,
    /// Growth of edges away from fine places, by length
    #[arg(
        long,
        value_name = "RATE",
        default_value_t = Settings::GRADING,
        value_parser = positive,
        requires = "element_size",
        allow_negative_numbers = true
    )]
    pub(crate) grading: f64,
    /// Pair triangles to quadrilaterals; formats without them get the triangles
    #[arg(long, requires = "element_size")]
    pub(crate) quads: bool,
    /// How sheets run where they meet
    #[arg(
        long,
        value_name = "HOW",
        value_enum,
        default_value_t = JunctionsArg::Medial,
        requires = "element_size"
    )]
    pub(crate) junctions: JunctionsArg,
}

/// As [`Junctions`].
#[derive(Clone, Copy, Debug, PartialEq, clap::ValueEnum)]
pub(crate) enum JunctionsArg {
    /// Equally far from the nearest walls, dipping towards seams and bends
    Medial,
    /// In the middle of their own walls up to where they meet
    Straight,
}

impl ElementArgs {
    /// The elements wanted; none for the mesh as it is.
    pub(crate) fn settings(&self) -> Option<ElementSettings> {
        self.element_size.map(|size| ElementSettings {
            size,
            sag: self.sag,
            grading: self.grading,
            quads: self.quads,
            junctions: match self.junctions {
                JunctionsArg::Medial => Junctions::Medial,
                JunctionsArg::Straight => Junctions::Straight,
            },
        })
    }
}
