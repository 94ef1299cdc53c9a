//! Target edge lengths at the vertices of a mesh that is to be remeshed.

use serde::Serialize;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::complex::{Complex, Rank};
use super::ground::Ground;
use super::lines::Lines;
use super::uncut::Kept;
use crate::surface::marked::MarkedVertex;

/// How fine, and how true to the surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Settings {
    /// Edge length wanted, part units.
    pub size: f64,
    /// How far edges may run beside a curved wall or line, part units.
    pub sag: f64,
    /// Growth of edges away from fine places, by length.
    pub grading: f64,
    /// Whether to pair triangles to quadrilaterals.
    pub quads: bool,
    /// How sheets run where they meet.
    pub junctions: Junctions,
}

/// How sheets run where they meet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Junctions {
    /// Equally far from the nearest walls: dipping towards seams and bends.
    #[default]
    Medial,
    /// In the middle of their own walls up to where they meet.
    Straight,
}

impl Settings {
    /// Default of [`Settings::grading`]: edges grow by two fifths from one to the next.
    pub const GRADING: f64 = 0.4;

    /// Default of [`Settings::sag`], in wall thicknesses: a little more than
    /// the eighth of a thickness by which a sheet dips towards a seam, which
    /// is not to be resolved.
    pub const SAG: f64 = 0.15;

    /// What elements are to be in the end.
    pub(super) fn wanted(&self) -> Wanted {
        Wanted {
            size: self.size,
            sag: self.sag,
            // Half the length of those that are halved.
            wall_sag: if self.quads {
                0.25 * COARSE_SAG * self.sag
            } else {
                self.sag
            },
            wall_arc: if self.quads { WARP_ARC } else { f64::INFINITY },
            ball_arc: if self.quads { BALL_ARC } else { f64::INFINITY },
            grading: self.grading,
            arc: ARC,
            parts: 1.0,
        }
    }

    /// What elements are to be before they are halved.
    pub(super) fn coarse(&self) -> Wanted {
        Wanted {
            size: 2.0 * self.size,
            sag: COARSE_SAG * self.sag,
            wall_sag: COARSE_SAG * self.sag,
            wall_arc: 2.0 * WARP_ARC,
            ball_arc: 2.0 * BALL_ARC,
            grading: COARSE_GRADING * self.grading,
            arc: COARSE_ARC,
            parts: 2.0,
        }
    }
}

/// Elements that are wanted.
pub(super) struct Wanted {
    /// Edge length, part units.
    pub(super) size: f64,
    /// How far edges may run beside a line, part units.
    pub(super) sag: f64,
    /// How far they may run beside a curved wall.
    wall_sag: f64,
    /// Angle that an edge on a curved wall may span.
    wall_arc: f64,
    /// The same where the wall bends in every direction.
    ball_arc: f64,
    /// Growth of edges away from fine places, by length.
    grading: f64,
    /// Angle that an edge of a line may span.
    arc: f64,
    /// Parts that an edge will be cut into.
    parts: f64,
}

/// Edges of a line span at most this share of its radius of curvature, so that
/// a small hole stays an octagon.
const ARC: f64 = 0.8;

/// Edges to be halved may span an arc and a half.
const COARSE_ARC: f64 = 1.5 * ARC;

/// Angle that a side of a quadrilateral may span on a curved wall: lying askew it
/// bends by seven tenths of that, which would be 16 degrees, but its vertices
/// move to where it bends less.
const WARP_ARC: f64 = 0.4;

/// The same where the wall bends in every direction, as a ball does: there is no way to
/// lie that bends less.
const BALL_ARC: f64 = 0.2;

/// Elements that are to be halved may stray so much farther than their halves
/// may: four times would do on a round wall, but edits could no longer tell
/// sheets apart.
const COARSE_SAG: f64 = 2.0;

/// Their growth against that of their halves; twice as fast would be the same,
/// and make worse angles.
const COARSE_GRADING: f64 = 1.5;

/// No target is below this share of the element size, nor below so many sags:
/// what is finer than edges may stray is not to be resolved.
const FLOOR: f64 = 0.02;
const FLOOR_IN_SAGS: f64 = 1.5;

/// The target edge length at every vertex: the element size, less where a wall
/// or a line bends, where lines are short or close together, half of that for
/// every try that failed, and growing away from such places by
/// [`Settings::grading`].
pub(super) fn sizes(
    complex: &Complex,
    vertices: &[MarkedVertex],
    lines: &Lines,
    ground: &dyn Ground,
    wanted: &Wanted,
    kept: &Kept,
) -> Vec<f64> {
    let mut size = vec![wanted.size; vertices.len()];
    let floor = (FLOOR * wanted.size).max(FLOOR_IN_SAGS * wanted.sag);
    let lower = |v: u32, to: f64, size: &mut Vec<f64>| {
        let slot = &mut size[v as usize];
        *slot = slot.min(to.max(floor));
    };
    let around = Neighbours::new(complex);
    for v in 0..vertices.len() as u32 {
        let [bend, least] = wall_bend(v, &around, complex, vertices, ground);
        if bend > 0.0 {
            let most = (8.0 * wanted.wall_sag / bend).sqrt();
            lower(v, most.min(wanted.wall_arc / bend), &mut size);
        }
        if least > 0.0 {
            lower(v, wanted.ball_arc / least, &mut size);
        }
    }
    for (v, bend) in lines.bends(complex, 0.5 * wanted.size) {
        let most = (8.0 * wanted.sag / bend).sqrt().min(wanted.arc / bend);
        lower(v, most, &mut size);
    }
    for course in lines.courses() {
        if course.ends()[0] != course.ends()[1] {
            for v in course.ends() {
                lower(v, wanted.parts * course.length(), &mut size);
            }
        }
    }
    for (v, gap) in gaps(complex, lines, &around, wanted.size / wanted.parts) {
        lower(v, wanted.parts * gap, &mut size);
    }
    for (v, size) in (0..).zip(&mut size) {
        let at = complex.at(v);
        let longest = around.of(v).iter().map(|n| n.1).fold(0.0, f64::max);
        match kept.is_left(at) {
            // Elements beside it are as large as what is there.
            true => *size = size.min(longest.max(floor)),
            false => *size *= 0.5_f64.powi(kept.tries_at(at)),
        }
    }
    grade(&mut size, &around, wanted.grading);
    size
}

/// Neighbours of each vertex over edges, with lengths.
struct Neighbours {
    first: Vec<usize>,
    list: Vec<(u32, f64)>,
}

impl Neighbours {
    fn new(complex: &Complex) -> Neighbours {
        let edges = complex.edges();
        let count = complex.vertex_count();
        let mut first = vec![0; count + 1];
        for &(a, b) in &edges {
            first[a as usize + 1] += 1;
            first[b as usize + 1] += 1;
        }
        for v in 0..count {
            first[v + 1] += first[v];
        }
        let mut next = first.clone();
        let mut list = vec![(0, 0.0); 2 * edges.len()];
        for &(a, b) in &edges {
            let length = complex.at(a).distance(complex.at(b));
            for (v, w) in [(a, b), (b, a)] {
                list[next[v as usize]] = (w, length);
                next[v as usize] += 1;
            }
        }
        Neighbours { first, list }
    }

    fn of(&self, v: u32) -> &[(u32, f64)] {
        &self.list[self.first[v as usize]..self.first[v as usize + 1]]
    }
}

/// Curvature of the walls at a vertex inside a sheet, as the turn of their
/// normals by length, the mean and the least over its edges; of the straighter wall, so that the dip of a sheet
/// beside a seam, where one footpoint sits on an edge, counts for nothing.
fn wall_bend(
    v: u32,
    around: &Neighbours,
    complex: &Complex,
    vertices: &[MarkedVertex],
    ground: &dyn Ground,
) -> [f64; 2] {
    if complex.rank(v) != Rank::Inner {
        return [0.0; 2];
    }
    let here = &vertices[v as usize];
    let (mut turns, mut length, mut least) = ([0.0; 2], 0.0, f64::INFINITY);
    for &(w, way) in around.of(v) {
        let step = ground.turns(here, &vertices[w as usize]);
        turns = [turns[0] + step[0], turns[1] + step[1]];
        length += way;
        least = least.min(step[0].min(step[1]) / way);
    }
    if length > 0.0 {
        [turns[0].min(turns[1]) / length, least]
    } else {
        [0.0; 2]
    }
}

/// Distances across a sheet between two lines that have no corner in common,
/// where they are less than `reach`, at the vertices between them.
fn gaps(complex: &Complex, lines: &Lines, around: &Neighbours, reach: f64) -> Vec<(u32, f64)> {
    const NONE: u32 = u32::MAX;
    let count = complex.vertex_count();
    let mut label = vec![NONE; count];
    let mut distance = vec![f64::INFINITY; count];
    let mut open: BinaryHeap<(Reverse<u64>, Reverse<u32>)> = BinaryHeap::new();
    for ((a, b), _) in complex.line_edges() {
        for v in [a, b] {
            if complex.rank(v) == Rank::Line
                && let Some(line) = lines.of_edge(a, b)
            {
                label[v as usize] = line;
                distance[v as usize] = 0.0;
                open.push((Reverse(0), Reverse(v)));
            }
        }
    }
    while let Some((Reverse(bits), Reverse(v))) = open.pop() {
        let here = f64::from_bits(bits);
        if here > distance[v as usize] || here > reach {
            continue;
        }
        for &(w, way) in around.of(v) {
            let there = here + way;
            if complex.rank(w) == Rank::Inner && there < distance[w as usize] {
                distance[w as usize] = there;
                label[w as usize] = label[v as usize];
                open.push((Reverse(there.to_bits()), Reverse(w)));
            }
        }
    }
    let apart = |s: u32, t: u32| {
        let [p, q] = [s, t].map(|n| lines.course(n).ends());
        s != t && p.iter().all(|v| !q.contains(v))
    };
    let mut found = Vec::new();
    for v in 0..count as u32 {
        for &(w, way) in around.of(v) {
            let [s, t] = [v, w].map(|x| label[x as usize]);
            let gap = distance[v as usize] + way + distance[w as usize];
            if v < w && s != NONE && t != NONE && gap < reach && apart(s, t) {
                found.extend([(v, gap), (w, gap)]);
            }
        }
    }
    found
}

/// Lets sizes grow by at most `grading` a unit of length.
fn grade(size: &mut [f64], around: &Neighbours, grading: f64) {
    let mut open: BinaryHeap<(Reverse<u64>, Reverse<u32>)> = (size.iter().enumerate())
        .map(|(v, s)| (Reverse(s.to_bits()), Reverse(v as u32)))
        .collect();
    while let Some((Reverse(bits), Reverse(v))) = open.pop() {
        let here = f64::from_bits(bits);
        if here > size[v as usize] {
            continue;
        }
        for &(w, way) in around.of(v) {
            let most = here + grading * way;
            if most < size[w as usize] {
                size[w as usize] = most;
                open.push((Reverse(most.to_bits()), Reverse(w)));
            }
        }
    }
}
