//! Triangles on each other.
//!
//! Where a sheet only just bulges through a lattice face, the pieces in both
//! tetrahedra have all their corners in that face, lie on each other and enclose
//! nothing: a pillow.

use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use super::marked::{Line, MarkedMesh, edge};
use crate::mesh::sets::Sets;

/// Corners of a triangle in order of their numbers.
type Corners = [u32; 3];

fn sorted(mut t: Corners) -> Corners {
    t.sort_unstable();
    t
}

fn sides(t: Corners) -> [(u32, u32); 3] {
    [0, 1, 2].map(|k| edge(t[k], t[(k + 1) % 3]))
}

impl MarkedMesh {
    /// Drops pairs of triangles on the same three corners, but for those without
    /// which a sheet would end: one of a pair stays there.
    pub fn drop_pillows(&mut self) {
        let mut all: Vec<Corners> = self.triangles.iter().copied().map(sorted).collect();
        all.par_sort_unstable();
        let mut count: FxHashMap<Corners, usize> = (all.chunk_by(|a, b| a == b))
            .filter(|same| same.len() > 1)
            .map(|same| (same[0], same.len()))
            .collect();
        drop(all);
        if count.is_empty() {
            return;
        }
        for t in self.stoppers(&count) {
            count.insert(t, 1);
        }
        self.triangles.retain(|&t| match count.get_mut(&sorted(t)) {
            // Of an odd number one stays, the first.
            Some(n) => std::mem::take(n) % 2 == 1,
            None => true,
        });
    }

    /// Of triangles that come so many times those of an even number of which one
    /// must stay. A seam that runs in a face has two sheets on each other there, of
    /// which the third goes on as one: all pillows side by side stay, if that closes
    /// it and opens nothing. Marks their sides that become seams so.
    fn stoppers(&mut self, count: &FxHashMap<Corners, usize>) -> Vec<Corners> {
        let mut pillows: Vec<Corners> = (count.iter())
            .filter(|(_, n)| *n % 2 == 0)
            .map(|(&t, _)| t)
            .collect();
        pillows.sort_unstable();
        let mut uses = self.uses_without(count, &pillows);
        // Those side by side hold only each other.
        let mut groups = Sets::new(pillows.len());
        let mut first: FxHashMap<(u32, u32), u32> = FxHashMap::default();
        for (n, &t) in (0..).zip(&pillows) {
            for side in sides(t).into_iter().filter(|side| uses[side] == 0) {
                groups.join(*first.entry(side).or_insert(n), n);
            }
        }
        let (labels, groups) = groups.labels();
        let mut members: Vec<Vec<Corners>> = vec![Vec::new(); groups];
        for (&t, label) in pillows.iter().zip(labels) {
            members[label as usize].push(t);
        }
        let mut kept = Vec::new();
        for group in members {
            let mut own: FxHashMap<(u32, u32), usize> = FxHashMap::default();
            for side in group.iter().flat_map(|&t| sides(t)) {
                *own.entry(side).or_default() += 1;
            }
            let is_open = |side: &(u32, u32), uses: usize| {
                let line = self.lines.get(side);
                uses == 1 && !matches!(line, Some(Line::CopingBorder | Line::FadingBorder))
            };
            let closes = own.keys().any(|side| is_open(side, uses[side]));
            let opens = own.iter().any(|(side, n)| is_open(side, uses[side] + n));
            if closes && !opens {
                for (side, n) in own {
                    *uses.entry(side).or_default() += n;
                }
                kept.extend(group);
            }
        }
        for side in kept.iter().flat_map(|&t| sides(t)) {
            if uses[&side] > 2 {
                self.lines.entry(side).or_insert(Line::Seam);
            }
        }
        kept
    }

    /// Triangles at each side of the pillows, without these.
    fn uses_without(
        &self,
        count: &FxHashMap<Corners, usize>,
        pillows: &[Corners],
    ) -> FxHashMap<(u32, u32), usize> {
        let mut uses: FxHashMap<(u32, u32), usize> = (pillows.iter())
            .flat_map(|&t| sides(t))
            .map(|side| (side, 0))
            .collect();
        let mut seen: FxHashSet<Corners> = FxHashSet::default();
        for t in self.triangles.iter().copied().map(sorted) {
            // Of an odd number one stays.
            let stays = match count.get(&t) {
                Some(n) => n % 2 == 1 && seen.insert(t),
                None => true,
            };
            if stays {
                for side in sides(t) {
                    uses.entry(side).and_modify(|n| *n += 1);
                }
            }
        }
        uses
    }
}
