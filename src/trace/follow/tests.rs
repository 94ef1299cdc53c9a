//! Faces laid at random through simple parts, against labels of the nearest wall.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use smallvec::SmallVec;

use super::face::{ArcEnd, FaceContours, FaceNodeKind, solve_face};
use super::region::{Barrier, Region};
use crate::field::Field;
use crate::mesh::{Part, PartOptions, TriMesh};
use crate::trace::edge::{Crossing, crossings, sample_node};
use crate::trace::oracle::{Dice, Oracle};
use crate::trace::probe::Probe;
use crate::trace::tolerances::TINY;
use crate::walls::{Separation, Walls};

type Side = SmallVec<[Crossing; 1]>;

/// A face, solved.
struct Solved {
    corners: [DVec3; 3],
    /// Vertices on its sides, those that contours found included.
    sides: [Side; 3],
    face: FaceContours,
}

/// Solves the triangle of these corners as the walk does: again with the
/// vertices that its contours led to, until none is new.
fn solve(probe: &mut Probe, corners: [DVec3; 3]) -> Solved {
    let nodes = corners.map(|c| sample_node(probe, c));
    let mut sides = [(0, 1), (1, 2), (0, 2)]
        .map(|(a, b)| crossings(probe, [corners[a], corners[b]], [&nodes[a], &nodes[b]]));
    loop {
        let region = Region::new(corners.into_iter().collect(), Barrier::Coping).unwrap();
        let given = [&sides[0][..], &sides[1][..], &sides[2][..]];
        let face = solve_face(probe, region, given, [true, true, false], &[]);
        if face.found.is_empty() {
            return Solved {
                corners,
                sides,
                face,
            };
        }
        for &(side, crossing) in &face.found {
            sides[side as usize].push(crossing);
        }
    }
}

/// What every solved face must hold.
fn check(oracle: &Oracle, solved: &Solved) {
    let Solved {
        corners,
        sides,
        face,
    } = solved;
    assert!(face.lost.is_empty(), "lost at {:?}", face.lost);

    // Every port takes one contour end.
    let mut ports: BTreeMap<(u8, u16, u16), usize> = BTreeMap::new();
    for (s, side) in sides.iter().enumerate() {
        ports.extend((0..side.len()).map(|n| ((s as u8, n as u16, 0), 0)));
    }
    for (n, node) in face.nodes.iter().enumerate() {
        ports.extend((0..node.spokes.len()).map(|s| ((9, n as u16, s as u16), 0)));
    }
    for arc in &face.arcs {
        for end in arc.ends {
            let port = match end {
                ArcEnd::Crossing { side, index } => (side, index, 0),
                ArcEnd::Spoke { node, spoke } => (9, node, spoke),
            };
            *ports.get_mut(&port).unwrap() += 1;
        }
    }
    assert!(ports.values().all(|&n| n == 1), "ports {ports:?}");

    // A contour keeps its two walls from end to end.
    let pair = |walls: [crate::mesh::FaceId; 2]| {
        let mut pair = walls.map(|w| oracle.of(w));
        pair.sort_unstable();
        pair
    };
    for arc in &face.arcs {
        let ends = arc.ends.map(|end| match end {
            ArcEnd::Crossing { side, index } => pair(sides[side as usize][index as usize].walls),
            ArcEnd::Spoke { node, spoke } => {
                let spoke = face.nodes[node as usize].spokes[spoke as usize].pair;
                pair([spoke.left, spoke.right])
            }
        });
        assert_eq!(ends[0], ends[1]);
        assert_ne!(ends[0][0], ends[0][1]);
    }

    // As many branch points as places where three labels meet.
    let normal = (corners[1] - corners[0])
        .cross(corners[2] - corners[0])
        .normalize();
    let (u, v) = normal.any_orthonormal_pair();
    let size = corners[0].distance(corners[1]);
    for node in &face.nodes {
        let round = |radius: f64| -> BTreeSet<u32> {
            (0..48)
                .map(|k| f64::from(k) / 48.0 * std::f64::consts::TAU)
                .filter_map(|a| oracle.label(node.at + radius * (a.cos() * u + a.sin() * v)))
                .collect()
        };
        let labels = round(1e-5 * size).len();
        match node.kind {
            // Where a fin was left out, a contour bends: two spokes, two walls.
            FaceNodeKind::Tie => assert_eq!(node.spokes.len(), labels.max(2), "{node:?}"),
            FaceNodeKind::Coping(_) => assert_eq!((node.spokes.len(), labels), (1, 2)),
            kind => panic!("nothing ends here: {kind:?}, {node:?}"),
        }
    }
    for place in triple_points(oracle, corners) {
        let near = |n: &super::face::FaceNode| n.at.distance(place) < 3.0 / GRID as f64 * size;
        let at_rim = (0..3).any(|k| {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let along = (b - a).normalize();
            (place - a).reject_from(along).length() < 3.0 / GRID as f64 * size
        });
        assert!(
            at_rim || face.nodes.iter().any(near),
            "no branch at {place}"
        );
    }
}

/// Steps of the grid of samples along a side.
const GRID: usize = 40;

/// Middles of small triangles with three labels.
fn triple_points(oracle: &Oracle, corners: &[DVec3; 3]) -> Vec<DVec3> {
    let at = |i: usize, j: usize| {
        let (s, t) = (i as f64 / GRID as f64, j as f64 / GRID as f64);
        corners[0] + s * (corners[1] - corners[0]) + t * (corners[2] - corners[0])
    };
    let mut labels = BTreeMap::new();
    for i in 0..=GRID {
        for j in 0..=GRID - i {
            labels.insert((i, j), oracle.label(at(i, j)));
        }
    }
    let mut places = Vec::new();
    for i in 0..GRID {
        for j in 0..GRID - i {
            let mut cells = vec![[(i, j), (i + 1, j), (i, j + 1)]];
            if i + j + 1 < GRID {
                cells.push([(i + 1, j + 1), (i + 1, j), (i, j + 1)]);
            }
            for cell in cells {
                let set: BTreeSet<_> = cell.iter().filter_map(|c| labels[c]).collect();
                if set.len() == 3 {
                    places.push(cell.iter().map(|c| at(c.0, c.1)).sum::<DVec3>() / 3.0);
                }
            }
        }
    }
    places
}

/// Faces at random about the mid-surface of a part, sizes from 0.3 to 3 thicknesses.
fn faces(oracle: &Oracle, thickness: f64, count: usize, seed: u64) -> Vec<[DVec3; 3]> {
    let mut dice = Dice(seed);
    let (low, high) = oracle.field.bounds();
    let mut out = Vec::new();
    while out.len() < count {
        let at = dice.point(low, high);
        if !oracle.field.inside(at) {
            continue;
        }
        let size = thickness * 10f64.powf(dice.unit() - 0.5);
        let one = DVec3::splat(1.0);
        let corners: [DVec3; 3] = std::array::from_fn(|_| at + size * dice.point(-one, one));
        let [a, b, c] = corners;
        let sides = [a.distance(b), b.distance(c), c.distance(a)];
        let area = (b - a).cross(c - a).length();
        // Slivers are no lattice faces.
        if area > 0.4 * sides.iter().fold(0.0, |m: f64, s| m.max(*s)).powi(2) {
            out.push(corners);
        }
    }
    out
}

const PARTS: [(&str, f64); 4] = [("plate", 2.0), ("ell", 2.0), ("tee", 2.0), ("cross", 2.0)];

#[test]
fn contours_agree_with_the_nearest_walls() {
    // How many vertices lie on the sides, sorted: every pattern that comes.
    let mut patterns = BTreeSet::new();
    for (name, thickness) in PARTS {
        let oracle = Oracle::new(name);
        let walls = oracle.walls();
        let mut probe = Probe::new(&walls);
        for corners in faces(&oracle, thickness, 120, 7) {
            let solved = solve(&mut probe, corners);
            check(&oracle, &solved);
            let mut pattern = solved.sides.each_ref().map(|s| s.len());
            pattern.sort_unstable();
            let ties = (solved.face.nodes.iter()).filter(|n| n.kind == FaceNodeKind::Tie);
            patterns.insert((pattern, ties.count()));
        }
    }
    // None, in at a coping face, across, bent where a fin was left out, three
    // sheets, and sides that are crossed twice.
    for wanted in [
        ([0, 0, 0], 0),
        ([0, 0, 1], 0),
        ([0, 1, 1], 0),
        ([0, 1, 1], 1),
        ([1, 1, 1], 1),
        ([1, 1, 2], 0),
        ([1, 1, 2], 1),
    ] {
        assert!(patterns.contains(&wanted), "{wanted:?} not in {patterns:?}");
    }
}

#[test]
fn crossings_agree_with_the_nearest_walls() {
    for (name, thickness) in PARTS {
        let oracle = Oracle::new(name);
        let walls = oracle.walls();
        let mut probe = Probe::new(&walls);
        for [p, q, _] in faces(&oracle, thickness, 150, 11) {
            let nodes = [p, q].map(|c| sample_node(&mut probe, c));
            let found: Vec<[u32; 2]> = crossings(&mut probe, [p, q], [&nodes[0], &nodes[1]])
                .iter()
                .map(|c| c.walls.map(|w| oracle.of(w)))
                .collect();
            assert_eq!(found, oracle.changes(p, q, 3000), "{name}: {p} to {q}");
        }
    }
}

#[test]
fn a_face_is_the_same_from_every_start_and_mirrored() {
    for (name, thickness) in PARTS {
        let oracle = Oracle::new(name);
        let walls = oracle.walls();
        let mut probe = Probe::new(&walls);
        for [a, b, c] in faces(&oracle, thickness, 40, 13) {
            let mut results = [
                [a, b, c],
                [b, c, a],
                [c, a, b],
                [a, c, b],
                [c, b, a],
                [b, a, c],
            ]
            .map(|corners| solve(&mut probe, corners).face);
            let places = |face: &FaceContours| {
                let mut all: Vec<DVec3> = face.nodes.iter().map(|n| n.at).collect();
                all.sort_by(|p, q| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)));
                all
            };
            let first = results[0].clone();
            for face in &mut results {
                assert_eq!(face.arcs.len(), first.arcs.len(), "{name}");
                assert_eq!(face.nodes.len(), first.nodes.len(), "{name}");
                for (p, q) in places(face).iter().zip(places(&first)) {
                    assert!(p.distance(q) < 1e-8 * thickness, "{name}: {p} and {q}");
                }
            }
        }
    }
}

/// A wedge: two plane walls that meet at an angle in a knife edge along z, the
/// mid-surface being the half-plane y = 0 between them up to the edge. Its
/// back and both ends are coping.
fn wedge(angle: f64) -> Part {
    let half = 10.0 * (0.5 * angle).to_radians().tan();
    let outline = [(0.0, 0.0), (10.0, -half), (10.0, half)];
    let at = |z: f64| outline.map(|(x, y)| DVec3::new(x, y, z));
    let mesh = TriMesh {
        positions: [at(0.0), at(6.0)].concat(),
        triangles: vec![
            [0, 2, 1],
            [3, 4, 5],
            [1, 2, 5],
            [1, 5, 4],
            [0, 1, 4],
            [0, 4, 3],
            [2, 0, 3],
            [2, 3, 5],
        ],
    };
    let coping = (0..8).map(|t| t < 4).collect();
    Part::new(mesh, coping, PartOptions::default()).unwrap().0
}

/// The part of y = 0 in a triangle that the wedge's mid-surface draws on it,
/// if it comes from a side.
fn drawn(corners: &[DVec3; 3]) -> Option<[DVec3; 2]> {
    let mut ends: Vec<DVec3> = (0..3)
        .map(|k| (corners[k], corners[(k + 1) % 3]))
        .filter(|(p, q)| (p.y < 0.0) != (q.y < 0.0))
        .map(|(p, q)| p.lerp(q, p.y / (p.y - q.y)))
        .collect();
    let (p, q) = (ends.pop()?, ends.pop()?);
    // Clipped to the part in x and z.
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    for (from, to, most) in [(p.x, q.x, 10.0), (p.z, q.z, 6.0)] {
        let (a, b) = ((0.0 - from) / (to - from), (most - from) / (to - from));
        (low, high) = (low.max(a.min(b)), high.min(a.max(b)));
    }
    let from_side = low == 0.0 || high == 1.0;
    (low < high && from_side).then(|| [p.lerp(q, low), p.lerp(q, high)])
}

#[test]
fn a_sheet_goes_on_to_the_knife_edge_between_its_walls() {
    for angle in [5.0, 14.0, 30.0] {
        let part = wedge(angle);
        let field = Field::new(&part);
        let separation = Separation {
            min_angle: crate::extract::DEFAULT_ANGLE,
            keep_fins_from: None,
        };
        let walls = Walls::new(&part, &field, separation);
        let mut probe = Probe::new(&walls);
        let mut dice = Dice(17);
        let (mut at_edge, mut across) = (0, 0);
        for _ in 0..300 {
            let at = dice.point(DVec3::new(-0.3, -0.2, -0.3), DVec3::new(4.0, 0.2, 6.3));
            let one = DVec3::splat(1.0);
            let corners: [DVec3; 3] = std::array::from_fn(|_| at + dice.point(-one, one));
            let solved = solve(&mut probe, corners);
            let face = &solved.face;
            assert!(face.lost.is_empty(), "{angle}: lost at {:?}", face.lost);
            // The follower stops where the walls are this near.
            let size = corners[0]
                .distance(corners[1])
                .max(corners[1].distance(corners[2]));
            let short = 2.0 * TINY * size / (0.5 * angle).to_radians().sin();
            let wanted = drawn(&corners).filter(|[p, q]| p.distance(*q) > 3.0 * short);
            let Some(wanted) = wanted else { continue };
            assert_eq!(face.arcs.len(), 1, "{angle}: {corners:?}");
            let ends = face.arcs[0].ends.map(|end| match end {
                ArcEnd::Crossing { side, index } => solved.sides[side as usize][index as usize].at,
                ArcEnd::Spoke { node, .. } => face.nodes[node as usize].at,
            });
            for (p, kind) in ends.iter().zip(face.arcs[0].ends) {
                let fades = matches!(kind, ArcEnd::Spoke { node, .. } if face.nodes[node as usize].kind == FaceNodeKind::Fading);
                let near = if fades { short } else { 1e-6 };
                let off = wanted
                    .iter()
                    .map(|w| w.distance(*p))
                    .fold(f64::MAX, f64::min);
                assert!(p.y.abs() < 1e-9 && off < near, "{angle}: {p} of {wanted:?}");
                at_edge += usize::from(fades);
            }
            across += 1;
        }
        assert!(at_edge > 5 && across > 30, "{angle}: {at_edge} of {across}");
    }
}
