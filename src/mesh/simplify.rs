//! Fewer triangles where a closed mesh is flat or bends one way.
//!
//! Edges are collapsed, one vertex into another, so that all vertices are vertices
//! of the given mesh. What is kept:
//!
//! * closed and manifold: the link condition (Dey, Edelsbrunner, Guha and
//!   Nekhayev, "Topology preserving edge contraction", 1999);
//! * the tolerance: every triangle knows the vertices and the middles of triangles
//!   that it stands for, and is nowhere farther from one of them; so creases and
//!   corners stay;
//! * no triangles that cut each other: looked for exactly at the end. Where some
//!   do, nothing may collapse any more, and all begins again.

use glam::DVec3;
use rustc_hash::FxHashSet;
use smallvec::SmallVec;

use super::{FaceId, TriMesh, is_thin, self_intersections};

/// Least cosine between the normals of a triangle before and after.
const LEAST_TURN: f64 = 0.7;

/// Triangles lower than this, over their longest side, are not made, unless lower
/// ones go.
const NEEDLE: f64 = 1e-3;

/// Triangles lower than this have no normal to keep.
const FLAT: f64 = 1e-6;

/// Squares of distances below this, over that of the tolerance, are none.
const ON_IT: f64 = 1e-6;

/// Turns below this, as one less the cosine, are none.
const STRAIGHT: f64 = 1e-6;

/// A pass that takes less than this share of the triangles is the last.
const LEAST_GAIN: f64 = 1e-4;

/// Times that all begins again without the places that cut each other, before
/// the mesh is left as it is.
const ROUNDS: usize = 5;

/// Times that the tolerance doubles to reach a number of triangles.
const DOUBLINGS: usize = 24;

/// How far to go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Simplify {
    /// Greatest distance of the given mesh's vertices and middles of triangles
    /// from the result, part units.
    pub tolerance: f64,
    /// Number of triangles at which to stop. The tolerance grows until it is
    /// reached.
    pub triangles: Option<usize>,
}

/// A mesh with fewer triangles.
#[derive(Clone, Debug)]
pub struct Simplified {
    /// Closed and manifold, cutting itself nowhere, as the given one.
    pub mesh: TriMesh,
    /// The tolerance that was used.
    pub tolerance: f64,
}

/// Simplifies a closed manifold mesh that cuts itself nowhere.
///
/// Deterministic. Where the guarantee cannot be had the mesh comes back as it
/// was.
pub fn simplify(mesh: &TriMesh, how: &Simplify) -> Simplified {
    simplify_beside(mesh, 0, how)
}

/// As [`simplify`], but the first `kept` triangles stay as they are, the first in
/// the result.
pub fn simplify_beside(mesh: &TriMesh, kept: usize, how: &Simplify) -> Simplified {
    let mut locked = vec![false; mesh.positions.len()];
    for &v in mesh.triangles.iter().take(kept).flatten() {
        locked[v as usize] = true;
    }
    for _ in 0..ROUNDS {
        let mut work = Work::new(mesh, &locked);
        let tolerance = work.run(how);
        let (result, faces) = work.result();
        let pairs = self_intersections(&result);
        if pairs.is_empty() {
            return Simplified {
                mesh: result,
                tolerance,
            };
        }
        for face in pairs.iter().flat_map(|&(f, g)| [f, g]) {
            work.lock(faces[face.index()], &mut locked);
        }
    }
    Simplified {
        mesh: mesh.clone(),
        tolerance: 0.0,
    }
}

/// Triangles with their corners after a collapse.
type Moved = SmallVec<[(u32, [u32; 3]); 8]>;

/// A collapse that may be.
struct Way {
    into: u32,
    /// Greatest turn of a triangle, as one less its cosine.
    bend: f64,
    /// Height over the longest side of the worst triangle.
    shape: f64,
    moved: Moved,
}

/// Corners of a triangle that is gone.
const GONE: [u32; 3] = [u32::MAX; 3];

struct Work<'m> {
    mesh: &'m TriMesh,
    locked: Vec<bool>,
    triangles: Vec<[u32; 3]>,
    count: usize,
    /// Triangles of each vertex.
    around: Vec<SmallVec<[u32; 8]>>,
    /// What each triangle stands for: vertices, and after them triangles by their
    /// middle.
    stands_for: Vec<Vec<u32>>,
    /// Vertices around which nothing has changed since they could not be
    /// collapsed.
    settled: Vec<bool>,
}

impl Work<'_> {
    fn new<'m>(mesh: &'m TriMesh, locked: &[bool]) -> Work<'m> {
        let vertices = mesh.positions.len();
        let mut around: Vec<SmallVec<[u32; 8]>> = vec![SmallVec::new(); vertices];
        for (t, corners) in (0..).zip(&mesh.triangles) {
            for &v in corners {
                around[v as usize].push(t);
            }
        }
        let middles = vertices as u32..(vertices + mesh.triangles.len()) as u32;
        Work {
            mesh,
            locked: locked.to_vec(),
            triangles: mesh.triangles.clone(),
            count: mesh.triangles.len(),
            around,
            stands_for: middles.map(|middle| vec![middle]).collect(),
            settled: vec![false; vertices],
        }
    }

    /// Collapses all that may; the tolerance in the end.
    fn run(&mut self, how: &Simplify) -> f64 {
        let wanted = how.triangles.unwrap_or(0);
        let mut tolerance = how.tolerance;
        for _ in 0..DOUBLINGS {
            loop {
                let before = self.count;
                self.pass(tolerance, wanted);
                let gained = (before - self.count) as f64;
                if gained <= LEAST_GAIN * before as f64 || self.count <= wanted {
                    break;
                }
            }
            if how.triangles.is_none() || self.count <= wanted {
                break;
            }
            tolerance *= 2.0;
            self.settled.fill(false);
        }
        tolerance
    }

    /// Tries every vertex once, those beside a collapse excepted: so triangles
    /// grow evenly.
    fn pass(&mut self, tolerance: f64, wanted: usize) {
        let mut touched = vec![false; self.around.len()];
        for u in 0..self.around.len() as u32 {
            if self.count <= wanted {
                return;
            }
            let at = u as usize;
            let idle = touched[at] || self.locked[at] || self.settled[at];
            if idle || self.around[at].is_empty() {
                continue;
            }
            match self.collapse(u, tolerance) {
                Some(v) => {
                    for w in self.star(v) {
                        touched[w as usize] = true;
                    }
                }
                None => self.settled[at] = true,
            }
        }
    }

    /// A vertex and its neighbours, some of them twice.
    fn star(&self, v: u32) -> impl Iterator<Item = u32> + '_ {
        let around = &self.around[v as usize];
        around.iter().flat_map(|&t| self.triangles[t as usize])
    }

    fn at(&self, v: u32) -> DVec3 {
        self.mesh.positions[v as usize]
    }

    fn corners(&self, t: [u32; 3]) -> [DVec3; 3] {
        t.map(|v| self.at(v))
    }

    fn neighbours(&self, u: u32) -> SmallVec<[u32; 8]> {
        let mut ring: SmallVec<[u32; 8]> = self.around[u as usize]
            .iter()
            .flat_map(|&t| self.triangles[t as usize])
            .filter(|&v| v != u)
            .collect();
        ring.sort_unstable();
        ring.dedup();
        ring
    }

    /// Whether a collapse of `u` into its neighbour `v` leaves a manifold.
    fn keeps_manifold(&self, u: u32, v: u32) -> bool {
        let (ring, theirs) = (self.neighbours(u), self.neighbours(v));
        let mut shared = ring.iter().filter(|w| theirs.binary_search(w).is_ok());
        let room = |w: &u32| self.around[*w as usize].len() > 3;
        let two = [shared.next(), shared.next()];
        shared.next().is_none() && two.into_iter().all(|w| w.is_some_and(room))
    }

    /// A collapse of `u` into `v`; none where triangles would turn over, or be
    /// lower than `least` over their longest side.
    fn way(&self, u: u32, v: u32, least: f64) -> Option<Way> {
        let mut way = Way {
            into: v,
            bend: 0.0,
            shape: f64::INFINITY,
            moved: Moved::new(),
        };
        for &t in &self.around[u as usize] {
            let before = self.triangles[t as usize];
            if before.contains(&v) {
                continue;
            }
            let after = before.map(|w| if w == u { v } else { w });
            let normal = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
            let [m, n] = [before, after].map(|t| normal(self.corners(t)));
            // The normal of a needle says nothing.
            if !is_thin(self.corners(before), FLAT) {
                let turn = m.dot(n) / (m.length() * n.length());
                if turn <= LEAST_TURN {
                    return None;
                }
                way.bend = way.bend.max(1.0 - turn);
            }
            let shape = shape(self.corners(after));
            if shape <= least {
                return None;
            }
            way.shape = way.shape.min(shape);
            way.moved.push((t, after));
        }
        if way.bend < STRAIGHT {
            way.bend = 0.0;
        }
        Some(way)
    }

    /// Collapses `u` into the neighbour that turns the triangles least, and of
    /// those that leave them as they were into the one that leaves the best
    /// ones. So ruled regions get triangles along their rulings.
    fn collapse(&mut self, u: u32, tolerance: f64) -> Option<u32> {
        let ring = self.neighbours(u);
        let around = self.around[u as usize].iter();
        let shapes = around.map(|&t| shape(self.corners(self.triangles[t as usize])));
        let least = shapes.fold(NEEDLE, f64::min);
        let ways = ring.iter().filter_map(|&v| self.way(u, v, least));
        let mut ways: SmallVec<[Way; 8]> = ways.collect();
        ways.sort_by(|a, b| {
            let bend = a.bend.total_cmp(&b.bend);
            let shape = b.shape.total_cmp(&a.shape);
            bend.then(shape).then(a.into.cmp(&b.into))
        });
        let mut points: Vec<u32> = vec![u];
        let stands_for = |t: &u32| &self.stands_for[*t as usize];
        points.extend(self.around[u as usize].iter().flat_map(stands_for));
        for way in ways {
            if self.keeps_manifold(u, way.into)
                && let Some(shares) = self.shares(&points, &way.moved, tolerance)
            {
                self.apply(u, &way, shares);
                return Some(way.into);
            }
        }
        None
    }

    /// What each of the moved triangles stands for; none if a point is too far
    /// from all.
    fn shares(
        &self,
        points: &[u32],
        moved: &[(u32, [u32; 3])],
        tolerance: f64,
    ) -> Option<Vec<Vec<u32>>> {
        let facets = moved.iter().map(|m| Facet::new(self.corners(m.1)));
        let facets: SmallVec<[Facet; 8]> = facets.collect();
        let most = tolerance * tolerance;
        let mut shares = vec![Vec::new(); moved.len()];
        // Points that follow each other mostly belong to one triangle.
        let mut last = 0;
        for &point in points {
            let p = self.point(point);
            let mut nearest = (f64::INFINITY, last);
            for k in (last..facets.len()).chain(0..last) {
                let square = facets[k].distance_squared(p);
                if square < nearest.0 {
                    nearest = (square, k);
                }
                if square <= ON_IT * most {
                    break;
                }
            }
            if nearest.0 > most {
                return None;
            }
            last = nearest.1;
            shares[last].push(point);
        }
        Some(shares)
    }

    fn point(&self, name: u32) -> DVec3 {
        let vertices = self.mesh.positions.len();
        match (name as usize).checked_sub(vertices) {
            None => self.mesh.positions[name as usize],
            Some(face) => self.mesh.corners(FaceId(face as u32)).iter().sum::<DVec3>() / 3.0,
        }
    }

    fn apply(&mut self, u: u32, way: &Way, shares: Vec<Vec<u32>>) {
        let v = way.into;
        let star = std::mem::take(&mut self.around[u as usize]);
        for &t in &star {
            if self.triangles[t as usize].contains(&v) {
                for w in self.triangles[t as usize] {
                    self.around[w as usize].retain(|&mut other| other != t);
                }
                self.triangles[t as usize] = GONE;
                self.stands_for[t as usize] = Vec::new();
                self.count -= 1;
            }
        }
        for (&(t, after), share) in way.moved.iter().zip(shares) {
            self.triangles[t as usize] = after;
            self.stands_for[t as usize] = share;
            self.around[v as usize].push(t);
        }
        // What depends on the triangles around `v`: all that share one with them.
        let near: SmallVec<[u32; 16]> = self.star(v).collect();
        for w in near {
            self.settled[w as usize] = false;
            for &t in &self.around[w as usize] {
                for x in self.triangles[t as usize] {
                    self.settled[x as usize] = false;
                }
            }
        }
    }

    /// The mesh, and which triangle each of its own is.
    fn result(&self) -> (TriMesh, Vec<usize>) {
        let alive = |&t: &usize| self.triangles[t] != GONE;
        let faces: Vec<usize> = (0..self.triangles.len()).filter(alive).collect();
        let mut number = vec![u32::MAX; self.mesh.positions.len()];
        for &v in faces.iter().flat_map(|&t| &self.triangles[t]) {
            number[v as usize] = 0;
        }
        let mut positions = Vec::new();
        for (slot, &p) in number.iter_mut().zip(&self.mesh.positions) {
            if *slot == 0 {
                *slot = positions.len() as u32;
                positions.push(p);
            }
        }
        let rename = |&t: &usize| self.triangles[t].map(|v| number[v as usize]);
        let mesh = TriMesh {
            positions,
            triangles: faces.iter().map(rename).collect(),
        };
        (mesh, faces)
    }

    /// Forbids to collapse what a triangle stands for.
    fn lock(&self, t: usize, locked: &mut [bool]) {
        let vertices = self.mesh.positions.len();
        let mut all: FxHashSet<u32> = self.triangles[t].into_iter().collect();
        for &name in &self.stands_for[t] {
            if let Some(face) = (name as usize).checked_sub(vertices) {
                all.extend(self.mesh.triangles[face]);
            } else {
                all.insert(name);
            }
        }
        for v in all {
            locked[v as usize] = true;
        }
    }
}

/// Height over the longest side.
fn shape([a, b, c]: [DVec3; 3]) -> f64 {
    (b - a).cross(c - a).length() / longest_squared([a, b, c])
}

fn longest_squared([a, b, c]: [DVec3; 3]) -> f64 {
    let sides = [(a, b), (b, c), (c, a)].map(|(p, q)| p.distance_squared(q));
    sides[0].max(sides[1]).max(sides[2])
}

/// A triangle with area, for distances to many points.
struct Facet {
    corners: [DVec3; 3],
    normal: DVec3,
    /// Of each side from its corner on: its direction, and the one across, out of
    /// the triangle.
    sides: [[DVec3; 2]; 3],
}

impl Facet {
    fn new(corners: [DVec3; 3]) -> Facet {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let sides = [b - a, c - b, a - c].map(|way| [way, way.cross(normal)]);
        Facet {
            corners,
            normal,
            sides,
        }
    }

    fn distance_squared(&self, p: DVec3) -> f64 {
        let from = self.corners.map(|corner| p - corner);
        let beyond = [0, 1, 2].map(|k| from[k].dot(self.sides[k][1]) > 0.0);
        if beyond == [false; 3] {
            return from[0].dot(self.normal).powi(2);
        }
        let to_side = |k: usize| {
            let way = self.sides[k][0];
            let share = (from[k].dot(way) / way.length_squared()).clamp(0.0, 1.0);
            (from[k] - share * way).length_squared()
        };
        to_side(0).min(to_side(1)).min(to_side(2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box of squares of side 1, halved.
    fn fine_box(n: [i32; 3]) -> TriMesh {
        let mut mesh = TriMesh::default();
        let mut numbers = rustc_hash::FxHashMap::default();
        for axis in 0..3 {
            let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
            for side in [0, n[axis]] {
                for i in 0..n[u] {
                    for j in 0..n[v] {
                        let mut corner = |di: i32, dj: i32| {
                            let mut at = [0; 3];
                            (at[axis], at[u], at[v]) = (side, i + di, j + dj);
                            *numbers.entry(at).or_insert_with(|| {
                                mesh.positions.push(DVec3::from_array(at.map(f64::from)));
                                mesh.positions.len() as u32 - 1
                            })
                        };
                        let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                        if side == 0 {
                            mesh.triangles.extend([[a, c, b], [a, d, c]]);
                        } else {
                            mesh.triangles.extend([[a, b, c], [a, c, d]]);
                        }
                    }
                }
            }
        }
        mesh
    }

    #[test]
    fn a_box_keeps_its_corners_alone() {
        let fine = fine_box([20, 12, 5]);
        let how = Simplify {
            tolerance: 1e-9,
            triangles: None,
        };
        let few = simplify(&fine, &how).mesh;
        assert_eq!(few.triangles.len(), 12);
        assert!((few.volume() - 1200.0).abs() < 1e-9);
        assert!(few.edges().census().is_closed());
    }

    /// A bar bent to an arc: triangles along its width, few along the arc.
    #[test]
    fn a_ruled_region_keeps_few() {
        let mut bar = fine_box([60, 30, 2]);
        for p in &mut bar.positions {
            let (sin, cos) = (3.0 * p.x / 60.0).sin_cos();
            *p = DVec3::new((20.0 + p.z) * cos, -p.y, (20.0 + p.z) * sin);
        }
        let how = Simplify {
            tolerance: 0.02,
            triangles: None,
        };
        let few = simplify(&bar, &how).mesh;
        assert!(few.triangles.len() < 600, "{}", few.triangles.len());
        assert!(few.edges().census().is_closed());
        assert!((few.volume() / bar.volume() - 1.0).abs() < 1e-3);
    }

    /// The triangles of one side stay, and so do their places in the list.
    #[test]
    fn what_is_kept_stays() {
        let mut fine = fine_box([20, 12, 5]);
        fine.triangles.rotate_left(5);
        let how = Simplify {
            tolerance: 1e-9,
            triangles: None,
        };
        let kept = 100;
        let few = simplify_beside(&fine, kept, &how).mesh;
        let corners =
            |mesh: &TriMesh, t: usize| mesh.triangles[t].map(|v| mesh.positions[v as usize]);
        for t in 0..kept {
            assert_eq!(corners(&few, t), corners(&fine, t));
        }
        assert!(few.triangles.len() < kept + 300, "{}", few.triangles.len());
        assert!((few.volume() - 1200.0).abs() < 1e-9);
        assert!(few.edges().census().is_closed());
    }

    #[test]
    fn a_wanted_number_is_reached() {
        let mut ball = fine_box([16, 16, 16]);
        for p in &mut ball.positions {
            *p = (*p - 8.0).normalize();
        }
        let within = |tolerance, triangles| {
            simplify(
                &ball,
                &Simplify {
                    tolerance,
                    triangles,
                },
            )
        };
        // Chords of the ball stray by 2e-3; twice as long ones by 8e-3.
        let few = within(2e-2, None);
        assert!(few.mesh.triangles.len() < ball.triangles.len() / 2);
        assert_eq!(few.tolerance, 2e-2);
        assert!(
            few.mesh
                .positions
                .iter()
                .all(|p| ball.positions.contains(p))
        );
        let fewer = within(1e-3, Some(200));
        assert!(fewer.mesh.triangles.len() <= 200);
        assert!(fewer.tolerance > 1e-3);
        for result in [few, fewer] {
            assert!(result.mesh.edges().by_edge().all(|uses| uses.len() == 2));
            assert!(result.mesh.edges().census().is_closed());
            assert_eq!(self_intersections(&result.mesh), []);
        }
    }
}
