//! Extraction closes wherever a part lies in the lattice: no crack, nothing
//! outside the part, no triangles that cut each other or have no area, and
//! the same sheets. `tools/placements` asks the same many times over.

use glam::{DMat3, DVec3};
use midsurf::extract::{Extraction, Settings, extract};
use midsurf::internals::field::Field;
use midsurf::mesh::{Part, PartOptions, TriMesh, self_intersections};
use midsurf::settings::cell::CellSize;
use midsurf::surface::BorderKind;

use crate::common::fixture_part;

/// A part of `fixtures/placed`, shifted and turned.
fn part(name: &str, turn: DMat3, shift: DVec3) -> Part {
    let (mesh, coping) = fixture_part(&format!("placed/{name}"));
    let mesh = TriMesh {
        positions: mesh.positions.iter().map(|p| turn * *p + shift).collect(),
        triangles: mesh.triangles,
    };
    Part::new(mesh, coping, PartOptions::default()).unwrap().0
}

fn at_rest(name: &str) -> Part {
    part(name, DMat3::IDENTITY, DVec3::ZERO)
}

fn run(part: &Part, cell: CellSize) -> Extraction {
    let settings = Settings {
        cell,
        ..Settings::default()
    };
    extract(part, &settings, &|_, _, _| ()).unwrap()
}

/// What must hold of every result.
fn check(part: &Part, e: &Extraction, what: &str) {
    let mesh = e.surface.mesh();
    assert_eq!(e.graph.cracks(), [], "{what}: cracks");
    let field = Field::new(part);
    let limit = 1e-6 * part.bounds().diagonal();
    for p in &mesh.positions {
        assert!(
            field.signed_clearance(*p) >= -limit,
            "{what}: {p} lies outside the part"
        );
    }
    let cut = self_intersections(&mesh);
    assert!(cut.is_empty(), "{what}: triangles {cut:?} cut each other");
    for face in mesh.faces() {
        let [a, b, c] = mesh.corners(face);
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let height = (b - a).cross(c - a).length() / longest;
        assert!(height > 1e-9 * longest, "{what}: {face:?} has no area");
    }
    assert_eq!(e.work.counts.unsettled, 0, "{what}: unsettled faces");
}

fn fading(e: &Extraction) -> usize {
    let fading = |b: &&midsurf::surface::Border| b.kind == BorderKind::Fading;
    e.surface.borders().iter().filter(fading).count()
}

/// A border passes close to corners of the facets of a freely meshed bore.
#[test]
fn a_border_keeps_to_the_facets_that_it_crosses() {
    let part = at_rest("meshed_bores");
    for cell in [3.0, 3.5, 4.95] {
        let e = run(&part, CellSize::Length(cell));
        check(&part, &e, &format!("cell {cell}"));
        let area = e.surface.mesh().area();
        assert!((area - 3300.4).abs() < 0.5, "cell {cell}: area {area}");
        assert_eq!((e.surface.sheet_count(), fading(&e)), (1, 0), "cell {cell}");
        assert_eq!(e.surface.borders().len(), 4, "cell {cell}");
        assert_eq!(e.work.counts.lost, 0, "cell {cell}");
    }
}

/// The facets of a bore have a row of edges in the middle of the wall, where
/// the border runs.
#[test]
fn a_border_may_run_along_the_edges_of_its_facets() {
    let part = at_rest("slit_plate");
    for cell in [1.0, 1.7, 3.1] {
        let e = run(&part, CellSize::Thicknesses(cell));
        check(&part, &e, &format!("cell {cell} t"));
        assert_eq!((e.surface.sheet_count(), fading(&e)), (1, 0), "cell {cell}");
        assert_eq!(e.surface.borders().len(), 4, "cell {cell}");
        assert_eq!(e.work.counts.lost, 0, "cell {cell}");
    }
}

/// The flanges of a folded box end before each other, 0.3 apart at a thickness of 2; and a
/// rib over two plates ends before the thinner one. Neither wall is the other's footpoint.
#[test]
fn across_a_gap_no_wall_is_a_footpoint() {
    for (name, sheets, seams, borders, area) in
        [("folded", 1, 0, 1, 4756.7), ("plates_rib", 2, 1, 1, 3969.8)]
    {
        let part = at_rest(name);
        for cell in [0.5, 1.0, 2.1] {
            let e = run(&part, CellSize::Thicknesses(cell));
            let what = format!("{name}, cell {cell} t");
            check(&part, &e, &what);
            let found = (e.surface.sheet_count(), e.surface.seams().len());
            assert_eq!(found, (sheets, seams), "{what}");
            let pieces = e.graph.counts().boundary_components;
            assert_eq!(pieces, borders, "{what}");
            assert_eq!(e.work.counts.lost, 0, "{what}");
            let found = e.surface.mesh().area();
            assert!((found / area - 1.0).abs() < 1e-3, "{what}: area {found}");
        }
    }
}

/// One cell size at which a sheet went on outside the part.
#[test]
fn nothing_outside_the_part_is_followed() {
    for (name, cell, sheets, seams, area) in [
        ("leak", 0.466_67, 1, 0, 5.84),
        ("grid_corner", 0.333_3, 3, 1, 106.7),
        ("rib_end", 0.7, 2, 1, 409.3),
    ] {
        let part = at_rest(name);
        let e = run(&part, CellSize::Thicknesses(cell));
        check(&part, &e, name);
        let found = e.surface.mesh().area();
        assert!((found / area - 1.0).abs() < 1e-3, "{name}: area {found}");
        assert_eq!(
            (e.surface.sheet_count(), e.surface.seams().len()),
            (sheets, seams),
            "{name}"
        );
    }
}

/// A web flush with the plate that it carries passes the plate's edge: where the
/// edge crosses it, the wall of the web and the top of the plate touch in a
/// corner, coping between them on both sides. Away from a square corner they are
/// two walls, and into a sharper one the border runs.
#[test]
fn walls_that_touch_in_a_corner_only_are_two() {
    let part = at_rest("passing_web");
    for cell in [0.5, 1.0, 2.1, 3.0] {
        let e = run(&part, CellSize::Thicknesses(cell));
        check(&part, &e, &format!("cell {cell} t"));
        assert_eq!((e.surface.sheet_count(), fading(&e)), (2, 4), "cell {cell}");
        assert_eq!(e.work.counts.lost, 0, "cell {cell}");
    }
    let (mesh, coping) = fixture_part("placed/passing_web");
    let skew = DMat3::from_cols(DVec3::X, DVec3::new(1.2, 1.0, 0.0), DVec3::Z);
    let mesh = TriMesh {
        positions: mesh.positions.iter().map(|&p| skew * p).collect(),
        triangles: mesh.triangles,
    };
    let part = Part::new(mesh, coping, PartOptions::default()).unwrap().0;
    let e = run(&part, CellSize::Thicknesses(1.0));
    check(&part, &e, "skewed");
    assert_eq!(e.work.counts.torn, 0, "skewed");
}

/// A placement: axis and angle of the turn, cell in wall thicknesses.
type Placement = ([f64; 3], f64, f64);

const PLACEMENTS: [Placement; 4] = [
    ([0.31, -0.62, 0.72], 0.93, 0.61),
    ([-0.55, 0.2, 0.81], 2.31, 1.38),
    ([0.9, 0.13, -0.4], 4.07, 1.92),
    ([0.02, 0.97, 0.24], 5.5, 2.71),
];

/// Parts as CAD systems give them, freely meshed, wherever they lie.
#[test]
fn parts_close_wherever_they_lie() {
    for (name, sheets, seams, euler) in [
        ("crossing_inner", 4, 5, 1),
        ("clamp", 1, 0, -1),
        ("honeycomb", 18, 12, -6),
        ("bracket_fillet", 1, 0, -2),
        ("boss_rib", 2, 1, 0),
        ("bent_rib", 2, 1, 1),
        ("engraved", 1, 0, 1),
        ("stepped", 1, 0, 1),
        ("passing_web", 2, 1, 1),
    ] {
        for (axis, angle, cell) in PLACEMENTS {
            let axis = DVec3::from_array(axis).normalize();
            let turn = DMat3::from_axis_angle(axis, angle);
            let part = part(name, turn, DVec3::new(0.37, 0.81, 0.13));
            let e = run(&part, CellSize::Thicknesses(cell));
            let what = format!("{name} at {angle}, cell {cell} t");
            check(&part, &e, &what);
            let counts = e.graph.counts();
            assert_eq!(
                (e.surface.sheet_count(), e.surface.seams().len()),
                (sheets, seams),
                "{what}"
            );
            assert_eq!(counts.euler, euler, "{what}");
        }
    }
}

/// A placement of `tools/placements` by its seed and number: turn, shift in
/// wall thicknesses, and cell in wall thicknesses.
fn numbered(seed: u64, number: u64) -> (DMat3, DVec3, f64) {
    let mut state = seed.wrapping_mul(0x1000_0000_01B3) ^ number;
    let mut unit = || {
        state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    };
    let height = 2.0 * unit() - 1.0;
    let round = std::f64::consts::TAU * unit();
    let side = (1.0 - height * height).sqrt();
    let axis = DVec3::new(side * round.cos(), side * round.sin(), height);
    let turn = DMat3::from_axis_angle(axis, std::f64::consts::TAU * unit());
    let shift = DVec3::from_array(std::array::from_fn(|_| unit()));
    (turn, shift, 0.25 * 16_f64.powf(unit()))
}

/// A placement by its part, seed and number, with the sheets, seams and Euler
/// characteristic of the part.
type Numbered = (&'static str, u64, u64, [usize; 2], i64);

/// Extracts placements and checks each.
fn check_numbered(placements: &[Numbered]) {
    for &(name, seed, number, shape, euler) in placements {
        let (turn, shift, cell) = numbered(seed, number);
        let (mesh, coping) = fixture_part(name);
        let given = Part::new(mesh.clone(), coping.clone(), PartOptions::default());
        let thickness = run(&given.unwrap().0, CellSize::Auto).work.cell;
        let place = |p: &DVec3| turn * *p + thickness * shift;
        let mesh = TriMesh {
            positions: mesh.positions.iter().map(place).collect(),
            triangles: mesh.triangles,
        };
        let part = Part::new(mesh, coping, PartOptions::default()).unwrap().0;
        let e = run(&part, CellSize::Length(cell * thickness));
        let what = format!("{name}, {number} of seed {seed}");
        check(&part, &e, &what);
        let found = [e.surface.sheet_count() as usize, e.surface.seams().len()];
        assert_eq!(found, shape, "{what}");
        assert_eq!(e.graph.counts().euler, euler, "{what}");
    }
}

/// Placements in which a follower is lost on a face, and the face closes in
/// small triangles; they ended in cracks, or in sheets that cut themselves.
#[test]
fn a_face_on_which_a_follower_is_lost_closes() {
    check_numbered(&[
        ("boss_gussets", 11, 1, [7, 12], 1),
        ("placed/tray", 11, 23, [2, 1], -2),
    ]);
}

/// Edges that looked harmless to their neighbours ended in sheets that pass
/// through each other.
#[test]
fn clean_up_makes_no_triangles_that_cut() {
    check_numbered(&[
        ("placed/boss_rib", 11, 18, [2, 1], 0),
        ("placed/clamp", 2024, 12, [1, 0], -1),
    ]);
}

/// A sheet that bulges through an edge of the lattice and leaves by it again,
/// in large cells: it lay flat in the faces there.
#[test]
fn a_contour_that_returns_to_its_side_has_width() {
    check_numbered(&[("placed/tray", 2024, 10, [2, 1], -2)]);
}

/// Polygons in large cells round a small radius: the vertex in the middle of
/// one was sought beyond its tetrahedron, and beyond the part.
#[test]
fn vertices_in_the_middle_stay_in_their_tetrahedron() {
    check_numbered(&[
        ("enclosure", 11, 10, [22, 31], -15),
        ("enclosure", 11, 17, [22, 31], -15),
    ]);
}

/// The end of a rib on a round wall: the seam passes several facets in the step
/// that meets the end, and its sheets were not known there.
#[test]
fn a_seam_arrives_with_the_facets_of_its_junction() {
    check_numbered(&[
        ("enclosure", 11, 18, [22, 31], -15),
        ("enclosure", 2024, 21, [22, 31], -15),
    ]);
}

/// An edge of the lattice that passes a bend of the sheet within a tie: a
/// contour saw a crossing of the wrong wall beside the right one.
#[test]
fn a_crossing_beside_a_bend_is_one() {
    check_numbered(&[("placed/boss_rib", 2024, 23, [2, 1], 0)]);
}
