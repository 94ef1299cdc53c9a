//! A face on which a follower was lost, cut to small triangles and solved again.
//!
//! The paper searches smaller and smaller circles where a contour is lost.
//! Here the face is cut evenly, each cut is solved like a lattice edge, by the
//! nearest walls along it, and the contours of the small triangles chain over
//! the cuts: every crossing of a cut has a contour on both of its sides. So
//! what a follower does not see costs a piece of the size of a small triangle,
//! which closes by parity: its ends are joined in the order round it, by the
//! walls that they lie between. All vertices on the way are solved.

use glam::DVec3;
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use super::contour;
use super::face::{ArcEnd, FaceArc, FaceContours, FaceNode, FaceNodeKind, FaceSeed, follow_all};
use super::fan::{Spoke, alike};
use super::region::{Barrier, Region};
use crate::trace::edge::{Crossing, NodeSample, crossings, sample_node};
use crate::trace::probe::{Pair, Probe};
use crate::trace::tolerances::Tolerances;

/// Rounds in which small triangles are solved again because a contour came to
/// a cut where no vertex was known.
const MOST_ROUNDS: usize = 8;

/// A side of small triangles.
struct Cut {
    /// From and to; walls of its crossings are in this order.
    ends: [usize; 2],
    crossings: Vec<Crossing>,
    /// The side of the whole face that it is part of, and the numbers of its
    /// crossings there.
    outer: Option<(usize, Vec<u16>)>,
    /// Small triangles at it.
    triangles: SmallVec<[usize; 2]>,
}

/// A small triangle.
struct Piece {
    corners: [usize; 3],
    cuts: [usize; 3],
    seeds: Vec<FaceSeed>,
    solved: FaceContours,
}

/// A face as small triangles.
pub(super) struct Refined<'r> {
    whole: &'r Region,
    steps: usize,
    near: f64,
    points: Vec<DVec3>,
    cuts: Vec<Cut>,
    pieces: Vec<Piece>,
    /// Vertices known on the sides of the whole face.
    known: [usize; 3],
    found: Vec<(u8, Crossing)>,
}

impl<'r> Refined<'r> {
    /// Cuts each side of a triangle into `steps`, and solves.
    pub(super) fn new(
        probe: &mut Probe,
        whole: &'r Region,
        steps: usize,
        sides: [&[Crossing]; 3],
        low_first: [bool; 3],
        seeds: &[FaceSeed],
    ) -> Refined<'r> {
        let mut face = Refined {
            whole,
            steps,
            near: Tolerances::new(probe.walls().tolerances(), whole.diameter()).same_point,
            points: Vec::new(),
            cuts: Vec::new(),
            pieces: Vec::new(),
            known: sides.map(|s| s.len()),
            found: Vec::new(),
        };
        face.lay_out(low_first);
        face.solve_cuts(probe);
        face.take_over(sides, low_first);
        face.plant(seeds);
        face.solve_pieces(probe);
        face
    }

    fn number(&self, i: usize, j: usize) -> usize {
        // Row `j` has one point less than the row before.
        j * (self.steps + 1) - j * j.saturating_sub(1) / 2 + i
    }

    fn lay_out(&mut self, low_first: [bool; 3]) {
        let n = self.steps;
        let [a, b, c] = [0, 1, 2].map(|k| self.whole.corners[k]);
        for j in 0..=n {
            for i in 0..=n - j {
                let (s, t) = (i as f64 / n as f64, j as f64 / n as f64);
                self.points.push(a + s * (b - a) + t * (c - a));
            }
        }
        let mut cut_of: FxHashMap<[usize; 2], usize> = FxHashMap::default();
        for j in 0..n {
            for i in 0..n - j {
                let mut corners = vec![[(i, j), (i + 1, j), (i, j + 1)]];
                if i + j + 1 < n {
                    corners.push([(i + 1, j), (i + 1, j + 1), (i, j + 1)]);
                }
                for [p, q, r] in corners {
                    let piece = self.pieces.len();
                    let cuts = [[p, q], [q, r], [r, p]].map(|[p, q]| {
                        let [from, to] = [p, q].map(|(i, j)| self.number(i, j));
                        let name = [from.min(to), from.max(to)];
                        let cut = *cut_of.entry(name).or_insert_with(|| {
                            let on = [
                                p.1 == 0 && q.1 == 0,
                                p.0 + p.1 == n && q.0 + q.1 == n,
                                p.0 == 0 && q.0 == 0,
                            ];
                            let outer = on.iter().position(|&o| o);
                            let along = outer.is_none_or(|side| low_first[side]);
                            self.cuts.push(Cut {
                                ends: if along { [from, to] } else { [to, from] },
                                crossings: Vec::new(),
                                outer: outer.map(|side| (side, Vec::new())),
                                triangles: SmallVec::new(),
                            });
                            self.cuts.len() - 1
                        });
                        self.cuts[cut].triangles.push(piece);
                        cut
                    });
                    self.pieces.push(Piece {
                        corners: [p, q, r].map(|(i, j)| self.number(i, j)),
                        cuts,
                        seeds: Vec::new(),
                        solved: FaceContours::default(),
                    });
                }
            }
        }
    }

    fn solve_cuts(&mut self, probe: &mut Probe) {
        let samples: Vec<NodeSample> = (self.points.iter())
            .map(|&p| sample_node(probe, p))
            .collect();
        for cut in self.cuts.iter_mut().filter(|c| c.outer.is_none()) {
            let [from, to] = cut.ends;
            let ends = [self.points[from], self.points[to]];
            cut.crossings = crossings(probe, ends, [&samples[from], &samples[to]]).into_vec();
        }
    }

    /// Vertices of the sides of the whole face belong to the small triangles there.
    fn take_over(&mut self, sides: [&[Crossing]; 3], low_first: [bool; 3]) {
        for (s, list) in sides.iter().enumerate() {
            let (p, q) = self.whole.side(s);
            for (number, &crossing) in list.iter().enumerate() {
                let place = (crossing.at - p).dot(q - p) / (q - p).length_squared();
                let step = (place * self.steps as f64).clamp(0.0, self.steps as f64 - 1.0);
                let end = |k: usize| match s {
                    0 => self.number(k, 0),
                    1 => self.number(self.steps - k, k),
                    _ => self.number(0, self.steps - k),
                };
                let (from, to) = (end(step as usize), end(step as usize + 1));
                let ends = if low_first[s] { [from, to] } else { [to, from] };
                if let Some(cut) = self.cuts.iter_mut().find(|c| c.ends == ends)
                    && let Some((_, numbers)) = &mut cut.outer
                {
                    numbers.push(number as u16);
                    cut.crossings.push(crossing);
                }
            }
        }
    }

    fn plant(&mut self, seeds: &[FaceSeed]) {
        for seed in seeds {
            let inside = |piece: &Piece| {
                self.region(piece, Barrier::None)
                    .map_or(f64::INFINITY, |r| r.excess(seed.at))
            };
            let best = (0..self.pieces.len())
                .min_by(|&a, &b| inside(&self.pieces[a]).total_cmp(&inside(&self.pieces[b])));
            if let Some(piece) = best {
                self.pieces[piece].seeds.push(*seed);
            }
        }
    }

    fn region(&self, piece: &Piece, barrier: Barrier) -> Option<Region> {
        let corners = piece.corners.map(|c| self.points[c]);
        Region::new(corners.into_iter().collect(), barrier)
    }

    fn solve_pieces(&mut self, probe: &mut Probe) {
        let mut todo: Vec<usize> = (0..self.pieces.len()).collect();
        for _ in 0..MOST_ROUNDS {
            let mut again: Vec<usize> = Vec::new();
            for piece in std::mem::take(&mut todo) {
                self.solve_piece(probe, piece);
                let found = std::mem::take(&mut self.pieces[piece].solved.found);
                for (side, crossing) in found {
                    let cut = self.pieces[piece].cuts[side as usize];
                    self.add_crossing(probe, cut, crossing);
                    again.extend(&self.cuts[cut].triangles);
                }
            }
            again.sort_unstable();
            again.dedup();
            if again.is_empty() {
                break;
            }
            todo = again;
        }
    }

    fn solve_piece(&mut self, probe: &mut Probe, number: usize) {
        let piece = &self.pieces[number];
        let sides = piece.cuts.map(|c| &self.cuts[c].crossings[..]);
        let low_first = [0, 1, 2].map(|k| self.cuts[piece.cuts[k]].ends[0] == piece.corners[k]);
        if piece.seeds.is_empty() && sides.iter().all(|s| s.is_empty()) {
            return;
        }
        let barrier = match self.whole.barrier {
            Barrier::Coping => Barrier::Coping,
            _ => Barrier::None,
        };
        if let Some(region) = self.region(piece, barrier) {
            let solved = follow_all(probe, region, sides, low_first, &piece.seeds);
            self.pieces[number].solved = solved.closed(probe);
        }
    }

    fn add_crossing(&mut self, probe: &Probe, cut: usize, crossing: Crossing) {
        let (near, field) = (self.near, probe.field());
        let same = |c: &Crossing| {
            c.at.distance(crossing.at) <= near && alike(field, c.at, c.walls, crossing.walls)
        };
        let side = |c: &Cut| c.outer.as_ref().map(|o| o.0);
        let on = side(&self.cuts[cut]);
        // At a point between two cuts of a side it may belong to the other.
        let beside = (self.cuts.iter().enumerate())
            .filter(|(k, c)| *k == cut || (on.is_some() && side(c) == on));
        if (beside.flat_map(|(_, c)| &c.crossings)).any(same) {
            return;
        }
        let cut = &mut self.cuts[cut];
        cut.crossings.push(crossing);
        if let Some((side, numbers)) = &mut cut.outer {
            let before = self.found.iter().filter(|f| f.0 as usize == *side).count();
            numbers.push((self.known[*side] + before) as u16);
            self.found.push((*side as u8, crossing));
        }
    }

    /// Whether every small triangle was solved without closing anything by its walls.
    pub(super) fn is_sound(&self) -> bool {
        let sound = |p: &Piece| p.solved.lost.is_empty() && p.solved.matched == 0;
        self.pieces.iter().all(sound)
    }

    /// The contours of the whole face: those of the small triangles chained
    /// over the cuts, with the crossings on the way that they need to stay
    /// within `slack` of where they run.
    pub(super) fn contours(&self, probe: &Probe, slack: f64) -> FaceContours {
        let mut out = FaceContours {
            found: self.found.clone(),
            ..FaceContours::default()
        };
        let mut first_node = Vec::new();
        for piece in &self.pieces {
            first_node.push(out.nodes.len() as u16);
            out.nodes.extend(piece.solved.nodes.iter().cloned());
            out.lost.extend(&piece.solved.lost);
            out.matched += piece.solved.matched;
        }
        for chain in self.chains(&first_node) {
            self.add_chain(probe, &chain, slack, &mut out);
        }
        out
    }

    /// Where an end of a contour of a small triangle lies in the whole face.
    fn end(&self, piece: usize, end: ArcEnd, first_node: &[u16]) -> Option<End> {
        match end {
            ArcEnd::Spoke { node, spoke } => Some(End::Face(ArcEnd::Spoke {
                node: first_node[piece] + node,
                spoke,
            })),
            ArcEnd::Crossing { side, index } => {
                let cut = self.pieces[piece].cuts[side as usize];
                let place = Place {
                    cut,
                    index: index as usize,
                };
                self.cuts[cut].crossings.get(place.index)?;
                Some(match &self.cuts[cut].outer {
                    None => End::Cut(place),
                    Some((side, numbers)) => End::Face(ArcEnd::Crossing {
                        side: *side as u8,
                        index: *numbers.get(place.index)?,
                    }),
                })
            }
        }
    }

    /// Contours of small triangles joined over the cuts. Closed ones are left
    /// out: there a sheet only bulges through the face.
    fn chains(&self, first_node: &[u16]) -> Vec<Chain> {
        let mut arcs: Vec<[End; 2]> = Vec::new();
        for (number, piece) in self.pieces.iter().enumerate() {
            for arc in &piece.solved.arcs {
                if let [Some(a), Some(b)] = arc.ends.map(|e| self.end(number, e, first_node)) {
                    arcs.push([a, b]);
                }
            }
        }
        let mut at: FxHashMap<Place, SmallVec<[usize; 2]>> = FxHashMap::default();
        for (k, arc) in arcs.iter().enumerate() {
            for end in arc {
                if let End::Cut(place) = end {
                    at.entry(*place).or_default().push(k);
                }
            }
        }
        let beyond = |end: End, arc: usize| match end {
            End::Cut(place) => at[&place].iter().copied().find(|&k| k != arc),
            End::Face(_) => None,
        };
        let mut used = vec![false; arcs.len()];
        let mut chains = Vec::new();
        for first in 0..arcs.len() {
            let start = (arcs[first].into_iter()).find(|&end| beyond(end, first).is_none());
            let Some(start) = start.filter(|_| !used[first]) else {
                continue;
            };
            let mut chain = Chain {
                ends: [start; 2],
                between: Vec::new(),
            };
            let (mut arc, mut near) = (first, start);
            loop {
                used[arc] = true;
                let [a, b] = arcs[arc];
                let far = if a == near { b } else { a };
                chain.ends[1] = far;
                match (far, beyond(far, arc)) {
                    (End::Cut(place), Some(next)) if !used[next] => {
                        chain.between.push(place);
                        (arc, near) = (next, far);
                    }
                    _ => break,
                }
            }
            chains.push(chain);
        }
        chains
    }

    fn add_chain(&self, probe: &Probe, chain: &Chain, slack: f64, out: &mut FaceContours) {
        let inside = |end: End| match end {
            End::Cut(_) => true,
            End::Face(ArcEnd::Spoke { node, .. }) => matches!(
                out.nodes[node as usize].kind,
                FaceNodeKind::Fading | FaceNodeKind::Torn
            ),
            End::Face(ArcEnd::Crossing { .. }) => false,
        };
        if chain.ends.into_iter().all(inside) {
            // A scrap of a weak sheet, which no neighbour reaches.
            for end in chain.ends {
                if let End::Face(ArcEnd::Spoke { node, .. }) = end {
                    out.nodes[node as usize].spokes.clear();
                }
            }
            return;
        }
        let places: Vec<DVec3> = std::iter::once(self.place(chain.ends[0], out))
            .chain(chain.between.iter().map(|&p| self.crossing(p).at))
            .chain([self.place(chain.ends[1], out)])
            .collect();
        let mut last = self.face_end(probe, chain.ends[0], out);
        for k in needed(&places, slack) {
            let spokes = self.spokes(probe, chain.between[k - 1], places[k - 1] - places[k]);
            let node = self.add_node(chain.between[k - 1], FaceNodeKind::Tie, spokes, out);
            let spoke = |spoke| ArcEnd::Spoke { node, spoke };
            out.arcs.push(FaceArc {
                ends: [last, spoke(0)],
            });
            last = spoke(1);
        }
        let ends = [last, self.face_end(probe, chain.ends[1], out)];
        out.arcs.push(FaceArc { ends });
    }

    fn crossing(&self, place: Place) -> &Crossing {
        &self.cuts[place.cut].crossings[place.index]
    }

    fn place(&self, end: End, out: &FaceContours) -> DVec3 {
        match end {
            End::Cut(place) => self.crossing(place).at,
            End::Face(ArcEnd::Spoke { node, .. }) => out.nodes[node as usize].at,
            End::Face(ArcEnd::Crossing { side, index }) => (self.cuts.iter())
                .find_map(|cut| {
                    let (s, numbers) = cut.outer.as_ref()?;
                    let k = numbers.iter().position(|&n| n == index)?;
                    (*s == side as usize).then(|| cut.crossings[k].at)
                })
                .unwrap_or(self.whole.corners[side as usize]),
        }
    }

    /// An end of a chain as an end of the face. A contour that is not known
    /// beyond a cut is torn there.
    fn face_end(&self, probe: &Probe, end: End, out: &mut FaceContours) -> ArcEnd {
        match end {
            End::Face(end) => end,
            End::Cut(place) => {
                let mut spokes = self.spokes(probe, place, DVec3::ZERO);
                spokes.truncate(1);
                out.matched += 1;
                let node = self.add_node(place, FaceNodeKind::Torn, spokes, out);
                ArcEnd::Spoke { node, spoke: 0 }
            }
        }
    }

    /// What leaves the vertex of a crossing: back along `back`, and on.
    fn spokes(&self, probe: &Probe, place: Place, back: DVec3) -> SmallVec<[Spoke; 4]> {
        let (normal, crossing) = (self.whole.normal, self.crossing(place));
        let [left, right] = crossing.walls;
        let back = contour::aim(probe, crossing.at, normal, Pair { left, right }, back);
        (([back, back.reversed()]).into_iter())
            .map(|pair| Spoke {
                pair,
                direction: contour::heading(probe, crossing.at, normal, pair).0,
            })
            .collect()
    }

    fn add_node(
        &self,
        place: Place,
        kind: FaceNodeKind,
        spokes: SmallVec<[Spoke; 4]>,
        out: &mut FaceContours,
    ) -> u16 {
        let crossing = self.crossing(place);
        out.nodes.push(FaceNode {
            at: crossing.at,
            kind,
            walls: SmallVec::from_slice(&crossing.walls),
            spokes,
        });
        (out.nodes.len() - 1) as u16
    }
}

/// A crossing of a cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Place {
    cut: usize,
    index: usize,
}

/// Where a contour of a small triangle ends: on the way, or for good.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    Cut(Place),
    Face(ArcEnd),
}

/// A contour over several small triangles.
struct Chain {
    ends: [End; 2],
    between: Vec<Place>,
}

/// Points of a polyline, but its ends, that it needs to stay within `slack` of
/// itself (Ramer 1972; Douglas and Peucker 1973).
fn needed(points: &[DVec3], slack: f64) -> Vec<usize> {
    let mut kept = Vec::new();
    let mut open = vec![(0, points.len() - 1)];
    while let Some((from, to)) = open.pop() {
        let (p, q) = (points[from], points[to]);
        let off = |k: usize| {
            let along = (points[k] - p).dot(q - p) / (q - p).length_squared();
            let s = if along.is_finite() {
                along.clamp(0.0, 1.0)
            } else {
                0.0
            };
            points[k].distance(p.lerp(q, s))
        };
        let farthest = (from + 1..to).max_by(|&a, &b| off(a).total_cmp(&off(b)));
        if let Some(k) = farthest.filter(|&k| off(k) > slack) {
            kept.push(k);
            open.extend([(from, k), (k, to)]);
        }
    }
    kept.sort_unstable();
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polyline_keeps_what_it_needs() {
        let points = [
            [0.0, 0.0],
            [1.0, 0.01],
            [2.0, 0.0],
            [2.0, 1.0],
            [2.01, 2.0],
            [2.0, 3.0],
        ]
        .map(|[x, y]| DVec3::new(x, y, 0.0));
        assert_eq!(needed(&points, 0.1), [2]);
        assert_eq!(needed(&points, 0.006), [1, 2, 4]);
        assert_eq!(needed(&points[..2], 0.0), [0; 0]);
    }
}
