//! Ends that no contour of a face has, because a follower was lost, closed by
//! the walls that they lie between.

use glam::DVec3;
use smallvec::SmallVec;

use super::contour;
use super::face::{ArcEnd, FaceArc, FaceContours, FaceNodeKind, SLACK, Work};
use super::fan::alike;
use crate::mesh::FaceId;
use crate::trace::edge::Crossing;
use crate::trace::probe::{Pair, Probe};
use crate::trace::solve::{Condition, solve};
use crate::walls::{MAX_FIN_ANGLE, object_angle};

impl Work {
    /// Ends that no contour has: a follower was lost on the way.
    fn open_ends(&self) -> SmallVec<[(ArcEnd, DVec3, [FaceId; 2]); 4]> {
        let crossings = (self.sides.iter().enumerate()).flat_map(|(side, list)| {
            list.iter().enumerate().map(move |(index, c)| {
                let end = ArcEnd::Crossing {
                    side: side as u8,
                    index: index as u16,
                };
                (end, c.at, c.walls)
            })
        });
        let spokes = (self.out.nodes.iter().enumerate()).flat_map(|(node, n)| {
            n.spokes.iter().enumerate().map(move |(spoke, s)| {
                let end = ArcEnd::Spoke {
                    node: node as u16,
                    spoke: spoke as u16,
                };
                (end, n.at, [s.pair.left, s.pair.right])
            })
        });
        let joined = |end: &ArcEnd| self.out.arcs.iter().any(|a| a.ends.contains(end));
        (crossings.chain(spokes))
            .filter(|(end, ..)| !joined(end))
            .collect()
    }

    /// The contours, open ends joined by their walls where a follower was lost.
    pub(super) fn closed(mut self, probe: &Probe) -> FaceContours {
        if !self.out.lost.is_empty() {
            self.join_open_ends(probe);
            self.end_open_ends(probe);
        }
        self.part_ends(probe);
        self.out
    }

    /// Gives contours that fade where they start some length, or their sheet
    /// would have triangles without area.
    fn part_ends(&mut self, probe: &Probe) {
        for arc in self.out.arcs.clone() {
            let [a, b] = arc.ends;
            for (start, end) in [(a, b), (b, a)] {
                let (ArcEnd::Crossing { side, index }, ArcEnd::Spoke { node, .. }) = (start, end)
                else {
                    continue;
                };
                let Crossing { at, walls } = self.sides[side as usize][index as usize];
                let vertex = &self.out.nodes[node as usize];
                let ends = matches!(vertex.kind, FaceNodeKind::Fading | FaceNodeKind::Torn);
                if ends && vertex.at.distance(at) <= self.near {
                    let [left, right] = walls;
                    self.out.nodes[node as usize].at =
                        self.step_in(probe, at, Pair { left, right });
                }
            }
        }
    }

    /// Joins open ends between the same two walls by a contour, the nearest
    /// first, so that both tetrahedra at the face get the same.
    fn join_open_ends(&mut self, probe: &Probe) {
        let open = self.open_ends();
        let field = probe.field();
        let mut candidates: Vec<(f64, usize, usize)> = Vec::new();
        for (i, a) in open.iter().enumerate() {
            for (j, b) in open.iter().enumerate().skip(i + 1) {
                let one_node = matches!((a.0, b.0), (ArcEnd::Spoke { node: m, .. }, ArcEnd::Spoke { node: n, .. }) if m == n);
                let like = alike(field, a.1, a.2, b.2) || alike(field, b.1, a.2, b.2);
                if like && !one_node {
                    candidates.push((a.1.distance(b.1), i, j));
                }
            }
        }
        candidates.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut taken: SmallVec<[bool; 4]> = SmallVec::from_elem(false, open.len());
        for (_, i, j) in candidates {
            if !taken[i] && !taken[j] {
                (taken[i], taken[j]) = (true, true);
                self.out.arcs.push(FaceArc {
                    ends: [open[i].0, open[j].0],
                });
                self.out.matched += 1;
            }
        }
    }

    /// Ends what is left: a spoke that leads nowhere is none if its vertex has
    /// others, and a contour ends where its follower stopped.
    fn end_open_ends(&mut self, probe: &Probe) {
        for (end, ..) in self.open_ends() {
            if let ArcEnd::Spoke { node, spoke } = end {
                self.faded.push((node, spoke));
            }
        }
        self.drop_faded();
        for (end, at, [left, right]) in self.open_ends() {
            let field = probe.field();
            let stood = self.stranded.iter().find(|s| s.0 == end).map(|s| s.1);
            let last = stood.unwrap_or(at);
            let [a, b] = [left, right].map(|w| field.footpoint_on(at, w));
            // Walls so weak that whether they are separate is told by the way
            // round them, from one point so and from another otherwise.
            let kind = if object_angle(at, &a, &b) <= MAX_FIN_ANGLE {
                FaceNodeKind::Fading
            } else {
                FaceNodeKind::Torn
            };
            let pair = Pair { left, right };
            let node = self.add_border(probe, last, pair, kind);
            let border = ArcEnd::Spoke {
                node: node as u16,
                spoke: 0,
            };
            self.out.arcs.push(FaceArc {
                ends: [end, border],
            });
            self.out.matched += 1;
        }
    }

    /// A point of the tie of two walls a little way into the face: where a
    /// contour stops at once, it has no length and its sheet no area.
    fn step_in(&self, probe: &Probe, at: DVec3, pair: Pair) -> DVec3 {
        /// Of the size of the face.
        const STEP: f64 = 0.1;
        let region = &self.region;
        let centre = region.corners.iter().sum::<DVec3>() / region.corners.len() as f64;
        let pair = contour::aim(probe, at, region.normal, pair, centre - at);
        let (t, _) = contour::heading(probe, at, region.normal, pair);
        let step = STEP * region.diameter();
        let across = Condition::plane(t, at + step * t);
        let conditions = [pair.tie(), region.plane(), across];
        let tolerance = probe.walls().tolerances().solve;
        solve(probe.field(), conditions, at + step * t, step, tolerance)
            .filter(|&y| region.excess(y) <= 0.0 && !probe.is_outside(y))
            .unwrap_or(at)
    }

    /// Whether the chords of two contours pass through each other.
    pub(super) fn contours_cross(&self) -> bool {
        let place = |end: ArcEnd| match end {
            ArcEnd::Crossing { side, index } => self.sides[side as usize][index as usize].at,
            ArcEnd::Spoke { node, .. } => self.out.nodes[node as usize].at,
        };
        let chords: SmallVec<[[DVec3; 2]; 4]> =
            (self.out.arcs.iter()).map(|a| a.ends.map(place)).collect();
        let parts = |[p, q]: [DVec3; 2], [a, b]: [DVec3; 2]| {
            let across = self.region.normal.cross(q - p).normalize_or_zero();
            let (s, t) = (across.dot(a - p), across.dot(b - p));
            s.min(t) < -self.near && s.max(t) > self.near
        };
        (chords.iter().enumerate())
            .any(|(k, &a)| chords[..k].iter().any(|&b| parts(a, b) && parts(b, a)))
    }

    /// Whether a contour ends on the side where it began, farther away than may
    /// be neglected. Its chord lies in that side and so do those of all faces
    /// there: it needs vertices on the way.
    pub(super) fn contours_return(&self) -> bool {
        let slack = SLACK * self.region.diameter();
        (self.out.arcs.iter()).any(|arc| match arc.ends {
            [
                ArcEnd::Crossing { side: s, index: i },
                ArcEnd::Crossing { side: t, index: j },
            ] if s == t => {
                let [p, q] = [i, j].map(|k| self.sides[s as usize][k as usize].at);
                p.distance(q) > slack
            }
            _ => false,
        })
    }
}
