//! Counts of meshes made by hand, whose facts are known.

use glam::DVec3;

use rustc_hash::FxHashMap;

use super::graph::{Counts, Crack, SeamEnd, SheetGraph};
use super::listing::listing;
use super::marked::{Line, MarkedMesh, edge};
use super::shapes::{band, book, built, grid, marked, mesh, no_field, part, raw, shuffled, vertex};
use super::{Ball, MidSurface, VertexKind, segments};
use crate::field::Field;

/// What every result must hold, whatever the mesh.
fn check(mesh: &MarkedMesh) -> (MidSurface, SheetGraph, Vec<Crack>) {
    let (surface, graph) = built(mesh, &no_field());
    let cracks = graph.cracks().to_vec();
    assert_eq!(
        MidSurface::new(surface.clone().into_parts()).as_ref(),
        Ok(&surface)
    );
    let counts = *graph.counts();
    assert_eq!(counts.vertices, surface.vertices().len());
    assert_eq!(counts.triangles, surface.triangles().len());
    assert_eq!(counts.sheets, graph.sheets().len());
    assert_eq!(counts.seams, surface.seams().len());
    assert_eq!(counts.cracks, cracks.len());
    assert_eq!(graph.borders().len(), surface.borders().len());

    // Each edge runs once each way inside an orientable sheet.
    let mut ways: FxHashMap<(u32, u32), Vec<(bool, u32)>> = FxHashMap::default();
    for t in surface.triangles() {
        for k in 0..3 {
            let (a, b) = (t.corners[k], t.corners[(k + 1) % 3]);
            ways.entry(edge(a, b)).or_default().push((a < b, t.sheet));
        }
    }
    for (e, uses) in &ways {
        if let [(a, s), (b, t)] = uses[..] {
            assert_eq!(s, t, "one sheet at {e:?}");
            assert!(a != b || !graph.sheets()[s as usize].orientable, "at {e:?}");
        }
    }
    // Lines run along edges, and every edge but those of two triangles is on
    // exactly one line or a crack.
    let mut covered = cracks.len();
    let paths = (surface.seams().iter().map(|s| (&s.path, s.closed)))
        .chain(surface.borders().iter().map(|b| (&b.path, b.closed)));
    for (path, closed) in paths {
        for [a, b] in segments(path, closed) {
            assert_ne!(ways[&edge(a, b)].len(), 2);
            covered += 1;
        }
    }
    assert_eq!(covered, ways.values().filter(|u| u.len() != 2).count());
    (surface, graph, cracks)
}

#[test]
fn two_sheets_that_share_an_edge_are_one() {
    // Marked as a seam, but with two triangles it is none.
    let mut mesh = marked(book(2, 1, 1), Line::CopingBorder);
    mesh.lines.insert((0, 1), Line::Seam);
    let (surface, graph, cracks) = check(&mesh);
    assert_eq!((surface.sheet_count(), surface.seams().len()), (1, 0));
    assert_eq!(graph.counts().creases, 1);
    assert_eq!((surface.borders().len(), cracks.len()), (1, 0));
    assert!(surface.borders()[0].closed);
    assert_eq!(graph.borders()[0].length, 6.0);
}

#[test]
fn three_pages_make_a_seam() {
    let (surface, graph, cracks) = check(&marked(book(3, 2, 4), Line::CopingBorder));
    assert_eq!((surface.sheet_count(), cracks.len()), (3, 0));
    let [seam] = surface.seams() else {
        panic!("{:?}", surface.seams())
    };
    assert_eq!(seam.sheets, [0, 1, 2]);
    assert_eq!(seam.path, [0, 1, 2, 3, 4]);
    assert_eq!(graph.seams()[0].ends, Some([SeamEnd::Coping; 2]));
    assert_eq!(graph.seams()[0].length, 4.0);
    // Ends on a border are no junctions.
    assert!(surface.junctions().is_empty());
    assert_eq!(surface.borders().len(), 3);
    assert_eq!(graph.counts().boundary_components, 1);
    assert_eq!(graph.counts().euler, 1);
    for sheet in graph.sheets() {
        assert!((sheet.area - 8.0).abs() < 1e-12);
        assert_eq!((sheet.euler, sheet.boundary_loops), (1, 1));
    }
    assert_eq!(graph.neighbours(1), [0, 2]);
    assert_eq!(surface.vertices()[0].kind, VertexKind::Seam);
}

#[test]
fn unmarked_seams_and_borders_are_told() {
    let (surface, graph, cracks) = check(&book(4, 1, 2));
    assert_eq!(surface.seams().len(), 1);
    assert_eq!(graph.counts().irregular_edges, 2);
    assert!(surface.seams()[0].unmarked == 2);
    assert_eq!(cracks.len(), 16);
    assert_eq!(graph.seams()[0].ends, Some([SeamEnd::Crack; 2]));
}

#[test]
fn rings_and_moebius_strips() {
    for (twists, loops, orientable) in [(0, 2, true), (1, 1, false), (2, 2, true)] {
        let (surface, graph, _) = check(&marked(band(12, twists), Line::FadingBorder));
        let sheet = &graph.sheets()[0];
        assert_eq!(surface.sheet_count(), 1, "{twists}");
        assert_eq!((sheet.euler, sheet.boundary_loops), (0, loops), "{twists}");
        assert_eq!(sheet.orientable, orientable, "{twists}");
        assert_eq!(graph.counts().euler, 0);
        assert_eq!(surface.borders().len(), loops);
        assert!(surface.borders().iter().all(|b| b.closed));
        assert_eq!(graph.counts().fading_borders, loops);
        assert_eq!(
            graph.counts().non_orientable_sheets,
            usize::from(!orientable)
        );
    }
}

#[test]
fn a_crack_is_told_with_its_place() {
    let mut mesh = marked(grid(&[0.0, 1.0, 2.0], &[0.0, 1.0]), Line::CopingBorder);
    mesh.lines.remove(&(0, 1));
    let (surface, graph, cracks) = check(&mesh);
    assert_eq!(
        cracks,
        [Crack {
            at: DVec3::new(0.5, 0.0, 0.0),
            length: 1.0
        }]
    );
    assert!(!surface.borders()[0].closed);
    assert_eq!(graph.borders()[0].length, 5.0);
    assert!(listing(&surface, &graph).contains("problem: 1 x crack edge"));
}

#[test]
fn a_border_changes_kind() {
    let mut mesh = marked(grid(&[0.0, 1.0, 2.0], &[0.0, 1.0]), Line::CopingBorder);
    for e in [(0, 1), (1, 2)] {
        mesh.lines.insert(e, Line::FadingBorder);
    }
    let (surface, graph, _) = check(&mesh);
    let counts = graph.counts();
    assert_eq!((counts.coping_borders, counts.fading_borders), (1, 1));
    assert_eq!(surface.vertices()[1].kind, VertexKind::FadingBorder);
    assert_eq!(surface.vertices()[0].kind, VertexKind::CopingBorder);
}

/// A square whose middle line carries a fin over its left half only.
#[test]
fn a_seam_may_end_inside() {
    let mut raw = grid(&[-1.0, 0.0, 1.0], &[-1.0, 0.0, 1.0]);
    // Vertices 3, 4, 5 lie on the middle line.
    for at in [DVec3::new(-1.0, 0.0, 1.0), DVec3::new(0.0, 0.0, 1.0)] {
        raw.vertices.push(vertex(at));
    }
    raw.triangles.extend([[3, 4, 10], [3, 10, 9]]);
    let (surface, graph, _) = check(&marked(raw, Line::CopingBorder));
    assert_eq!(surface.sheet_count(), 2);
    // The plate's both sides and the fin.
    assert_eq!(surface.seams()[0].sheets, [0, 0, 1]);
    // The fin's far edge rises from the seam's end: it ends on a border.
    assert_eq!(
        graph.seams()[0].ends.map(|mut e| {
            e.sort();
            e
        }),
        Some([SeamEnd::Coping; 2])
    );
    assert_eq!(graph.seams_of(0), [0, 0]);
    assert_eq!(graph.sheets()[0].euler, 1);
}

#[test]
fn seams_that_cross_meet_at_a_junction() {
    // Three planes through the origin, in quadrants.
    let mut positions = vec![DVec3::ZERO];
    let mut triangles = Vec::new();
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        positions.extend([axis, -axis]);
    }
    for (a, b) in [(1, 3), (3, 5), (5, 1)] {
        for (i, j) in [(0, 0), (0, 1), (1, 1), (1, 0)] {
            triangles.push([0, a + i, b + j]);
        }
    }
    let (surface, graph, _) = check(&marked(mesh(&positions, &triangles), Line::CopingBorder));
    assert_eq!((surface.sheet_count(), surface.seams().len()), (12, 6));
    assert_eq!(surface.junctions(), [0]);
    assert_eq!(surface.vertices()[0].kind, VertexKind::Junction);
    assert!((graph.seams().iter()).all(|s| s.ends == Some([SeamEnd::Junction, SeamEnd::Coping])));
    assert_eq!(graph.counts().euler, 1);
}

#[test]
fn sheets_that_touch_in_a_point_are_pinched() {
    let positions = [
        DVec3::ZERO,
        DVec3::X,
        DVec3::Y,
        DVec3::new(-1.0, 0.0, 0.0),
        DVec3::new(0.0, -1.0, 0.0),
    ];
    let (surface, graph, _) = check(&mesh(&positions, &[[0, 1, 2], [0, 3, 4]]));
    assert_eq!(graph.counts().pinches, 1);
    assert_eq!(graph.counts().components, 2);
    assert_eq!(surface.sheet_count(), 2);
}

#[test]
fn useless_vertices_and_triangles_go() {
    let far = DVec3::splat(9.0);
    let positions = [far, DVec3::ZERO, far, DVec3::X, DVec3::Y];
    let (surface, graph, _) = check(&mesh(&positions, &[[1, 3, 4], [1, 1, 3]]));
    assert_eq!(
        surface
            .vertices()
            .iter()
            .map(|v| v.position)
            .collect::<Vec<_>>(),
        [DVec3::ZERO, DVec3::X, DVec3::Y]
    );
    assert_eq!(graph.counts().triangles, 1);
}

#[test]
fn nothing_comes_of_nothing() {
    let (surface, graph, cracks) = check(&MarkedMesh::default());
    assert_eq!(surface, MidSurface::default());
    assert_eq!(*graph.counts(), Counts::default());
    assert!(cracks.is_empty());
    assert!(listing(&surface, &graph).starts_with("0 sheets"));
}

#[test]
fn the_listing_does_not_depend_on_numbers() {
    for mesh in [
        marked(book(3, 2, 4), Line::CopingBorder),
        marked(band(9, 0), Line::FadingBorder),
        book(4, 1, 2),
    ] {
        let text = |mesh: &MarkedMesh| {
            let (surface, graph, _) = check(mesh);
            listing(&surface, &graph)
        };
        assert_eq!(text(&mesh), text(&shuffled(&mesh)));
    }
}

#[test]
fn a_plate_knows_its_thickness() {
    let part = part("plate");
    let field = Field::new(&part);
    let (surface, graph) = built(&raw(&part, &field, 5.0), &field);
    assert!(graph.cracks().is_empty());
    assert_eq!(graph.counts().lone_feet, 0);
    for vertex in surface.vertices() {
        assert!((vertex.ball.thickness - 2.0).abs() < 1e-9);
        assert_eq!(vertex.ball.footpoints.len(), 2);
    }
    let sheet = &graph.sheets()[0];
    assert!((sheet.area - 2400.0).abs() < 1e-6);
    assert!((sheet.angle.min - 180.0).abs() < 1e-3);
    assert!((sheet.thickness.median - 2.0).abs() < 1e-9);
}

#[test]
fn the_widest_footpoints_are_as_far_apart_as_the_wall_is_thick() {
    let feet = [DVec3::X, -DVec3::X, DVec3::Y];
    let ball = Ball::touching(DVec3::ZERO, feet.into_iter().collect());
    assert_eq!(ball.widest(), Some([DVec3::X, -DVec3::X]));
    assert_eq!(ball.thickness, 2.0);
    assert_eq!(Ball::default().widest(), None);
}

/// A seam that turns round in a lattice face leaves two sheets on each other there:
/// the third one goes on as one of them. Where they enclose nothing both go.
#[test]
fn of_two_triangles_on_each_other_one_stays_where_a_sheet_would_end() {
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z];
    let corners = [-x, 0.2 * y, x, y + y, -y + z, -y - z, -0.1 * y];
    let kept = |around: &[[u32; 3]], pillows: &[[u32; 3]], used: usize| {
        let mut twice = mesh(&corners[..used], &[around, pillows].concat());
        for e in [(0, 1), (1, 2)] {
            twice.lines.insert(e, Line::Seam);
        }
        for e in [(0, 3), (2, 3), (0, 4), (2, 4), (0, 5), (2, 5)] {
            twice.lines.insert(e, Line::FadingBorder);
        }
        twice.drop_pillows();
        twice.drop_stray_lines();
        let (surface, _, cracks) = check(&twice);
        assert_eq!(cracks, []);
        (twice.triangles.len(), surface.seams()[0].path.clone())
    };
    let around = [[3, 0, 1], [3, 1, 2], [0, 2, 4], [2, 0, 5]];
    assert_eq!(kept(&around, &[[0, 1, 2]; 2], 6), (5, vec![0, 2]));
    // The same of two pillows side by side: neither alone would close the sheet.
    let around = [
        [3, 0, 1],
        [3, 1, 2],
        [0, 6, 4],
        [6, 2, 4],
        [6, 0, 5],
        [2, 6, 5],
    ];
    let pillows = [[0, 1, 6], [1, 2, 6], [6, 1, 0], [6, 2, 1]];
    assert_eq!(kept(&around, &pillows, 7), (8, vec![0, 6, 2]));

    let mut pillow = marked(grid(&[0.0, 1.0, 2.0], &[0.0, 1.0]), Line::CopingBorder);
    let flat = pillow.clone();
    let [a, b, c] = flat.triangles[0];
    pillow.vertices.push(vertex(DVec3::Z));
    let top = pillow.vertices.len() as u32 - 1;
    pillow.triangles.extend([[a, b, top], [b, a, top]]);
    pillow.triangles.extend([[b, c, top]; 2]);
    pillow.drop_pillows();
    assert_eq!(pillow.triangles, flat.triangles);
}
