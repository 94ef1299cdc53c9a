//! Sheets: triangles that hang together over edges with exactly two of them.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::edges::Edges;
use crate::mesh::sets::Sets;

/// Finds the sheets and turns triangles so that each sheet has one
/// orientation, as far as it can be oriented.
///
/// The largest component of a sheet's summed area vector becomes positive,
/// so that sheets side by side face the same way. (Of a sheet whose area
/// vectors cancel, the lowest triangle keeps its orientation.)
pub(super) fn orient(
    triangles: &mut [[u32; 3]],
    edges: &Edges,
    at: &dyn Fn(u32) -> DVec3,
) -> (Vec<u32>, u32) {
    const NONE: u32 = u32::MAX;
    let mut of_face = vec![NONE; triangles.len()];
    let mut turned = vec![false; triangles.len()];
    let mut count = 0;
    let mut queue = Vec::new();
    for seed in 0..triangles.len() {
        if of_face[seed] != NONE {
            continue;
        }
        let sheet = count;
        count += 1;
        of_face[seed] = sheet;
        queue.push(seed as u32);
        let mut next = 0;
        while let Some(&face) = queue.get(next) {
            next += 1;
            for &edge in &edges.of_face[face as usize] {
                let &[a, b] = edges.uses(edge as usize) else {
                    continue;
                };
                let other = if a / 3 == face { b / 3 } else { a / 3 };
                let same_way = start(triangles, a) == start(triangles, b);
                let wanted = turned[face as usize] != same_way;
                if of_face[other as usize] == NONE {
                    of_face[other as usize] = sheet;
                    turned[other as usize] = wanted;
                    queue.push(other);
                }
            }
        }
        let (mut sum, mut size) = (DVec3::ZERO, 0.0);
        for &face in &queue {
            let [a, b, c] = triangles[face as usize].map(at);
            let vector = (b - a).cross(c - a);
            size += vector.length();
            sum += if turned[face as usize] {
                -vector
            } else {
                vector
            };
        }
        let largest = sum.to_array()[sum.abs().max_position()];
        if largest < -1e-6 * size {
            for &face in &queue {
                turned[face as usize] ^= true;
            }
        }
        queue.clear();
    }
    for (triangle, _) in triangles.iter_mut().zip(turned).filter(|t| t.1) {
        triangle.swap(1, 2);
    }
    (of_face, count)
}

/// Vertex from which a face runs along one of its edges, by use.
fn start(triangles: &[[u32; 3]], slot: u32) -> u32 {
    triangles[slot as usize / 3][slot as usize % 3]
}

/// Shape of one sheet taken by itself, cut loose along seams.
#[derive(Clone, Copy, Default)]
pub(super) struct Shape {
    /// Euler characteristic.
    pub(super) euler: i64,
    /// Closed curves that bound it, seam sides included.
    pub(super) loops: usize,
    /// Whether no orientation suits all its triangles.
    pub(super) twisted: bool,
}

/// Shapes of all sheets.
///
/// A vertex of the loose sheet is a fan: corners of triangles joined over
/// edges with two triangles.
pub(super) fn shapes(
    triangles: &[[u32; 3]],
    edges: &Edges,
    sheet_of: &[u32],
    count: usize,
) -> Vec<Shape> {
    let mut fans = Sets::new(3 * triangles.len());
    let corner = |face: u32, vertex: u32| {
        let c = triangles[face as usize];
        let k = c.iter().position(|&v| v == vertex).unwrap_or(0);
        3 * face + k as u32
    };
    let mut shapes = vec![Shape::default(); count];
    for e in 0..edges.len() {
        if let Some([a, b]) = edges.pair(e) {
            for v in edges.ends[e] {
                fans.join(corner(a, v), corner(b, v));
            }
            let shape = &mut shapes[sheet_of[a as usize] as usize];
            shape.euler -= 1;
            shape.twisted |=
                start(triangles, edges.uses(e)[0]) == start(triangles, edges.uses(e)[1]);
        } else {
            for slot in edges.uses(e) {
                shapes[sheet_of[*slot as usize / 3] as usize].euler -= 1;
            }
        }
    }
    for slot in 0..3 * triangles.len() as u32 {
        let sheet = sheet_of[slot as usize / 3] as usize;
        let is_fan = fans.find(slot) == slot;
        shapes[sheet].euler += i64::from(is_fan) + i64::from(slot % 3 == 0);
    }
    // Fans joined along the sheet's rim are its boundary curves.
    let mut rims = Sets::new(3 * triangles.len());
    let mut on_rim: FxHashMap<u32, u32> = FxHashMap::default();
    for e in (0..edges.len()).filter(|&e| edges.pair(e).is_none()) {
        for slot in edges.uses(e) {
            let face = slot / 3;
            let [a, b] = edges.ends[e].map(|v| fans.find(corner(face, v)));
            rims.join(a, b);
            for fan in [a, b] {
                on_rim.insert(fan, sheet_of[face as usize]);
            }
        }
    }
    for (&fan, &sheet) in &on_rim {
        shapes[sheet as usize].loops += usize::from(rims.find(fan) == fan);
    }
    shapes
}
