//! What the mid-surface does inside one tetrahedron: contours of its faces,
//! seams and borders through it, chained to polygons
//! (Bloomenthal 2011, section 4.4).
//!
//! Contours, seam sides and borders are *strands*. Every strand end plugs into
//! a *port*: a vertex on an edge, a spoke of a face vertex, or a sheet at an
//! inner vertex. A port takes exactly two strand ends, so the strands chain to
//! closed loops like dominoes, and a loop that does not close shows as a port
//! with one end: a missing answer that can be counted.

mod loops;
mod polygon;

use glam::DVec3;
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use crate::lattice::{EdgeKey, FaceKey, TetKey};
use crate::mesh::FaceId;
use crate::surface::marked::Line;
use crate::trace::edge::Crossing;
use crate::trace::follow::border::{self, BorderStop, Kink};
use crate::trace::follow::contour::{self, Start};
use crate::trace::follow::face::{ArcEnd, FaceContours, FaceNodeKind, FaceSeed};
use crate::trace::follow::fan::{Spoke, Star, fan, star};
use crate::trace::follow::seam::{self, Cage, CurveStop};
use crate::trace::probe::{Pair, Probe};
use crate::trace::solve::distance_to;
use crate::trace::tolerances::{SAME_WAY, Tolerances};

/// Name of a vertex of the mid-surface, the same for all who share it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum VertexKey {
    /// On a lattice edge, with its number there.
    Edge(EdgeKey, u16),
    /// In a tetrahedron face, with its number there.
    Face(FaceKey, u16),
    /// Inside a tetrahedron, with its number there.
    Inner(TetKey, u16),
}

/// What an inner vertex is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InnerKind {
    /// Seams meet, or a seam ends on a fading border.
    Junction,
    /// A seam or a fading border ends on coping, through this triangle.
    OnCoping(FaceId),
    /// A coping border bends.
    Kink,
    /// A polygon needed a vertex in its middle.
    Middle,
}

/// A vertex inside a tetrahedron.
#[derive(Clone, Debug)]
pub struct InnerVertex {
    /// Where.
    pub at: DVec3,
    /// What it is.
    pub kind: InnerKind,
    /// Walls that tie there.
    pub walls: SmallVec<[FaceId; 6]>,
}

/// A loop of strands: one piece of one sheet.
#[derive(Clone, Debug, Default)]
pub struct Polygon {
    /// Its corners.
    pub corners: Vec<VertexKey>,
    /// `lines[i]` is the side from corner `i` to corner `i + 1`.
    pub lines: Vec<Line>,
}

/// The mid-surface inside one tetrahedron.
#[derive(Clone, Debug, Default)]
pub struct TetSurface {
    /// Vertices inside.
    pub inner: Vec<InnerVertex>,
    /// Pieces of sheets.
    pub polygons: Vec<Polygon>,
    /// Triangles of all polygons.
    pub triangles: Vec<[VertexKey; 3]>,
    /// Faces that should have had a vertex where a curve came through.
    pub seeds: Vec<(FaceKey, FaceSeed)>,
    /// Places where a follower was lost or a loop does not close.
    pub open: Vec<DVec3>,
    /// Loops closed by matching ports instead of following.
    pub matched: u32,
}

/// Where a strand end plugs in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
enum Port {
    Crossing(EdgeKey, u16),
    Spoke { face: u8, node: u16, spoke: u16 },
    Sheet { inner: u16, sheet: u16 },
}

/// Strand ends, sorted by the port that they plug into.
struct Plugs {
    ends: Vec<(Port, usize, usize)>,
}

impl Plugs {
    fn at(&self, port: Port) -> &[(Port, usize, usize)] {
        let from = self.ends.partition_point(|e| e.0 < port);
        let to = self.ends.partition_point(|e| e.0 <= port);
        &self.ends[from..to]
    }
}

struct Strand {
    ports: [Port; 2],
    vertices: [VertexKey; 2],
    /// Inner vertices on the way.
    between: Vec<VertexKey>,
    line: Line,
}

/// One end of a curve through the tetrahedron.
#[derive(Clone, Debug)]
struct CurveEnd {
    vertex: VertexKey,
    at: DVec3,
    /// Ports of its sheets, with the two walls of each.
    sheets: SmallVec<[(Port, Pair); 4]>,
    kind: EndKind,
    done: bool,
}

#[derive(Clone, Debug)]
enum EndKind {
    /// A seam (or fading border), its walls and the direction in which it leaves.
    Tie { walls: seam::Walls, towards: DVec3 },
    /// A coping border that starts in the plane of a coping triangle.
    Border { coping: FaceId, towards: DVec3 },
}

/// Solves a tetrahedron given the contours of its four faces and the vertices of its edges.
pub fn solve_tet(
    probe: &mut Probe,
    key: TetKey,
    cage: &Cage,
    faces: [&FaceContours; 4],
    crossings: &FxHashMap<EdgeKey, SmallVec<[Crossing; 1]>>,
) -> TetSurface {
    let lengths = Tolerances::new(probe.walls().tolerances(), cage.size());
    let mut work = Work {
        probe,
        key,
        cage,
        faces,
        face_keys: key.faces(),
        crossings,
        near: lengths.same_point,
        ends: Vec::new(),
        strands: Vec::new(),
        bridges: Vec::new(),
        places: Vec::new(),
        out: TetSurface::default(),
    };
    work.contours();
    work.face_ends();
    work.curves();
    work.match_open_ports();
    work.chain();
    work.cut_polygons();
    work.out
}

struct Work<'w, 'a> {
    probe: &'w mut Probe<'a>,
    key: TetKey,
    cage: &'w Cage,
    faces: [&'w FaceContours; 4],
    face_keys: [FaceKey; 4],
    crossings: &'w FxHashMap<EdgeKey, SmallVec<[Crossing; 1]>>,
    near: f64,
    ends: Vec<CurveEnd>,
    strands: Vec<Strand>,
    /// Ports joined without a strand: a sheet that passes a crease.
    bridges: Vec<(Port, Port)>,
    /// Inner vertices that are ends of curves: number, place.
    places: Vec<(u16, DVec3)>,
    out: TetSurface,
}

impl Work<'_, '_> {
    fn contours(&mut self) {
        for (f, face) in self.faces.iter().enumerate() {
            let edges = self.face_keys[f].edges();
            let end = |end: ArcEnd| match end {
                ArcEnd::Crossing { side, index } => {
                    let edge = edges[side as usize];
                    (Port::Crossing(edge, index), VertexKey::Edge(edge, index))
                }
                ArcEnd::Spoke { node, spoke } => (
                    Port::Spoke {
                        face: f as u8,
                        node,
                        spoke,
                    },
                    VertexKey::Face(self.face_keys[f], node),
                ),
            };
            for arc in &face.arcs {
                let (a, b) = (end(arc.ends[0]), end(arc.ends[1]));
                self.strands.push(Strand {
                    ports: [a.0, b.0],
                    vertices: [a.1, b.1],
                    between: Vec::new(),
                    line: Line::Sheet,
                });
            }
        }
    }

    /// Curves that enter through a vertex of a face.
    fn face_ends(&mut self) {
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
                    FaceNodeKind::Fading => continue,
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
    fn curves(&mut self) {
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
        let line = if end.sheets.len() == 1 {
            Line::FadingBorder
        } else {
            Line::Seam
        };
        let arrived = match stop {
            CurveStop::Face { face, at } => match self.end_near(from, at, Some(face), false) {
                Some(k) => Some(k),
                None => {
                    self.ask(face, FaceSeed { at, border: None });
                    return;
                }
            },
            CurveStop::Coping { at, coping } => {
                let normal = self.probe.field().normal(coping);
                self.tie_end_near(from, at).or_else(|| {
                    let d = distance_to(self.probe.field(), at, carried[0]).0;
                    let fan = fan(self.probe, at, normal, d);
                    self.add_coping_vertex(at, coping, &fan.spokes, &fan.walls);
                    self.tie_end_near(from, at)
                })
            }
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
        let other = self.ends[to].clone();
        let x = other.at;
        // A sheet keeps its footpoints; that is how it is known at the other end.
        let field = self.probe.field();
        let away = |w: FaceId| distance_to(field, x, w).1;
        let mut taken: SmallVec<[bool; 4]> = SmallVec::from_elem(false, other.sheets.len());
        for (slot, (port, _)) in slots.iter().zip(&end.sheets) {
            let (u, v) = (away(carried[slot.0]), away(carried[slot.1]));
            let gap = |pair: &Pair| {
                let (p, q) = (away(pair.left), away(pair.right));
                (u.distance(p) + v.distance(q)).min(u.distance(q) + v.distance(p))
            };
            let best = (0..other.sheets.len())
                .filter(|&s| !taken[s])
                .min_by(|&a, &b| gap(&other.sheets[a].1).total_cmp(&gap(&other.sheets[b].1)));
            match best {
                Some(s) if gap(&other.sheets[s].1) < 0.2 => {
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

    /// The unused end on a face nearest to a place.
    fn end_near(&self, from: usize, at: DVec3, face: Option<usize>, border: bool) -> Option<usize> {
        let wanted = face.map(|f| self.face_keys[f]);
        self.nearest_end(from, at, |end| {
            let on_face = match (end.vertex, wanted) {
                (VertexKey::Face(k, _), Some(w)) => k == w,
                _ => false,
            };
            on_face && matches!(end.kind, EndKind::Border { .. }) == border
        })
    }

    fn tie_end_near(&self, from: usize, at: DVec3) -> Option<usize> {
        self.nearest_end(from, at, |end| {
            matches!(end.vertex, VertexKey::Inner(..)) && matches!(end.kind, EndKind::Tie { .. })
        })
    }

    fn nearest_end(
        &self,
        from: usize,
        at: DVec3,
        fits: impl Fn(&CurveEnd) -> bool,
    ) -> Option<usize> {
        (0..self.ends.len())
            .filter(|&k| k != from && !self.ends[k].done && fits(&self.ends[k]))
            .filter(|&k| self.ends[k].at.distance(at) <= self.near)
            .min_by(|&a, &b| {
                self.ends[a]
                    .at
                    .distance(at)
                    .total_cmp(&self.ends[b].at.distance(at))
            })
    }

    /// The unused curve end at an inner vertex that points most along `back`.
    fn ray_near(&self, from: usize, at: DVec3, back: Option<DVec3>) -> Option<usize> {
        let back = back?;
        self.best_end(from, at, |end| match &end.kind {
            EndKind::Tie { towards, .. } => Some(towards.dot(back)),
            EndKind::Border { .. } => None,
        })
    }

    fn border_end_near(&self, from: usize, at: DVec3, back: Option<DVec3>) -> Option<usize> {
        let back = back?;
        self.best_end(from, at, |end| match &end.kind {
            EndKind::Border { towards, .. } => Some(towards.dot(back)),
            EndKind::Tie { .. } => None,
        })
    }

    fn best_end(
        &self,
        from: usize,
        at: DVec3,
        score: impl Fn(&CurveEnd) -> Option<f64>,
    ) -> Option<usize> {
        let mut best: Option<(f64, usize)> = None;
        for (k, end) in self.ends.iter().enumerate() {
            if k == from || end.done || !matches!(end.vertex, VertexKey::Inner(..)) {
                continue;
            }
            if end.at.distance(at) > self.near {
                continue;
            }
            if let Some(s) = score(end)
                && s > SAME_WAY
                && best.is_none_or(|b| s > b.0)
            {
                best = Some((s, k));
            }
        }
        best.map(|b| b.1)
    }

    fn place_near(&self, at: DVec3) -> Option<u16> {
        self.places
            .iter()
            .find(|p| p.1.distance(at) <= self.near)
            .map(|p| p.0)
    }

    fn add_inner(&mut self, at: DVec3, kind: InnerKind, walls: SmallVec<[FaceId; 6]>) -> u16 {
        self.out.inner.push(InnerVertex { at, kind, walls });
        (self.out.inner.len() - 1) as u16
    }

    fn add_kink(&mut self, kink: &Kink) -> VertexKey {
        let walls = SmallVec::from_slice(&[kink.pair.left, kink.pair.right]);
        VertexKey::Inner(self.key, self.add_inner(kink.at, InnerKind::Kink, walls))
    }

    /// A vertex on coping: borders leave along the coping, and a seam (or a
    /// fading border) into the part.
    fn add_coping_vertex(&mut self, at: DVec3, coping: FaceId, spokes: &[Spoke], walls: &[FaceId]) {
        let inner = self.add_inner(at, InnerKind::OnCoping(coping), SmallVec::from_slice(walls));
        self.places.push((inner, at));
        let vertex = VertexKey::Inner(self.key, inner);
        let port = |s: usize| Port::Sheet {
            inner,
            sheet: s as u16,
        };
        for (s, spoke) in spokes.iter().enumerate() {
            self.ends.push(CurveEnd {
                vertex,
                at,
                sheets: SmallVec::from_slice(&[(port(s), spoke.pair)]),
                kind: EndKind::Border {
                    coping,
                    towards: spoke.direction,
                },
                done: false,
            });
        }
        if spokes.len() == 2 {
            return;
        }
        let normal = self.probe.field().normal(coping);
        let walls = curve_walls(self.probe, at, spokes, walls);
        self.ends.push(CurveEnd {
            vertex,
            at,
            sheets: spokes
                .iter()
                .enumerate()
                .map(|(s, spoke)| (port(s), spoke.pair))
                .collect(),
            kind: EndKind::Tie {
                walls,
                towards: -normal,
            },
            done: false,
        });
    }

    fn add_junction(&mut self, star: &Star) {
        let mut walls: SmallVec<[FaceId; 6]> = star
            .rays
            .iter()
            .flat_map(|r| r.walls.iter().copied())
            .collect();
        walls.sort();
        walls.dedup();
        let inner = self.add_inner(star.at, InnerKind::Junction, walls);
        self.places.push((inner, star.at));
        let vertex = VertexKey::Inner(self.key, inner);
        // A sheet that passes a crease is one sheet.
        let mut root: Vec<usize> = (0..star.sheets).collect();
        for ray in &star.rays {
            if let [a, b] = ray.sheets[..] {
                let (keep, drop) = (root[a.2].min(root[b.2]), root[a.2].max(root[b.2]));
                root.iter_mut()
                    .filter(|r| **r == drop)
                    .for_each(|r| *r = keep);
            }
        }
        for ray in &star.rays {
            if ray.sheets.len() == 2 {
                continue;
            }
            let sheets: SmallVec<[(Port, Pair); 4]> = ray
                .sheets
                .iter()
                .map(|&(i, j, sheet)| {
                    let pair = Pair {
                        left: ray.walls[i],
                        right: ray.walls[j],
                    };
                    (
                        Port::Sheet {
                            inner,
                            sheet: root[sheet] as u16,
                        },
                        pair,
                    )
                })
                .collect();
            let spokes: SmallVec<[Spoke; 4]> = sheets
                .iter()
                .map(|s| Spoke {
                    pair: s.1,
                    direction: ray.direction,
                })
                .collect();
            let walls = curve_walls(self.probe, star.at, &spokes, &ray.walls);
            self.ends.push(CurveEnd {
                vertex,
                at: star.at,
                sheets,
                kind: EndKind::Tie {
                    walls,
                    towards: ray.direction,
                },
                done: false,
            });
        }
    }
}

/// The walls by which to follow the curve of a vertex: those of its sheets,
/// and for a fading border the further wall that fixes its direction best.
fn curve_walls(probe: &Probe, at: DVec3, spokes: &[Spoke], tied: &[FaceId]) -> seam::Walls {
    let mut walls = seam::Walls::new();
    for spoke in spokes {
        for wall in [spoke.pair.left, spoke.pair.right] {
            if !walls.contains(&wall) {
                walls.push(wall);
            }
        }
    }
    if walls.len() == 2 {
        let field = probe.field();
        let away = |w: FaceId| distance_to(field, at, w).1;
        let (a, b) = (away(walls[0]), away(walls[1]));
        let spread = |w: FaceId| (b - a).cross(away(w) - a).length();
        let third = tied
            .iter()
            .copied()
            .filter(|w| !walls.contains(w))
            .max_by(|&p, &q| spread(p).total_cmp(&spread(q)).then(q.cmp(&p)));
        walls.extend(third);
    }
    walls
}
