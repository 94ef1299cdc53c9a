//! Edge vertices: where a lattice edge crosses the mid-surface
//! (Bloomenthal 2011, section 3).
//!
//! The paper compares the footpoint vectors of two lattice points and bisects.
//! That needs cells smaller than the wall, and some twenty queries a vertex.
//! Here the edge is first cut by the part. On each stretch inside, the two
//! ends know their nearest wall (an end on a wall face *is* on it), and the
//! place where these two walls tie either is a vertex or shows a nearer wall
//! between, which splits the stretch in two. The cell may be larger than the
//! wall, an edge may carry several vertices, and a planar part needs one query
//! a vertex. [`bisect`] keeps the paper's way as an oracle for tests.

use glam::DVec3;
use smallvec::SmallVec;

use crate::field::Footpoint;
use crate::mesh::FaceId;
use crate::trace::probe::Probe;
use crate::trace::solve::{distance_to, tie_on_segment};
use crate::trace::tolerances::{SAME_HIT, Tolerances};

/// What is known of a lattice point.
#[derive(Clone, Copy, Debug)]
pub struct NodeSample {
    /// Inside the part.
    pub inside: bool,
    /// Distance to the nearest triangle of any kind.
    pub clearance: f64,
    /// Nearest wall triangle.
    pub wall: FaceId,
}

/// Samples a lattice point.
pub fn sample_node(probe: &mut Probe, at: DVec3) -> NodeSample {
    let near = probe.nearest_anywhere(at).face;
    sample_node_near(probe, at, near)
}

/// The same; `hint` is a wall near by, which saves time.
pub fn sample_node_near(probe: &mut Probe, at: DVec3, hint: FaceId) -> NodeSample {
    let (foot, signed) = probe.nearest_and_clearance(at, hint);
    NodeSample {
        inside: signed > 0.0,
        clearance: signed.abs(),
        wall: foot.face,
    }
}

/// A vertex on a lattice edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Where.
    pub at: DVec3,
    /// Nearest wall before and behind, walking from the low node to the high one.
    pub walls: [FaceId; 2],
}

/// Every vertex on the segment between two sampled nodes, in order from the first.
pub fn crossings(
    probe: &mut Probe,
    ends: [DVec3; 2],
    samples: [&NodeSample; 2],
) -> SmallVec<[Crossing; 1]> {
    let mut out = SmallVec::new();
    let [p, q] = ends;
    let length = p.distance(q);
    let whole = samples.iter().any(|s| s.clearance > length);
    if whole {
        if samples[0].inside && samples[1].inside {
            stretch(probe, &mut out, p, samples[0].wall, q, samples[1].wall, 0);
        }
        return out;
    }
    let mut hits = std::mem::take(&mut probe.hits);
    hits.clear();
    probe.field().hits(p, q, &mut hits);
    // Cut into stretches. Between two hits the segment is inside or outside
    // throughout; the midpoint tells, whatever the triangles' corners do.
    let mut cuts: SmallVec<[(f64, Option<FaceId>); 8]> = SmallVec::new();
    cuts.push((0.0, None));
    for hit in &hits {
        let wall = (!probe.field().is_coping(hit.face)).then_some(hit.face);
        match cuts.last_mut() {
            Some(last) if hit.t - last.0 < SAME_HIT => last.1 = last.1.or(wall),
            _ => cuts.push((hit.t, wall)),
        }
    }
    match cuts.last_mut() {
        Some(last) if 1.0 - last.0 < SAME_HIT => {}
        _ => cuts.push((1.0, None)),
    }
    probe.hits = hits;
    let last = cuts.len() - 1;
    for k in 0..last {
        let ((s, first_wall), (t, second_wall)) = (cuts[k], cuts[k + 1]);
        let inside = match (k, last) {
            (0, 1) => samples[0].inside && samples[1].inside,
            _ => probe.field().inside(p.lerp(q, 0.5 * (s + t))),
        };
        if !inside {
            continue;
        }
        let (x, y) = (p.lerp(q, s), p.lerp(q, t));
        let a = match first_wall {
            Some(face) => face,
            None if k == 0 => samples[0].wall,
            None => probe.nearest_anywhere(x).face,
        };
        let b = match second_wall {
            Some(face) => face,
            None if k + 1 == last => samples[1].wall,
            None => probe.nearest(y, a).face,
        };
        stretch(probe, &mut out, x, a, y, b, 0);
    }
    out
}

/// The mid-surface point nearest to `centre` on the line along `direction`,
/// at most `reach` away.
pub fn crossing_near(
    probe: &mut Probe,
    centre: DVec3,
    direction: DVec3,
    reach: f64,
) -> Option<Crossing> {
    let ends = [centre - reach * direction, centre + reach * direction];
    let near = probe.nearest_anywhere(centre).face;
    let samples = ends.map(|p| sample_node_near(probe, p, near));
    crossings(probe, ends, [&samples[0], &samples[1]])
        .into_iter()
        .min_by(|a, b| a.at.distance(centre).total_cmp(&b.at.distance(centre)))
}

/// Vertices on a stretch inside the part whose ends have `a` and `b` nearest.
fn stretch(
    probe: &mut Probe,
    out: &mut SmallVec<[Crossing; 1]>,
    x: DVec3,
    a: FaceId,
    y: DVec3,
    b: FaceId,
    depth: usize,
) {
    const DEEPEST: usize = 48;
    let lengths = Tolerances::new(probe.walls().tolerances(), 0.0);
    if a == b || depth > DEEPEST || x.distance(y) <= lengths.decided {
        return;
    }
    let field = probe.field();
    let s = tie_on_segment(field, x, y, a, b, lengths.solve);
    let m = x.lerp(y, s);
    let (fa, fb) = (field.footpoint_on(m, a), field.footpoint_on(m, b));
    let distance = fa.distance.max(fb.distance);
    let nearest = probe.nearest(m, a);
    let tied = (fa.distance - fb.distance).abs() <= lengths.solved_tie;
    if tied && nearest.distance >= distance - lengths.decided {
        if probe.walls().separate(m, &fa, &fb) {
            out.push(Crossing {
                at: m,
                walls: [a, b],
            });
        }
        return;
    }
    let c = nearest.face;
    // A third wall is nearer; what lies on one smooth wall with it is no jump.
    let foot = probe.field().footpoint_on(m, c);
    let left = c != a && !slides(probe, &fa, &foot);
    let right = c != b && !slides(probe, &fb, &foot);
    if left {
        stretch(probe, out, x, a, m, c, depth + 1);
    }
    if right {
        stretch(probe, out, m, c, y, b, depth + 1);
    }
}

fn slides(probe: &Probe, a: &Footpoint, b: &Footpoint) -> bool {
    probe.walls().slides(a, b)
}

/// The paper's bisection: a vertex between two points inside the part whose
/// footpoint vectors diverge. The oracle of the tests; needs cells smaller
/// than the wall.
pub fn bisect(probe: &mut Probe, mut x: DVec3, mut y: DVec3, tolerance: f64) -> Option<Crossing> {
    let (mut a, mut b) = (probe.nearest_anywhere(x), probe.nearest_anywhere(y));
    while x.distance(y) > tolerance {
        let m = 0.5 * (x + y);
        let f = probe.nearest_anywhere(m);
        let u = (f.point - m).normalize_or_zero();
        let to_a = u.dot((a.point - x).normalize_or_zero());
        let to_b = u.dot((b.point - y).normalize_or_zero());
        if to_a >= to_b {
            (x, a) = (m, f);
        } else {
            (y, b) = (m, f);
        }
    }
    let m = 0.5 * (x + y);
    let field = probe.field();
    let (fa, fb) = (field.footpoint_on(m, a.face), field.footpoint_on(m, b.face));
    let tied = (distance_to(field, m, a.face).0 - distance_to(field, m, b.face).0).abs()
        < 10.0 * tolerance;
    (tied && probe.walls().separate(m, &fa, &fb)).then_some(Crossing {
        at: m,
        walls: [a.face, b.face],
    })
}
