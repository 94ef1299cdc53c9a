//! The 2D follower: one contour of the mid-surface in a plane
//! (Bloomenthal 2011, section 4.1).

use glam::DVec3;
use smallvec::SmallVec;

use super::fan::{Fan, fan, one_place};
use crate::mesh::FaceId;
use crate::trace::probe::{Pair, Probe};
use crate::trace::solve::{Condition, distance_to, on_coping, solve};
use crate::trace::tolerances::{REACH, SAME_WAY, SHRINK, STRAIGHT, TINY, Tolerances};

/// Object angle, degrees, below which two walls that a contour passes between
/// are facets of one curved wall: the contour bends by less than half of it
/// and gets no vertex of its own.
pub const CREASE_ANGLE: f64 = 20.0;

/// How far a contour may lie off its chord, in chords: it bends by at most
/// twice 30 degrees in a step.
const SAGITTA: f64 = REACH;

/// A convex polygon in a plane: where a contour may run.
#[derive(Clone, Debug)]
pub struct Region {
    /// Unit normal; corners run counter-clockwise round it.
    pub normal: DVec3,
    /// Corners; side `i` joins corner `i` and `i + 1`.
    pub corners: SmallVec<[DVec3; 8]>,
    /// What ends contours inside the polygon besides its sides.
    pub barrier: Barrier,
    /// Vertices known to lie inside, where contours stop: those through which
    /// a 3D follower came.
    pub stations: Vec<DVec3>,
}

/// What ends a contour inside a region.
#[derive(Clone, Debug)]
pub enum Barrier {
    /// Nothing: coping is far.
    None,
    /// Coping triangles, where the contour leaves the part.
    Coping,
    /// Segments in the plane with their inside on the left: the outline of
    /// the flat patch of coping that a border runs on.
    Fences(Vec<Fence>),
}

/// A segment of an outline.
#[derive(Clone, Copy, Debug)]
pub struct Fence {
    /// From here.
    pub from: DVec3,
    /// To there.
    pub to: DVec3,
    /// Coping triangle inside the outline.
    pub face: FaceId,
    /// Its edge that the segment is.
    pub edge: usize,
}

/// The place where a contour meets a barrier.
#[derive(Clone, Copy, Debug)]
pub enum Exit {
    /// Through this coping triangle.
    Coping(FaceId),
    /// Through this fence, by number.
    Fence(usize),
}

impl Region {
    /// A polygon through its corners; `None` where they have no area.
    pub fn new(corners: SmallVec<[DVec3; 8]>, barrier: Barrier) -> Option<Region> {
        let mut area = DVec3::ZERO;
        for k in 1..corners.len().saturating_sub(1) {
            area += (corners[k] - corners[0]).cross(corners[k + 1] - corners[0]);
        }
        let normal = area.try_normalize()?;
        Some(Region {
            normal,
            corners,
            barrier,
            stations: Vec::new(),
        })
    }

    fn plane(&self) -> Condition {
        Condition::plane(self.normal, self.corners[0])
    }

    /// Ends of side `i`.
    pub fn side(&self, i: usize) -> (DVec3, DVec3) {
        (self.corners[i], self.corners[(i + 1) % self.corners.len()])
    }

    /// Unit normal of side `i`, in the plane, towards the inside.
    pub fn inward(&self, i: usize) -> DVec3 {
        let (p, q) = self.side(i);
        self.normal.cross(q - p).normalize_or_zero()
    }

    fn diameter(&self) -> f64 {
        let mut d: f64 = 0.0;
        for a in &self.corners {
            for b in &self.corners {
                d = d.max(a.distance(*b));
            }
        }
        d
    }

    /// How far outside `x` lies, at most (negative inside).
    fn excess(&self, x: DVec3) -> f64 {
        (0..self.corners.len())
            .map(|i| -self.inward(i).dot(x - self.corners[i]))
            .fold(f64::NEG_INFINITY, f64::max)
    }
}

/// How a contour ends.
#[derive(Clone, Debug)]
pub enum Stop {
    /// On a side of the region.
    Side {
        /// Which side.
        side: usize,
        /// Where.
        at: DVec3,
        /// The pair on arrival.
        pair: Pair,
    },
    /// Where other walls tie: a branch point (three or more spokes), a crease
    /// (two) or the end of the sheet in a round (one).
    Node {
        /// All that leaves the point.
        fan: Fan,
        /// The spoke on which the contour arrived.
        arrived: usize,
        /// The pair on arrival: another than the spoke's where its walls are
        /// hardly separate at the point itself.
        pair: Pair,
    },
    /// At the region's barrier: out of the part through coping, or off the
    /// patch of coping.
    Leaves {
        /// Where.
        at: DVec3,
        /// The pair on arrival.
        pair: Pair,
        /// Through what.
        exit: Exit,
    },
    /// At a station of the region.
    Station {
        /// Which one.
        station: usize,
        /// Heading on arrival.
        heading: DVec3,
        /// The pair on arrival.
        pair: Pair,
    },
    /// The two walls stop being separate along the contour itself.
    Fades {
        /// Last point where they are.
        at: DVec3,
        /// The pair there.
        pair: Pair,
    },
    /// The follower could not go on.
    Lost {
        /// Where it gave up.
        at: DVec3,
    },
}

/// Turns a pair so that a walk from `x` in the plane of `normal` heads to the
/// side of `towards`.
pub fn aim(probe: &Probe, x: DVec3, normal: DVec3, pair: Pair, towards: DVec3) -> Pair {
    if heading(probe, x, normal, pair).0.dot(towards) < 0.0 {
        pair.reversed()
    } else {
        pair
    }
}

/// Unit heading of the walk with `pair` at `x`, and its length before
/// normalising (zero where the sheet is parallel to the plane).
fn heading(probe: &Probe, x: DVec3, normal: DVec3, pair: Pair) -> (DVec3, f64) {
    let field = probe.field();
    let ul = distance_to(field, x, pair.left).1;
    let ur = distance_to(field, x, pair.right).1;
    // The gradient of d_left - d_right points to where right is nearer, that
    // is to the right hand.
    let t = normal.cross(ul - ur);
    let length = t.length();
    (t / length.max(1e-300), length)
}

/// What a contour starts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// A point of the contour like any other. However near other walls or the
    /// barrier are, they count.
    Plain,
    /// A vertex where walls tie or the contour ends on the barrier: what is
    /// met within a tie of it is the vertex itself.
    Vertex,
}

/// Follows the contour of `pair` from `at` through the region.
pub fn follow(probe: &mut Probe, region: &Region, at: DVec3, pair: Pair, start: Start) -> Stop {
    Follower::new(probe, region, at, pair, start).run()
}

struct Follower<'p, 'a, 'r> {
    probe: &'p mut Probe<'a>,
    region: &'r Region,
    size: f64,
    tie: f64,
    tolerance: f64,
    lengths: Tolerances,
    x: DVec3,
    pair: Pair,
    travelled: f64,
    start: Start,
    /// Facet edges passed at one place.
    turns: usize,
    /// A station that turned out to lie beside the contour.
    passed: Option<usize>,
}

/// A chord that leaves the region at its very start, where the contour runs
/// into the region first: a shorter one is needed.
struct Bulges;

/// Outcome of one trial step.
#[expect(
    clippy::large_enum_variant,
    reason = "one at a time, on the stack; a box would allocate a contour"
)]
enum Step {
    Stop(Stop),
    Moved,
    Shorten,
    ShortenTo(f64),
}

impl<'p, 'a, 'r> Follower<'p, 'a, 'r> {
    fn new(
        probe: &'p mut Probe<'a>,
        region: &'r Region,
        x: DVec3,
        pair: Pair,
        start: Start,
    ) -> Self {
        let tolerances = probe.walls().tolerances();
        let size = region.diameter();
        Follower {
            probe,
            region,
            size,
            tie: tolerances.tie,
            tolerance: tolerances.solve,
            lengths: Tolerances::new(tolerances, size),
            x,
            pair,
            travelled: 0.0,
            start,
            turns: 0,
            passed: None,
        }
    }

    fn run(&mut self) -> Stop {
        const MOST_STEPS: usize = 2000;
        let mut length = self.size;
        for _ in 0..MOST_STEPS {
            match self.step(length) {
                Step::Stop(stop) => return stop,
                Step::Moved => length = (2.0 * length).min(self.size),
                Step::ShortenTo(most) => length = most,
                Step::Shorten => {
                    length = length.min(self.size) * SHRINK;
                    if length < self.lengths.shortest {
                        break;
                    }
                }
            }
        }
        // At a knife edge the walls meet and the sheet ends on them.
        let d = distance_to(self.probe.field(), self.x, self.pair.left).0;
        if d < TINY * self.size {
            return Stop::Fades {
                at: self.x,
                pair: self.pair,
            };
        }
        Stop::Lost { at: self.x }
    }

    /// Whether the contour has not left the vertex yet that it starts from.
    fn at_vertex(&self) -> bool {
        self.travelled == 0.0 && self.start == Start::Vertex
    }

    fn tie_condition(&self, pair: Pair) -> Condition {
        Condition::Tie(pair.left, pair.right)
    }

    fn step(&mut self, length: f64) -> Step {
        /// Steepness of the sheet against the plane below which a contour has no direction.
        const PARALLEL: f64 = 1e-7;
        let (t, slope) = heading(self.probe, self.x, self.region.normal, self.pair);
        if slope < PARALLEL {
            return Step::Stop(Stop::Lost { at: self.x });
        }
        let (side, exit) = self.exit(t);
        let station = self.station_ahead(t, length.min(exit));
        let length = station.map_or(length, |s| s.1);
        let leaving = side.is_some() && length >= exit && station.is_none();
        let (predicted, third) = match side {
            Some(i) if leaving => (
                self.x + exit * t,
                Condition::plane(self.region.inward(i), self.region.corners[i]),
            ),
            _ => (
                self.x + length * t,
                Condition::plane(t, self.x + length * t),
            ),
        };
        let stride = predicted.distance(self.x);
        // A tie in distance is a wider gap where the sheet runs nearly along the plane.
        let allowed = REACH * stride + 8.0 * self.tie / slope.min(1.0);
        // Facets of a smooth wall take each other's place until the pair is the
        // one that is nearest at the far end of the step.
        const MOST_SLIDES: usize = 24;
        let mut pair = self.pair;
        let mut landed = None;
        for _ in 0..MOST_SLIDES {
            let Some(mut y) = self.correct(predicted, third, pair, allowed) else {
                return Step::Shorten;
            };
            // A bent contour may leave through another side than its tangent.
            let outside = if leaving {
                self.off_side(side.unwrap_or(0), y)
            } else {
                self.region.excess(y) > self.lengths.rounding
            };
            if outside {
                return Step::Shorten;
            }
            let Ok(exit) = self.barrier(y, pair) else {
                return Step::Shorten;
            };
            if let Some((at, _)) = exit {
                // Coping that the chord grazes and the contour does not meet
                // ahead: a shorter chord keeps clear of it.
                let ahead = (at - self.x).dot(t);
                if ahead < -self.tie || self.region.excess(at) > self.lengths.outside {
                    return Step::Shorten;
                }
                y = at;
            }
            let (d, _) = distance_to(self.probe.field(), y, pair.left);
            let foot = self.probe.nearest(y, pair.left);
            let mut clear = foot.face == pair.left
                || foot.face == pair.right
                || foot.distance >= d - self.tolerance;
            if !clear {
                // A facet of the same wall counts to rounding, so that all who
                // come here agree; another wall only beyond a tie.
                match self.slide(y, pair, foot.face) {
                    // Where the footpoints leave their triangles, what stands
                    // between is seen only by steps no longer than the ball.
                    Some(_) if stride > 1.01 * d => return Step::ShortenTo(d),
                    Some(next) => pair = next,
                    None if foot.distance < d - self.tie => {
                        return self.meet(y, pair, foot.face);
                    }
                    // On a side the neighbours decide by the walls that are
                    // nearest there, and a branch point within a tie counts.
                    None if leaving => match self.meet(y, pair, foot.face) {
                        Step::Stop(stop) => return Step::Stop(stop),
                        _ => clear = true,
                    },
                    None => clear = true,
                }
            }
            if clear {
                landed = Some((y, exit.map(|e| e.1)));
                break;
            }
        }
        let Some((y, left_part)) = landed else {
            return Step::Shorten;
        };
        if !self.plain_step(y, pair, stride) {
            return Step::Shorten;
        }
        if let Some((station, _)) = station {
            if left_part.is_none()
                && y.distance(self.region.stations[station])
                    <= 1e-6 * self.size + self.lengths.same_point
            {
                return Step::Stop(Stop::Station {
                    station,
                    heading: t,
                    pair,
                });
            }
            self.passed = Some(station);
        }
        if left_part.is_none() && (self.strays(y) || self.off_patch(y)) {
            return Step::Shorten;
        }
        let (next_heading, _) = heading(self.probe, y, self.region.normal, pair);
        if left_part.is_none() && next_heading.dot(t) < STRAIGHT && stride > TINY * self.size {
            return Step::Shorten;
        }
        if !self.probe.separate(y, pair.left, pair.right) {
            return if stride > 1e-7 * self.size.max(self.tie) && self.shrinkable(stride) {
                Step::Shorten
            } else {
                Step::Stop(Stop::Fades {
                    at: self.x,
                    pair: self.pair,
                })
            };
        }
        if let Some(exit) = left_part {
            return Step::Stop(Stop::Leaves { at: y, pair, exit });
        }
        if leaving && let Some(side) = side {
            return Step::Stop(Stop::Side { side, at: y, pair });
        }
        self.travelled += y.distance(self.x);
        self.x = y;
        self.pair = pair;
        Step::Moved
    }

    /// Whether a step can still be shortened before the follower gives up.
    fn shrinkable(&self, stride: f64) -> bool {
        stride * SHRINK >= self.lengths.shortest / SHRINK
    }

    /// The first station on the way ahead, and the way to it.
    fn station_ahead(&self, t: DVec3, length: f64) -> Option<(usize, f64)> {
        let mut best: Option<(usize, f64)> = None;
        for (k, p) in self.region.stations.iter().enumerate() {
            let way = (*p - self.x).dot(t);
            let aside = (*p - self.x - way * t).length();
            if way > 8.0 * self.tie
                && way <= length
                && aside <= 0.05 * way
                && self.passed != Some(k)
                && best.is_none_or(|b| way < b.1)
            {
                best = Some((k, way));
            }
        }
        best
    }

    /// First side ahead and the way to it.
    fn exit(&self, t: DVec3) -> (Option<usize>, f64) {
        let mut best = (None, f64::INFINITY);
        for i in 0..self.region.corners.len() {
            let m = self.region.inward(i);
            let speed = -m.dot(t);
            if speed <= 1e-12 {
                continue;
            }
            let way = (m.dot(self.x - self.region.corners[i]) / speed).max(0.0);
            if way < best.1 {
                best = (Some(i), way);
            }
        }
        best
    }

    fn correct(&self, start: DVec3, third: Condition, pair: Pair, reach: f64) -> Option<DVec3> {
        let conditions = [self.tie_condition(pair), self.region.plane(), third];
        solve(self.probe.field(), conditions, start, reach, self.tolerance)
    }

    /// Whether a point on the line of a side lies beyond its ends.
    fn off_side(&self, side: usize, y: DVec3) -> bool {
        let (p, q) = self.region.side(side);
        let s = (y - p).dot(q - p) / (q - p).length_squared();
        let slack = 1e-9;
        !(-slack..=1.0 + slack).contains(&s)
    }

    /// Whether a step ends outside the part without having crossed the
    /// barrier: the contour bulges into the part, its chord does not.
    fn strays(&self, y: DVec3) -> bool {
        matches!(self.region.barrier, Barrier::Coping) && self.probe.is_outside(y)
    }

    /// A branch point among facets of a curved wall, exact: within a tie the
    /// facet beside the right one would do. Gives the point for the facets that
    /// are nearest on their walls, if others than those given.
    fn polish(&self, at: DVec3, triple: [FaceId; 3]) -> Option<(DVec3, f64)> {
        let walls = self.probe.walls();
        let mut exact = at;
        let mut triple = triple;
        let mut changed = false;
        for _ in 0..8 {
            let settled = triple.map(|w| walls.settle(exact, w, CREASE_ANGLE));
            if settled == triple {
                break;
            }
            let conditions = [
                Condition::Tie(settled[0], settled[1]),
                Condition::Tie(settled[0], settled[2]),
                self.region.plane(),
            ];
            exact = solve(
                walls.field(),
                conditions,
                exact,
                64.0 * self.tie,
                self.tolerance,
            )?;
            triple = settled;
            changed = true;
        }
        changed.then(|| (exact, distance_to(walls.field(), exact, triple[0]).0))
    }

    /// Whether no wall is nearer to `y` than those of the pair.
    fn nearest_there(&mut self, y: DVec3, pair: Pair) -> bool {
        let d = distance_to(self.probe.field(), y, pair.left).0;
        self.probe.nearest(y, pair.left).distance >= d - self.tie
    }

    /// Where the way from the present point to `y` meets the barrier.
    fn barrier(&mut self, y: DVec3, pair: Pair) -> Result<Option<(DVec3, Exit)>, Bulges> {
        let skip = if self.at_vertex() {
            self.lengths.same_point
        } else {
            0.0
        };
        match &self.region.barrier {
            Barrier::None => Ok(None),
            Barrier::Coping => match self.probe.coping_hit(self.x, y, skip) {
                None => Ok(None),
                Some((near, coping)) => {
                    let (at, coping) = self.settle(near, coping, pair).ok_or(Bulges)?;
                    Ok(Some((at, Exit::Coping(coping))))
                }
            },
            Barrier::Fences(fences) => self.fence(fences, y, pair),
        }
    }

    /// The first fence that the contour crosses outwards on the way to `y`.
    ///
    /// The chord only proposes fences: near a corner of the patch the contour
    /// may pass on the other side of it than its chord. Where the contour
    /// itself meets the line of a fence decides.
    fn fence(
        &self,
        fences: &[Fence],
        y: DVec3,
        pair: Pair,
    ) -> Result<Option<(DVec3, Exit)>, Bulges> {
        let t = heading(self.probe, self.x, self.region.normal, self.pair).0;
        let chord = y - self.x;
        let sagitta = SAGITTA * chord.length() + 2.0 * self.tie;
        let mut first: Option<(f64, DVec3, usize)> = None;
        for (k, fence) in fences.iter().enumerate() {
            let along = fence.to - fence.from;
            let length = along.length();
            let along = along / length.max(f64::MIN_POSITIVE);
            let inside = self.region.normal.cross(along).normalize_or_zero();
            let (a, b) = (inside.dot(self.x - fence.from), inside.dot(y - fence.from));
            // Along a fence, as over a row of facets, the contour stays in its facet.
            if b >= -self.lengths.outside || a <= b || a < -self.tie {
                continue;
            }
            if a <= self.tie && t.dot(inside) > 0.0 {
                // It starts on this fence, inwards, and comes back to it.
                return Err(Bulges);
            }
            let s = (a / (a - b)).clamp(0.0, 1.0);
            let guess = self.x + s * chord;
            let off = |p: DVec3| {
                let place = (p - fence.from).dot(along);
                (-place).max(place - length)
            };
            if off(guess) > sagitta {
                continue;
            }
            let third = Condition::plane(inside, fence.from);
            // Without a tie there the pair is that of the far end of the step.
            let at = (self.correct(guess, third, pair, 2.0 * sagitta)).ok_or(Bulges)?;
            let way = (at - self.x).dot(chord);
            if off(at) <= self.tie && first.is_none_or(|f| way < f.0) {
                first = Some((way, at, k));
            }
        }
        Ok(first.map(|(_, at, k)| (at, Exit::Fence(k))))
    }

    /// Whether a step on a patch of coping ends off the coping: it passed the
    /// outline unseen.
    fn off_patch(&self, y: DVec3) -> bool {
        matches!(self.region.barrier, Barrier::Fences(_))
            && self.probe.field().nearest_coping(y, self.tie).is_none()
    }

    /// The point of the contour on the coping, starting from a guess.
    fn settle(&self, near: DVec3, coping: FaceId, pair: Pair) -> Option<(DVec3, FaceId)> {
        let conditions = [self.tie_condition(pair), self.region.plane()];
        on_coping(
            self.probe.field(),
            conditions,
            near,
            coping,
            self.size,
            self.tolerance,
        )
    }

    /// The pair with `nearer` in the place of a facet of the same smooth wall.
    fn slide(&mut self, y: DVec3, pair: Pair, nearer: FaceId) -> Option<Pair> {
        let walls = self.probe.walls();
        let field = walls.field();
        let foot = field.footpoint_on(y, nearer);
        let u = (y - foot.point).normalize_or_zero();
        let cosine = CREASE_ANGLE.to_radians().cos();
        let mut best: Option<(f64, Pair)> = None;
        for (old, new) in [
            (
                pair.left,
                Pair {
                    left: nearer,
                    right: pair.right,
                },
            ),
            (
                pair.right,
                Pair {
                    left: pair.left,
                    right: nearer,
                },
            ),
        ] {
            let was = field.footpoint_on(y, old);
            let mut bend = (y - was.point).normalize_or_zero().dot(u);
            if walls.smooth_neighbours(old, nearer, CREASE_ANGLE) {
                bend = bend.max(cosine);
            }
            if bend < cosine || best.is_some_and(|b| b.0 >= bend) || !walls.slides(&was, &foot) {
                continue;
            }
            best = Some((bend, new));
        }
        let (_, new) = best?;
        walls
            .separate(
                y,
                &field.footpoint_on(y, new.left),
                &field.footpoint_on(y, new.right),
            )
            .then_some(new)
    }

    /// Whether the walls lie plain under a step on which they gave way to
    /// others; a thin web that stands between shows in a shorter step.
    fn plain_step(&self, y: DVec3, pair: Pair, stride: f64) -> bool {
        const SHORT: f64 = 0.05;
        let (walls, field) = (self.probe.walls(), self.probe.field());
        [(self.pair.left, pair.left), (self.pair.right, pair.right)]
            .into_iter()
            .all(|(old, new)| {
                let to = field.footpoint_on(y, new);
                old == new
                    || stride <= SHORT * to.distance
                    || walls.plain_between(&field.footpoint_on(self.x, old), &to)
            })
    }

    /// `pair` with `wall` in the place of a triangle that it shares its footpoint with.
    fn prefer(&self, at: DVec3, pair: Pair, wall: FaceId) -> Pair {
        let field = self.probe.field();
        let foot = field.footpoint_on(at, wall);
        let near = one_place(foot.distance, self.tie);
        let same = |f: FaceId| field.footpoint_on(at, f).point.distance(foot.point) <= near;
        Pair {
            left: if same(pair.left) { wall } else { pair.left },
            right: if same(pair.right) { wall } else { pair.right },
        }
    }

    /// Another wall is nearer at `y`: find where it came up and what meets there.
    fn meet(&mut self, y: DVec3, pair: Pair, nearer: FaceId) -> Step {
        /// Facet edges passed at one place before it becomes a vertex, where
        /// the contour goes on by the walls alone: those round a corner of a
        /// tessellated wall.
        const MOST_TURNS: usize = 12;
        let field = self.probe.field();
        let mut third = nearer;
        let mut at = None;
        for _ in 0..16 {
            let lead =
                |p: DVec3| distance_to(field, p, third).0 - distance_to(field, p, pair.left).0;
            let (g, h) = (lead(self.x), lead(y));
            let s = if g > h {
                (g / (g - h)).clamp(0.0, 1.0)
            } else {
                0.5
            };
            let guess = self.x.lerp(y, s);
            let reach = 2.0 * self.x.distance(y) + self.lengths.same_point;
            let conditions = [
                self.tie_condition(pair),
                Condition::Tie(pair.left, third),
                self.region.plane(),
            ];
            let Some(p) = solve(field, conditions, guess, reach, self.tolerance) else {
                return Step::Shorten;
            };
            let d = distance_to(field, p, pair.left).0;
            let foot = self.probe.nearest(p, third);
            if foot.distance >= d - self.tie {
                at = Some((p, d.min(foot.distance)));
                break;
            }
            if foot.face == third {
                return Step::Shorten;
            }
            third = foot.face;
        }
        let Some((at, distance)) = at else {
            return Step::Shorten;
        };
        let (at, distance) = self
            .polish(at, [pair.left, pair.right, third])
            .unwrap_or((at, distance));
        let (t, _) = heading(self.probe, self.x, self.region.normal, self.pair);
        let ahead = (at - self.x).dot(t);
        if ahead < -self.lengths.same_point || self.region.excess(at) > self.lengths.outside {
            return Step::Shorten;
        }
        if self.at_vertex() && ahead <= self.lengths.same_point {
            // The branch point that the contour leaves: its walls come near
            // again farther on, and a shorter step tells where.
            return Step::Shorten;
        }
        let Ok(exit) = self.barrier(at, pair) else {
            return Step::Shorten;
        };
        if ahead > self.tie
            && let Some((place, exit)) = exit
            && place.distance(at) > self.tie
        {
            // The barrier stands before the branch point. Where the walls of
            // the far end do not lead to it, a shorter step has the right ones.
            if place.distance(self.x) > at.distance(self.x) || !self.nearest_there(place, pair) {
                return Step::Shorten;
            }
            return Step::Stop(Stop::Leaves {
                at: place,
                pair,
                exit,
            });
        }
        if self.strays(at) {
            return Step::Shorten;
        }
        let fan = fan(self.probe, at, self.region.normal, distance);
        let (back, _) = heading(self.probe, at, self.region.normal, pair);
        let arrived = fan.spokes.iter().enumerate().max_by(|a, b| {
            a.1.direction
                .dot(-back)
                .total_cmp(&b.1.direction.dot(-back))
        });
        let Some((arrived, spoke)) = arrived else {
            return Step::Shorten;
        };
        if spoke.direction.dot(-back) < SAME_WAY {
            return Step::Shorten;
        }
        if fan.spokes.len() == 2 {
            let on = fan.spokes[1 - arrived];
            let bend = on.direction.dot(-fan.spokes[arrived].direction);
            if bend > (0.5 * CREASE_ANGLE).to_radians().cos() {
                // A facet edge of a curved wall: walk on with the other facet.
                let pair = self.prefer(at, on.pair, third);
                if pair == self.pair && ahead <= self.tie {
                    return Step::Shorten;
                }
                self.turns = if ahead <= self.tie { self.turns + 1 } else { 0 };
                if self.turns > MOST_TURNS {
                    return Step::Stop(Stop::Node { fan, arrived, pair });
                }
                self.travelled += at.distance(self.x) + self.tie;
                self.x = at;
                self.pair = pair;
                return Step::Moved;
            }
        }
        Step::Stop(Stop::Node { fan, arrived, pair })
    }
}
