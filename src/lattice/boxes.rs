//! Boxes of cells: the lattice cut into parts that are walked apart.

use glam::{DVec3, IVec3};

use super::{Lattice, TetKey};

/// A box of cells: those from `low` up to but without `high`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellBox {
    low: IVec3,
    high: IVec3,
}

impl CellBox {
    /// All cells.
    pub const ALL: CellBox = CellBox {
        low: IVec3::splat(i32::MIN),
        high: IVec3::splat(i32::MAX),
    };

    /// Whether a tetrahedron lies in one of the cells.
    pub fn contains(&self, tet: TetKey) -> bool {
        let at = tet.cell().coordinates();
        at.cmpge(self.low).all() && at.cmplt(self.high).all()
    }

    /// With so many more cells to every side.
    pub fn grown(&self, cells: i32) -> CellBox {
        CellBox {
            low: self.low.saturating_sub(IVec3::splat(cells)),
            high: self.high.saturating_add(IVec3::splat(cells)),
        }
    }

    /// The cells that both hold.
    pub fn meet(&self, other: &CellBox) -> CellBox {
        CellBox {
            low: self.low.max(other.low),
            high: self.high.min(other.high),
        }
    }

    /// Cuts the box in `count` boxes that hold about as many of the given
    /// tetrahedra each: in two across the longest side of what they span, and
    /// so on.
    pub fn cut(self, tets: Vec<TetKey>, count: usize) -> Vec<CellBox> {
        let mut cells: Vec<IVec3> = tets.iter().map(|t| t.cell().coordinates()).collect();
        let mut out = Vec::with_capacity(count);
        self.cut_into(&mut cells, count.max(1), &mut out);
        out
    }

    fn cut_into(self, cells: &mut [IVec3], count: usize, out: &mut Vec<CellBox>) {
        if count == 1 {
            out.push(self);
            return;
        }
        let first = count / 2;
        let low = cells
            .iter()
            .copied()
            .reduce(IVec3::min)
            .unwrap_or(IVec3::ZERO);
        let high = cells
            .iter()
            .copied()
            .reduce(IVec3::max)
            .unwrap_or(IVec3::ZERO);
        let span = (high - low).to_array();
        let axis = (0..3).max_by_key(|&k| (span[k], 2 - k)).unwrap_or(0);
        cells.sort_unstable_by_key(|c| (c[axis], c.to_array()));
        let middle = cells.len() * first / count;
        let place = cells.get(middle).map_or(low[axis], |c| c[axis]);
        let split = cells.partition_point(|c| c[axis] < place);
        let (mut before, mut behind) = (self, self);
        before.high[axis] = place;
        behind.low[axis] = place;
        let (some, others) = cells.split_at_mut(split);
        before.cut_into(some, first, out);
        behind.cut_into(others, count - first, out);
    }

    /// Whether no cell is in it.
    fn is_empty(&self) -> bool {
        self.low.cmpge(self.high).any()
    }

    /// The two halves across the longest side, or the one cell.
    fn halves(&self) -> Result<[CellBox; 2], IVec3> {
        let size = (self.high - self.low).to_array();
        let axis = (0..3).max_by_key(|&k| size[k]).unwrap_or(0);
        if size[axis] <= 1 {
            return Err(self.low);
        }
        let middle = self.low[axis] + size[axis] / 2;
        let (mut before, mut behind) = (*self, *self);
        before.high[axis] = middle;
        behind.low[axis] = middle;
        Ok([before, behind])
    }

    /// Tetrahedra of the outermost layer of cells, on those sides that lie inside
    /// `all`, wherever `may_matter` says so of the ball around some cells: its
    /// centre and radius. Ascending.
    pub fn rim(
        &self,
        lattice: &Lattice,
        all: &CellBox,
        may_matter: impl Fn(DVec3, f64) -> bool,
    ) -> Vec<TetKey> {
        let inner = self.meet(all);
        let mut open = Vec::new();
        for axis in 0..3 {
            if self.low[axis] > all.low[axis] {
                let mut layer = inner;
                layer.high[axis] = layer.low[axis] + 1;
                open.push(layer);
            }
            if self.high[axis] < all.high[axis] {
                let mut layer = inner;
                layer.low[axis] = layer.high[axis] - 1;
                open.push(layer);
            }
        }
        if inner.is_empty() {
            return Vec::new();
        }
        let mut tets = Vec::new();
        while let Some(cells) = open.pop() {
            let [low, high] = [cells.low, cells.high].map(|c| lattice.corner(c));
            if !may_matter(0.5 * (low + high), 0.5 * low.distance(high)) {
                continue;
            }
            match cells.halves() {
                Ok(halves) => open.extend(halves),
                Err(cell) => tets.extend(TetKey::of_cell(cell)),
            }
        }
        tets.sort_unstable();
        tets.dedup();
        tets
    }
}

impl Lattice {
    /// The cells that cover a box.
    pub fn cells(&self, low: DVec3, high: DVec3) -> CellBox {
        let cell = |p| self.locate(p).cell().coordinates();
        CellBox {
            low: cell(low),
            high: cell(high) + IVec3::ONE,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lattice() -> Lattice {
        Lattice::covering(DVec3::ZERO, DVec3::new(20.0, 9.0, 4.0), 1.0).unwrap()
    }

    fn points() -> Vec<TetKey> {
        let at = |i: usize| DVec3::new(0.2 * i as f64, 9.0 - 0.09 * i as f64, 2.0);
        (0..100).map(|i| lattice().locate(at(i))).collect()
    }

    #[test]
    fn a_cut_box_holds_every_tetrahedron_once_and_about_as_many_in_each_part() {
        for count in [1, 2, 3, 7] {
            let boxes = CellBox::ALL.cut(points(), count);
            assert_eq!(boxes.len(), count);
            for tet in points() {
                assert_eq!(boxes.iter().filter(|b| b.contains(tet)).count(), 1);
            }
            for part in &boxes {
                let held = points().iter().filter(|&&t| part.contains(t)).count();
                // A column of cells holds up to six points and is not cut; cuts add up.
                assert!(held.abs_diff(100 / count) <= 10, "{held} in one of {count}");
            }
        }
        assert_eq!(CellBox::ALL.cut(Vec::new(), 3).len(), 3);
    }

    #[test]
    fn the_rim_is_one_layer_on_the_sides_inside() {
        let lattice = lattice();
        let all = lattice.cells(DVec3::ZERO, DVec3::new(20.0, 9.0, 4.0));
        assert!(CellBox::ALL.rim(&lattice, &all, |_, _| true).is_empty());
        let [left, right] = CellBox::ALL.cut(points(), 2)[..] else {
            panic!("two boxes");
        };
        let size = all.high - all.low;
        for part in [left, right] {
            let rim = part.rim(&lattice, &all, |_, _| true);
            assert_eq!(rim.len() as i32, 6 * size.y * size.z);
            assert!(
                rim.iter()
                    .all(|&t| part.contains(t) && !part.grown(-1).contains(t))
            );
            assert!(part.rim(&lattice, &all, |_, _| false).is_empty());
        }
    }
}
