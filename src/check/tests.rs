//! Surfaces with one known defect each.

use glam::DVec3;

use super::*;
use crate::extract::{Settings, extract};
use crate::mesh::Part;
use crate::settings::cell::CellSize;
use crate::surface::marked::Line;
use crate::surface::shapes::{grid, marked, no_field, part};
use crate::surface::{MidSurface, SurfaceParts};

fn tee() -> (Part, MidSurface) {
    extracted("tee", 1.0)
}

fn extracted(name: &str, cell: f64) -> (Part, MidSurface) {
    let part = part(name);
    let settings = Settings {
        cell: CellSize::Thicknesses(cell),
        ..Settings::default()
    };
    let surface = extract(&part, &settings, &|_, _, _| ()).unwrap().surface;
    (part, surface)
}

fn counts(part: &Part, surface: &MidSurface) -> Vec<(Measure, usize)> {
    let check = Check::of(part, surface, true, &Limits::default());
    check
        .outcomes
        .iter()
        .map(|o| (o.measure, o.count))
        .collect()
}

fn count(all: &[(Measure, usize)], measure: Measure) -> usize {
    all.iter().find(|c| c.0 == measure).unwrap().1
}

/// The surface with its vertices moved.
fn moved(surface: &MidSurface, by: &dyn Fn(DVec3) -> DVec3) -> MidSurface {
    let mut parts = surface.clone().into_parts();
    for vertex in &mut parts.vertices {
        vertex.position = by(vertex.position);
    }
    MidSurface::new(parts).unwrap()
}

#[test]
fn an_extraction_passes() {
    let (part, surface) = tee();
    let check = Check::of(&part, &surface, true, &Limits::default());
    assert_eq!(check.covered, 1.0);
    for outcome in &check.outcomes {
        assert_eq!(outcome.count, 0, "{outcome:?}");
    }
    assert!(check.marks.iter().all(|&m| m == 0));
}

#[test]
fn a_surface_moved_to_one_side_is_off_the_middle() {
    let (part, surface) = tee();
    let thickness = Check::of(&part, &surface, true, &Limits::default()).thickness;
    let all = counts(
        &part,
        &moved(&surface, &|p| p + 0.2 * thickness * (DVec3::X + DVec3::Y)),
    );
    assert!(count(&all, Measure::NodesOffMiddle) > 0);
    assert!(count(&all, Measure::CentresOffMiddle) > 0);
    let all = counts(
        &part,
        &moved(&surface, &|p| p + 2.0 * thickness * (DVec3::X + DVec3::Y)),
    );
    assert!(count(&all, Measure::NodesOutside) > 0);
    assert!(count(&all, Measure::Excess) > 0);
}

/// The surface without some of its triangles and without any lines.
fn without(surface: &MidSurface, drop: &dyn Fn(DVec3, u32) -> bool) -> MidSurface {
    let parts = surface.clone().into_parts();
    let centre = |c: [u32; 3]| c.map(|v| surface.position(v)).into_iter().sum::<DVec3>() / 3.0;
    let mut mesh = surface.mesh();
    mesh.triangles = (parts.triangles.iter())
        .filter(|t| !drop(centre(t.corners), t.sheet))
        .map(|t| t.corners)
        .collect();
    let mut marked_mesh = grid(&[0.0, 1.0], &[0.0, 1.0]);
    marked_mesh.triangles = mesh.triangles;
    marked_mesh.vertices = (mesh.positions.into_iter())
        .map(crate::surface::shapes::vertex)
        .collect();
    crate::surface::shapes::built(&marked(marked_mesh, Line::CopingBorder), &no_field()).0
}

#[test]
fn a_missing_sheet_leaves_the_wall_bare() {
    let (part, surface) = tee();
    let bare = without(&surface, &|_, sheet| sheet == 0);
    let check = Check::of(&part, &bare, false, &Limits::default());
    assert!(check.covered < 0.95, "{}", check.covered);
}

#[test]
fn a_sheet_with_nodes_of_its_own_is_unwelded() {
    let (part, surface) = tee();
    let mut parts: SurfaceParts = surface.into_parts();
    // Sheet 0 gets copies of all its nodes.
    let first = parts.vertices.len() as u32;
    let copies = parts.vertices.clone();
    parts.vertices.extend(copies);
    for triangle in parts.triangles.iter_mut().filter(|t| t.sheet == 0) {
        triangle.corners = triangle.corners.map(|v| v + first);
    }
    (parts.seams, parts.borders, parts.creases) = Default::default();
    parts.junctions.clear();
    let surface = MidSurface::new(parts).unwrap();
    let all = counts(&part, &surface);
    assert!(count(&all, Measure::Unwelded) > 0);
    assert_eq!(count(&all, Measure::Pieces), 1);
}

/// Along a border triangles are so small that some beside an edge share no node
/// with it.
#[test]
fn small_triangles_beside_each_other_are_welded() {
    let (part, surface) = extracted("plate_holes", 0.33);
    let all = counts(&part, &surface);
    assert_eq!(count(&all, Measure::Unwelded), 0);
}

#[test]
fn a_wrong_thickness_is_told() {
    let (part, surface) = tee();
    let mut parts = surface.into_parts();
    for vertex in &mut parts.vertices {
        vertex.ball.thickness *= 1.3;
    }
    let all = counts(&part, &MidSurface::new(parts).unwrap());
    assert!(count(&all, Measure::ThicknessOff) > 0);
    assert_eq!(count(&all, Measure::NodesOffMiddle), 0);
}
