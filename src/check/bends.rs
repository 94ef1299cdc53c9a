//! Where a surface has seams or bends: what is measured there has other limits.

use glam::DVec3;
use rustc_hash::FxHashMap;

use crate::surface::edges::Edges;

/// Bend between neighbours, degrees, from which the surface has a bend that
/// counts as a seam does.
const BEND: f64 = 20.0;

/// Where the surface has seams or bends.
pub(super) struct Bends {
    cell: f64,
    places: FxHashMap<[i64; 3], Vec<DVec3>>,
}

impl Bends {
    /// Of edges, with the angle between the two triangles of each that has two, degrees.
    pub(super) fn of(
        edges: &Edges,
        at: impl Fn(u32) -> DVec3,
        bend: impl Fn(usize) -> Option<f64>,
        reach: f64,
    ) -> Bends {
        let mut bends = Bends {
            cell: reach,
            places: FxHashMap::default(),
        };
        for e in 0..edges.len() {
            let seam = edges.uses(e).len() > 2;
            if seam || bend(e).is_some_and(|bend| bend > BEND) {
                let [p, q] = edges.ends[e].map(&at);
                // Long edges count along their length.
                let steps = ((p.distance(q) / reach).ceil() as u32).clamp(1, 1000);
                for k in 0..=steps {
                    let at = p.lerp(q, f64::from(k) / f64::from(steps));
                    bends.places.entry(bends.key(at)).or_default().push(at);
                }
            }
        }
        bends
    }

    fn key(&self, at: DVec3) -> [i64; 3] {
        (at / self.cell).floor().to_array().map(|x| x as i64)
    }

    /// Whether a seam or bend is within reach.
    pub(super) fn near(&self, at: DVec3) -> bool {
        let [x, y, z] = self.key(at);
        (-1..=1)
            .flat_map(|i| (-1..=1).flat_map(move |j| (-1..=1).map(move |k| [x + i, y + j, z + k])))
            .filter_map(|key| self.places.get(&key))
            .flatten()
            .any(|place| place.distance(at) < self.cell)
    }
}
