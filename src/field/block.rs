//! Rough distances from a point to four triangles at once, in f32.
//!
//! Each triangle is kept in its own frame: the origin at one end of its longest
//! edge, `x` along that edge, `z` along the normal. In that frame it is flat,
//! with corners `(0, 0)`, `(length, 0)` and `apex`, where `apex.y >= 0` and
//! `0 <= apex.x <= length`:
//!
//! ```text
//!           apex
//!          /    \
//!        /        \        y
//!      /            \      ^
//!     0 ------------ length -> x
//! ```
//!
//! # Error
//!
//! With `u = 2^-24` and `q` the vector from the origin to the query point, the
//! three frame coordinates of `q` are off by at most `5 u |q|` (`x`, `z`) and
//! `9 u |q|` (`y`, whose axis is a computed cross product). The flat problem adds
//! less than `8 u |q|`: a foot that is off along an edge, or an edge chosen
//! instead of the interior, lengthens the distance by no more than it is off.
//! Rounding query and origin adds `2 u` times their size. In tree units, where
//! `|q| <= sqrt(3) (1 + reach)` with `reach` the greatest coordinate of the
//! query, all of this is below [`error`]. The bound holds for slivers as well,
//! because the frame comes from f64 and is orthonormal whatever the shape.

use glam::{BVec4A, DVec3, Vec4};

use super::frame::Frame;
use super::triangle::Triangle;

/// Triangles a block.
pub(super) const LANES: usize = 4;

/// Bound on the error of [`Block::squares`] after taking the root, for a query
/// whose greatest coordinate in tree units is `reach`.
pub(super) fn error(reach: f64) -> f64 {
    4e-6 * (1.0 + reach)
}

/// Four triangles, lane by lane; 192 bytes, three cache lines.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(super) struct Block {
    origin: [Vec4; 3],
    x: [Vec4; 3],
    z: [Vec4; 3],
    length: Vec4,
    apex: [Vec4; 2],
}

impl Block {
    /// One to four triangles; free lanes repeat the last.
    pub fn new(triangles: &[Triangle], frame: Frame) -> Block {
        let lanes: [Flat; LANES] =
            std::array::from_fn(|i| Flat::new(&triangles[i.min(triangles.len() - 1)], frame));
        let gather =
            |f: &dyn Fn(&Flat) -> f64| Vec4::from_array(lanes.each_ref().map(|t| f(t) as f32));
        let vector = |f: &dyn Fn(&Flat) -> DVec3| {
            [
                gather(&|t| f(t).x),
                gather(&|t| f(t).y),
                gather(&|t| f(t).z),
            ]
        };
        Block {
            origin: vector(&|t| t.origin),
            x: vector(&|t| t.x),
            z: vector(&|t| t.z),
            length: gather(&|t| t.length),
            apex: [gather(&|t| t.apex.0), gather(&|t| t.apex.1)],
        }
    }

    /// Squared distances from `p` (tree units) to the four triangles.
    #[inline]
    pub fn squares(&self, p: [Vec4; 3]) -> Vec4 {
        let q = [0, 1, 2].map(|i| p[i] - self.origin[i]);
        let [x, z] = [&self.x, &self.z];
        let y = [
            z[1] * x[2] - z[2] * x[1],
            z[2] * x[0] - z[0] * x[2],
            z[0] * x[1] - z[1] * x[0],
        ];
        let px = q[0] * x[0] + q[1] * x[1] + q[2] * x[2];
        let py = q[0] * y[0] + q[1] * y[1] + q[2] * y[2];
        let pz = q[0] * z[0] + q[1] * z[1] + q[2] * z[2];

        let [ax, ay] = self.apex;
        let base_x = px - px.max(Vec4::ZERO).min(self.length);
        let base = base_x * base_x + py * py;
        let (left, left_side) = slanted(px, py, ax, ay);
        let (rx, right_x) = (px - self.length, ax - self.length);
        let (right, right_side) = slanted(rx, py, right_x, ay);

        // Left of the right edge, right of the left one, above the base.
        let beyond = (-left_side).max(right_side).max(-py);
        let inside: BVec4A = beyond.cmple(Vec4::ZERO);
        let flat = Vec4::select(inside, Vec4::ZERO, base.min(left).min(right));
        flat + pz * pz
    }
}

/// For the edge from the origin to `(ex, ey)`: squared distance of `(x, y)`,
/// and the side, positive to the right.
#[inline]
fn slanted(x: Vec4, y: Vec4, ex: Vec4, ey: Vec4) -> (Vec4, Vec4) {
    // Kept above zero, so that the quotient is a number.
    let square = (ex * ex + ey * ey).max(Vec4::splat(f32::MIN_POSITIVE));
    let along = ((x * ex + y * ey) / square).max(Vec4::ZERO).min(Vec4::ONE);
    let (dx, dy) = (x - along * ex, y - along * ey);
    (dx * dx + dy * dy, x * ey - y * ex)
}

/// One triangle in its own frame.
struct Flat {
    origin: DVec3,
    x: DVec3,
    z: DVec3,
    length: f64,
    apex: (f64, f64),
}

impl Flat {
    fn new(triangle: &Triangle, frame: Frame) -> Flat {
        let c = triangle.corners;
        let edge = |i: usize| (c[(i + 1) % 3] - c[i]) * frame.scale;
        let longest = (0..3)
            .max_by(|&i, &j| {
                edge(i)
                    .length_squared()
                    .total_cmp(&edge(j).length_squared())
            })
            .unwrap_or(0);
        let along = edge(longest);
        let length = along.length();
        let x = along / length;
        let to_apex = -edge((longest + 2) % 3);
        // Twice, so that what is left of a sliver is still square to `x`.
        let up = to_apex - x * x.dot(to_apex);
        let up = up - x * x.dot(up);
        let y = up
            .try_normalize()
            .unwrap_or_else(|| x.any_orthonormal_vector());
        let y = (y - x * x.dot(y)).normalize();
        Flat {
            origin: frame.to_tree(c[longest]),
            x,
            z: x.cross(y),
            length,
            apex: (x.dot(to_apex), up.length()),
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::FaceId;
    use super::*;

    fn check(corners: [DVec3; 3], p: DVec3) -> Result<(), TestCaseError> {
        let low = corners[0].min(corners[1]).min(corners[2]);
        let high = corners[0].max(corners[1]).max(corners[2]);
        let frame = Frame::new(low, high);
        let triangle = Triangle::new(corners, FaceId(0));
        if triangle.is_degenerate() {
            return Ok(());
        }
        let block = Block::new(std::slice::from_ref(&triangle), frame);
        let local = frame.to_tree(p);
        let query = local.to_array().map(|x| Vec4::splat(x as f32));
        let exact = triangle.closest(p).square.sqrt() * frame.scale;
        let bound = error(local.abs().max_element());
        for square in block.squares(query).to_array() {
            let rough = f64::from(square).sqrt();
            prop_assert!(
                (rough - exact).abs() <= bound,
                "{corners:?} {p:?}: {rough} for {exact}, off by {:e}, bound {bound:e}",
                rough - exact
            );
        }
        Ok(())
    }

    fn vector(reach: f64) -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-reach..reach).prop_map(DVec3::from)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        #[test]
        fn error_is_bounded(
            a in vector(1.0),
            b in vector(1.0),
            c in vector(1.0),
            p in vector(1.0),
            flatness in 0..16_i32,
            shrink in 0..6_i32,
            away in 0..5_i32,
            shift in prop::sample::select(vec![0.0, 1.0, 1e4]),
        ) {
            // Slivers of every height: the apex approaches the line a-b.
            let foot = a.lerp(b, c.x);
            let apex = foot + (c - foot) * 10.0_f64.powi(-flatness);
            // Small ones beside a query at the part's own scale, too.
            let size = 10.0_f64.powi(-shrink);
            let place = |x: DVec3| x * size + DVec3::splat(shift);
            check([a, b, apex].map(place), place(p * 10.0_f64.powi(away - 2)))?;
        }
    }
}
