//! The grid: planes along the three axes, and the cells between them.
//!
//! A plane's coordinate is computed once and read by all, so that "the vertex
//! lies in its cell" is a comparison of the very numbers that every neighbour
//! compares with. Nothing in the contouring asks that the planes be evenly
//! spaced; each is rounded to the numbers that vertices may have.

use glam::{DVec3, IVec3};

use super::numbers::Numbers;
use crate::mesh::Bounds;

/// The distance of the first plane from the box, as fractions of a cell along
/// x, y and z: odd ones, because faces of mechanical parts love round numbers
/// and a face in a grid plane is the worst place for it.
const SHIFT: DVec3 = DVec3::new(0.381_966, 0.437_016, 0.344_153);

/// Planes a contour must stay away from the grid's rim, so that every cell
/// with a vertex has all its neighbours.
const RIM: f64 = 2.0;

/// Cells of equal size around a box.
#[derive(Clone, Debug)]
pub struct Grid {
    planes: [Vec<f64>; 3],
    cell: f64,
    numbers: Numbers,
}

impl Grid {
    /// Most cells along one axis.
    pub const MOST_CELLS: f64 = 1_000_000.0;

    /// Cells along each axis that [`Grid::around`] would make.
    pub fn cells_around(bounds: &Bounds, cell: f64) -> [f64; 3] {
        ((bounds.size() / cell).ceil() + 2.0 * RIM + 1.0).to_array()
    }

    /// A grid of cells of length `cell` around `bounds`, with room to spare.
    ///
    /// None if `cell` is not a positive number, the box is empty, an axis
    /// would have more than [`Grid::MOST_CELLS`] cells, or the numbers allowed
    /// are too coarse to tell its planes apart.
    pub fn around(bounds: &Bounds, cell: f64, numbers: impl Into<Numbers>) -> Option<Grid> {
        let numbers = numbers.into();
        if cell.is_nan() || cell <= 0.0 || bounds.is_empty() {
            return None;
        }
        let cells = Grid::cells_around(bounds, cell);
        let low = bounds.min - (RIM + SHIFT) * cell;
        let mut planes = [Vec::new(), Vec::new(), Vec::new()];
        for axis in 0..3 {
            if cells[axis].is_nan() || cells[axis] > Grid::MOST_CELLS {
                return None;
            }
            let count = cells[axis] as usize + 1;
            planes[axis] = (0..count)
                .map(|i| numbers.round(axis, low[axis] + i as f64 * cell))
                .collect();
            // Room for vertices between two planes, and rounding that is far
            // below a cell.
            let roomy = |w: &[f64]| {
                let even = w[1] - w[0] > 0.99 * cell && w[1] - w[0] < 1.01 * cell;
                let apart = numbers.above(axis, w[0]) <= numbers.below(axis, w[1]);
                even && (apart || !numbers.are_sparse(axis))
            };
            if !planes[axis].windows(2).all(roomy) {
                return None;
            }
        }
        Some(Grid {
            planes,
            cell,
            numbers,
        })
    }

    /// Length of a cell, part units; planes deviate from it by their
    /// rounding.
    pub fn cell(&self) -> f64 {
        self.cell
    }

    /// Numbers that vertices may have.
    pub fn numbers(&self) -> Numbers {
        self.numbers
    }

    /// Number of cells along each axis.
    pub fn cells(&self) -> IVec3 {
        IVec3::from_array([0, 1, 2].map(|axis| self.planes[axis].len() as i32 - 1))
    }

    /// Position of a node; indices beyond the rim are taken to it.
    pub fn node(&self, at: IVec3) -> DVec3 {
        DVec3::from_array([0, 1, 2].map(|axis| {
            let planes = &self.planes[axis];
            planes[at[axis].clamp(0, planes.len() as i32 - 1) as usize]
        }))
    }

    /// The number allowed along an axis that is nearest to `x` and strictly
    /// between two neighbouring planes.
    pub fn between(&self, axis: usize, [low, high]: [f64; 2], x: f64) -> f64 {
        let margin = MARGIN * (high - low);
        let numbers = self.numbers;
        let x = numbers.round(axis, x.clamp(low + margin, high - margin));
        if numbers.are_sparse(axis) {
            // Some number lies between two planes: a grid without is none.
            x.clamp(numbers.above(axis, low), numbers.below(axis, high))
        } else {
            x
        }
    }

    /// The point allowed that is nearest to `p` and strictly inside a cell.
    pub fn settle(&self, p: DVec3, cell: &CellBox) -> DVec3 {
        DVec3::from_array(
            [0, 1, 2].map(|axis| self.between(axis, [cell.low[axis], cell.high[axis]], p[axis])),
        )
    }

    /// The point allowed that is nearest to `p`, strictly inside the lower
    /// face of a cell across `axis`.
    pub fn settle_on_face(&self, p: DVec3, cell: &CellBox, axis: usize) -> DVec3 {
        let mut p = self.settle(p, cell);
        p[axis] = cell.low[axis];
        p
    }

    /// Lower and upper corner of a cell.
    pub fn cell_box(&self, at: IVec3) -> CellBox {
        CellBox {
            low: self.node(at),
            high: self.node(at + IVec3::ONE),
        }
    }
}

/// A cell's box; a vertex lies strictly between its planes.
#[derive(Clone, Copy, Debug)]
pub struct CellBox {
    /// Corner of least coordinates.
    pub low: DVec3,
    /// Corner of greatest coordinates.
    pub high: DVec3,
}

/// Least distance of a vertex from the planes of its cell, over the cell's
/// length. The proof asks for more than zero; this keeps triangles' normals
/// above rounding.
const MARGIN: f64 = 1e-9;

impl CellBox {
    /// Whether `p` lies strictly inside.
    pub fn contains(&self, p: DVec3) -> bool {
        let margin = MARGIN * (self.high - self.low);
        p.cmpgt(self.low + margin).all() && p.cmplt(self.high - margin).all()
    }

    /// Whether `p`, which lies in the box's lower plane of `axis`, lies
    /// strictly inside that face.
    pub fn face_contains(&self, p: DVec3, axis: usize) -> bool {
        let mut lifted = p;
        lifted[axis] = 0.5 * (self.low[axis] + self.high[axis]);
        self.contains(lifted)
    }

    /// The point of the box that is nearest to `p`, `inset` times the box's
    /// length away from its planes.
    pub fn clamp(&self, p: DVec3, inset: f64) -> DVec3 {
        let inset = inset * (self.high - self.low);
        p.clamp(self.low + inset, self.high - inset)
    }

    /// Centre.
    pub fn centre(&self) -> DVec3 {
        0.5 * (self.low + self.high)
    }

    /// The part of a line that lies in the box, as lengths along `direction`
    /// from `origin`.
    pub fn clip(&self, origin: DVec3, direction: DVec3) -> Option<[f64; 2]> {
        let mut span = [f64::NEG_INFINITY, f64::INFINITY];
        for axis in 0..3 {
            let (low, high) = (
                self.low[axis] - origin[axis],
                self.high[axis] - origin[axis],
            );
            if direction[axis].abs() < 1e-12 {
                if low > 0.0 || high < 0.0 {
                    return None;
                }
                continue;
            }
            let (a, b) = (low / direction[axis], high / direction[axis]);
            span = [span[0].max(a.min(b)), span[1].min(a.max(b))];
        }
        (span[0] <= span[1]).then_some(span)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::precision::Precision;

    fn unit_box() -> Bounds {
        Bounds::of([DVec3::ZERO, DVec3::ONE])
    }

    #[test]
    fn planes_enclose_the_box() {
        for precision in [Precision::Double, Precision::Single] {
            let grid = Grid::around(&unit_box(), 0.1, precision).unwrap();
            let cells = grid.cells();
            assert!(grid.node(IVec3::ONE).cmplt(DVec3::ZERO).all());
            assert!(grid.node(cells - IVec3::ONE).cmpgt(DVec3::ONE).all());
        }
    }

    #[test]
    fn single_planes_are_single() {
        let grid = Grid::around(&unit_box(), 0.013, Precision::Single).unwrap();
        for i in 0..grid.cells().x {
            let x = grid.node(IVec3::splat(i)).x;
            assert_eq!(x, f64::from(x as f32));
        }
    }

    #[test]
    fn nonsense_makes_no_grid() {
        let far = Bounds::of([DVec3::splat(1e9), DVec3::splat(1e9) + 1.0]);
        assert!(Grid::around(&unit_box(), 0.0, Precision::Double).is_none());
        assert!(Grid::around(&unit_box(), f64::NAN, Precision::Double).is_none());
        assert!(Grid::around(&unit_box(), 1e-9, Precision::Double).is_none());
        assert!(Grid::around(&far, 0.1, Precision::Single).is_none());
        assert!(Grid::around(&Bounds::of([]), 0.1, Precision::Double).is_none());
    }

    #[test]
    fn a_line_is_clipped() {
        let cell = CellBox {
            low: DVec3::ZERO,
            high: DVec3::ONE,
        };
        let span = cell.clip(DVec3::new(-1.0, 0.5, 0.5), DVec3::X).unwrap();
        assert_eq!(span, [1.0, 2.0]);
        assert!(cell.clip(DVec3::new(-1.0, 1.5, 0.5), DVec3::X).is_none());
    }
}
