//! A picture of a mesh in colours, from two sides: PNG, drawn with a depth
//! buffer, for whoever has no viewer at hand.

use std::io::{self, Write};
use std::path::Path;

use glam::DVec3;

use super::{Staged, WriteError, stage};
use crate::mesh::TriMesh;

/// Pixels of one of the two views.
const SIZE: usize = 900;

/// Directions from which the part is seen: from above and from below.
const VIEWS: [DVec3; 2] = [DVec3::new(1.0, -1.2, 0.9), DVec3::new(-1.0, 1.1, -0.9)];

/// Margin around the part, as a share of the picture.
const MARGIN: f64 = 0.04;

/// Writes a picture with one colour a triangle, to a place beside its target;
/// nothing shows under its name before [`Staged::commit`].
///
/// # Errors
///
/// [`WriteError`] names the file.
///
/// # Panics
///
/// If there are fewer colours than triangles.
pub fn stage_picture(
    mesh: &TriMesh,
    colours: &[[u8; 3]],
    file: &Path,
) -> Result<Staged, WriteError> {
    let suffix = file.extension().and_then(|suffix| suffix.to_str());
    if !suffix.is_some_and(|suffix| suffix.eq_ignore_ascii_case("png")) {
        return Err(WriteError::UnknownFormat {
            file: file.to_owned(),
            known: ".png",
        });
    }
    stage(file, |out| write(mesh, colours, out))
}

fn write(mesh: &TriMesh, colours: &[[u8; 3]], out: &mut dyn Write) -> io::Result<()> {
    let views = VIEWS.map(|from| View::new(mesh, from).draw(mesh, colours));
    let mut pixels = Vec::with_capacity(2 * SIZE * SIZE * 3);
    for row in 0..SIZE {
        for view in &views {
            pixels.extend(view[row * SIZE..(row + 1) * SIZE].iter().flatten());
        }
    }
    let mut encoder = png::Encoder::new(out, 2 * SIZE as u32, SIZE as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().map_err(io::Error::other)?;
    writer.write_image_data(&pixels).map_err(io::Error::other)?;
    writer.finish().map_err(io::Error::other)
}

/// A parallel projection that shows the whole part.
struct View {
    right: DVec3,
    up: DVec3,
    towards: DVec3,
    /// Pixels a part unit.
    scale: f64,
    /// Middle of what is seen, along right and up.
    middle: [f64; 2],
}

impl View {
    fn new(mesh: &TriMesh, from: DVec3) -> View {
        let towards = from.normalize();
        let right = DVec3::Z.cross(towards).normalize();
        let up = towards.cross(right);
        let extent = |axis: DVec3| {
            let along = mesh.positions.iter().map(|p| p.dot(axis));
            along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (low.min(x), high.max(x))
            })
        };
        let (left, far_right) = extent(right);
        let (bottom, top) = extent(up);
        let widest = (far_right - left).max(top - bottom).max(f64::MIN_POSITIVE);
        View {
            right,
            up,
            towards,
            scale: SIZE as f64 * (1.0 - 2.0 * MARGIN) / widest,
            middle: [0.5 * (left + far_right), 0.5 * (bottom + top)],
        }
    }

    /// Column, row and height towards the viewer, in pixels.
    fn project(&self, p: DVec3) -> [f64; 3] {
        let half = 0.5 * SIZE as f64;
        [
            half + self.scale * (p.dot(self.right) - self.middle[0]),
            half - self.scale * (p.dot(self.up) - self.middle[1]),
            self.scale * p.dot(self.towards),
        ]
    }

    fn draw(&self, mesh: &TriMesh, colours: &[[u8; 3]]) -> Vec<[u8; 3]> {
        let mut pixels = vec![[255; 3]; SIZE * SIZE];
        let mut depths = vec![f64::NEG_INFINITY; SIZE * SIZE];
        for face in mesh.faces() {
            let normal = mesh.area_vector(face).normalize_or_zero();
            // Light from the viewer; the back of an open mesh is dark.
            let light = 0.35 + 0.65 * normal.dot(self.towards).max(0.0);
            let colour = colours[face.index()].map(|c| (f64::from(c) * light) as u8);
            let corners = mesh.corners(face).map(|p| self.project(p));
            fill(corners, |at, depth| {
                if depth > depths[at] {
                    depths[at] = depth;
                    pixels[at] = colour;
                }
            });
        }
        pixels
    }
}

/// Visits the pixels whose middle lies in a triangle, with their depth.
fn fill([a, b, c]: [[f64; 3]; 3], mut visit: impl FnMut(usize, f64)) {
    let side = |p: [f64; 3], q: [f64; 3], x: f64, y: f64| {
        (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0])
    };
    let area = side(a, b, c[0], c[1]);
    if area == 0.0 || !area.is_finite() {
        return;
    }
    let range = |k: usize| {
        let low = a[k].min(b[k]).min(c[k]).max(0.0).floor() as usize;
        let high = a[k].max(b[k]).max(c[k]).ceil().clamp(0.0, SIZE as f64) as usize;
        low..high
    };
    for row in range(1) {
        for column in range(0) {
            let (x, y) = (column as f64 + 0.5, row as f64 + 0.5);
            let u = side(b, c, x, y) / area;
            let v = side(c, a, x, y) / area;
            let w = 1.0 - u - v;
            if u >= 0.0 && v >= 0.0 && w >= 0.0 {
                visit(row * SIZE + column, u * a[2] + v * b[2] + w * c[2]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square towards the viewer, in front of a larger one.
    #[test]
    fn what_is_in_front_hides_what_is_behind() {
        let towards = VIEWS[0].normalize();
        let right = DVec3::Z.cross(towards).normalize();
        let up = towards.cross(right);
        let mut mesh = TriMesh::default();
        for (height, half) in [(1.0, 0.5), (0.0, 1.0)] {
            let first = mesh.positions.len() as u32;
            for (x, y) in [(-half, -half), (half, -half), (half, half), (-half, half)] {
                mesh.positions.push(x * right + y * up + height * towards);
            }
            mesh.triangles.push([first, first + 1, first + 2]);
            mesh.triangles.push([first, first + 2, first + 3]);
        }
        let [red, blue] = [[200, 0, 0], [0, 0, 200]];
        let pixels = View::new(&mesh, VIEWS[0]).draw(&mesh, &[red, red, blue, blue]);
        let count = |colour: [u8; 3]| pixels.iter().filter(|&&p| p == colour).count() as f64;
        let whole = (SIZE as f64 * (1.0 - 2.0 * MARGIN)).powi(2);
        // 200 lit from the front may lose one step to rounding.
        let red = count(red) + count([199, 0, 0]);
        let blue = count(blue) + count([0, 0, 199]);
        assert!((red / whole - 0.25).abs() < 0.01, "{red}");
        assert!((blue / whole - 0.75).abs() < 0.01, "{blue}");
    }
}
