//! Nodes on a wall instead of the middle.

use glam::DVec3;
use nalgebra::{Matrix3, Vector3};

use super::ShellModel;

/// Normals whose planes meet at a flatter angle than this (sine squared) have
/// no line in common worth moving a node to.
const LEAST_BEND: f64 = 1e-3;

impl ShellModel {
    /// Moves the nodes along the normals to `placement` of the way between the
    /// walls: 0 to the wall against the normals, 1 to the one that they point
    /// to. The material stays where it was: elements tell their offset.
    ///
    /// Where sheets meet, a node goes to where their moved planes meet, or as
    /// near to all of them as can be.
    pub fn place(&mut self, placement: f64) {
        let mut at: Vec<Vec<DVec3>> = vec![Vec::new(); self.nodes.len()];
        for element in &self.elements {
            for (&node, &normal) in element.nodes.iter().zip(&element.normals) {
                let normal = self.normals[normal as usize];
                let known = &mut at[node as usize];
                if known.iter().all(|n| n.distance_squared(normal) > 1e-12) {
                    known.push(normal);
                }
            }
        }
        let step = placement - self.placement;
        for (node, normals) in self.nodes.iter_mut().zip(at) {
            node.position += meeting(&normals) * (step * node.thickness);
        }
        self.placement = placement;
    }
}

/// The shortest move that comes nearest to 1 along each normal.
pub(super) fn meeting(normals: &[DVec3]) -> DVec3 {
    let (mut products, mut sums) = (Matrix3::zeros(), Vector3::zeros());
    for n in normals {
        let n = Vector3::new(n.x, n.y, n.z);
        products += n * n.transpose();
        sums += n;
    }
    let largest = normals.len().max(1) as f64;
    let svd = products.svd(true, true);
    match svd.solve(&sums, LEAST_BEND * largest) {
        Ok(m) => DVec3::new(m.x, m.y, m.z),
        Err(_) => DVec3::ZERO,
    }
}
