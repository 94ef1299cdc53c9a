//! Merging of vertices: bit-equal ones, and those within a tolerance.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::TriMesh;

/// Outcome of a weld: the new index of each old vertex.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Weld {
    /// New index of each old vertex; the lowest of merged vertices survives.
    pub new_index: Vec<u32>,
    /// Old index of each vertex that stays, ascending.
    pub kept: Vec<u32>,
}

impl Weld {
    /// How many vertices went away.
    pub fn merged(&self) -> usize {
        self.new_index.len() - self.kept.len()
    }

    /// The mesh with merged vertices; triangles keep their order and number,
    /// and may collapse to a repeated corner.
    pub fn apply(&self, mesh: &TriMesh) -> TriMesh {
        TriMesh {
            positions: self
                .kept
                .iter()
                .map(|&old| mesh.positions[old as usize])
                .collect(),
            triangles: mesh
                .triangles
                .iter()
                .map(|corners| corners.map(|v| self.new_index[v as usize]))
                .collect(),
        }
    }
}

/// Bits of a position; both zeros count as one.
fn key(position: DVec3) -> [u64; 3] {
    (position + DVec3::ZERO).to_array().map(f64::to_bits)
}

/// Merges vertices whose coordinates are equal to the bit (and 0 with -0).
pub fn weld_exact(positions: &[DVec3]) -> Weld {
    let mut seen: FxHashMap<[u64; 3], u32> = FxHashMap::default();
    seen.reserve(positions.len());
    let mut weld = Weld {
        new_index: Vec::with_capacity(positions.len()),
        kept: Vec::new(),
    };
    for (old, &position) in positions.iter().enumerate() {
        let next = weld.kept.len() as u32;
        let index = *seen.entry(key(position)).or_insert(next);
        if index == next {
            weld.kept.push(old as u32);
        }
        weld.new_index.push(index);
    }
    weld
}

/// Merges each vertex into the first earlier one that stayed and lies no
/// farther than `tolerance` (part units).
///
/// Chains do not creep: a vertex is compared with survivors only. Coordinates
/// must be finite and `tolerance` positive.
pub fn weld_within(positions: &[DVec3], tolerance: f64) -> Weld {
    let cell_of = |p: DVec3| (p / tolerance).floor().to_array().map(f64::to_bits);
    let mut grid: FxHashMap<[u64; 3], Vec<u32>> = FxHashMap::default();
    let mut weld = Weld {
        new_index: Vec::with_capacity(positions.len()),
        kept: Vec::new(),
    };
    for (old, &position) in positions.iter().enumerate() {
        let mut found: Option<u32> = None;
        for x in -1..=1 {
            for y in -1..=1 {
                for z in -1..=1 {
                    let step = DVec3::new(f64::from(x), f64::from(y), f64::from(z));
                    let cell = (position / tolerance).floor() + step + DVec3::ZERO;
                    let Some(survivors) = grid.get(&cell.to_array().map(f64::to_bits)) else {
                        continue;
                    };
                    for &new in survivors {
                        let other = positions[weld.kept[new as usize] as usize];
                        if other.distance(position) <= tolerance
                            && found.is_none_or(|best| new < best)
                        {
                            found = Some(new);
                        }
                    }
                }
            }
        }
        let index = found.unwrap_or_else(|| {
            let new = weld.kept.len() as u32;
            weld.kept.push(old as u32);
            grid.entry(cell_of(position + DVec3::ZERO))
                .or_default()
                .push(new);
            new
        });
        weld.new_index.push(index);
    }
    weld
}

/// The mesh without the vertices that no triangle uses.
pub(super) fn drop_unused(mesh: TriMesh) -> TriMesh {
    let mut used = vec![false; mesh.positions.len()];
    for &v in mesh.triangles.iter().flatten() {
        used[v as usize] = true;
    }
    if used.iter().all(|&used| used) {
        return mesh;
    }
    let mut new_index = vec![u32::MAX; used.len()];
    let mut kept = Vec::new();
    for (old, _) in used.iter().enumerate().filter(|(_, used)| **used) {
        new_index[old] = kept.len() as u32;
        kept.push(old as u32);
    }
    Weld { new_index, kept }.apply(&mesh)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_zeros_are_one_place() {
        let weld = weld_exact(&[DVec3::ZERO, DVec3::new(-0.0, 0.0, -0.0), DVec3::X]);
        assert_eq!(weld.new_index, [0, 0, 1]);
        assert_eq!(weld.kept, [0, 2]);
        assert_eq!(weld.merged(), 1);
    }

    #[test]
    fn near_points_merge_across_cell_borders_without_creeping() {
        let line: Vec<DVec3> = [-0.01, 0.01, 0.9, 1.0, 1.1, 1.2]
            .iter()
            .map(|&x| DVec3::new(x, 0.0, 0.0))
            .collect();
        let weld = weld_within(&line, 0.15);
        assert_eq!(weld.new_index, [0, 0, 1, 1, 2, 2]);
    }
}
