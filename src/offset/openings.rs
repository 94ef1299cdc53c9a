//! Holes and cuts that open a cavity: a printed part has to let resin or powder
//! out.

use std::f64::consts::{PI, TAU};
use std::str::FromStr;

use glam::DVec3;
use miette::Diagnostic;
use thiserror::Error;

use crate::field::Field;
use crate::mesh::{Bounds, TriMesh, UniteError, closed_shells, without};
use crate::settings::precision::Precision;

/// A round hole through the wall, square to the surface where it begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drain {
    /// Its diameter, part units.
    pub diameter: f64,
    /// It begins at the point of the part that is nearest to this.
    pub at: DVec3,
}

/// A plane beyond which all is cut away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cut {
    /// Unit normal, towards what is cut away.
    pub normal: DVec3,
    /// Of the plane along the normal, part units.
    pub distance: f64,
}

/// What a drain or a cut cannot be read from.
#[derive(Clone, Debug, PartialEq, Error, Diagnostic)]
pub enum OpeningSyntax {
    /// No drain.
    #[error("{0} is no drain: it is written DIAMETER@X,Y,Z, as 4@10,0,2.5")]
    Drain(String),
    /// No cut.
    #[error("{0} is no plane: it is written +z=10, -x=3 or NX,NY,NZ=DISTANCE")]
    Cut(String),
}

/// Why a cavity was not opened.
#[derive(Clone, Debug, PartialEq, Error, Diagnostic)]
#[non_exhaustive]
pub enum OpeningError {
    /// No cavity under the hole.
    #[error(
        "the drain at {at} does not reach the cavity: straight into the wall from there is none"
    )]
    #[diagnostic(help("move --drain to a wall that has the cavity behind it"))]
    NoCavity {
        /// Where it would begin.
        at: DVec3,
    },
    /// It breaks through beside the cavity, or not at all.
    #[error(
        "the drain of {diameter} at {at} does not open the cavity: it is as wide as the cavity there, or cuts through another wall"
    )]
    #[diagnostic(help("give --drain a smaller diameter, or move it away from edges"))]
    NotOpened {
        /// Its diameter.
        diameter: f64,
        /// Where it begins.
        at: DVec3,
    },
    /// The plane leaves nothing.
    #[error("nothing is left of the part on this side of the plane")]
    #[diagnostic(help(
        "--open +z=10 cuts away what lies above z = 10, --open -z=10 what lies below"
    ))]
    NothingLeft,
    /// The solids could not be subtracted.
    #[error("the opening could not be cut: {0}")]
    #[diagnostic(help("move it a little"))]
    Failed(#[from] UniteError),
}

impl FromStr for Drain {
    type Err = OpeningSyntax;

    fn from_str(text: &str) -> Result<Drain, OpeningSyntax> {
        let parse = || {
            let (diameter, at) = text.split_once('@')?;
            let diameter: f64 = diameter.trim().parse().ok()?;
            let at = point(at)?;
            (diameter > 0.0 && diameter.is_finite()).then_some(Drain { diameter, at })
        };
        parse().ok_or_else(|| OpeningSyntax::Drain(text.to_owned()))
    }
}

impl FromStr for Cut {
    type Err = OpeningSyntax;

    fn from_str(text: &str) -> Result<Cut, OpeningSyntax> {
        let parse = || {
            let (normal, distance) = text.split_once('=')?;
            let normal = match normal.trim() {
                "+x" | "x" => DVec3::X,
                "-x" => DVec3::NEG_X,
                "+y" | "y" => DVec3::Y,
                "-y" => DVec3::NEG_Y,
                "+z" | "z" => DVec3::Z,
                "-z" => DVec3::NEG_Z,
                other => point(other)?,
            };
            let distance: f64 = distance.trim().parse().ok()?;
            let length = normal.length();
            // `-z=3` is the plane z = 3 too, looked at from above.
            let turned = text.trim_start().starts_with('-') && !text.contains(',');
            let distance = if turned { -distance } else { distance };
            (length > 0.0 && length.is_finite() && distance.is_finite()).then(|| Cut {
                normal: normal / length,
                distance,
            })
        };
        parse().ok_or_else(|| OpeningSyntax::Cut(text.to_owned()))
    }
}

fn point(text: &str) -> Option<DVec3> {
    let mut numbers = text.split(',').map(|x| x.trim().parse::<f64>());
    let p = DVec3::new(
        numbers.next()?.ok()?,
        numbers.next()?.ok()?,
        numbers.next()?.ok()?,
    );
    (numbers.next().is_none() && p.is_finite()).then_some(p)
}

/// Sides of a drain.
const SIDES: usize = 64;

/// A hollowed part with drains and cuts; `part` is its outer surface, `cavity` the
/// offset that was put in.
///
/// # Errors
///
/// [`OpeningError`]: where a drain does not open the cavity, or a cut leaves
/// nothing.
pub fn opened(
    hollow: &TriMesh,
    [part, cavity]: [&TriMesh; 2],
    drains: &[Drain],
    cuts: &[Cut],
    precision: Precision,
) -> Result<TriMesh, OpeningError> {
    let mut solid = hollow.clone();
    let fields = [part, cavity].map(Field::of_mesh);
    for drain in drains {
        let pin = pin(drain, &fields)?;
        let drained = without(&solid, &pin)?;
        // The first into a cavity opens it, another one makes a tunnel.
        let opens = cavities(&drained) < cavities(&solid) || tunnels(&drained) > tunnels(&solid);
        if !opens {
            let Drain { diameter, at } = *drain;
            return Err(OpeningError::NotOpened { diameter, at });
        }
        solid = drained;
    }
    for cut in cuts {
        solid = match without(&solid, &beyond(cut, &solid.bounds())) {
            Err(UniteError::Empty) => return Err(OpeningError::NothingLeft),
            other => other?,
        };
    }
    for p in &mut solid.positions {
        *p = precision.round_point(*p);
    }
    Ok(solid)
}

/// Shells that look inwards.
fn cavities(mesh: &TriMesh) -> usize {
    let shells = closed_shells(mesh, &mesh.edges());
    shells.iter().filter(|shell| shell.volume < 0.0).count()
}

/// Handles of a closed manifold mesh: half of what its shells' Euler
/// characteristics lack.
fn tunnels(mesh: &TriMesh) -> i64 {
    let uses = mesh.edges();
    let shells = closed_shells(mesh, &uses).len() as i64;
    let mut used = vec![false; mesh.positions.len()];
    mesh.triangles
        .iter()
        .flatten()
        .for_each(|&v| used[v as usize] = true);
    let vertices = used.into_iter().filter(|&used| used).count() as i64;
    let euler = vertices - uses.by_edge().count() as i64 + mesh.triangles.len() as i64;
    shells - euler / 2
}

/// A block that holds all of a box that lies beyond the plane.
fn beyond(cut: &Cut, bounds: &Bounds) -> TriMesh {
    let centre = bounds.center();
    let size = 2.0 * bounds.diagonal();
    let height = cut.normal.dot(centre);
    let base = centre + (cut.distance - height) * cut.normal;
    let side = cut.normal.any_orthonormal_vector();
    let up = cut.normal.cross(side);
    let ring = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let mut positions: Vec<DVec3> = (ring.iter())
        .map(|[u, v]| base + size * (u * side + v * up))
        .collect();
    let depth = size + (height - cut.distance).abs();
    let far: Vec<DVec3> = positions.iter().map(|p| *p + depth * cut.normal).collect();
    positions.extend(far);
    let mut triangles = vec![[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7]];
    for k in 0..4 {
        let next = (k + 1) % 4;
        triangles.extend([[k, next, next + 4], [k, next + 4, k + 4]]);
    }
    TriMesh {
        positions,
        triangles,
    }
}

/// The cylinder that is cut out: from outside the wall into the cavity.
fn pin(drain: &Drain, [part, cavity]: &[Field; 2]) -> Result<TriMesh, OpeningError> {
    let foot = part.footpoint(drain.at);
    let normal = part.normal(foot.face);
    let reach = {
        let (low, high) = part.bounds();
        (high - low).length()
    };
    let along = |field: &Field, direction: DVec3| {
        let mut hits = Vec::new();
        field.hits(foot.point, foot.point + reach * direction, &mut hits);
        let mut ways: Vec<f64> = hits.iter().map(|hit| hit.t * reach).collect();
        ways.sort_by(f64::total_cmp);
        ways
    };
    let inner = along(cavity, -normal);
    let [enter, rest @ ..] = &inner[..] else {
        return Err(OpeningError::NoCavity { at: foot.point });
    };
    let leave = rest.iter().copied().find(|&way| way > enter + 1e-9 * reach);
    let depth = enter + drain.diameter.min(0.5 * (leave.unwrap_or(reach) - enter));
    // Out of the wall, but not into another one.
    let outer = along(part, normal);
    let free = outer
        .into_iter()
        .find(|&way| way > 1e-9 * reach)
        .unwrap_or(reach);
    let height = drain.diameter.min(0.5 * free);
    Ok(cylinder(
        [foot.point + height * normal, foot.point - depth * normal],
        0.5 * drain.diameter,
    ))
}

/// A closed prism of many sides with the area of the circle, from one end to the
/// other.
fn cylinder(ends: [DVec3; 2], radius: f64) -> TriMesh {
    let axis = (ends[1] - ends[0]).normalize_or_zero();
    let side = axis.any_orthonormal_vector();
    let up = axis.cross(side);
    let wide = radius * (TAU / SIDES as f64 / (TAU / SIDES as f64).sin()).sqrt();
    let mut mesh = TriMesh {
        positions: ends.to_vec(),
        triangles: Vec::new(),
    };
    for k in 0..SIDES {
        let angle = (2.0 * k as f64 + 1.0) * PI / SIDES as f64;
        let out = wide * (angle.cos() * side + angle.sin() * up);
        mesh.positions.extend(ends.map(|end| end + out));
    }
    for k in 0..SIDES as u32 {
        let next = (k + 1) % SIDES as u32;
        let [a, b] = [2 + 2 * k, 2 + 2 * next];
        mesh.triangles.extend([
            [0, b, a],
            [1, a + 1, b + 1],
            [a, b, a + 1],
            [b, b + 1, a + 1],
        ]);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drains_and_planes_are_read() {
        let drain: Drain = "4@10, 0,2.5".parse().unwrap();
        assert_eq!(
            (drain.diameter, drain.at),
            (4.0, DVec3::new(10.0, 0.0, 2.5))
        );
        let cut: Cut = "+z=10".parse().unwrap();
        assert_eq!((cut.normal, cut.distance), (DVec3::Z, 10.0));
        let cut: Cut = "-x=3".parse().unwrap();
        assert_eq!((cut.normal, cut.distance), (DVec3::NEG_X, -3.0));
        let cut: Cut = "0,3,4=-2".parse().unwrap();
        assert_eq!(
            (cut.normal, cut.distance),
            (DVec3::new(0.0, 0.6, 0.8), -2.0)
        );
        for bad in [
            "",
            "4",
            "0@1,2,3",
            "4@1,2",
            "4@1,2,3,4",
            "x@1,2,3",
            "inf@0,0,0",
        ] {
            assert!(bad.parse::<Drain>().is_err(), "{bad}");
        }
        for bad in ["", "z", "w=3", "0,0,0=1", "z=nan"] {
            assert!(bad.parse::<Cut>().is_err(), "{bad}");
        }
    }

    #[test]
    fn tools_are_closed_and_outward() {
        let pin = cylinder([DVec3::ZERO, DVec3::new(1.0, 2.0, 2.0)], 0.5);
        assert!(pin.edges().census().is_closed());
        assert!((pin.volume() - 0.75 * PI).abs() < 1e-12);
        let cut: Cut = "0,0.6,0.8=1".parse().unwrap();
        let block = beyond(&cut, &Bounds::of([DVec3::ZERO, DVec3::splat(5.0)]));
        assert!(block.edges().census().is_closed());
        assert!(block.volume() > 0.0);
    }
}
