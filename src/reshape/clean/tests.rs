//! Needles go, topology and lines stay.

use glam::DVec3;
use proptest::prelude::*;

use super::*;
use crate::field::Field;
use crate::surface::MidSurface;
use crate::surface::graph::{Counts, SheetGraph};
use crate::surface::marked::edge;
use crate::surface::quality::Quality;
use crate::surface::shapes::{band, book, built, grid, marked, mesh, no_field, part, raw};

/// Counts that clean-up may not change. Of cracks and unmarked seams it may
/// contract edges, but never the last.
fn fixed(graph: &SheetGraph) -> Counts {
    Counts {
        cracks: graph.counts().cracks.min(1),
        irregular_edges: graph.counts().irregular_edges.min(1),
        vertices: 0,
        edges: 0,
        triangles: 0,
        creases: 0,
        lone_feet: 0,
        degenerate_triangles: 0,
        ..*graph.counts()
    }
}

/// Cleans with cell size 1 and checks what is promised of any mesh.
fn check(mesh: &MarkedMesh, field: &Field, cell: f64) -> (MarkedMesh, MidSurface, SheetGraph) {
    let clean = clean_on(mesh, cell, field, &Kept::default());
    let (_, before) = built(mesh, field);
    let (surface, after) = built(&clean, field);
    assert_eq!(fixed(&before), fixed(&after));
    assert!(after.counts().degenerate_triangles <= before.counts().degenerate_triangles);
    let shapes = |graph: &SheetGraph| {
        let mut all: Vec<_> = (graph.sheets().iter())
            .map(|s| (s.euler, s.boundary_loops, s.orientable))
            .collect();
        all.sort_unstable();
        all
    };
    assert_eq!(shapes(&before), shapes(&after));
    let ends = |graph: &SheetGraph| {
        let mut all: Vec<_> = graph.seams().iter().map(|s| s.ends).collect();
        all.sort_unstable();
        all
    };
    assert_eq!(ends(&before), ends(&after));

    // No vertex moves, none is new, and the order stays.
    let mut old = mesh.vertices.iter();
    for v in &clean.vertices {
        assert!(old.any(|o| o.at == v.at && o.walls == v.walls && o.coping == v.coping));
    }
    // No triangle twice.
    let mut all: Vec<[u32; 3]> = clean.triangles.clone();
    all.iter_mut().for_each(|t| t.sort_unstable());
    all.sort_unstable();
    assert!(all.windows(2).all(|w| w[0] != w[1]));
    // Marks lie on edges.
    let edges = clean.edge_triangles();
    for e in clean.lines.keys() {
        assert!(edges.binary_search_by_key(e, |x| x.0).is_ok(), "{e:?}");
    }
    (clean, surface, after)
}

fn check_alone(mesh: &MarkedMesh) -> (MarkedMesh, MidSurface, SheetGraph) {
    check(mesh, &no_field(), 1.0)
}

fn shortest(mesh: &MarkedMesh) -> f64 {
    let lengths = mesh
        .edge_triangles()
        .into_iter()
        .map(|((a, b), _)| (mesh.vertices[a as usize].at - mesh.vertices[b as usize].at).length());
    lengths.fold(f64::INFINITY, f64::min)
}

#[test]
fn rows_of_needles_go() {
    // Columns down to rounding, in the inside and at the rim.
    let xs = [0.0, 1e-9, 1.0, 1.0 + 1e-12, 1.01, 1.02, 2.0, 2.999, 3.0];
    let ys = [0.0, 1.0, 1.05, 2.0, 2.0 + 1e-7, 3.0];
    let raw = marked(grid(&xs, &ys), Line::CopingBorder);
    let (clean, surface, graph) = check_alone(&raw);
    assert!(
        shortest(&clean) > 0.2,
        "{:?}",
        clean.vertices.iter().map(|v| v.at).collect::<Vec<_>>()
    );
    assert!((graph.area() - 9.0).abs() < 1e-9);
    assert!(Quality::of(&surface).least > 20.0);
}

/// Where several vertices are at one place no contraction leaves triangles with
/// area; they go one after the other.
#[test]
fn vertices_at_one_place_become_one() {
    let xs = [0.0, 1.0, 1.0, 1.0, 2.0, 2.0];
    let ys = [0.0, 0.0, 1.0, 1.0, 2.0];
    let raw = marked(grid(&xs, &ys), Line::CopingBorder);
    let (clean, surface, graph) = check_alone(&raw);
    assert!(shortest(&clean) > 0.2);
    assert!((graph.area() - 4.0).abs() < 1e-9);
    assert!(Quality::of(&surface).least > 20.0);
}

#[test]
fn a_mesh_without_needles_is_left_alone() {
    let raw = marked(grid(&[0.0, 1.0, 2.0], &[0.0, 1.0, 2.0]), Line::CopingBorder);
    let (clean, edits) = clean_counted(&raw, 1.0, &Settings::default(), None, &Kept::default());
    assert_eq!(edits, Edits::default());
    assert_eq!(clean.triangles, raw.triangles);
}

/// The rim's vertex near a bend goes, the bend stays.
#[test]
fn bends_of_a_coping_border_stay() {
    let xs = [0.0, 1.0, 2.0];
    for rise in [0.1, 1e-6] {
        let mut raw = marked(grid(&xs, &[0.0, 1.0]), Line::CopingBorder);
        // Bend the lower rim at vertex 1, and put a vertex close to it.
        raw.vertices[1].at = DVec3::new(0.05, -rise, 0.0);
        let (clean, ..) = check_alone(&raw);
        assert!(
            clean.vertices.iter().any(|v| v.at.y == -rise),
            "bend of {rise} is lost"
        );
        // On one coping triangle the rim may be straightened.
        if rise < 0.02 {
            for v in &mut raw.vertices[0..3] {
                v.coping = Some(FaceId(7));
            }
            let (clean, ..) = check_alone(&raw);
            assert!(clean.vertices.iter().all(|v| v.at.y >= 0.0));
        }
    }
}

#[test]
fn needles_on_a_seam_go_along_the_seam() {
    for pages in [3, 4, 5] {
        let mut raw = marked(book(pages, 2, 6), Line::CopingBorder);
        // Draw the spine's vertices 2 and 3 together.
        raw.vertices[3].at = DVec3::new(0.0, 0.0, 2.0 + 1e-8);
        let (clean, surface, graph) = check_alone(&raw);
        assert!(shortest(&clean) > 0.2);
        assert_eq!(surface.seams().len(), 1);
        assert_eq!(surface.seams()[0].sheets.len(), pages);
        assert!((graph.seams()[0].length - 6.0).abs() < 1e-12);
        assert!((graph.area() - 12.0 * pages as f64).abs() < 1e-7);
    }
}

#[test]
fn vertices_beside_a_seam_fall_onto_it() {
    let mut raw = marked(book(3, 2, 4), Line::CopingBorder);
    // First row of the first page: vertices 5 to 9.
    for v in 5..10 {
        raw.vertices[v].at.x = 1e-7;
    }
    let (clean, surface, _) = check_alone(&raw);
    assert!(shortest(&clean) > 0.2);
    assert_eq!(surface.seams()[0].path.len(), 5);
}

#[test]
fn two_lines_close_together_do_not_merge() {
    // A strip narrower than the threshold.
    let xs: Vec<f64> = (0..8).map(f64::from).collect();
    let raw = marked(grid(&xs, &[0.0, 0.01]), Line::CopingBorder);
    let (_, _, graph) = check_alone(&raw);
    assert!((graph.area() - 0.07).abs() < 1e-12);
    let ring = marked(band(40, 0), Line::FadingBorder);
    check(&ring, &no_field(), 30.0);
}

#[test]
fn small_closed_surfaces_stay_closed() {
    // A tetrahedron and an octahedron far below the cell size.
    let tetrahedron = mesh(
        &[DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
        &[[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
    );
    check(&tetrahedron, &no_field(), 100.0);
    let tops = [DVec3::X, DVec3::Y, DVec3::Z];
    let positions: Vec<DVec3> = tops.iter().flat_map(|&p| [p, -p]).collect();
    let mut triangles = Vec::new();
    for a in [0, 1] {
        for b in [2, 3] {
            triangles.extend([4, 5].map(|c| [a, b, c]));
        }
    }
    check(&mesh(&positions, &triangles), &no_field(), 100.0);
}

#[test]
fn caps_are_flipped() {
    // The apex of the upper triangle stands just above the long edge.
    let at = |x, y| DVec3::new(x, y, 0.0);
    let positions = [
        at(0.0, 0.0),
        at(1.0, 0.0),
        at(0.5, 0.02),
        at(0.5, -1.0),
        at(0.5, 1.0),
    ];
    let triangles = [[0, 1, 2], [1, 0, 3], [0, 2, 4], [2, 1, 4]];
    let raw = marked(mesh(&positions, &triangles), Line::CopingBorder);
    let (clean, edits) = clean_counted(&raw, 1.0, &Settings::default(), None, &Kept::default());
    assert_eq!((edits.flipped, edits.contracted), (1, 0));
    check_alone(&raw);
    let e = clean.edge_triangles();
    assert!(e.iter().any(|e| e.0 == (2, 3)) && !e.iter().any(|e| e.0 == (0, 1)));
}

#[test]
fn a_fold_stays() {
    // Two pages at 120 degrees with a narrow row beside an unmarked fold:
    // contracting it across the fold would cut the edge.
    let mut raw = book(3, 2, 4);
    raw.triangles.truncate(2 * 2 * 2 * 4);
    let mut raw = marked(raw, Line::CopingBorder);
    for v in 5..10 {
        raw.vertices[v].at = raw.vertices[v].at.with_x(0.15);
    }
    let (_, _, graph) = check_alone(&raw);
    let (_, before) = built(&raw, &no_field());
    assert!((graph.area() - before.area()).abs() < 0.02 * before.area());
}

proptest! {
    /// Random heights, squeezed rows and columns, random marks.
    #[test]
    fn any_grid_keeps_its_topology(
        xs in prop::collection::vec(1e-10..1.0f64, 3..9),
        ys in prop::collection::vec(1e-10..1.0f64, 3..9),
        heights in prop::collection::vec(-0.5..0.5f64, 81),
        power in 1..12i32,
        marks in prop::collection::vec((0usize..200, 0usize..3), 0..12),
    ) {
        let sums = |steps: &[f64]| -> Vec<f64> {
            (steps.iter())
                .scan(0.0, |sum, step| {
                    *sum += step.powi(power);
                    Some(*sum)
                })
                .collect()
        };
        let mut raw = marked(grid(&sums(&xs), &sums(&ys)), Line::CopingBorder);
        for (v, h) in raw.vertices.iter_mut().zip(heights) {
            v.at.z = h.powi(power);
        }
        let edges = raw.edge_triangles();
        for (place, line) in marks {
            let line = [Line::Seam, Line::FadingBorder, Line::Sheet][line];
            let e = edges[place % edges.len()].0;
            raw.lines.insert(edge(e.0, e.1), line);
        }
        check_alone(&raw);
    }
}

proptest! {
    /// Sheets at a seam, rings and Moebius strips, with vertices anywhere:
    /// shapes are senseless here, only the topology counts.
    #[test]
    fn any_complex_keeps_its_topology(
        kind in 0usize..4,
        size in 1usize..6,
        places in prop::collection::vec((0..4i32, 0..4i32, 0..4i32), 130),
        cell in 0.5..20.0f64,
    ) {
        let mut raw = match kind {
            0 => book(3 + size % 3, 2, size),
            1 => book(4, 1 + size, 3),
            2 => band(5 + size, 1),
            _ => band(5 + size, 0),
        };
        raw = marked(raw, Line::FadingBorder);
        for (v, (x, y, z)) in raw.vertices.iter_mut().zip(places) {
            v.at += 0.3 * DVec3::new(x.into(), y.into(), z.into());
        }
        // Any drift is allowed, so that all contractions are tried.
        let settings = Settings { drift: 100.0, short: 1.0, ..Settings::default() };
        let (clean, _) = clean_counted(&raw, cell, &settings, None, &Kept::default());
        let (_, before) = built(&raw, &no_field());
        let (_, after) = built(&clean, &no_field());
        prop_assert_eq!(fixed(&before), fixed(&after));
        check(&raw, &no_field(), cell);
    }
}

/// In a plane nothing may overlap: the area stays.
#[test]
fn flat_sheets_stay_covered_once() {
    for (name, cells) in [
        ("plate", &[1.0, 5.0][..]),
        ("plate_holes", &[0.7, 2.0, 6.0]),
        ("cross", &[1.0, 6.0]),
    ] {
        let part = part(name);
        let field = Field::new(&part);
        for &cell in cells {
            let raw = raw(&part, &field, cell);
            let (_, _, after) = check(&raw, &field, cell);
            let (_, before) = built(&raw, &field);
            let change = (after.area() / before.area() - 1.0).abs();
            assert!(change < 1e-8, "{name} {cell}: area by {change}");
        }
    }
}

/// Border edges lie on coping faces, between their ends too.
#[test]
fn coping_borders_stay_on_coping() {
    for (name, cell) in [
        ("slanted_45", 6.0),
        ("cylinder_shell", 6.0),
        ("plate_holes", 6.0),
        ("ell_bend", 2.0),
        ("rib_grid", 6.0),
    ] {
        let part = part(name);
        let field = Field::new(&part);
        let raw = raw(&part, &field, cell);
        let gap = |mesh: &MarkedMesh| {
            let borders = mesh.lines.iter().filter(|l| *l.1 == Line::CopingBorder);
            let gaps = borders.flat_map(|((a, b), _)| {
                let [p, q] = [a, b].map(|v| mesh.vertices[*v as usize].at);
                [0.1, 0.5, 0.8].map(|s| {
                    let nearest = field.nearest_coping(p.lerp(q, s), f64::INFINITY);
                    nearest.map_or(f64::INFINITY, |n| n.distance)
                })
            });
            gaps.fold(0.0, f64::max)
        };
        let (before, after) = (
            gap(&raw),
            gap(&clean_on(&raw, cell, &field, &Kept::default())),
        );
        assert!(after <= before + 1e-8, "{name}: {before} {after}");
    }
}

#[test]
fn the_same_mesh_gives_the_same_result() {
    let part = part("tee_rotated");
    let field = Field::new(&part);
    let raw = raw(&part, &field, 3.0);
    let [a, b] = [clean(raw.clone(), 3.0), clean(raw, 3.0)];
    assert_eq!(a.triangles, b.triangles);
    assert!(
        a.vertices
            .iter()
            .zip(&b.vertices)
            .all(|(a, b)| a.at == b.at)
    );
    assert_eq!(a.lines, b.lines);
}

/// The raw meshes of parts, at cells smaller and larger than the wall.
#[test]
fn parts_keep_their_topology() {
    for (name, cells) in [
        ("tee", &[1.0, 6.0][..]),
        ("cross", &[2.0]),
        ("ell", &[2.0]),
        ("box_divider", &[2.0, 4.5]),
        ("slanted_45", &[6.0]),
        ("plate_round_edge", &[4.0]),
        ("plate_holes", &[6.0]),
        ("cylinder_shell", &[2.0]),
        ("wavy_rib", &[1.6, 4.8]),
        ("rib_grid", &[2.0, 6.0]),
        ("boss_gussets", &[2.0]),
    ] {
        let part = part(name);
        let field = Field::new(&part);
        for &cell in cells {
            let raw = raw(&part, &field, cell);
            let (clean, surface, graph) = check(&raw, &field, cell);
            let (old, before) = built(&raw, &field);
            let (was, is) = (Quality::of(&old), Quality::of(&surface));
            assert!(
                is.share_below_5 <= was.share_below_5 && is.share_below_5 < 0.05,
                "{name} {cell}: {was:?} {is:?}"
            );
            assert!(is.percentile_5 >= was.percentile_5, "{name} {cell}");
            let change = (graph.area() / before.area() - 1.0).abs();
            assert!(change < 2e-3, "{name} {cell}: area by {change}");
            // Once more changes little: a fixed point was near.
            let again = clean_on(&clean, cell, &field, &Kept::default());
            let rest = clean.triangles.len() - again.triangles.len();
            assert!(rest * 50 <= clean.triangles.len(), "{name} {cell}: {rest}");
        }
    }
}
