//! Face contours: everything the mid-surface draws on one tetrahedron face.
//!
//! A face is solved once, from the vertices on its edges and from places where
//! a 3D follower came through it, and read by both its tetrahedra.

use glam::DVec3;
use smallvec::SmallVec;

use super::contour::{self, Start, Stop};
use super::fan::{ALIKE, Spoke, alike, fan};
use super::refine::Refined;
use super::region::{Exit, Region};
use crate::mesh::FaceId;
use crate::trace::edge::Crossing;
use crate::trace::probe::{Pair, Probe};
use crate::trace::solve::distance_to;
use crate::trace::tolerances::{SAME_WAY, Tolerances};

/// What a face vertex is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FaceNodeKind {
    /// Walls tie: three or more spokes make a seam, two a bend of one sheet, one
    /// the end of the sheet in a round.
    Tie,
    /// The contour leaves the part through this coping triangle.
    Coping(FaceId),
    /// The walls of the contour stop being separate.
    Fading,
    /// The contour was lost between walls that are: it ends where no wall does.
    Torn,
}

/// A vertex inside a face.
#[derive(Clone, Debug)]
pub struct FaceNode {
    /// Where.
    pub at: DVec3,
    /// What it is.
    pub kind: FaceNodeKind,
    /// Walls that tie there.
    pub walls: SmallVec<[FaceId; 6]>,
    /// Contours that leave it.
    pub spokes: SmallVec<[Spoke; 4]>,
}

/// End of a contour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ArcEnd {
    /// A vertex on side `side` of the face, by its number on that edge.
    Crossing {
        /// Side of the face.
        side: u8,
        /// Number on the edge.
        index: u16,
    },
    /// A spoke of a face vertex.
    Spoke {
        /// Number of the vertex.
        node: u16,
        /// Number of the spoke.
        spoke: u16,
    },
}

/// A contour from end to end.
#[derive(Clone, Copy, Debug)]
pub struct FaceArc {
    /// Its two ends.
    pub ends: [ArcEnd; 2],
}

/// A point where a 3D follower came through a face.
#[derive(Clone, Copy, Debug)]
pub struct FaceSeed {
    /// Where.
    pub at: DVec3,
    /// For a coping border, the triangle and the walls; otherwise walls tie here.
    pub border: Option<(FaceId, Pair)>,
}

/// All contours of one face.
#[derive(Clone, Debug, Default)]
pub struct FaceContours {
    /// Vertices inside the face.
    pub nodes: Vec<FaceNode>,
    /// Contours between vertices.
    pub arcs: Vec<FaceArc>,
    /// Vertices on the edges that only the contours led to, by side; their
    /// numbers follow those that were known.
    pub found: Vec<(u8, Crossing)>,
    /// Where a follower could not go on, or two disagreed.
    pub lost: Vec<DVec3>,
    /// Contours joined by their walls where a follower was lost.
    pub matched: u32,
}

/// Steps into which the sides of a face are cut where a follower is lost on it.
const REFINED: [usize; 2] = [4, 16];

/// How far a contour may lie beside its chord on a refined face, in sizes of
/// the face: a fiftieth cannot be seen.
pub(super) const SLACK: f64 = 0.02;

/// Solves a face given the vertices on its sides and the seeds inside it.
pub fn solve_face(
    probe: &mut Probe,
    region: Region,
    sides: [&[Crossing]; 3],
    low_first: [bool; 3],
    seeds: &[FaceSeed],
) -> FaceContours {
    let plain = follow_all(probe, region.clone(), sides, low_first, seeds);
    let straight = !plain.contours_cross() && !plain.contours_return();
    let mut out = if plain.out.lost.is_empty() && straight {
        plain.out
    } else {
        refined(probe, &region, sides, low_first, seeds)
    };
    out.number_by_place();
    out
}

/// Solves a face in small triangles, smaller ones if need be.
fn refined(
    probe: &mut Probe,
    region: &Region,
    sides: [&[Crossing]; 3],
    low_first: [bool; 3],
    seeds: &[FaceSeed],
) -> FaceContours {
    let slack = SLACK * region.diameter();
    let [coarse, fine] = REFINED;
    let mut face = Refined::new(probe, region, coarse, sides, low_first, seeds);
    if !face.is_sound() {
        face = Refined::new(probe, region, fine, sides, low_first, seeds);
    }
    face.contours(probe, slack)
}

/// Follows every contour of a face, from the vertices known.
pub(super) fn follow_all(
    probe: &mut Probe,
    mut region: Region,
    sides: [&[Crossing]; 3],
    low_first: [bool; 3],
    seeds: &[FaceSeed],
) -> Work {
    let size = region.corners[0].distance(region.corners[1]);
    region.stations = seeds.iter().map(|s| s.at).collect();
    let mut face = Work {
        region,
        sides: sides.map(|s| s.to_vec()),
        low_first,
        used: sides.map(|s| vec![false; s.len()]),
        spokes_used: Vec::new(),
        near: Tolerances::new(probe.walls().tolerances(), size).same_point,
        faded: Vec::new(),
        stranded: Vec::new(),
        out: FaceContours::default(),
    };
    for seed in seeds {
        face.plant(probe, seed);
    }
    let mut next_node = 0;
    let mut next_side = 0;
    loop {
        // Spokes first: a contour through a known vertex must not pass it by.
        while next_node < face.out.nodes.len() {
            for spoke in 0..face.out.nodes[next_node].spokes.len() {
                if !face.spokes_used[next_node][spoke] {
                    let at = face.out.nodes[next_node].at;
                    let pair = face.out.nodes[next_node].spokes[spoke].pair;
                    let end = ArcEnd::Spoke {
                        node: next_node as u16,
                        spoke: spoke as u16,
                    };
                    face.walk(probe, end, at, pair);
                }
            }
            next_node += 1;
        }
        let Some((side, index)) = face.unused_crossing(next_side) else {
            break;
        };
        next_side = side;
        let crossing = face.sides[side][index];
        let pair = Pair {
            left: crossing.walls[0],
            right: crossing.walls[1],
        };
        let inward = face.region.inward(side);
        let pair = contour::aim(probe, crossing.at, face.region.normal, pair, inward);
        face.walk(
            probe,
            ArcEnd::Crossing {
                side: side as u8,
                index: index as u16,
            },
            crossing.at,
            pair,
        );
    }
    face.drop_faded();
    face
}

impl FaceContours {
    /// Numbers the vertices by their place, so that their numbers do not tell
    /// in which order they were found.
    fn number_by_place(&mut self) {
        let place = |n: &FaceNode| n.at.to_array();
        let mut order: SmallVec<[usize; 4]> = (0..self.nodes.len()).collect();
        order.sort_by(|&a, &b| {
            let (p, q) = (place(&self.nodes[a]), place(&self.nodes[b]));
            (p[0].total_cmp(&q[0]))
                .then(p[1].total_cmp(&q[1]))
                .then(p[2].total_cmp(&q[2]))
        });
        let mut number: SmallVec<[u16; 4]> = SmallVec::from_elem(0, order.len());
        for (new, &old) in order.iter().enumerate() {
            number[old] = new as u16;
        }
        for arc in &mut self.arcs {
            for end in &mut arc.ends {
                if let ArcEnd::Spoke { node, .. } = end {
                    *node = number[*node as usize];
                }
            }
        }
        self.nodes = order.iter().map(|&k| self.nodes[k].clone()).collect();
    }
}

/// A face on which contours are being followed.
pub(super) struct Work {
    pub(super) region: Region,
    pub(super) sides: [Vec<Crossing>; 3],
    low_first: [bool; 3],
    used: [Vec<bool>; 3],
    spokes_used: Vec<SmallVec<[bool; 4]>>,
    pub(super) near: f64,
    /// Spokes along which no sheet leaves.
    pub(super) faded: Vec<(u16, u16)>,
    /// Ends whose followers could not go on, and how far they came.
    pub(super) stranded: Vec<(ArcEnd, DVec3)>,
    pub(super) out: FaceContours,
}

impl Work {
    fn unused_crossing(&self, from: usize) -> Option<(usize, usize)> {
        (from..3).find_map(|s| self.used[s].iter().position(|u| !u).map(|i| (s, i)))
    }

    fn plant(&mut self, probe: &mut Probe, seed: &FaceSeed) {
        if self
            .out
            .nodes
            .iter()
            .any(|n| n.at.distance(seed.at) <= self.near)
        {
            return;
        }
        if probe.is_outside(seed.at) {
            self.out.lost.push(seed.at);
            return;
        }
        match seed.border {
            Some((coping, pair)) => {
                let into = -probe.field().normal(coping);
                let pair = contour::aim(probe, seed.at, self.region.normal, pair, into);
                self.add_border(probe, seed.at, pair, FaceNodeKind::Coping(coping));
            }
            None => {
                let nearest = probe.nearest_anywhere(seed.at);
                let fan = fan(probe, seed.at, self.region.normal, nearest.distance);
                self.add_node(FaceNode {
                    at: seed.at,
                    kind: FaceNodeKind::Tie,
                    walls: fan.walls,
                    spokes: fan.spokes,
                });
            }
        }
    }

    fn add_node(&mut self, node: FaceNode) -> usize {
        self.spokes_used
            .push(SmallVec::from_elem(false, node.spokes.len()));
        self.out.nodes.push(node);
        self.out.nodes.len() - 1
    }

    /// A vertex with one contour, `pair` heading away from it.
    pub(super) fn add_border(
        &mut self,
        probe: &Probe,
        at: DVec3,
        pair: Pair,
        kind: FaceNodeKind,
    ) -> usize {
        let field = probe.field();
        let across = distance_to(field, at, pair.left).1 - distance_to(field, at, pair.right).1;
        let direction = self.region.normal.cross(across).normalize_or_zero();
        self.add_node(FaceNode {
            at,
            kind,
            walls: SmallVec::from_slice(&[pair.left, pair.right]),
            spokes: SmallVec::from_slice(&[Spoke { pair, direction }]),
        })
    }

    fn mark(&mut self, end: ArcEnd) {
        match end {
            ArcEnd::Crossing { side, index } => self.used[side as usize][index as usize] = true,
            ArcEnd::Spoke { node, spoke } => self.spokes_used[node as usize][spoke as usize] = true,
        }
    }

    fn walk(&mut self, probe: &mut Probe, from: ArcEnd, at: DVec3, pair: Pair) {
        self.mark(from);
        let start = match from {
            ArcEnd::Crossing { .. } => Start::Plain,
            ArcEnd::Spoke { .. } => Start::Vertex,
        };
        let stop = contour::follow(probe, &self.region, at, pair, start);
        let to = match stop {
            Stop::Side { side, at, pair } => self.arrive_on_side(probe, side, at, pair),
            Stop::Node { fan, arrived, pair } => {
                let spoke = fan.spokes[arrived];
                let field = probe.field();
                let own = |s: &Spoke| {
                    alike(
                        field,
                        fan.at,
                        [s.pair.left, s.pair.right],
                        [pair.left, pair.right],
                    )
                };
                let (known, own) = (self.node_near(fan.at), own(&spoke));
                let node = known.unwrap_or_else(|| {
                    self.add_node(FaceNode {
                        at: fan.at,
                        kind: FaceNodeKind::Tie,
                        walls: fan.walls,
                        spokes: fan.spokes,
                    })
                });
                let free = match known {
                    _ if !own => None,
                    Some(node) => self.free_spoke(node, spoke.direction),
                    None => Some(ArcEnd::Spoke {
                        node: node as u16,
                        spoke: arrived as u16,
                    }),
                };
                free.or_else(|| self.end_at(probe, node, spoke.direction, pair))
            }
            Stop::Leaves {
                at,
                pair,
                exit: Exit::Coping(coping),
            } => self.arrive_at_border(probe, at, pair, FaceNodeKind::Coping(coping)),
            // A face has no fences.
            Stop::Leaves {
                exit: Exit::Fence(_),
                ..
            } => None,
            Stop::Station {
                station,
                heading,
                pair,
            } => self
                .node_near(self.region.stations[station])
                .and_then(|node| {
                    self.free_spoke(node, -heading)
                        .or_else(|| self.end_at(probe, node, -heading, pair))
                }),
            // No sheet leaves the vertex there after all.
            Stop::Fades { at: last, .. }
                if last.distance(at) <= self.near && matches!(from, ArcEnd::Spoke { .. }) =>
            {
                if let ArcEnd::Spoke { node, spoke } = from {
                    self.faded.push((node, spoke));
                }
                return;
            }
            Stop::Fades { at, pair } => {
                self.arrive_at_border(probe, at, pair, FaceNodeKind::Fading)
            }
            Stop::Lost { at } => {
                self.stranded.push((from, at));
                self.out.lost.push(at);
                return;
            }
        };
        match to {
            Some(to) => {
                self.mark(to);
                self.out.arcs.push(FaceArc { ends: [from, to] });
            }
            None => self.out.lost.push(at),
        }
    }

    /// Takes spokes along which no sheet leaves from vertices that keep another.
    pub(super) fn drop_faded(&mut self) {
        self.faded.sort_unstable();
        self.faded.dedup();
        for (node, spoke) in std::mem::take(&mut self.faded).into_iter().rev() {
            let end = ArcEnd::Spoke { node, spoke };
            let spokes = &mut self.out.nodes[node as usize].spokes;
            if spokes.len() < 2 || self.out.arcs.iter().any(|a| a.ends.contains(&end)) {
                continue;
            }
            spokes.remove(spoke as usize);
            for end in self.out.arcs.iter_mut().flat_map(|a| &mut a.ends) {
                if let ArcEnd::Spoke { node: n, spoke: s } = end
                    && *n == node
                    && *s > spoke
                {
                    *s -= 1;
                }
            }
        }
    }

    fn node_near(&self, at: DVec3) -> Option<usize> {
        let near = |n: &FaceNode| n.at.distance(at);
        (0..self.out.nodes.len())
            .filter(|&k| near(&self.out.nodes[k]) <= self.near)
            .min_by(|&a, &b| near(&self.out.nodes[a]).total_cmp(&near(&self.out.nodes[b])))
    }

    /// The unused spoke of a vertex that points most along `direction`.
    fn free_spoke(&self, node: usize, direction: DVec3) -> Option<ArcEnd> {
        let spokes = &self.out.nodes[node].spokes;
        (0..spokes.len())
            .filter(|&s| {
                !self.spokes_used[node][s] && spokes[s].direction.dot(direction) > SAME_WAY
            })
            .max_by(|&a, &b| {
                spokes[a]
                    .direction
                    .dot(direction)
                    .total_cmp(&spokes[b].direction.dot(direction))
            })
            .map(|spoke| ArcEnd::Spoke {
                node: node as u16,
                spoke: spoke as u16,
            })
    }

    /// Ends a contour at a vertex where walls tie, although its own are hardly
    /// separate there: the sheet reaches the vertex, which gets a spoke for it.
    fn end_at(
        &mut self,
        probe: &Probe,
        node: usize,
        direction: DVec3,
        pair: Pair,
    ) -> Option<ArcEnd> {
        let (field, vertex) = (probe.field(), &mut self.out.nodes[node]);
        let walls = [pair.left, pair.right];
        let has = |s: &Spoke| alike(field, vertex.at, [s.pair.left, s.pair.right], walls);
        if vertex.kind != FaceNodeKind::Tie || vertex.spokes.iter().any(has) {
            return None;
        }
        vertex.spokes.push(Spoke {
            pair: pair.reversed(),
            direction,
        });
        self.spokes_used[node].push(false);
        Some(ArcEnd::Spoke {
            node: node as u16,
            spoke: (self.out.nodes[node].spokes.len() - 1) as u16,
        })
    }

    /// The far end of a contour that faded out on its way from `end`: one
    /// that gets there from the other side did not, and takes its place.
    fn faded_short(&mut self, end: ArcEnd) -> Option<ArcEnd> {
        let arc = self.out.arcs.iter().position(|a| a.ends.contains(&end))?;
        let [a, b] = self.out.arcs[arc].ends;
        let ArcEnd::Spoke { node, .. } = (if a == end { b } else { a }) else {
            return None;
        };
        let vertex = &mut self.out.nodes[node as usize];
        if vertex.kind != FaceNodeKind::Fading {
            return None;
        }
        vertex.spokes.clear();
        self.spokes_used[node as usize].clear();
        self.out.arcs.remove(arc);
        Some(end)
    }

    fn arrive_at_border(
        &mut self,
        probe: &Probe,
        at: DVec3,
        pair: Pair,
        kind: FaceNodeKind,
    ) -> Option<ArcEnd> {
        let node = match self.node_near(at) {
            Some(node) => node,
            None => self.add_border(probe, at, pair.reversed(), kind),
        };
        let free = (0..self.spokes_used[node].len()).find(|&s| !self.spokes_used[node][s])?;
        Some(ArcEnd::Spoke {
            node: node as u16,
            spoke: free as u16,
        })
    }

    /// The unused crossing of a side at a place where one wall of a contour has
    /// just given way to another: crossings are decided exactly, and contours
    /// to a tie.
    fn taken_over(&self, probe: &Probe, side: usize, at: DVec3, pair: Pair) -> Option<usize> {
        let exact = Tolerances::new(probe.walls().tolerances(), 0.0).decided;
        let distance = distance_to(probe.field(), at, pair.left).0;
        if probe.field().footpoint_near(at, pair.left).distance >= distance - exact {
            return None;
        }
        let field = probe.field();
        let away = |wall: FaceId| distance_to(field, at, wall).1;
        let shares = |c: &Crossing| {
            let own = [pair.left, pair.right].map(away);
            let ties = |w: &FaceId| own.iter().any(|u| u.distance(away(*w)) < ALIKE);
            c.walls.iter().any(ties)
        };
        let gap = |k: &usize| self.sides[side][*k].at.distance(at);
        (0..self.sides[side].len())
            .filter(|k| gap(k) <= self.near && !self.used[side][*k])
            .filter(|k| shares(&self.sides[side][*k]))
            .min_by(|a, b| gap(a).total_cmp(&gap(b)))
    }

    fn arrive_on_side(
        &mut self,
        probe: &Probe,
        side: usize,
        at: DVec3,
        pair: Pair,
    ) -> Option<ArcEnd> {
        let gap = |c: &Crossing| c.at.distance(at);
        let known = &self.sides[side];
        let field = probe.field();
        let best = (0..known.len())
            .filter(|&k| gap(&known[k]) <= self.near)
            .filter(|&k| alike(field, at, known[k].walls, [pair.left, pair.right]))
            .min_by(|&a, &b| {
                (self.used[side][a], gap(&known[a]))
                    .partial_cmp(&(self.used[side][b], gap(&known[b])))
                    .unwrap_or(std::cmp::Ordering::Equal)
            });
        let best = best.or_else(|| self.taken_over(probe, side, at, pair));
        let index = match best {
            Some(k) if self.used[side][k] => {
                return self.faded_short(ArcEnd::Crossing {
                    side: side as u8,
                    index: k as u16,
                });
            }
            Some(k) => k,
            None if probe.is_outside(at) => return None,
            None => {
                let (p, q) = self.region.side(side);
                let way = if self.low_first[side] { q - p } else { p - q };
                // Walls in order along the edge: `across` points to where the right one is nearer.
                let across =
                    distance_to(field, at, pair.left).1 - distance_to(field, at, pair.right).1;
                let walls = if across.dot(way) > 0.0 {
                    [pair.left, pair.right]
                } else {
                    [pair.right, pair.left]
                };
                let crossing = Crossing { at, walls };
                self.sides[side].push(crossing);
                self.used[side].push(false);
                self.out.found.push((side as u8, crossing));
                self.sides[side].len() - 1
            }
        };
        Some(ArcEnd::Crossing {
            side: side as u8,
            index: index as u16,
        })
    }
}
