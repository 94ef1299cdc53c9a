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

/// Triangles lower than this, over their longest side, are not made.
const NEEDLE: f64 = 1e-3;

/// Triangles lower than this have no normal to keep.
const FLAT: f64 = 1e-6;

/// A pass that takes less than this share of the triangles is the last.
const LEAST_GAIN: f64 = 0.002;

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
    let mut locked = vec![false; mesh.positions.len()];
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
            if touched[u as usize] || self.locked[u as usize] || self.around[u as usize].is_empty()
            {
                continue;
            }
            if let Some(v) = self.collapse(u, tolerance) {
                touched[v as usize] = true;
                for &t in &self.around[v as usize] {
                    for w in self.triangles[t as usize] {
                        touched[w as usize] = true;
                    }
                }
            }
        }
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

    /// The triangles around `u` with `v` in its place; none where the mesh would
    /// be no manifold, or triangles would turn over or become needles. With the
    /// height over the longest side of the worst.
    fn moved(&self, u: u32, v: u32, ring: &[u32]) -> Option<(f64, Moved)> {
        let theirs = self.neighbours(v);
        let shared = ring.iter().filter(|w| theirs.binary_search(w).is_ok());
        let shared: SmallVec<[u32; 4]> = shared.copied().collect();
        let room = |&w: &u32| self.around[w as usize].len() > 3;
        if shared.len() != 2 || !shared.iter().all(room) {
            return None;
        }
        let mut worst = f64::INFINITY;
        let mut moved = Moved::new();
        for &t in &self.around[u as usize] {
            let before = self.triangles[t as usize];
            if before.contains(&v) {
                continue;
            }
            let after = before.map(|w| if w == u { v } else { w });
            let normal = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
            let [m, n] = [before, after].map(|t| normal(self.corners(t)));
            // The normal of a needle says nothing.
            let turns = m.dot(n) <= LEAST_TURN * m.length() * n.length()
                && !is_thin(self.corners(before), FLAT);
            if turns || is_thin(self.corners(after), NEEDLE) {
                return None;
            }
            worst = worst.min(n.length() / longest_squared(self.corners(after)));
            moved.push((t, after));
        }
        Some((worst, moved))
    }

    /// Collapses `u` into the neighbour that leaves the best triangles within the
    /// tolerance.
    fn collapse(&mut self, u: u32, tolerance: f64) -> Option<u32> {
        let ring = self.neighbours(u);
        let mut ways: SmallVec<[_; 8]> = ring
            .iter()
            .filter_map(|&v| {
                self.moved(u, v, &ring)
                    .map(|(worst, moved)| (worst, v, moved))
            })
            .collect();
        ways.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut points: Vec<u32> = vec![u];
        points.extend(
            self.around[u as usize]
                .iter()
                .flat_map(|&t| &self.stands_for[t as usize]),
        );
        for (_, v, moved) in ways {
            if let Some(shares) = self.shares(&points, &moved, tolerance) {
                self.apply(u, v, &moved, shares);
                return Some(v);
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
        let corners: SmallVec<[[DVec3; 3]; 8]> = moved.iter().map(|m| self.corners(m.1)).collect();
        let mut shares = vec![Vec::new(); moved.len()];
        for &point in points {
            let p = self.point(point);
            let squares = corners.iter().map(|&c| distance_squared(p, c));
            let (nearest, square) = squares.enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
            if square > tolerance * tolerance {
                return None;
            }
            shares[nearest].push(point);
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

    fn apply(&mut self, u: u32, v: u32, moved: &[(u32, [u32; 3])], shares: Vec<Vec<u32>>) {
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
        for (&(t, after), share) in moved.iter().zip(shares) {
            self.triangles[t as usize] = after;
            self.stands_for[t as usize] = share;
            self.around[v as usize].push(t);
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

fn longest_squared([a, b, c]: [DVec3; 3]) -> f64 {
    let sides = [(a, b), (b, c), (c, a)].map(|(p, q)| p.distance_squared(q));
    sides[0].max(sides[1]).max(sides[2])
}

/// Square of the distance of a point from a triangle with area.
fn distance_squared(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let beyond = |from: DVec3, to: DVec3| (to - from).cross(p - from).dot(normal) < 0.0;
    let sides = [(a, b), (b, c), (c, a)];
    if !sides.into_iter().any(|(from, to)| beyond(from, to)) {
        let height = (p - a).dot(normal);
        return height * height / normal.length_squared();
    }
    let to_side = |(from, to): (DVec3, DVec3)| {
        let way = to - from;
        let share = ((p - from).dot(way) / way.length_squared()).clamp(0.0, 1.0);
        (from + share * way).distance_squared(p)
    };
    let [x, y, z] = sides.map(to_side);
    x.min(y).min(z)
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
