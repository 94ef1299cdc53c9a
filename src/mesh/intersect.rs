//! Pairs of triangles that cut or touch each other, decided exactly.
//!
//! Boxes find the candidates, Shewchuk's adaptive predicates (crate `robust`)
//! decide them; so neither a missed nor a false pair comes from rounding.

mod parted;

use glam::DVec3;
use rayon::prelude::*;
use robust::{Coord, Coord3D};

use super::{FaceId, TriMesh, weld_exact};
use parted::parted;

/// Triangles of one leaf of the tree.
const LEAF: usize = 8;

/// Children of one inner node.
const FANOUT: usize = 4;

/// All pairs of triangles with a point in common beyond the corners and edges
/// that they share, lower index first, sorted.
///
/// Corners at the same place count as shared, whatever their index. So:
///
/// * without a common corner: any common point, touching included;
/// * with one: any other common point;
/// * with a common edge: folded flat onto each other;
/// * with three: always.
///
/// Triangles without area, with a coordinate that is no finite number, or with
/// an index out of range take part in no pair. The result depends neither on
/// rounding (short of under- and overflow: products of three coordinate
/// differences must be representable) nor on the number of threads.
///
/// Time goes with the number of triangles and of overlapping boxes: about
/// two seconds for a smooth mesh of a million triangles on one core.
///
/// Once some [`MOST_PAIRS`] are found no more are looked for: a mesh that lies
/// upon itself many times has pairs in the square of its triangles.
pub fn self_intersections(mesh: &TriMesh) -> Vec<(FaceId, FaceId)> {
    let place = weld_exact(&mesh.positions).new_index;
    let mut solids: Vec<Solid> = mesh
        .triangles
        .par_iter()
        .enumerate()
        .filter_map(|(face, corners)| Solid::new(face, corners, &mesh.positions, &place))
        .collect();
    if solids.is_empty() {
        return Vec::new();
    }
    let whole = solids
        .iter()
        .fold(Box3::EMPTY, |all, s| all.with(s.bounds()));
    solids.par_sort_by_cached_key(|solid| (whole.morton(solid.bounds().middle()), solid.face));
    let tree = Tree::new(&solids);
    let leaves = solids.len().div_ceil(LEAF);
    let mut pairs: Vec<(FaceId, FaceId)> = Vec::new();
    for first in (0..leaves).step_by(BATCH) {
        let batch = first..leaves.min(first + BATCH);
        let found = batch.into_par_iter();
        pairs.par_extend(found.flat_map_iter(|leaf| tree.pairs_of(leaf, &solids)));
        if pairs.len() > MOST_PAIRS {
            break;
        }
    }
    pairs.par_sort_unstable();
    pairs
}

/// Whether two triangles have a point in common beyond the corners and edges
/// that they share, as [`self_intersections`] tells it. Corners with the same
/// name are shared. True if either has no area or is not finite.
pub fn clash(corners: [[DVec3; 3]; 2], names: [[u32; 3]; 2]) -> bool {
    let [a, b] = [0, 1].map(|i| Solid::named(0, corners[i], names[i]));
    match (a, b) {
        (Some(a), Some(b)) => a.clashes(&b),
        _ => true,
    }
}

/// Pairs after which a mesh is bad enough.
pub const MOST_PAIRS: usize = 4_000_000;

/// Leaves of the tree between two looks at the number of pairs.
const BATCH: usize = 1024;

/// A triangle with area.
struct Solid {
    face: FaceId,
    corners: [DVec3; 3],
    /// Numbers by which equal places are equal.
    places: [u32; 3],
    /// Coordinate to drop so that the shadow keeps an area.
    drop: usize,
}

impl Solid {
    fn new(face: usize, indices: &[u32; 3], positions: &[DVec3], place: &[u32]) -> Option<Solid> {
        let mut corners = [DVec3::ZERO; 3];
        let mut places = [0; 3];
        for (k, &index) in indices.iter().enumerate() {
            corners[k] = *positions.get(index as usize)?;
            places[k] = place[index as usize];
        }
        Solid::named(face, corners, places)
    }

    fn named(face: usize, corners: [DVec3; 3], places: [u32; 3]) -> Option<Solid> {
        if !corners.iter().all(|corner| corner.is_finite()) {
            return None;
        }
        let [a, b, c] = corners;
        let area = [0, 1, 2].map(|drop| turn(a, b, c, drop).abs());
        let drop = (0..3).max_by(|&i, &j| area[i].total_cmp(&area[j]))?;
        (area[drop] > 0.0).then_some(Solid {
            face: FaceId(face as u32),
            corners,
            places,
            drop,
        })
    }

    fn bounds(&self) -> Box3 {
        let [a, b, c] = self.corners;
        Box3 {
            low: a.min(b).min(c),
            high: a.max(b).max(c),
        }
    }

    /// Side of the triangle's plane: the sign alone is exact.
    fn side(&self, p: DVec3) -> f64 {
        let [a, b, c] = self.corners;
        volume(a, b, c, p)
    }

    /// Whether a point of the triangle's plane lies in the triangle.
    fn holds(&self, p: DVec3) -> bool {
        let [a, b, c] = self.corners;
        same_sense([
            turn(a, b, p, self.drop),
            turn(b, c, p, self.drop),
            turn(c, a, p, self.drop),
        ])
    }

    /// Whether a segment meets the triangle; `p` and `q` differ.
    fn meets(&self, p: DVec3, q: DVec3) -> bool {
        let (at_p, at_q) = (self.side(p), self.side(q));
        if (at_p > 0.0 && at_q > 0.0) || (at_p < 0.0 && at_q < 0.0) {
            return false;
        }
        let [a, b, c] = self.corners;
        if at_p == 0.0 && at_q == 0.0 {
            return self.holds(p)
                || self.holds(q)
                || [(a, b), (b, c), (c, a)]
                    .iter()
                    .any(|&(a, b)| cross(a, b, p, q, self.drop));
        }
        same_sense([volume(p, q, a, b), volume(p, q, b, c), volume(p, q, c, a)])
    }

    /// Whether the two have a point in common beyond what they share.
    fn clashes(&self, other: &Solid) -> bool {
        let own = self.shared(other);
        !parted(self.corners, other.corners, own) && self.clashes_exactly(other, own)
    }

    /// The corner of the other that is each corner of this one.
    fn shared(&self, other: &Solid) -> [Option<usize>; 3] {
        (self.places).map(|place| other.places.iter().position(|&p| p == place))
    }

    /// The same by exact signs alone.
    fn clashes_exactly(&self, other: &Solid, own: [Option<usize>; 3]) -> bool {
        let shared = own.iter().flatten().count();
        let lone =
            |solid: &Solid, used: [bool; 3]| (0..3).find(|&k| !used[k]).map(|k| solid.corners[k]);
        let mut taken = [false; 3];
        own.iter().flatten().for_each(|&k| taken[k] = true);
        match shared {
            0 => {
                let edges = |s: &Solid| {
                    let [a, b, c] = s.corners;
                    [(a, b), (b, c), (c, a)]
                };
                // Both wholly on one side of the other's plane: far apart.
                one_sided(other.corners.map(|p| self.side(p)))
                    .then_some(false)
                    .or_else(|| one_sided(self.corners.map(|p| other.side(p))).then_some(false))
                    .unwrap_or_else(|| {
                        edges(self).iter().any(|&(p, q)| other.meets(p, q))
                            || edges(other).iter().any(|&(p, q)| self.meets(p, q))
                    })
            }
            1 => {
                // The shared corner, and from it the two other corners of each.
                let k = own.iter().position(Option::is_some).unwrap_or(0);
                let j = own[k].unwrap_or(0);
                let (p, q) = (self.corners[(k + 1) % 3], self.corners[(k + 2) % 3]);
                let (r, s) = (other.corners[(j + 1) % 3], other.corners[(j + 2) % 3]);
                other.meets(p, q) || self.meets(r, s)
            }
            2 => {
                let (Some(c), Some(d)) = (lone(self, own.map(|k| k.is_some())), lone(other, taken))
                else {
                    return true;
                };
                if self.side(d) != 0.0 {
                    return false;
                }
                let k = own.iter().position(Option::is_none).unwrap_or(0);
                let (a, b) = (self.corners[(k + 1) % 3], self.corners[(k + 2) % 3]);
                (turn(a, b, c, self.drop) > 0.0) == (turn(a, b, d, self.drop) > 0.0)
            }
            _ => true,
        }
    }
}

/// Whether three signed measures are of one sense, zeros allowed.
fn same_sense(measures: [f64; 3]) -> bool {
    measures.iter().all(|&m| m >= 0.0) || measures.iter().all(|&m| m <= 0.0)
}

/// Whether all three lie strictly on one side.
fn one_sided(sides: [f64; 3]) -> bool {
    sides.iter().all(|&s| s > 0.0) || sides.iter().all(|&s| s < 0.0)
}

/// Signed volume of a tetrahedron; the sign is exact.
fn volume(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    let [a, b, c, d] = [a, b, c, d].map(|p| Coord3D {
        x: p.x,
        y: p.y,
        z: p.z,
    });
    robust::orient3d(a, b, c, d)
}

/// Signed area of a triangle's shadow; the sign is exact.
fn turn(a: DVec3, b: DVec3, c: DVec3, drop: usize) -> f64 {
    let (x, y) = ((drop + 1) % 3, (drop + 2) % 3);
    let [a, b, c] = [a, b, c].map(|p| Coord { x: p[x], y: p[y] });
    robust::orient2d(a, b, c)
}

/// Whether two segments of one plane meet strictly inside each other's span
/// or at an end; called after the ends were tried against the triangle, so
/// segments of one line need no care.
fn cross(a: DVec3, b: DVec3, p: DVec3, q: DVec3, drop: usize) -> bool {
    let opposite = |s: f64, t: f64| (s >= 0.0 && t <= 0.0) || (s <= 0.0 && t >= 0.0);
    let (s, t) = (turn(p, q, a, drop), turn(p, q, b, drop));
    if s == 0.0 && t == 0.0 {
        // On one line: the segment covers the edge, or an end of it is held.
        let x = (drop + 1) % 3;
        let y = (drop + 2) % 3;
        let inside = |v: f64, e: f64, f: f64| e.min(f) <= v && v <= e.max(f);
        return inside(a[x], p[x], q[x]) && inside(a[y], p[y], q[y]);
    }
    opposite(s, t) && opposite(turn(a, b, p, drop), turn(a, b, q, drop))
}

/// An axis-parallel box.
#[derive(Clone, Copy)]
struct Box3 {
    low: DVec3,
    high: DVec3,
}

impl Box3 {
    const EMPTY: Box3 = Box3 {
        low: DVec3::INFINITY,
        high: DVec3::NEG_INFINITY,
    };

    fn with(self, other: Box3) -> Box3 {
        Box3 {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    fn touches(&self, other: &Box3) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }

    fn middle(&self) -> DVec3 {
        0.5 * self.low + 0.5 * self.high
    }

    /// Place along a curve that keeps neighbours together: the bits of three
    /// 21-bit coordinates, interleaved.
    fn morton(&self, p: DVec3) -> u64 {
        let size = (self.high - self.low).max_element();
        let unit = (p - self.low) / if size > 0.0 { size } else { 1.0 };
        let spread = |value: f64| {
            // Saturates, and NaN becomes 0.
            let mut bits = (value * 2_097_151.0) as u64 & 0x1f_ffff;
            for (shift, mask) in [
                (32, 0x001f_0000_0000_ffff),
                (16, 0x001f_0000_ff00_00ff),
                (8, 0x100f_00f0_0f00_f00f),
                (4, 0x10c3_0c30_c30c_30c3),
                (2, 0x1249_2492_4924_9249),
            ] {
                bits = (bits | bits << shift) & mask;
            }
            bits
        };
        spread(unit.x) | spread(unit.y) << 1 | spread(unit.z) << 2
    }
}

/// Boxes over runs of the sorted triangles: level 0 holds one box a leaf, each
/// further level one box for `FANOUT` of the level below, up to a single one.
struct Tree {
    levels: Vec<Vec<Box3>>,
}

impl Tree {
    fn new(solids: &[Solid]) -> Tree {
        let merge = |boxes: &[Box3]| boxes.iter().fold(Box3::EMPTY, |all, &b| all.with(b));
        let leaf = |solids: &[Solid]| {
            solids
                .iter()
                .fold(Box3::EMPTY, |all, solid| all.with(solid.bounds()))
        };
        let mut levels: Vec<Vec<Box3>> = vec![solids.par_chunks(LEAF).map(leaf).collect()];
        while let Some(last) = levels.last()
            && last.len() > 1
        {
            let next = last.chunks(FANOUT).map(merge).collect();
            levels.push(next);
        }
        Tree { levels }
    }

    /// Clashes between the triangles of a leaf and those of it and later ones.
    fn pairs_of(&self, leaf: usize, solids: &[Solid]) -> Vec<(FaceId, FaceId)> {
        let mut found = Vec::new();
        let bounds = self.levels[0][leaf];
        let own = &solids[leaf * LEAF..solids.len().min((leaf + 1) * LEAF)];
        let own_boxes: Vec<Box3> = own.iter().map(Solid::bounds).collect();
        let mut stack = vec![(self.levels.len() - 1, 0_usize)];
        while let Some((level, node)) = stack.pop() {
            // Leaves under a node end before (node + 1) * FANOUT^level.
            let reach = (node + 1).saturating_mul(FANOUT.saturating_pow(level as u32));
            if reach <= leaf || !self.levels[level][node].touches(&bounds) {
                continue;
            }
            if level > 0 {
                let below = self.levels[level - 1].len();
                let children = node * FANOUT..below.min((node + 1) * FANOUT);
                stack.extend(children.map(|child| (level - 1, child)));
                continue;
            }
            let first = node * LEAF;
            let theirs = &solids[first..solids.len().min(first + LEAF)];
            for (j, other) in theirs.iter().enumerate() {
                let other_box = other.bounds();
                if !other_box.touches(&bounds) {
                    continue;
                }
                // Within the leaf itself each pair once.
                let before = if node == leaf { j } else { own.len() };
                for (solid, own_box) in own[..before].iter().zip(&own_boxes) {
                    if own_box.touches(&other_box) && solid.clashes(other) {
                        let (a, b) = (solid.face, other.face);
                        found.push((a.min(b), a.max(b)));
                    }
                }
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn mesh(points: &[[f64; 3]], triangles: &[[u32; 3]]) -> TriMesh {
        TriMesh {
            positions: points.iter().map(|&p| p.into()).collect(),
            triangles: triangles.to_vec(),
        }
    }

    /// Whether two triangles over a list of points clash, in every order of
    /// their corners and of themselves, and in all six orders of the axes.
    fn check(points: &[[f64; 3]], first: [u32; 3], second: [u32; 3], expected: bool) {
        let turns = |t: [u32; 3]| {
            let [a, b, c] = t;
            [
                [a, b, c],
                [b, c, a],
                [c, a, b],
                [a, c, b],
                [c, b, a],
                [b, a, c],
            ]
        };
        for axes in [
            [0, 1, 2],
            [1, 2, 0],
            [2, 0, 1],
            [1, 0, 2],
            [0, 2, 1],
            [2, 1, 0],
        ] {
            let points: Vec<[f64; 3]> = points.iter().map(|p| axes.map(|k| p[k])).collect();
            for one in turns(first) {
                for other in turns(second) {
                    for pair in [[one, other], [other, one]] {
                        let found = self_intersections(&mesh(&points, &pair));
                        assert_eq!(!found.is_empty(), expected, "{points:?} {pair:?}");
                    }
                }
            }
        }
    }

    const FLAT: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];

    /// The flat triangle against a second one of its own corners.
    fn apart(second: [[f64; 3]; 3], expected: bool) {
        let points = [FLAT, second].concat();
        check(&points, [0, 1, 2], [3, 4, 5], expected);
    }

    #[test]
    fn apart_through_and_touching() {
        apart([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [9.0, 9.0, 0.0]], true);
        apart([[9.0, 9.0, -1.0], [9.0, 9.0, 1.0], [8.0, 9.0, 0.0]], false);
        apart([[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [2.0, 1.0, 1.0]], true);
        apart(
            [[1.0, 1.0, 1e-300], [1.0, 1.0, 1.0], [2.0, 1.0, 1.0]],
            false,
        );
        // A corner on an edge; an edge across an edge.
        apart([[2.0, 0.0, 0.0], [2.0, -1.0, 1.0], [3.0, -1.0, 1.0]], true);
        apart([[2.0, 0.0, -1.0], [2.0, 0.0, 1.0], [2.0, -3.0, 0.0]], true);
        // In one plane: overlap, inside, around, touching, apart.
        apart([[1.0, 1.0, 0.0], [5.0, 1.0, 0.0], [1.0, 5.0, 0.0]], true);
        apart([[1.0, 1.0, 0.0], [2.0, 1.0, 0.0], [1.0, 2.0, 0.0]], true);
        apart(
            [[-9.0, -9.0, 0.0], [40.0, -9.0, 0.0], [-9.0, 40.0, 0.0]],
            true,
        );
        apart([[2.0, 2.0, 0.0], [3.0, 3.0, 0.0], [2.0, 3.0, 0.0]], true);
        apart([[3.0, 3.0, 0.0], [4.0, 4.0, 0.0], [3.0, 4.0, 0.0]], false);
        apart([[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, -3.0, 0.0]], true);
        apart([[-1.0, 0.0, 0.0], [5.0, 0.0, 0.0], [1.0, -3.0, 0.0]], true);
        apart([[5.0, 0.0, 0.0], [7.0, 0.0, 0.0], [6.0, -3.0, 0.0]], false);
        // Without area.
        apart([[1.0, 1.0, -1.0], [1.0, 1.0, 0.0], [1.0, 1.0, 1.0]], false);
    }

    #[test]
    fn one_shared_corner() {
        let with = |p: [f64; 3], q: [f64; 3], expected| {
            let points = [&FLAT[..], &[p, q]].concat();
            check(&points, [0, 1, 2], [0, 3, 4], expected);
        };
        with([1.0, 1.0, 1.0], [1.0, 1.0, -1.0], true);
        with([9.0, 9.0, 1.0], [9.0, 9.0, -1.0], true);
        with([-1.0, 1.0, 1.0], [-1.0, 1.0, -1.0], false);
        with([1.0, 1.0, 1.0], [2.0, 1.0, 1.0], false);
        // In one plane: beside, within, across, along an edge.
        with([-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], false);
        with([1.0, 2.0, 0.0], [2.0, 1.0, 0.0], true);
        with([9.0, 1.0, 0.0], [9.0, -9.0, 0.0], true);
        with([2.0, 0.0, 0.0], [2.0, -1.0, 0.0], true);
        with([2.0, 0.0, 0.0], [2.0, -1.0, 5.0], true);
    }

    #[test]
    fn a_shared_edge_or_all() {
        let with = |p: [f64; 3], expected| {
            let points = [&FLAT[..], &[p]].concat();
            check(&points, [0, 1, 2], [1, 0, 3], expected);
        };
        with([1.0, -1.0, 0.0], false);
        with([1.0, 1.0, 0.0], true);
        with([1.0, 1.0, 1e-300], false);
        check(&FLAT, [0, 1, 2], [0, 2, 1], true);
    }

    #[test]
    fn equal_places_are_shared_whatever_their_index() {
        let points = [FLAT, [FLAT[1], FLAT[0], [1.0, -1.0, 3.0]]].concat();
        check(&points, [0, 1, 2], [3, 4, 5], false);
    }

    #[test]
    fn broken_triangles_are_passed_over() {
        let mut bad = mesh(&FLAT, &[[0, 1, 2], [0, 1, 7], [0, 0, 1], [0, 1, 3]]);
        bad.positions.push(DVec3::NAN);
        assert!(self_intersections(&bad).is_empty());
        assert!(self_intersections(&TriMesh::default()).is_empty());
    }

    proptest! {
        /// Small whole coordinates, so that every kind of contact occurs; the
        /// tree against all pairs.
        #[test]
        fn the_tree_finds_what_all_pairs_give(
            points in prop::collection::vec([0..5i8, 0..5, 0..5], 12),
            triangles in prop::collection::vec([0..12u32, 0..12, 0..12], 2..60),
        ) {
            let mesh = TriMesh {
                positions: points.iter().map(|p| p.map(f64::from).into()).collect(),
                triangles,
            };
            let place = weld_exact(&mesh.positions).new_index;
            let solids: Vec<Solid> = (0..mesh.triangles.len())
                .filter_map(|f| Solid::new(f, &mesh.triangles[f], &mesh.positions, &place))
                .collect();
            let mut expected = Vec::new();
            for (k, a) in solids.iter().enumerate() {
                for b in &solids[k + 1..] {
                    let exactly = a.clashes_exactly(b, a.shared(b));
                    prop_assert_eq!(a.clashes(b), exactly);
                    prop_assert_eq!(b.clashes(a), exactly);
                    if exactly {
                        expected.push((a.face, b.face));
                    }
                }
            }
            prop_assert_eq!(self_intersections(&mesh), expected);
        }
    }
}
