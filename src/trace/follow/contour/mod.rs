//! The 2D follower: one contour of the mid-surface in a plane
//! (Bloomenthal 2011, section 4.1).
//!
//! * [`barrier`]: where it leaves the part.
//! * [`branch`]: where other walls come up.
//! * [`slide`]: facets of one wall that take each other's place.

mod barrier;
mod branch;
mod slide;

use glam::DVec3;

use super::fan::Fan;
use super::region::{Exit, Region};
use crate::trace::probe::{Pair, Probe};
use crate::trace::solve::{Condition, distance_to, solve};
use crate::trace::tolerances::{
    AHEAD, BALL_HOP, BESIDE, DEPENDENT, OUTSIDE, REACH, SHRINK, STRAIGHT, TINY, Tolerances,
};

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
pub(in crate::trace::follow) fn heading(
    probe: &Probe,
    x: DVec3,
    normal: DVec3,
    pair: Pair,
) -> (DVec3, f64) {
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

/// Outcome of one trial step that was not too long.
#[expect(
    clippy::large_enum_variant,
    reason = "one at a time, on the stack; a box would allocate a contour"
)]
enum Step {
    Stop(Stop),
    Moved,
}

/// A step that must be tried again, shorter.
enum Shorten {
    /// By the usual factor.
    Some,
    /// To a length.
    To(f64),
}

/// The way ahead from a point of a contour.
struct Ahead {
    /// Unit heading.
    t: DVec3,
    /// Steepness of the sheet against the plane.
    slope: f64,
    /// The first side on the way.
    side: Option<usize>,
    /// Whether the step ends on that side.
    leaving: bool,
    /// The station at which the step ends.
    station: Option<usize>,
    predicted: DVec3,
    /// The line on which it lands: a side, or across the contour.
    line: Condition,
    stride: f64,
}

/// Where a step lands.
struct Landing {
    y: DVec3,
    pair: Pair,
    exit: Option<Exit>,
}

/// How a trial landing ends.
enum Trial {
    Landed(Landing),
    /// A branch point came before.
    Met(Step),
}

impl<'p, 'a, 'r> Follower<'p, 'a, 'r> {
    fn new(
        probe: &'p mut Probe<'a>,
        region: &'r Region,
        x: DVec3,
        pair: Pair,
        start: Start,
    ) -> Self {
        let size = region.diameter();
        let lengths = Tolerances::new(probe.walls().tolerances(), size);
        Follower {
            probe,
            region,
            size,
            lengths,
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
                Ok(Step::Stop(stop)) => return stop,
                Ok(Step::Moved) => length = (2.0 * length).min(self.size),
                Err(Shorten::To(most)) => length = most,
                Err(Shorten::Some) => {
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
            return self.fades();
        }
        Stop::Lost { at: self.x }
    }

    fn fades(&self) -> Stop {
        Stop::Fades {
            at: self.x,
            pair: self.pair,
        }
    }

    /// Whether the contour has not left the vertex yet that it starts from.
    fn at_vertex(&self) -> bool {
        self.travelled == 0.0 && self.start == Start::Vertex
    }

    fn step(&mut self, length: f64) -> Result<Step, Shorten> {
        let Some(ahead) = self.ahead(length) else {
            return Ok(Step::Stop(Stop::Lost { at: self.x }));
        };
        let landing = match self.land(&ahead)? {
            Trial::Landed(landing) => landing,
            Trial::Met(step) => return Ok(step),
        };
        self.arrive(&ahead, landing)
    }

    /// The way ahead; none where the sheet runs along the plane, so that the
    /// contour has no direction.
    fn ahead(&self, length: f64) -> Option<Ahead> {
        let (t, slope) = heading(self.probe, self.x, self.region.normal, self.pair);
        if slope < DEPENDENT {
            return None;
        }
        let (side, exit) = self.exit(t);
        let station = self.station_ahead(t, length.min(exit));
        let length = station.map_or(length, |s| s.1);
        let leaving = side.is_some() && length >= exit && station.is_none();
        let (predicted, line) = match side {
            Some(i) if leaving => (
                self.x + exit * t,
                Condition::plane(self.region.inward(i), self.region.corners[i]),
            ),
            _ => (
                self.x + length * t,
                Condition::plane(t, self.x + length * t),
            ),
        };
        Some(Ahead {
            t,
            slope,
            side,
            leaving,
            station: station.map(|s| s.0),
            predicted,
            line,
            stride: predicted.distance(self.x),
        })
    }

    /// Returns from the prediction to the contour. Facets of a smooth wall take
    /// each other's place until the pair is the one that is nearest at the far
    /// end of the step.
    fn land(&mut self, ahead: &Ahead) -> Result<Trial, Shorten> {
        const MOST_SLIDES: usize = 24;
        // A tie in distance is a wider gap where the sheet runs nearly along the plane.
        let reach = REACH * ahead.stride + self.lengths.parted / ahead.slope.min(1.0);
        let mut pair = self.pair;
        for _ in 0..MOST_SLIDES {
            let (y, exit) = self.place(ahead, pair, reach)?;
            let landed = Trial::Landed(Landing { y, pair, exit });
            let d = distance_to(self.probe.field(), y, pair.left).0;
            let foot = self.probe.nearest(y, pair.left);
            let own = foot.face == pair.left || foot.face == pair.right;
            if own || foot.distance >= d - self.lengths.solve {
                return Ok(landed);
            }
            // A facet of the same wall counts to rounding, so that all who
            // come here agree; another wall only beyond a tie.
            match self.slide(y, pair, foot.face) {
                // Where the footpoints leave their triangles, what stands
                // between is seen only by steps no longer than the ball.
                Some(_) if ahead.stride > BALL_HOP * d => return Err(Shorten::To(d)),
                Some(next) => pair = next,
                None if foot.distance < d - self.lengths.tie => {
                    return self.meet(y, pair, foot.face).map(Trial::Met);
                }
                // On a side the neighbours decide by the walls that are
                // nearest there, and a branch point within a tie counts.
                None if ahead.leaving => {
                    return match self.meet(y, pair, foot.face) {
                        Ok(Step::Stop(stop)) => Ok(Trial::Met(Step::Stop(stop))),
                        _ => Ok(landed),
                    };
                }
                None => return Ok(landed),
            }
        }
        Err(Shorten::Some)
    }

    /// The place on the contour of a pair where a step lands, and what it
    /// leaves through there.
    fn place(
        &mut self,
        ahead: &Ahead,
        pair: Pair,
        reach: f64,
    ) -> Result<(DVec3, Option<Exit>), Shorten> {
        let landed = self.correct(ahead.predicted, ahead.line, pair, reach);
        let y = landed.ok_or(Shorten::Some)?;
        // A bent contour may leave through another side than its tangent.
        let outside = if ahead.leaving {
            self.off_side(ahead.side.unwrap_or(0), y)
        } else {
            self.region.excess(y) > self.lengths.rounding
        };
        if outside {
            return Err(Shorten::Some);
        }
        let Some((at, exit)) = self.barrier(y, pair)? else {
            return Ok((y, None));
        };
        // Coping that the chord grazes and the contour does not meet ahead: a
        // shorter chord keeps clear of it.
        let behind = (at - self.x).dot(ahead.t) < -self.lengths.tie;
        if behind || self.region.excess(at) > self.lengths.outside {
            return Err(Shorten::Some);
        }
        Ok((at, Some(exit)))
    }

    /// Whether the contour may go to the landing in one step, and what is there.
    fn arrive(&mut self, ahead: &Ahead, landing: Landing) -> Result<Step, Shorten> {
        let Landing { y, pair, exit } = landing;
        if !self.plain_step(y, pair, ahead.stride) {
            return Err(Shorten::Some);
        }
        if let Some(station) = ahead.station {
            let gap = y.distance(self.region.stations[station]);
            if exit.is_none() && gap <= self.lengths.station {
                return Ok(Step::Stop(Stop::Station {
                    station,
                    heading: ahead.t,
                    pair,
                }));
            }
            self.passed = Some(station);
        }
        if exit.is_none() {
            if self.strays(y) || self.off_patch(y) {
                return Err(Shorten::Some);
            }
            let next = heading(self.probe, y, self.region.normal, pair).0;
            if next.dot(ahead.t) < STRAIGHT && ahead.stride > TINY * self.size {
                return Err(Shorten::Some);
            }
        }
        if !self.probe.separate(y, pair.left, pair.right) {
            return if self.shrinkable(ahead.stride) {
                Err(Shorten::Some)
            } else {
                Ok(Step::Stop(self.fades()))
            };
        }
        if let Some(exit) = exit {
            return Ok(Step::Stop(Stop::Leaves { at: y, pair, exit }));
        }
        if let (true, Some(side)) = (ahead.leaving, ahead.side) {
            return Ok(Step::Stop(Stop::Side { side, at: y, pair }));
        }
        self.travelled += y.distance(self.x);
        self.x = y;
        self.pair = pair;
        Ok(Step::Moved)
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
            if way > self.lengths.parted
                && way <= length
                && aside <= BESIDE * way
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
            if speed <= AHEAD {
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
        let conditions = [pair.tie(), self.region.plane(), third];
        solve(
            self.probe.field(),
            conditions,
            start,
            reach,
            self.lengths.solve,
        )
    }

    /// Whether a point on the line of a side lies beyond its ends.
    fn off_side(&self, side: usize, y: DVec3) -> bool {
        let (p, q) = self.region.side(side);
        let s = (y - p).dot(q - p) / (q - p).length_squared();
        !(-OUTSIDE..=1.0 + OUTSIDE).contains(&s)
    }
}
