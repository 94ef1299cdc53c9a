//! Creases: where a fin was left out, its sheet bends, and the mesh gets a
//! chain of edges there.
//!
//! Along the line where a pruned fin would have joined, three walls are equally
//! near: two that a convex edge or round joins, and one across. Followers take
//! the first two for one wall, so the sheet runs on with a kink. An edge of the
//! mesh crosses such a line if the footpoint on one side jumps: the jump stays
//! however short the piece of the edge. The crossing is then solved as a point
//! of three ties and becomes a vertex: a new one, or the end of the edge if it
//! is near. Two such vertices of a triangle are joined by an edge.

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use super::complex::{Complex, Rank};
use super::facing::TURN;
use super::project::Projector;
use super::uncut::Kept;
use crate::field::Footpoint;
use crate::mesh::{FaceId, angle};
use crate::surface::marked::{Line, MarkedMesh, MarkedVertex, edge};
use crate::trace::solve::{Condition, on_coping, solve};
use crate::trace::tolerances::CREASE_ANGLE;

/// Footpoint directions that differ by less, in degrees, are no jump: creases
/// flatter than this are left to the triangles.
const LEAST_JUMP: f64 = 10.0;

/// Walls that differ by more, in degrees, make a crease whatever is beside them: chords of
/// a round wall do so where eight go round it.
const SHARP: f64 = 40.0;

/// A wall that goes on to turn by this share of the turn of a crease, beside it, is
/// round.
const GOES_ON: f64 = 0.5;

/// Where that is looked for: so far from the footpoints, in distances of the wall.
/// Triangles laid freely over a round wall bend to and fro; beyond the fourth only what
/// bends the same way counts, as two bends of a sheet may follow each other there.
const BESIDE: [f64; 7] = [0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0];
const ANY_WAY: f64 = 4.0;

/// A piece of an edge this short, against the distance of its walls, tells a
/// jump from a tight round: a fillet smaller than an eighth of the wall's
/// thickness is a crease.
const BRACKET: f64 = 0.03;

/// A crossing nearer to an end of its edge than this share of the edge moves
/// the end; the sum of two such shares leaves room between them.
const NEAR_END: f64 = 0.25;

/// A crossing nearer to a corner than this share of its edge is the corner.
const AT_CORNER: f64 = 0.02;

/// Sine of ten degrees: no vertex is moved where it would leave a flatter angle.
const FLATTEST: f64 = 0.17;

/// Least height over longest edge of a triangle that is cut off.
const THINNEST: f64 = 0.01;

/// Where a crease crosses an edge.
#[derive(Clone, Debug)]
struct Crossing {
    /// Share of the edge before it, from its low vertex.
    share: f64,
    vertex: MarkedVertex,
}

/// Cuts the mesh along its creases, but at places kept, and marks their edges.
pub fn mark_creases(mesh: MarkedMesh, projector: &Projector, kept: &Kept) -> MarkedMesh {
    let mut cutter = Cutter {
        complex: Complex::new(&mesh),
        vertices: mesh.vertices,
        creased: Vec::new(),
        projector,
        kept,
    };
    cutter.creased = (cutter.vertices.iter())
        .map(|v| cutter.is_creased(v))
        .collect();
    let left = cutter.snap();
    cutter.split(left);
    cutter.meet();
    cutter.into_marked()
}

struct Cutter<'a> {
    complex: Complex,
    vertices: Vec<MarkedVertex>,
    /// Vertices on a crease.
    creased: Vec<bool>,
    projector: &'a Projector<'a>,
    kept: &'a Kept,
}

impl Cutter<'_> {
    fn foot(&self, x: DVec3, face: FaceId) -> Footpoint {
        self.projector.walls().field().footpoint_on(x, face)
    }

    /// Feet of a vertex on its walls, one for each place.
    fn feet(&self, vertex: &MarkedVertex) -> SmallVec<[Footpoint; 4]> {
        let mut feet: SmallVec<[Footpoint; 4]> = SmallVec::new();
        let all = vertex.walls.iter().map(|&f| self.foot(vertex.at, f));
        for foot in all {
            let same = |f: &Footpoint| f.point.distance(foot.point) <= 1e-4 * foot.distance;
            if !feet.iter().any(same) {
                feet.push(foot);
            }
        }
        feet
    }

    /// Whether three walls tie at a vertex, two of them joined round a convex
    /// edge.
    fn is_creased(&self, vertex: &MarkedVertex) -> bool {
        let feet = self.feet(vertex);
        (feet.iter().enumerate()).any(|(n, a)| {
            feet[..n].iter().any(|b| {
                turn(vertex.at, a, vertex.at, b) > LEAST_JUMP
                    && !self.projector.walls().separate(vertex.at, a, b)
                    && !self.is_round(a, b)
            })
        })
    }

    /// Whether two walls that an edge joins are facets of one round wall: no bend of
    /// the part, but of its triangles. The wall goes on to turn beyond one of them.
    fn is_round(&self, a: &Footpoint, b: &Footpoint) -> bool {
        let field = self.projector.walls().field();
        let between = |f: FaceId, g: FaceId| angle(field.normal(f), field.normal(g)).to_degrees();
        let turn = between(a.face, b.face);
        turn < SHARP
            && [(a, b), (b, a)].into_iter().any(|(on, other)| {
                let away = (on.point - other.point).reject_from_normalized(field.normal(on.face));
                let away = away.normalize_or_zero();
                BESIDE.iter().any(|&step| {
                    let beside = on.point + step * on.distance * away;
                    let found = field.footpoint_near(beside, on.face).face;
                    (GOES_ON * turn..SHARP).contains(&between(found, on.face))
                        && (step <= ANY_WAY || field.normal(found).dot(away) > 0.0)
                })
            })
    }

    /// The crossing of an edge by a crease.
    fn crossing(&self, a: u32, b: u32) -> Option<Crossing> {
        let creased = |v: u32| self.creased[v as usize];
        let kept = |v: u32| self.kept.contains(self.complex.at(v));
        if creased(a) || creased(b) || kept(a) || kept(b) {
            return None;
        }
        let mark = match self.complex.class(a, b) {
            None => Line::Sheet,
            Some(class) => class.mark?,
        };
        let ends = [a, b].map(|v| &self.vertices[v as usize]);
        let [from, to] = ends.map(|v| self.feet(v));
        let way = ends[1].at - ends[0].at;
        if jump(ends[0].at, &from, ends[1].at, &to) < LEAST_JUMP {
            return None;
        }
        let bracket = self.bracket(ends, mark)?;
        let vertex = self.solve_crossing(ends, &bracket, mark)?;
        let share = (vertex.at - ends[0].at).dot(way) / way.length_squared();
        // A little beyond an end is at the end.
        (share > -NEAR_END && share < 1.0 + NEAR_END).then_some(Crossing { share, vertex })
    }

    /// A short piece of an edge across which a footpoint jumps round a convex
    /// edge, with its two ends.
    fn bracket(&self, ends: [&MarkedVertex; 2], mark: Line) -> Option<[MarkedVertex; 2]> {
        const HALVINGS: usize = 16;
        if mark == Line::FadingBorder {
            return None;
        }
        let mut piece = ends.map(|v| v.clone());
        let jump = |p: &MarkedVertex, q: &MarkedVertex| -> f64 {
            jump(p.at, &self.feet(p), q.at, &self.feet(q))
        };
        for _ in 0..HALVINGS {
            let [p, q] = &piece;
            let gap = p.at.distance(q.at);
            let distance = self.feet(p).first()?.distance;
            if jump(p, q) < LEAST_JUMP {
                return None;
            }
            if gap <= BRACKET * distance {
                return Some(piece);
            }
            let hints: SmallVec<[FaceId; 8]> = p.walls.iter().chain(&q.walls).copied().collect();
            let guess = 0.5 * (p.at + q.at);
            let middle = match mark {
                Line::Sheet => self.projector.on_sheet(guess, &hints, 0.5 * gap),
                line => {
                    let hints = MarkedVertex {
                        at: guess,
                        walls: hints.iter().copied().collect(),
                        coping: p.coping.or(q.coping),
                    };
                    let along = (q.at - p.at).try_normalize()?;
                    self.projector
                        .on_line(line, guess, along, &hints, 0.5 * gap)
                }
            }?;
            if jump(p, &middle) >= jump(&middle, q) {
                piece[1] = middle;
            } else {
                piece[0] = middle;
            }
        }
        None
    }

    /// Solves the point where the walls of both ends of a short piece tie.
    fn solve_crossing(
        &self,
        ends: [&MarkedVertex; 2],
        piece: &[MarkedVertex; 2],
        mark: Line,
    ) -> Option<MarkedVertex> {
        let walls = self.projector.walls();
        let field = walls.field();
        let [p, q] = piece;
        let (start, reach) = (0.5 * (p.at + q.at), 4.0 * p.at.distance(q.at));
        let [fp, fq] = [self.feet(p), self.feet(q)];
        let lonely = |f: &&Footpoint, at: DVec3, others: &[Footpoint], other: DVec3| {
            others.iter().all(|g| turn(at, f, other, g) > LEAST_JUMP)
        };
        let one = fp.iter().find(|f| lonely(f, p.at, &fq, q.at))?;
        let two = fq.iter().find(|f| lonely(f, q.at, &fp, p.at))?;
        let kept = (fp.iter()).filter(|f| !lonely(f, p.at, &fq, q.at));
        let kept: SmallVec<[FaceId; 4]> = kept.map(|f| f.face).collect();
        let &across = kept.first()?;
        let (foot_one, foot_two) = (self.foot(start, one.face), self.foot(start, two.face));
        if walls.separate(start, &foot_one, &foot_two) || self.is_round(&foot_one, &foot_two) {
            return None;
        }
        let ties = [
            Condition::Tie(across, one.face),
            Condition::Tie(across, two.face),
        ];
        let tolerance = walls.tolerances().solve;
        let coping = p.coping.or(q.coping);
        let (at, coping) = match mark {
            Line::CopingBorder => {
                let (at, on) = on_coping(field, ties, start, coping?, reach, tolerance)?;
                (at, Some(on))
            }
            Line::Seam => {
                let third = Condition::Tie(across, *kept.get(1)?);
                (
                    solve(field, [ties[0], ties[1], third], start, reach, tolerance)?,
                    None,
                )
            }
            _ => {
                // In the plane of the edge across the sheet.
                let way = (ends[1].at - ends[0].at).try_normalize()?;
                let normal = self.projector.normal(start, across, one.face)
                    + self.projector.normal(start, across, two.face);
                let side = way.cross(normal).try_normalize()?;
                let plane = Condition::plane(side, ends[0].at);
                (
                    solve(field, [ties[0], ties[1], plane], start, reach, tolerance)?,
                    None,
                )
            }
        };
        if !self.is_nearest(at, across) {
            return None;
        }
        let mut tied: SmallVec<[FaceId; 4]> = SmallVec::from_slice(&[one.face, two.face]);
        tied.extend(kept);
        Some(MarkedVertex {
            at,
            walls: tied,
            coping,
        })
    }

    /// Whether no wall is nearer to a point than a given one, by more than its
    /// thousandth part.
    fn is_nearest(&self, at: DVec3, face: FaceId) -> bool {
        let field = self.projector.walls().field();
        let nearest = field.footpoint_near(at, face).distance;
        nearest >= 0.999 * field.footpoint_on(at, face).distance
    }

    fn all_crossings(&self) -> Vec<((u32, u32), Crossing)> {
        (self.complex.edges().into_par_iter())
            .filter_map(|(a, b)| Some(((a, b), self.crossing(a, b)?)))
            .collect()
    }

    /// Moves vertices onto creases near by; returns the crossings left.
    fn snap(&mut self) -> Vec<((u32, u32), Crossing)> {
        let mut near: Vec<(u64, u32, MarkedVertex)> = Vec::new();
        let mut corners: Vec<(u32, bool)> = Vec::new();
        let mut crossings = self.all_crossings();
        for ((a, b), crossing) in &crossings {
            let (a, b) = (*a, *b);
            let on_line = self.complex.class(a, b).is_some();
            for (v, share) in [(a, crossing.share), (b, 1.0 - crossing.share)] {
                // A vertex of a line moves along it only.
                let free = match self.complex.rank(v) {
                    Rank::Inner => true,
                    Rank::Line => on_line,
                    Rank::Corner => {
                        // A crease that ends in a corner.
                        corners.push((v, share < AT_CORNER));
                        false
                    }
                };
                if free && share < NEAR_END {
                    let gap = self.complex.at(v).distance(crossing.vertex.at);
                    near.push((gap.to_bits(), v, crossing.vertex.clone()));
                }
            }
        }
        for (v, gap) in corners {
            self.creased[v as usize] |= gap;
        }
        // The nearest crossing first: of a vertex with several it is the one.
        near.sort_by_key(|n| (n.0, n.1));
        for (_, v, vertex) in near {
            if self.creased[v as usize] || self.complex.around(v).is_empty() {
                continue;
            }
            if self.may_move(v, vertex.at) {
                self.complex.put(v, vertex.at);
                self.vertices[v as usize] = vertex;
                self.creased[v as usize] = true;
            } else if let Some(w) = self.beside(v, vertex.at) {
                self.complex.contract(v, w);
            }
        }
        // Vertices that moved are creased; the other crossings are as they were.
        crossings.retain(|&((a, b), _)| {
            let free = |v: u32| !self.creased[v as usize];
            free(a) && free(b) && self.complex.adjacent(a, b)
        });
        crossings
    }

    /// The neighbour on the crease, the nearest to a place there, that a vertex can be
    /// contracted into: were it moved, a triangle between it and the crease would
    /// collapse.
    fn beside(&self, v: u32, place: DVec3) -> Option<u32> {
        let around = self.complex.around(v).iter();
        let corners = around.filter_map(|&t| self.complex.corners(t)).flatten();
        let mut near: SmallVec<[(u64, u32); 8]> = corners
            .filter(|&w| w != v && self.creased[w as usize])
            .map(|w| (self.complex.at(w).distance(place).to_bits(), w))
            .collect();
        near.sort_unstable();
        near.dedup();
        let may = |&(_, w): &(u64, u32)| {
            self.keeps_shapes(v, self.complex.at(w), Some(w)) && self.complex.contractible(v, w)
        };
        near.into_iter().find(may).map(|(_, w)| w)
    }

    /// Whether no triangle turns over or collapses if a vertex moves.
    fn may_move(&self, v: u32, to: DVec3) -> bool {
        self.keeps_shapes(v, to, None)
    }

    /// Whether no triangle around a vertex turns over or collapses if it moves, but
    /// for those with another corner.
    fn keeps_shapes(&self, v: u32, to: DVec3, but: Option<u32>) -> bool {
        self.complex.around(v).iter().all(|&t| {
            let Some(corners) = self.complex.corners(t) else {
                return true;
            };
            if but.is_some_and(|w| corners.contains(&w)) {
                return true;
            }
            let old = self.complex.shape(corners);
            let new = self.complex.shape_with(corners, v, to);
            new.normal.dot(old.normal) > TURN && new.sine > FLATTEST.min(0.9 * old.sine)
        })
    }

    /// Whether an edge can be split at a point so that no half of a triangle
    /// turns over or lies flat on its base.
    fn may_split(&self, a: u32, b: u32, at: DVec3) -> bool {
        let around = self.complex.around(a).iter();
        let beside = around.filter_map(|&t| self.complex.corners(t));
        beside.filter(|c| c.contains(&b)).all(|c| {
            let old = self.complex.shape(c);
            [a, b].iter().all(|&end| {
                let half = self.complex.shape_with(c, end, at);
                half.flatness > THINNEST && half.normal.dot(old.normal) > TURN
            })
        })
    }

    /// Splits edges that cross a crease.
    fn split(&mut self, crossings: Vec<((u32, u32), Crossing)>) {
        let inside = |c: &Crossing| c.share > AT_CORNER && c.share < 1.0 - AT_CORNER;
        for ((a, b), crossing) in crossings {
            if !inside(&crossing) || !self.may_split(a, b, crossing.vertex.at) {
                continue;
            }
            let new = self.complex.split(a, b, crossing.vertex.at);
            debug_assert_eq!(new as usize, self.vertices.len());
            self.vertices.push(crossing.vertex);
            self.creased.push(true);
        }
    }

    /// Where creases meet, a triangle has three creased corners, and four walls
    /// tie at a point near by: it becomes a vertex, in the triangle or in place
    /// of the nearest corner.
    fn meet(&mut self) {
        for t in 0..self.complex.triangle_count() as u32 {
            let Some(c) = self.complex.corners(t) else {
                continue;
            };
            if !c.iter().all(|&v| self.creased[v as usize]) {
                continue;
            }
            let Some(vertex) = self.meeting(c) else {
                continue;
            };
            let corner = |v: u32| self.complex.shape_with(c, v, vertex.at);
            let sound = c.iter().all(|&v| corner(v).flatness > THINNEST);
            if sound && self.is_within(c, vertex.at) {
                self.complex.insert(t, vertex.at);
                self.vertices.push(vertex);
                self.creased.push(true);
                continue;
            }
            let gap = |v: u32| self.complex.at(v).distance(vertex.at);
            let nearest = c.into_iter().min_by(|&v, &w| gap(v).total_cmp(&gap(w)));
            if let Some(v) = nearest
                && self.complex.rank(v) == Rank::Inner
                && self.may_move(v, vertex.at)
            {
                self.complex.put(v, vertex.at);
                self.vertices[v as usize] = vertex;
            }
        }
    }

    /// The point near three vertices on creases where all their walls tie.
    fn meeting(&self, corners: [u32; 3]) -> Option<MarkedVertex> {
        let walls = self.projector.walls();
        let field = walls.field();
        let points = corners.map(|v| self.complex.at(v));
        let start = (points[0] + points[1] + points[2]) / 3.0;
        let hints = corners
            .iter()
            .flat_map(|&v| &self.vertices[v as usize].walls);
        let mut tied: SmallVec<[Footpoint; 6]> = SmallVec::new();
        for &face in hints {
            let foot = self.foot(start, walls.settle(start, face, CREASE_ANGLE));
            if tied
                .iter()
                .all(|f| turn(start, f, start, &foot) > LEAST_JUMP)
            {
                tied.push(foot);
            }
        }
        let &[a, b, c, d] = tied.as_slice() else {
            return None;
        };
        let ties = [b, c, d].map(|other| Condition::Tie(a.face, other.face));
        let reach = points.iter().map(|p| p.distance(start)).fold(0.0, f64::max);
        let at = solve(field, ties, start, 2.0 * reach, walls.tolerances().solve)?;
        self.is_nearest(at, a.face).then(|| MarkedVertex {
            at,
            walls: tied.iter().map(|f| f.face).collect(),
            coping: None,
        })
    }

    /// Whether a point lies over a triangle, off its edges.
    fn is_within(&self, corners: [u32; 3], p: DVec3) -> bool {
        let [a, b, c] = corners.map(|v| self.complex.at(v));
        let normal = (b - a).cross(c - a);
        let share = |p: DVec3, q: DVec3| (q - p).cross(normal);
        let over = |from: DVec3, to: DVec3, apex: DVec3| {
            let inward = -share(from, to);
            inward.dot(p - from) > AT_CORNER * inward.dot(apex - from)
        };
        over(a, b, c) && over(b, c, a) && over(c, a, b)
    }

    /// Marks the edges along creases.
    fn into_marked(self) -> MarkedMesh {
        let mut creases: FxHashMap<(u32, u32), Line> = FxHashMap::default();
        for (a, b) in self.complex.edges() {
            let both = self.creased[a as usize] && self.creased[b as usize];
            if both && self.complex.wings(a, b).is_some() && self.bends(a, b) {
                creases.insert(edge(a, b), Line::Crease);
            }
        }
        self.drop_shortcuts(&mut creases);
        self.complex.into_mesh_with(&self.vertices, creases)
    }

    /// Of a triangle with three creased edges the longest is a shortcut.
    fn drop_shortcuts(&self, creases: &mut FxHashMap<(u32, u32), Line>) {
        let mut shortcuts = Vec::new();
        for t in 0..self.complex.triangle_count() as u32 {
            let Some(c) = self.complex.corners(t) else {
                continue;
            };
            let edges = [0, 1, 2].map(|k| edge(c[k], c[(k + 1) % 3]));
            if edges.iter().all(|e| creases.contains_key(e)) {
                let length = |e: &(u32, u32)| self.complex.at(e.0).distance(self.complex.at(e.1));
                shortcuts.extend(
                    edges
                        .into_iter()
                        .max_by(|e, f| length(e).total_cmp(&length(f))),
                );
            }
        }
        for shortcut in shortcuts {
            creases.remove(&shortcut);
        }
    }

    /// Whether the two triangles of an edge lie on the two sides of a crease:
    /// their far corners have different walls on the side that jumps.
    fn bends(&self, a: u32, b: u32) -> bool {
        let Some([(_, c), (_, d)]) = self.complex.wings(a, b) else {
            return false;
        };
        let [c, d] = [c, d].map(|v| &self.vertices[v as usize]);
        let [fc, fd] = [self.feet(c), self.feet(d)];
        turns(c.at, &fc, d.at, &fd).into_iter().fold(0.0, f64::max) > LEAST_JUMP
    }
}

/// By how much footpoints jump round a convex edge between two points, degrees: one of either
/// point has no like at the other. A wall that only joins or leaves, at a seam, is no jump.
fn jump(x: DVec3, from: &[Footpoint], y: DVec3, to: &[Footpoint]) -> f64 {
    let [there, back] = turns(x, from, y, to);
    there.min(back)
}

/// The largest turn of a footpoint from `x` to its like at `y`, and back, degrees.
fn turns(x: DVec3, from: &[Footpoint], y: DVec3, to: &[Footpoint]) -> [f64; 2] {
    let one = |f: &Footpoint, at: DVec3, others: &[Footpoint], other: DVec3| {
        (others.iter())
            .map(|g| turn(at, f, other, g))
            .fold(180.0, f64::min)
    };
    let there = from.iter().map(|f| one(f, x, to, y)).fold(0.0, f64::max);
    let back = to.iter().map(|f| one(f, y, from, x)).fold(0.0, f64::max);
    [there, back]
}

/// By how much the direction of a footpoint turns from one point to another,
/// degrees.
fn turn(x: DVec3, f: &Footpoint, y: DVec3, g: &Footpoint) -> f64 {
    angle(f.point - x, g.point - y).to_degrees()
}
