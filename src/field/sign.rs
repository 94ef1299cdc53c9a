//! Inside or outside.
//!
//! A closed manifold gets angle-weighted pseudonormals (Baerentzen and Aanaes,
//! "Signed distance computation using the angle weighted pseudonormal", 2005):
//! the sign of `(p - c) . n`, where `c` is the closest point and `n` belongs to
//! the face, edge or vertex that holds it. That is exact in exact arithmetic,
//! near edges and vertices too, and costs one nearest-point search.
//!
//! Any other set of triangles (open or non-manifold) gets the generalised
//! winding number (Jacobson, Kavan, Sorkine-Hornung, 2013) against one half,
//! with the dipole approximation for far nodes (Barill, Dickson, Schmidt,
//! Levin, Jacobson, 2018). It is right up to small faults of the mesh, bridges
//! openings smoothly, and counts an inverted part as outside everywhere. A
//! closed manifold with slivers gets it for the few points whose closest point
//! is on one, because the normals there mean nothing.

use glam::{DMat3, DVec3};
use smallvec::SmallVec;

use super::Field;
use super::frame::Frame;
use super::topology::Topology;
use super::tree::{Child, Tree, WIDTH};
use super::triangle::{Closest, Feature, Triangle};
use crate::mesh::angle;

#[derive(Clone, Debug)]
pub(super) struct Sign {
    /// Of a closed manifold.
    normals: Option<Pseudonormals>,
    /// Of anything else, and of a manifold with slivers.
    winding: Option<Winding>,
}

impl Sign {
    /// `triangles` are those in the trees, by slot, then those without area.
    pub fn new(
        triangles: &[Triangle],
        in_trees: usize,
        indices: &[[u32; 3]],
        trees: [&Tree; 2],
        frame: Frame,
    ) -> Sign {
        let normals = Topology::new(triangles, in_trees, indices)
            .map(|topology| Pseudonormals::new(triangles, topology));
        let sound = |normals: &Pseudonormals| !normals.doubtful;
        let winding = (!normals.as_ref().is_some_and(sound))
            .then(|| Winding::new(&triangles[..in_trees], trees, frame));
        Sign { normals, winding }
    }

    /// Winding numbers, whatever the triangles are.
    pub fn winding(triangles: &[Triangle], trees: [&Tree; 2], frame: Frame) -> Sign {
        Sign {
            normals: None,
            winding: Some(Winding::new(triangles, trees, frame)),
        }
    }

    /// Of a closed manifold.
    pub fn normals(&self) -> Option<&Pseudonormals> {
        self.normals.as_ref()
    }

    /// Whether a query lies behind its closest point, as far as that tells.
    pub fn behind(&self, triangles: &[Triangle], slot: usize, closest: &Closest) -> Option<bool> {
        self.normals.as_ref()?.inside(triangles, slot, closest)
    }

    /// Whether `p` is inside by its winding number; if there is none, then
    /// [`Sign::behind`] always tells.
    pub fn wound_round(&self, field: &Field, p: DVec3) -> bool {
        (self.winding.as_ref()).is_some_and(|winding| winding.inside(field, p))
    }
}

#[derive(Clone, Debug)]
pub(super) struct Pseudonormals {
    topology: Topology,
    /// By vertex; not of unit length. Zero at slivers.
    vertex_normals: Vec<DVec3>,
    /// There are slivers.
    doubtful: bool,
}

impl Pseudonormals {
    fn new(triangles: &[Triangle], topology: Topology) -> Pseudonormals {
        let mut vertex_normals = vec![DVec3::ZERO; topology.vertex_count];
        for (triangle, vertices) in triangles.iter().zip(&topology.vertices) {
            let c = triangle.corners;
            let normal = triangle.normal();
            for i in 0..3 {
                let (u, v) = (c[(i + 1) % 3] - c[i], c[(i + 2) % 3] - c[i]);
                vertex_normals[vertices[i] as usize] += normal * angle(u, v);
            }
        }
        let slots = triangles.iter().zip(&topology.vertices);
        let slivers = slots.filter(|(triangle, _)| triangle.is_sliver());
        let mut doubtful = false;
        for &vertex in slivers.flat_map(|(_, vertices)| vertices) {
            vertex_normals[vertex as usize] = DVec3::ZERO;
            doubtful = true;
        }
        Pseudonormals {
            topology,
            vertex_normals,
            doubtful,
        }
    }

    /// Visits the slots of all triangles that hold a feature of one.
    pub fn around(&self, slot: usize, feature: Feature, mut visit: impl FnMut(usize)) {
        match feature {
            Feature::Face => visit(slot),
            Feature::Edge(edge) => {
                visit(slot);
                visit(self.topology.neighbours[slot][usize::from(edge)].slot as usize);
            }
            Feature::Corner(corner) => self
                .topology
                .fan(slot as u32, corner)
                .for_each(|(slot, _)| visit(slot as usize)),
        }
    }

    /// Whether the query lies behind its closest point. None where a sliver
    /// holds that.
    fn inside(&self, triangles: &[Triangle], slot: usize, closest: &Closest) -> Option<bool> {
        let own = |slot: usize| (!triangles[slot].is_sliver()).then(|| triangles[slot].normal());
        let normal = match closest.feature {
            Feature::Face => own(slot)?,
            Feature::Edge(edge) => {
                let side = self.topology.neighbours[slot][usize::from(edge)];
                own(slot)? + own(side.slot as usize)?
            }
            Feature::Corner(corner) => {
                let vertex = self.topology.vertices[slot][usize::from(corner)];
                let normal = self.vertex_normals[vertex as usize];
                (normal != DVec3::ZERO).then_some(normal)?
            }
        };
        Some(closest.offset.dot(normal) < 0.0)
    }
}

#[derive(Clone, Debug)]
pub(super) struct Winding {
    /// For each tree, for each node and lane.
    dipoles: [Vec<[Dipole; WIDTH]>; 2],
}

/// Far-field stand-in for the triangles under one child, in tree units: the
/// solid angle's Taylor expansion about `centre`, up to first derivatives.
///
/// The second term is not a luxury here. The two faces of a thin wall nearly
/// cancel in `moment`, and what is left is of the order of thickness over
/// distance however small the node.
#[derive(Clone, Copy, Debug, Default)]
struct Dipole {
    centre: DVec3,
    /// Sum of area times normal.
    moment: DVec3,
    /// Sum of (triangle's centre - `centre`), times (area times normal)
    /// transposed.
    spread: DMat3,
    area: f64,
    /// All triangles lie within this of `centre`, squared.
    square_radius: f64,
}

/// A dipole serves from this many radii on. On bumpy solids and thin shells the
/// winding number then errs by less than half of `DOUBTFUL`.
const FAR: f64 = 2.0;

/// When the winding number comes out this near to one half, it is computed
/// again with dipoles only from `VERY_FAR` radii on, where it errs by 1e-4.
const DOUBTFUL: f64 = 0.1;
const VERY_FAR: f64 = 16.0;

impl Winding {
    fn new(triangles: &[Triangle], trees: [&Tree; 2], frame: Frame) -> Winding {
        Winding {
            dipoles: trees.map(|tree| dipoles(tree, triangles, frame)),
        }
    }

    /// Whether the winding number at `p` is above one half.
    pub fn inside(&self, field: &Field, p: DVec3) -> bool {
        let mut number = self.number(field, p, FAR);
        if (number - 0.5).abs() < DOUBTFUL {
            number = self.number(field, p, VERY_FAR);
        }
        number > 0.5
    }

    /// Winding number at `p`: 1 inside a closed part, 0 outside.
    pub fn number(&self, field: &Field, p: DVec3, far: f64) -> f64 {
        let trees = [&field.wall_tree, &field.coping_tree];
        let local = field.frame.to_tree(p);
        let mut solid_angle = 0.0;
        for (tree, dipoles) in trees.into_iter().zip(&self.dipoles) {
            if tree.nodes.is_empty() {
                continue;
            }
            // Holds at most `7 depth + 1` nodes; deeper trees spill to the heap.
            let mut stack: SmallVec<[usize; 64]> = SmallVec::new();
            stack.push(0);
            while let Some(index) = stack.pop() {
                for (child, dipole) in tree.nodes[index].child.into_iter().zip(&dipoles[index]) {
                    if child == Child::EMPTY {
                        break;
                    }
                    let d = dipole.centre - local;
                    let square = d.length_squared();
                    if square > far * far * dipole.square_radius {
                        solid_angle += dipole.solid_angle(d, square);
                    } else if child.is_leaf() {
                        let triangles = &field.triangles[tree.leaf_slots(child)];
                        solid_angle += seen_angle(triangles, p);
                    } else {
                        stack.push(child.index());
                    }
                }
            }
        }
        solid_angle / (4.0 * std::f64::consts::PI)
    }
}

/// Signed solid angle of a leaf's triangles seen from `p`, positive from behind
/// (van Oosterom and Strackee, 1983).
///
/// Half the angle of a triangle is the argument of a complex number. As long as
/// these are below an eighth of a turn, at most four can be multiplied and
/// their sum taken from one arc tangent.
fn seen_angle(triangles: &[Triangle], p: DVec3) -> f64 {
    let mut sum = 0.0;
    let (mut re, mut im) = (1.0, 0.0);
    for triangle in triangles {
        let [a, b, c] = triangle.corners.map(|x| x - p);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let y = a.dot(b.cross(c));
        let x = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        if y.abs() < x {
            let slope = y / x;
            (re, im) = (re - im * slope, im + re * slope);
        } else {
            sum += y.atan2(x);
        }
    }
    2.0 * (sum + im.atan2(re))
}

fn dipoles(tree: &Tree, triangles: &[Triangle], frame: Frame) -> Vec<[Dipole; WIDTH]> {
    let mut all = vec![[Dipole::default(); WIDTH]; tree.nodes.len()];
    // Children stand after their parents, so the last node comes first.
    for index in (0..tree.nodes.len()).rev() {
        let node = &tree.nodes[index];
        for lane in 0..WIDTH {
            let child = node.child[lane];
            if child == Child::EMPTY {
                break;
            }
            let parts: SmallVec<[Dipole; WIDTH]> = if child.is_leaf() {
                let slots = tree.leaf_slots(child);
                let own = |t| Dipole::of_triangle(t, frame);
                triangles[slots].iter().map(own).collect()
            } else {
                let lanes = all[child.index()].into_iter();
                lanes.filter(|d| d.area > 0.0).collect()
            };
            let mut dipole = Dipole::gather(&parts);
            let (low, high) = node.bounds(lane);
            let reach = (high - dipole.centre).max(dipole.centre - low);
            dipole.square_radius = reach.length_squared();
            all[index][lane] = dipole;
        }
    }
    all
}

impl Dipole {
    fn of_triangle(triangle: &Triangle, frame: Frame) -> Dipole {
        let [a, b, c] = triangle.corners.map(|x| frame.to_tree(x));
        let moment = (b - a).cross(c - a) * 0.5;
        Dipole {
            centre: (a + b + c) / 3.0,
            moment,
            // Never zero, so that a sum of slivers still has a centre.
            area: moment.length().max(1e-300),
            ..Dipole::default()
        }
    }

    /// The sum of parts, about their common centre; the radius is left open.
    fn gather(parts: &[Dipole]) -> Dipole {
        let mut sum = Dipole::default();
        for part in parts {
            sum.centre += part.centre * part.area;
            sum.moment += part.moment;
            sum.area += part.area;
        }
        sum.centre /= sum.area;
        for part in parts {
            let (shift, n) = (part.centre - sum.centre, part.moment);
            sum.spread += part.spread + DMat3::from_cols(shift * n.x, shift * n.y, shift * n.z);
        }
        sum
    }

    /// Solid angle seen from a point at `centre - d`, positive from behind.
    fn solid_angle(&self, d: DVec3, square: f64) -> f64 {
        let spread = &self.spread;
        let trace = spread.x_axis.x + spread.y_axis.y + spread.z_axis.z;
        let bent = 3.0 * d.dot(*spread * d) / square;
        (self.moment.dot(d) + trace - bent) / (square * square.sqrt())
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::shapes::{Dice, bumpy, shell};
    use super::super::tests::winding;
    use super::*;

    #[test]
    fn dipoles_stay_near_the_exact_winding_number() {
        // Open at one place: a solid, and a shell of thin walls.
        for mut shape in [bumpy(4), shell(bumpy(4), 0.97)] {
            shape.drop_last(300);
            let field = shape.field();
            assert!(field.sign.normals().is_none(), "an open surface");
            let number = field.sign.winding.as_ref().unwrap();
            let mut dice = Dice(3);
            for _ in 0..1500 {
                let p = dice.point(field.bounds());
                let exact = winding(&field, p);
                let error = |far| (number.number(&field, p, far) - exact).abs();
                assert!(error(FAR) < DOUBTFUL / 2.0, "{p:?} {}", error(FAR));
                assert!(error(VERY_FAR) < 1e-4, "{p:?} {}", error(VERY_FAR));
            }
        }
    }
}
