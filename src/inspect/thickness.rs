//! Wall thickness for print shops and moulders: where it is least, and how much
//! of the wall is too thin.

use glam::DVec3;
use serde::Serialize;

use crate::field::Field;
use crate::mesh::Part;
use crate::walls::thickness::{ThicknessProfile, ThicknessSample, thickness_at};

/// Points of the walls at which the thickness is measured.
const SAMPLES: usize = 4000;

/// How far points that look for the thinnest wall lie inside the corners of
/// their triangle, as a share of the way to its middle: on an edge the next wall
/// would be nearest.
const CLOSE: f64 = 0.01;

/// Wall thickness by share of the wall area, in part units.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WallThickness {
    /// 5 % of the wall area are thinner.
    pub p5: f64,
    /// A quarter is thinner.
    pub p25: f64,
    /// Median.
    pub p50: f64,
    /// A quarter is thicker.
    pub p75: f64,
    /// 5 % are thicker.
    pub p95: f64,
    /// The least that was met.
    pub thinnest: f64,
    /// Where the wall is thinnest.
    pub thinnest_at: [f64; 3],
    /// Triangle of the wall there.
    pub thinnest_triangle: u32,
    /// Whether the walls are as thick as was asked for.
    pub check: Option<WallCheck>,
}

/// Whether the walls are thick enough.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WallCheck {
    /// What was asked for, in part units.
    pub min_wall: f64,
    /// Share of the wall area that is thinner.
    pub share_below: f64,
    /// Whether none is.
    pub passed: bool,
}

impl WallThickness {
    pub(super) fn measure(
        part: &Part,
        field: &Field,
        min_wall: Option<f64>,
    ) -> Option<WallThickness> {
        let profile = ThicknessProfile::measure(field, SAMPLES);
        let thinnest = thinnest(part, field, &profile)?;
        // Single precision of the file is no fault of the wall.
        let slack = 1e-6 * part.bounds().diagonal();
        let check = min_wall.map(|min_wall| WallCheck {
            min_wall,
            share_below: profile.share_below(min_wall - slack),
            passed: thinnest.thickness >= min_wall - slack,
        });
        Some(WallThickness {
            p5: profile.percentile(5.0)?,
            p25: profile.percentile(25.0)?,
            p50: profile.percentile(50.0)?,
            p75: profile.percentile(75.0)?,
            p95: profile.percentile(95.0)?,
            thinnest: thinnest.thickness,
            thinnest_at: thinnest.at.to_array(),
            thinnest_triangle: thinnest.face.0,
            check,
        })
    }

    /// What a map of it shows from red to blue: from what is too thin, or from
    /// the 5 % that are thinnest, to the 5 % that are thickest.
    pub fn range(&self) -> [f64; 2] {
        let low = self.check.map_or(self.p5, |check| check.min_wall);
        [low, self.p95.max(low)]
    }
}

/// The thinnest of the profile's points and, where triangles are so large that
/// those are far between, of points close to the corners of all walls.
fn thinnest(part: &Part, field: &Field, profile: &ThicknessProfile) -> Option<ThicknessSample> {
    let mut least = *profile.thinnest()?;
    if part.triangle_count() > SAMPLES {
        return Some(least);
    }
    let walls = part.mesh().faces();
    for face in walls.filter(|face| !part.coping()[face.index()]) {
        let corners = part.corners(face);
        let middle = corners.iter().sum::<DVec3>() / 3.0;
        for at in corners.map(|corner| corner.lerp(middle, CLOSE)) {
            if let Some(thickness) = thickness_at(field, face, at)
                && thickness < least.thickness
            {
                least = ThicknessSample {
                    thickness,
                    area: 0.0,
                    at,
                    face,
                };
            }
        }
    }
    Some(least)
}
