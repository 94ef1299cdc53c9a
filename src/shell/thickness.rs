//! Thickness of nodes where the ball alone does not tell it.

use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use super::{ShellElement, ShellNode};
use crate::surface::{MidSurface, segments};

/// Length, in thicknesses, over which an element spreads the ball's excess
/// without making more of it.
///
/// Beside a T of equal walls the ball's diameter is t + s^2 / t at the distance
/// s < t / 2 from where it starts to grow, t / 4 too much at the seam: that is
/// t^2 / 24 in all, as under a straight line of length t / 3. At a sharp bend of
/// a right angle the line is 0.28 t long.
const SPREAD: f64 = 0.3;

/// Gives nodes without a thickness, where a wall was not found, the mean of
/// their neighbours', from the rim of such a place inwards; how many there
/// were. Where no node has one they stay as they are.
pub(super) fn fill(elements: &[ShellElement], nodes: &mut [ShellNode]) -> usize {
    let unknown = |n: &ShellNode| n.thickness <= 0.0;
    let count = nodes.iter().filter(|n| unknown(n)).count();
    let mut left = count;
    while left > 0 {
        let mut sums: FxHashMap<u32, (f64, f64)> = FxHashMap::default();
        for element in elements {
            let corners = element.corners();
            let known = corners.iter().map(|&n| nodes[n as usize].thickness);
            let known: SmallVec<[f64; 4]> = known.filter(|&t| t > 0.0).collect();
            for &n in corners.iter().filter(|&&n| unknown(&nodes[n as usize])) {
                let sum = sums.entry(n).or_default();
                *sum = (
                    sum.0 + known.iter().sum::<f64>(),
                    sum.1 + known.len() as f64,
                );
            }
        }
        sums.retain(|_, sum| sum.1 > 0.0);
        if sums.is_empty() {
            break;
        }
        left -= sums.len();
        for (n, (sum, of)) in sums {
            nodes[n as usize].thickness = sum / of;
        }
    }
    count
}

/// Takes the ball's excess at seams and creases down to what the elements there
/// can carry: a linear element as long as several thicknesses would make the
/// wall too thick along its whole length.
pub(super) fn fit(surface: &MidSurface, elements: &[ShellElement], nodes: &mut [ShellNode]) {
    let mut tied = vec![false; nodes.len()];
    let seams = surface.seams().iter().map(|l| (&l.path, l.closed));
    let creases = surface.creases().iter().map(|l| (&l.path, l.closed));
    for (path, closed) in seams.chain(creases) {
        for v in segments(path, closed).flatten() {
            tied[v as usize] = true;
        }
    }
    // Thickness and distance of the neighbours that are on no such line, each
    // as often as elements have the side.
    let mut around: FxHashMap<u32, (f64, f64, f64)> = FxHashMap::default();
    for element in elements {
        let corners = element.corners();
        for k in 0..corners.len() {
            let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
            for (own, other) in [(a, b), (b, a)] {
                if tied[own as usize] && !tied[other as usize] {
                    let [p, q] = [own, other].map(|n| &nodes[n as usize]);
                    let sum = around.entry(own).or_default();
                    sum.0 += q.thickness;
                    sum.1 += p.position.distance(q.position);
                    sum.2 += 1.0;
                }
            }
        }
    }
    for (own, (thickness, distance, count)) in around {
        let node = &mut nodes[own as usize];
        let (wall, length) = (thickness / count, distance / count);
        let excess = node.thickness - wall;
        if excess > 0.0 {
            node.thickness = wall + excess * (SPREAD * wall / length).min(1.0);
        }
    }
}
