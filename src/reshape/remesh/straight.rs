//! Straight junctions: each wall's mid-surface carried on to where it meets the
//! others.
//!
//! Beside a seam or bend the medial sheet dips out of the middle of its wall,
//! and a web ends half its width before the end of its rib. Where a sheet is
//! undisturbed its footpoints lie opposite each other; its tangent plane at the
//! nearest such vertex is carried on to every disturbed one. Vertices inside a
//! patch go onto that plane, those of lines onto the planes of all patches that
//! meet there: least squares, the shortest way. A border that fades between a
//! coping face and the end of a seam goes onto the plane of the coping face, so
//! that a web goes straight down to its flange.

use glam::DVec3;
use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use rustc_hash::FxHashMap;
use smallvec::SmallVec;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::Remesher;
use crate::mesh::FaceId;
use crate::reshape::complex::Rank;
use crate::surface::Ball;
use crate::surface::marked::{Line, MarkedVertex};

/// Object angles within this of the greatest usual of their patch are
/// undisturbed, degrees.
const PLAIN: f64 = 4.0;

/// How far from a line the sheets of a junction may be disturbed, along them: in
/// distances of the walls there. Farther on a wall is what it is, also where
/// chords of round walls do not lie opposite each other.
const REACH: f64 = 3.0;

/// Planes whose normals lean less count as one when they are intersected: the
/// square of the sine of ten degrees.
const ONE_PLANE: f64 = 0.03;

/// No vertex moves farther than this many wall thicknesses.
const FARTHEST: f64 = 1.5;

/// A fading border longer than this many wall thicknesses is no rib's end.
const RIB_END: f64 = 2.0;

/// A coping plane counts for this many walls: ends stay on it.
const ON_COPING: f64 = 100.0;

/// Steps in which vertices go to their places, the rest of the mesh giving way.
const STEPS: usize = 6;

/// On the way no angle falls below one with this sine, 15 degrees.
const LEAST: f64 = 0.26;

/// A wall's mid-surface near a vertex, carried on from where it is undisturbed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Support {
    pub(super) normal: DVec3,
    pub(super) through: DVec3,
    thickness: f64,
    /// Whether it is the vertex's own, not carried on from another.
    own: bool,
}

impl Support {
    /// The point of the plane nearest to `p`.
    pub(super) fn onto(&self, p: DVec3) -> DVec3 {
        p - self.normal * self.normal.dot(p - self.through)
    }
}

/// A vertex as a corner of one patch.
type Corner = (u32, u32);

/// Patches: pieces of sheets between lines.
struct Patches {
    /// Corners in the order in which triangles name them.
    corners: Vec<Corner>,
    /// Their neighbours in the patch, with lengths.
    beside: Vec<SmallVec<[(u32, f64); 8]>>,
    /// Number of patches.
    count: u32,
}

impl Patches {
    /// For each corner the nearest of those that begin with a distance, along edges; none
    /// where all are `reach` away or farther.
    fn nearest(&self, begin: &[Option<f64>], reach: f64) -> Vec<Option<u32>> {
        let mut nearest = vec![None; begin.len()];
        let mut distance = vec![reach; begin.len()];
        let mut queue: BinaryHeap<(Reverse<u64>, Reverse<u32>)> = BinaryHeap::new();
        for (n, begin) in (0..).zip(begin) {
            if let Some(begin) = *begin {
                nearest[n as usize] = Some(n);
                distance[n as usize] = begin;
                queue.push((Reverse(begin.to_bits()), Reverse(n)));
            }
        }
        while let Some((Reverse(bits), Reverse(n))) = queue.pop() {
            let here = f64::from_bits(bits);
            if here > distance[n as usize] {
                continue;
            }
            for &(m, way) in &self.beside[n as usize] {
                if here + way < distance[m as usize] {
                    distance[m as usize] = here + way;
                    nearest[m as usize] = nearest[n as usize];
                    queue.push((Reverse((here + way).to_bits()), Reverse(m)));
                }
            }
        }
        nearest
    }
}

impl Remesher<'_> {
    /// Moves disturbed vertices onto the mid-surfaces of their walls, the rest of
    /// the mesh giving way.
    pub(super) fn straighten(&mut self, give_way: &dyn Fn(&mut Self)) {
        let patches = self.patches();
        let disturbed = self.disturbed(&patches);
        let supports = self.supports(&patches, &disturbed);
        let mut reached = vec![false; self.vertices.len()];
        for (&(_, v), disturbed) in patches.corners.iter().zip(&disturbed) {
            reached[v as usize] |= disturbed;
        }
        let mut at_vertex: Vec<SmallVec<[Option<Support>; 3]>> =
            vec![SmallVec::new(); self.vertices.len()];
        for (&(_, v), support) in patches.corners.iter().zip(&supports) {
            at_vertex[v as usize].push(*support);
        }
        let ends = self.rib_ends(&at_vertex);
        for v in 0..self.vertices.len() as u32 {
            if !reached[v as usize] || self.kept.contains(self.complex.at(v)) {
                continue;
            }
            let here = &at_vertex[v as usize];
            let known: Option<SmallVec<[Support; 3]>> = here.iter().copied().collect();
            let Some(known) = known.filter(|k| !k.is_empty()) else {
                continue;
            };
            let copings: SmallVec<[FaceId; 2]> = (self.vertices[v as usize].coping.into_iter())
                .chain(ends.get(&v).copied())
                .collect();
            if let Some(to) = self.target(v, &known, &copings) {
                self.targets.push((v, to));
            }
            if known.iter().any(|s| !s.own) {
                self.straight[v as usize] = widest(&known);
                self.note_normal(v);
            }
        }
        self.frozen = true;
        // Ends of sheets leave the places where they were traced.
        for v in 0..self.vertices.len() as u32 {
            if self.complex.rank(v) == Rank::Line {
                self.note_normal(v);
            }
        }
        for step in 0..STEPS {
            self.approach(1.0 / (STEPS - step) as f64);
            give_way(self);
        }
    }

    /// Moves disturbed vertices a share of the way that is left to their places,
    /// where that leaves good triangles.
    pub(super) fn approach(&mut self, share: f64) {
        for n in 0..self.targets.len() {
            let (v, to) = self.targets[n];
            let here = self.complex.at(v);
            if here == to || self.complex.around(v).is_empty() {
                continue;
            }
            let at = here.lerp(to, share);
            let old = self.complex.worst_around(v);
            let fits = self.complex.moved(v, at);
            if fits.is_some_and(|sine| sine >= old.min(LEAST)) {
                let moved = self.vertices[v as usize].clone();
                self.settle(v, MarkedVertex { at, ..moved }, false);
            }
        }
    }

    /// Patches and which vertices are next to each other in them.
    fn patches(&self) -> Patches {
        const NONE: u32 = u32::MAX;
        let count = self.complex.triangle_count();
        let mut patch = vec![NONE; count];
        let mut patches = Patches {
            corners: Vec::new(),
            beside: Vec::new(),
            count: 0,
        };
        for seed in 0..count as u32 {
            if patch[seed as usize] != NONE || self.complex.corners(seed).is_none() {
                continue;
            }
            let number = patches.count;
            patches.count += 1;
            patch[seed as usize] = number;
            let mut open = vec![seed];
            while let Some(t) = open.pop() {
                let Some(c) = self.complex.corners(t) else {
                    continue;
                };
                for k in 0..3 {
                    let wings = self.complex.wings(c[k], c[(k + 1) % 3]);
                    for (s, _) in wings.into_iter().flatten() {
                        if patch[s as usize] == NONE {
                            patch[s as usize] = number;
                            open.push(s);
                        }
                    }
                }
            }
        }
        let mut number_of: FxHashMap<Corner, u32> = FxHashMap::default();
        for t in 0..count as u32 {
            let Some(c) = self.complex.corners(t) else {
                continue;
            };
            let numbers = c.map(|v| {
                let corner = (patch[t as usize], v);
                *number_of.entry(corner).or_insert_with(|| {
                    patches.corners.push(corner);
                    patches.beside.push(SmallVec::new());
                    patches.corners.len() as u32 - 1
                })
            });
            for k in 0..3 {
                let (a, b) = (k, (k + 1) % 3);
                let length = self.length(c[a], c[b]);
                patches.beside[numbers[a] as usize].push((numbers[b], length));
                patches.beside[numbers[b] as usize].push((numbers[a], length));
            }
        }
        patches
    }

    /// Object angle, degrees, thickness and normal at a vertex of one sheet.
    fn openness(&self, v: u32) -> Option<(f64, f64, DVec3)> {
        let vertex = &self.vertices[v as usize];
        let &[a, b] = vertex.walls.as_slice() else {
            return None;
        };
        let field = self.ground.walls()?.field();
        let [p, q] = [a, b].map(|f| field.footpoint_on(vertex.at, f).point);
        let angle = (p - vertex.at).angle_between(q - vertex.at).to_degrees();
        let normal = self.ground.normal(vertex);
        let known = angle.is_finite() && normal != DVec3::ZERO && !self.chord[v as usize];
        known.then_some((angle, p.distance(q), normal))
    }

    /// Whether each corner of a patch is within reach of a line where walls meet or
    /// bend, or a web fades.
    fn disturbed(&self, patches: &Patches) -> Vec<bool> {
        let mut radius = vec![0.0; self.vertices.len()];
        if let Some(walls) = self.ground.walls() {
            for ((a, b), class) in self.complex.line_edges() {
                if matches!(class.mark, None | Some(Line::CopingBorder)) {
                    continue;
                }
                for v in [a, b].map(|v| v as usize) {
                    if radius[v] == 0.0 {
                        radius[v] = walls.field().footpoint(self.vertices[v].at).distance;
                    }
                }
            }
        }
        // The widest first, the others as if they were farther.
        let most = REACH * radius.iter().copied().fold(0.0, f64::max);
        let begin = |&(_, v): &Corner| {
            let radius = radius[v as usize];
            (radius > 0.0).then_some(most - REACH * radius)
        };
        let begin: Vec<Option<f64>> = patches.corners.iter().map(begin).collect();
        let found = patches.nearest(&begin, most);
        found.iter().map(Option::is_some).collect()
    }

    /// For each corner of a patch that is disturbed, the plane of the nearest
    /// undisturbed one; an undisturbed corner has its own.
    fn supports(&self, patches: &Patches, disturbed: &[bool]) -> Vec<Option<Support>> {
        let open: Vec<Option<(f64, f64, DVec3)>> = patches
            .corners
            .iter()
            .map(|&(_, v)| self.openness(v))
            .collect();
        // The usual greatest angle of each patch.
        let mut angles: Vec<Vec<f64>> = vec![Vec::new(); patches.count as usize];
        for (&(patch, _), found) in patches.corners.iter().zip(&open) {
            angles[patch as usize].extend(found.map(|f| f.0));
        }
        let usual: Vec<f64> = (angles.into_iter())
            .map(|mut all| {
                all.sort_unstable_by(f64::total_cmp);
                all.get(all.len() * 9 / 10).copied().unwrap_or(180.0)
            })
            .collect();
        let own = |n: usize| {
            let (patch, v) = patches.corners[n];
            let (angle, thickness, normal) = open[n]?;
            let plain = angle >= usual[patch as usize] - PLAIN || !disturbed[n];
            plain.then(|| Support {
                normal,
                through: self.complex.at(v),
                thickness,
                own: true,
            })
        };
        let own: Vec<Option<Support>> = (0..patches.corners.len()).map(own).collect();
        let begin: Vec<Option<f64>> = own.iter().map(|s| s.map(|_| 0.0)).collect();
        let nearest = patches.nearest(&begin, f64::INFINITY);
        let carried = |(n, from): (usize, Option<u32>)| {
            let from = from? as usize;
            let own_here = from == n;
            own[from].map(|s| Support { own: own_here, ..s })
        };
        nearest.into_iter().enumerate().map(carried).collect()
    }

    /// Vertices of fading borders at the ends of ribs, with the coping face
    /// that each goes on.
    fn rib_ends(&self, supports: &[SmallVec<[Option<Support>; 3]>]) -> FxHashMap<u32, FaceId> {
        let mut ends = FxHashMap::default();
        let mut courses: FxHashMap<u32, (f64, Vec<u32>)> = FxHashMap::default();
        for ((a, b), class) in self.complex.line_edges() {
            if class.mark == Some(Line::FadingBorder)
                && let Some(line) = self.lines.of_edge(a, b)
            {
                let (length, on) = courses.entry(line).or_default();
                *length += self.length(a, b);
                on.extend([a, b]);
            }
        }
        let mut courses: Vec<(u32, (f64, Vec<u32>))> = courses.into_iter().collect();
        courses.sort_by_key(|c| c.0);
        for (_, (length, on)) in courses {
            let thickness = (on.iter())
                .flat_map(|&v| supports[v as usize].iter().flatten())
                .map(|s| s.thickness)
                .fold(0.0, f64::max);
            let mut copings = on.iter().filter_map(|&v| self.vertices[v as usize].coping);
            if let (Some(coping), true) = (copings.next(), length <= RIB_END * thickness) {
                for v in on {
                    ends.insert(v, coping);
                }
            }
        }
        ends
    }

    /// Where a vertex goes: onto its planes and coping faces by the shortest
    /// way; `None` if it is there.
    fn target(&self, v: u32, supports: &[Support], copings: &[FaceId]) -> Option<DVec3> {
        let at = self.complex.at(v);
        let field = self.ground.walls()?.field();
        let mut matrix = Matrix3::<f64>::zeros();
        let mut rest = Vector3::<f64>::zeros();
        let mut add = |normal: DVec3, through: DVec3, weight: f64| {
            let n = Vector3::from(normal.to_array());
            matrix += weight * n * n.transpose();
            rest += weight * normal.dot(through - at) * n;
        };
        for support in supports {
            add(support.normal, support.through, 1.0);
        }
        for &coping in copings {
            add(field.normal(coping), field.corners(coping)[0], ON_COPING);
        }
        let eigen = SymmetricEigen::new(matrix);
        let mut way = Vector3::zeros();
        for k in 0..3 {
            let value = eigen.eigenvalues[k];
            let axis = eigen.eigenvectors.column(k).into_owned();
            if value > ONE_PLANE {
                way += axis * (axis.dot(&rest) / value);
            }
        }
        let way = DVec3::new(way.x, way.y, way.z);
        let thickness = supports.iter().map(|s| s.thickness).fold(0.0, f64::max);
        let far = way.length();
        (far > 1e-9 * thickness && far <= FARTHEST * thickness).then_some(at + way)
    }

    /// The balls of vertices on straightened walls, by the numbers of the
    /// finished mesh: thickness is the wall's own.
    pub(super) fn straight_balls(&self) -> Vec<(u32, Ball)> {
        let mut number = 0..;
        let mut balls = Vec::new();
        for v in 0..self.vertices.len() as u32 {
            if self.complex.around(v).is_empty() {
                continue;
            }
            let Some(n) = number.next() else { break };
            if let Some(support) = self.straight[v as usize] {
                let (at, half) = (self.complex.at(v), 0.5 * support.thickness);
                let feet = [at - half * support.normal, at + half * support.normal];
                balls.push((n, Ball::touching(at, SmallVec::from(feet))));
            }
        }
        balls
    }

    /// Whether a vertex inside a patch moves in a plane carried on.
    pub(super) fn support_of(&self, v: u32) -> Option<&Support> {
        let inner = self.complex.rank(v) == Rank::Inner;
        self.straight[v as usize].as_ref().filter(|_| inner)
    }
}

/// The support of the thickest wall, the first of equals.
fn widest(supports: &[Support]) -> Option<Support> {
    (supports.iter().copied()).reduce(|a, b| if b.thickness > a.thickness { b } else { a })
}
