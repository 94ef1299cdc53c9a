//! Curves through a tetrahedron: seams, and borders of both kinds.

use glam::DVec3;
use smallvec::SmallVec;

use super::ends::{CurveEnd, EndKind};
use super::vertices::curve_walls;
use super::{InnerKind, Port, Strand, VertexKey, Work};
use crate::mesh::FaceId;
use crate::surface::marked::Line;
use crate::trace::follow::border::{self, BorderStop};
use crate::trace::follow::contour::{self, Start};
use crate::trace::follow::face::{FaceNodeKind, FaceSeed};
use crate::trace::follow::fan::{self, ALIKE, star, unlike};
use crate::trace::follow::seam::{self, CurveStop};
use crate::trace::probe::Pair;
use crate::trace::solve::{Condition, distance_to, solve};

impl Work<'_, '_> {
    /// Curves that enter through a vertex of a face.
    pub(super) fn face_ends(&mut self) {
        for f in 0..4 {
            let inward = self.cage.inward[f];
            for (n, node) in self.faces[f].nodes.iter().enumerate() {
                let port = |spoke: usize| Port::Spoke {
                    face: f as u8,
                    node: n as u16,
                    spoke: spoke as u16,
                };
                let sheets: SmallVec<[(Port, Pair); 4]> = node
                    .spokes
                    .iter()
                    .enumerate()
                    .map(|(s, spoke)| (port(s), spoke.pair))
                    .collect();
                let kind = match node.kind {
                    FaceNodeKind::Coping(coping) => EndKind::Border {
                        coping,
                        towards: inward,
                    },
                    FaceNodeKind::Fading | FaceNodeKind::Torn => continue,
                    FaceNodeKind::Tie if sheets.is_empty() => continue,
                    FaceNodeKind::Tie if sheets.len() == 2 => {
                        self.bridges.push((port(0), port(1)));
                        continue;
                    }
                    FaceNodeKind::Tie => {
                        let walls = curve_walls(self.probe, node.at, &node.spokes, &node.walls);
                        EndKind::Tie {
                            walls,
                            towards: inward,
                        }
                    }
                };
                self.ends.push(CurveEnd {
                    vertex: VertexKey::Face(self.face_keys[f], n as u16),
                    at: node.at,
                    sheets,
                    kind,
                    done: false,
                });
            }
        }
    }

    /// Follows every curve from its first end to its second.
    pub(super) fn curves(&mut self) {
        let mut next = 0;
        while next < self.ends.len() {
            let end = self.ends[next].clone();
            if !end.done {
                self.ends[next].done = true;
                match end.kind.clone() {
                    EndKind::Tie { walls, towards } => self.follow_tie(next, &end, walls, towards),
                    EndKind::Border { coping, towards } => {
                        self.follow_border(next, &end, coping, towards)
                    }
                }
            }
            next += 1;
        }
    }

    fn follow_tie(&mut self, from: usize, end: &CurveEnd, walls: seam::Walls, towards: DVec3) {
        // Sheets by the place of their walls in `walls`, which slide on the way.
        let slots: SmallVec<[(usize, usize); 4]> = end
            .sheets
            .iter()
            .filter_map(|(_, pair)| {
                let place = |w: FaceId| walls.iter().position(|&x| x == w);
                Some((place(pair.left)?, place(pair.right)?))
            })
            .collect();
        if slots.len() != end.sheets.len() {
            self.out.open.push(end.at);
            return;
        }
        let mut carried = walls;
        let on_coping = self.is_inner(end.vertex, |k| matches!(k, InnerKind::OnCoping(_)));
        let stop = seam::follow(
            self.probe,
            self.cage,
            end.at,
            &mut carried,
            towards,
            on_coping,
        );
        let arrived = match stop {
            CurveStop::Face { face, at } => match self.end_near(from, at, Some(face), false) {
                Some(k) => Some(k),
                None => {
                    self.ask(face, FaceSeed { at, border: None });
                    return;
                }
            },
            CurveStop::Coping { at, coping } => self.tie_on_coping(from, at, coping, &carried),
            CurveStop::Junction { at, distance } => {
                if self.place_near(at).is_none()
                    && let Some(star) = star(self.probe, at, distance)
                {
                    self.add_junction(&star);
                }
                // Of the rays of the junction, the one that leads back.
                let back = seam::direction(self.probe, at, &carried, end.at - at);
                self.ray_near(from, at, back)
            }
            CurveStop::Lost { at } => {
                self.out.open.push(at);
                return;
            }
        };
        let Some(to) = arrived else {
            self.out.open.push(end.at);
            return;
        };
        self.ends[to].done = true;
        let pairs: SmallVec<[[FaceId; 2]; 4]> =
            slots.iter().map(|s| [carried[s.0], carried[s.1]]).collect();
        self.join_sheets(end, &pairs, to);
    }

    /// The curve end where walls that tie leave the part, made if need be.
    fn tie_on_coping(
        &mut self,
        from: usize,
        at: DVec3,
        coping: FaceId,
        walls: &[FaceId],
    ) -> Option<usize> {
        self.tie_end_near(from, at).or_else(|| {
            let normal = self.probe.field().normal(coping);
            let d = distance_to(self.probe.field(), at, walls[0]).0;
            let fan = fan::fan(self.probe, at, normal, d);
            self.add_coping_vertex(at, coping, &fan.spokes, &fan.walls);
            self.tie_end_near(from, at)
        })
    }

    /// Joins the sheets of a curve at both its ends; `pairs` are their walls
    /// as they arrive. A sheet keeps its footpoints; that is how it is known at
    /// the other end.
    fn join_sheets(&mut self, end: &CurveEnd, pairs: &[[FaceId; 2]], to: usize) {
        let line = if end.sheets.len() == 1 {
            Line::FadingBorder
        } else {
            Line::Seam
        };
        let other = self.ends[to].clone();
        let (field, x) = (self.probe.field(), other.at);
        let mut taken: SmallVec<[bool; 4]> = SmallVec::from_elem(false, other.sheets.len());
        for (&walls, (port, _)) in pairs.iter().zip(&end.sheets) {
            let gap = |s: usize| {
                let pair = other.sheets[s].1;
                unlike([x; 2], field, walls, [pair.left, pair.right])
            };
            let best = (0..other.sheets.len())
                .filter(|&s| !taken[s])
                .min_by(|&a, &b| gap(a).total_cmp(&gap(b)));
            match best {
                Some(s) if gap(s) < ALIKE => {
                    taken[s] = true;
                    self.strands.push(Strand {
                        ports: [*port, other.sheets[s].0],
                        vertices: [end.vertex, other.vertex],
                        between: Vec::new(),
                        line,
                    });
                }
                _ => self.out.open.push(x),
            }
        }
        if taken.iter().any(|t| !t) {
            self.out.open.push(x);
        }
    }

    /// Joins the ends of seams that were lost on the way, by the walls of their
    /// sheets: two ends with the same sheets are one seam, and three or more
    /// meet in a vertex between them.
    pub(super) fn close_curves(&mut self) {
        let mut open = self.lost_ends();
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (n, &i) in open.iter().enumerate() {
            for &j in open[n + 1..].iter().filter(|&&j| self.same_sheets(i, j)) {
                pairs.push((self.ends[i].at.distance(self.ends[j].at), i, j));
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        for (_, i, j) in pairs {
            if open.contains(&i) && open.contains(&j) {
                open.retain(|&k| k != i && k != j);
                let end = self.ends[i].clone();
                let walls: SmallVec<[[FaceId; 2]; 4]> =
                    (end.sheets.iter().map(|s| [s.1.left, s.1.right])).collect();
                self.join_sheets(&end, &walls, j);
                self.out.matched += 1;
            }
        }
        if open.len() > 2 {
            self.meet_between(&open);
        }
    }

    /// Ends of seams none of whose sheets has been joined to another end.
    fn lost_ends(&self) -> Vec<usize> {
        if self.out.open.is_empty() {
            return Vec::new();
        }
        let plugged = self.plugged();
        let open = |port: Port| plugged.at(self.common(port)).len() < 2;
        (0..self.ends.len())
            .filter(|&k| {
                let end = &self.ends[k];
                let seam = matches!(end.kind, EndKind::Tie { .. }) && end.sheets.len() > 2;
                seam && end.sheets.iter().all(|s| open(s.0))
            })
            .collect()
    }

    /// Whether each sheet of one end is one of the other, by its walls.
    fn same_sheets(&self, i: usize, j: usize) -> bool {
        let (a, b) = (&self.ends[i], &self.ends[j]);
        let field = self.probe.field();
        let own = |p: Pair| {
            let alike = |q: Pair| fan::alike(field, b.at, [p.left, p.right], [q.left, q.right]);
            b.sheets.iter().filter(|s| alike(s.1)).count() == 1
        };
        a.vertex != b.vertex
            && a.sheets.len() == b.sheets.len()
            && a.sheets.iter().all(|s| own(s.1))
    }

    /// A vertex between ends of seams, in which the sheets that they share meet.
    fn meet_between(&mut self, ends: &[usize]) {
        let middle = ends.iter().map(|&k| self.ends[k].at).sum::<DVec3>() / ends.len() as f64;
        let mut walls: SmallVec<[FaceId; 6]> = (ends.iter())
            .flat_map(|&k| {
                self.ends[k]
                    .sheets
                    .iter()
                    .flat_map(|s| [s.1.left, s.1.right])
            })
            .collect();
        walls.sort_unstable();
        walls.dedup();
        let sheets: Vec<(usize, Port, VertexKey, [FaceId; 2])> = (ends.iter())
            .flat_map(|&k| {
                let end = &self.ends[k];
                end.sheets
                    .iter()
                    .map(move |s| (k, s.0, end.vertex, [s.1.left, s.1.right]))
            })
            .collect();
        let field = self.probe.field();
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (i, a) in sheets.iter().enumerate() {
            for (j, b) in sheets.iter().enumerate().skip(i + 1) {
                let gap = unlike([middle; 2], field, a.3, b.3);
                if a.0 != b.0 && gap < ALIKE {
                    pairs.push((gap, i, j));
                }
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let at = self.tied_near(middle, &walls).unwrap_or(middle);
        let vertex = VertexKey::Inner(self.key, self.add_inner(at, InnerKind::Junction, walls));
        let mut taken = vec![false; sheets.len()];
        for (_, i, j) in pairs {
            if !taken[i] && !taken[j] {
                (taken[i], taken[j]) = (true, true);
                self.out.matched += 1;
                self.strands.push(Strand {
                    ports: [sheets[i].1, sheets[j].1],
                    vertices: [sheets[i].2, sheets[j].2],
                    between: vec![vertex],
                    line: Line::Seam,
                });
            }
        }
    }

    /// The point nearest to a place where four of the walls tie.
    fn tied_near(&self, place: DVec3, walls: &[FaceId]) -> Option<DVec3> {
        let (field, size) = (self.probe.field(), self.cage.size());
        let tolerance = self.probe.walls().tolerances().solve;
        let (&first, others) = walls.split_first()?;
        let ties: SmallVec<[Condition; 6]> =
            (others.iter().map(|&w| Condition::Tie(first, w))).collect();
        let mut best: Option<DVec3> = None;
        for (i, &a) in ties.iter().enumerate() {
            for (j, &b) in ties.iter().enumerate().skip(i + 1) {
                for &c in &ties[j + 1..] {
                    let found = solve(field, [a, b, c], place, size, tolerance);
                    let inside = |x: &DVec3| self.cage.excess(*x, None) <= 0.0;
                    let nearer =
                        |x: &DVec3| best.is_none_or(|b| x.distance(place) < b.distance(place));
                    best = found.filter(|x| inside(x) && nearer(x)).or(best);
                }
            }
        }
        best
    }

    fn follow_border(&mut self, from: usize, end: &CurveEnd, coping: FaceId, towards: DVec3) {
        let normal = self.probe.field().normal(coping);
        let pair = contour::aim(self.probe, end.at, normal, end.sheets[0].1, towards);
        let start = if self.is_inner(end.vertex, |_| true) {
            Start::Vertex
        } else {
            Start::Plain
        };
        let (stop, kinks) = border::follow(self.probe, self.cage, end.at, pair, coping, start);
        let arrived = match stop {
            BorderStop::Face {
                face,
                at,
                pair,
                coping,
            } => match self.end_near(from, at, Some(face), true) {
                Some(k) => Some(k),
                None => {
                    self.ask(
                        face,
                        FaceSeed {
                            at,
                            border: Some((coping, pair)),
                        },
                    );
                    return;
                }
            },
            BorderStop::Node {
                fan,
                arrived,
                coping,
            } => {
                if self.place_near(fan.at).is_none() {
                    self.add_coping_vertex(fan.at, coping, &fan.spokes, &fan.walls);
                }
                let back = fan.spokes.get(arrived).map(|s| s.direction);
                self.border_end_near(from, fan.at, back)
            }
            BorderStop::Lost { at } => {
                self.out.open.push(at);
                return;
            }
        };
        let Some(to) = arrived else {
            self.out.open.push(end.at);
            return;
        };
        self.ends[to].done = true;
        let other = self.ends[to].clone();
        let near = self.near;
        let between = (kinks.iter())
            .filter(|kink| kink.at.distance(other.at) > near)
            .map(|kink| self.add_kink(kink))
            .collect();
        self.strands.push(Strand {
            ports: [end.sheets[0].0, other.sheets[0].0],
            vertices: [end.vertex, other.vertex],
            between,
            line: Line::CopingBorder,
        });
    }

    /// Whether a vertex lies inside, and is of such a kind.
    fn is_inner(&self, vertex: VertexKey, is: impl Fn(InnerKind) -> bool) -> bool {
        match vertex {
            VertexKey::Inner(_, n) => (self.out.inner.get(n as usize)).is_some_and(|v| is(v.kind)),
            _ => false,
        }
    }

    fn ask(&mut self, face: usize, seed: FaceSeed) {
        self.out.seeds.push((self.face_keys[face], seed));
    }
}
