//! Wall thickness for print shops and moulders: where it is least, how much of
//! the wall is too thin, and a map of it.

use std::path::Path;

use crate::field::Field;
use crate::io::write::{Scalars, Staged, WriteError, stage_scalars};
use crate::mesh::{FaceId, Part, TriMesh};
use crate::walls::thickness::{ThicknessProfile, ThicknessSample, thickness_at};
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

/// Points of the walls at which the thickness is measured.
const SAMPLES: usize = 4000;

/// Pieces that the map cuts a part into, about.
const PIECES: f64 = 40_000.0;

/// How far the points of a piece lie inside its corners, as a share of the way
/// to its middle: on an edge the next wall would be nearest.
const INSET: f64 = 0.15;

/// The same for points that look for the thinnest wall.
const CLOSE: f64 = 0.01;

/// Wall thickness by share of the wall area, in part units.
#[derive(Clone, Debug, Serialize)]
pub struct WallThickness {
    /// 5 % of the wall area is thinner.
    pub p5: f64,
    /// 25 % of the wall area is thinner.
    pub p25: f64,
    /// 50 % of the wall area is thinner.
    pub p50: f64,
    /// 75 % of the wall area is thinner.
    pub p75: f64,
    /// 95 % of the wall area is thinner.
    pub p95: f64,
    /// The least found.
    pub thinnest: f64,
    /// Where the wall is thinnest.
    pub thinnest_at: [f64; 3],
    /// Triangle of the wall there.
    pub thinnest_triangle: u32,
    /// What `--min-wall` asked for.
    pub check: Option<WallCheck>,
}

/// Whether the walls are thick enough.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct WallCheck {
    /// The least thickness allowed.
    pub min_wall: f64,
    /// Share of the wall area that is thinner.
    pub share_below: f64,
    /// Whether no wall is.
    pub passed: bool,
}

impl WallThickness {
    /// Measures a part; none where no wall faces another. `min_wall` is the
    /// least thickness allowed.
    pub fn of(part: &Part, min_wall: Option<f64>) -> Option<WallThickness> {
        let field = &Field::new(part);
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
}

/// The thinnest of the profile's points and, where triangles are so large that
/// those are far between, of points close to the corners of all walls.
fn thinnest(part: &Part, field: &Field, profile: &ThicknessProfile) -> Option<ThicknessSample> {
    let mut least = *profile.thinnest()?;
    if part.triangle_count() > SAMPLES {
        return Some(least);
    }
    for face in part
        .mesh()
        .faces()
        .filter(|face| !part.coping()[face.index()])
    {
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

/// A map of the thickness over the walls, beside its target; coping has none.
///
/// # Errors
///
/// [`WriteError`] names the file.
pub fn stage_map(
    part: &Part,
    thickness: &WallThickness,
    file: &Path,
) -> Result<Staged, WriteError> {
    let field = Field::new(part);
    let (mesh, faces) = pieces(part);
    let value = |(piece, &face): (usize, &FaceId)| {
        let corners = mesh.corners(FaceId(piece as u32));
        let middle = corners.iter().sum::<DVec3>() / 3.0;
        let wall = !part.coping()[face.index()];
        corners.map(|corner| {
            let measured = || thickness_at(&field, face, corner.lerp(middle, INSET));
            wall.then(measured).flatten().unwrap_or(f64::NAN)
        })
    };
    let values: Vec<[f64; 3]> = faces
        .par_iter()
        .enumerate()
        .map(|(i, f)| value((i, f)))
        .collect();
    let low = thickness.check.map_or(thickness.p5, |check| check.min_wall);
    let scalars = Scalars {
        name: "thickness",
        values: values.as_flattened(),
        range: [low, thickness.p95.max(low)],
    };
    stage_scalars(&mesh, scalars, file)
}

/// The part in small pieces with corners of their own, and the triangle that
/// each comes from.
fn pieces(part: &Part) -> (TriMesh, Vec<FaceId>) {
    let largest = part.area() / PIECES;
    let mut mesh = TriMesh::default();
    let mut faces = Vec::new();
    for face in part.mesh().faces() {
        let [a, b, c] = part.corners(face);
        let n = (part.mesh().triangle_area(face) / largest)
            .sqrt()
            .ceil()
            .max(1.0) as usize;
        let at = |i: usize, j: usize| {
            a + (b - a) * (i as f64 / n as f64) + (c - a) * (j as f64 / n as f64)
        };
        let mut push = |corners: [DVec3; 3]| {
            let first = mesh.positions.len() as u32;
            mesh.positions.extend(corners);
            mesh.triangles.push([first, first + 1, first + 2]);
            faces.push(face);
        };
        for i in 0..n {
            for j in 0..n - i {
                push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                if i + j + 1 < n {
                    push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
    }
    (mesh, faces)
}
