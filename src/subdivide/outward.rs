//! Shells of a control mesh turned as they nest: bodies outwards, cavities
//! inwards.

use super::cage::Cage;
use crate::mesh::{TriMesh, closed_shells, turn_by_nesting};

impl Cage {
    /// The mesh with closed shells turned that were inside out, and the number of
    /// faces turned. A shell in an odd number of others bounds a cavity. Told by
    /// the control mesh itself, each face as a fan around its first corner.
    pub fn outward(self) -> (Cage, usize) {
        let mut mesh = TriMesh {
            positions: self.positions().to_vec(),
            triangles: Vec::with_capacity(self.corner_count()),
        };
        let mut first = Vec::with_capacity(self.face_count());
        for face in 0..self.face_count() {
            first.push(mesh.triangles.len());
            let ring = self.face(face);
            let fan = ring[1..].windows(2).map(|pair| [ring[0], pair[0], pair[1]]);
            mesh.triangles.extend(fan);
        }
        let given = mesh.triangles.clone();
        let uses = mesh.edges();
        match &closed_shells(&mesh, &uses)[..] {
            [] => return (self, 0),
            // Alone it nests in nothing.
            [shell] if shell.volume < 0.0 => {
                for face in &shell.faces {
                    mesh.triangles[face.index()].swap(1, 2);
                }
            }
            _ => {
                // Too many to tell stay as they are.
                let _ = turn_by_nesting(&mut mesh, &uses);
            }
        }
        let wrong = |face: usize| mesh.triangles[first[face]] != given[first[face]];
        let count = (0..self.face_count()).filter(|&face| wrong(face)).count();
        if count == 0 {
            return (self, 0);
        }
        (self.turned_over(wrong), count)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::subdivide::{Polygon, Tags};

    /// Cubes by their middle and half side; `true` for one that looks inwards.
    fn cubes(all: &[(f64, f64, bool)]) -> Cage {
        const SIDES: [[u32; 4]; 6] = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let (mut positions, mut faces) = (Vec::new(), Vec::new());
        for &(middle, half, inward) in all {
            let base = positions.len() as u32;
            for k in 0..8 {
                let side = |bit: i32| if k >> bit & 1 == 1 { half } else { -half };
                positions.push(DVec3::new(middle + side(0), side(1), side(2)));
            }
            for mut ring in SIDES.map(|ring| ring.map(|v| v + base)) {
                if inward {
                    ring.reverse();
                }
                faces.push(Polygon::from_slice(&ring));
            }
        }
        Cage::new(positions, &faces).expect("cubes")
    }

    #[test]
    fn each_shell_is_turned_as_it_nests() {
        for (shells, turned) in [
            (&[(0.0, 1.0, false)][..], 0),
            (&[(0.0, 1.0, true)], 6),
            // Side by side, one of them inside out.
            (&[(0.0, 1.0, false), (5.0, 1.0, true)], 6),
            // One in the other: a cavity, whichever way it looks.
            (&[(0.0, 2.0, false), (0.0, 1.0, false)], 6),
            (&[(0.0, 2.0, false), (0.0, 1.0, true)], 0),
            (&[(0.0, 2.0, true), (0.0, 1.0, true)], 6),
        ] {
            let cage = cubes(shells);
            let tags = Tags {
                creases: vec![([0, 1], 3.0)],
                ..Tags::default()
            };
            let cage = cage.tagged(&tags).expect("an edge");
            let (outward, count) = cage.outward();
            assert_eq!(count, turned, "{shells:?}");
            assert_eq!(outward.tags().creases.len(), 1);
            assert_eq!(outward.clone().outward().1, 0, "{shells:?}");
        }
    }
}
