//! Feature lines by the length along them: seams, borders and creases between
//! their corners, as they were traced.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::complex::{Complex, Rank};
use super::ground::Ground;
use crate::surface::marked::{Line, MarkedVertex, edge};

/// One line between corners, or a loop.
pub(super) struct Course {
    /// What it is; `None` for an edge of odd valence that no follower marked.
    kind: Option<Line>,
    /// Its traced vertices in order; a loop repeats its first at the end.
    vertices: Vec<MarkedVertex>,
    /// Normal of the sheet that ends there, either way up; zero where several
    /// meet, and at the ends.
    normals: Vec<DVec3>,
    /// Their numbers at the time of tracing.
    numbers: Vec<u32>,
    /// Length along it at each of them, from 0.
    at: Vec<f64>,
    /// Vertex numbers of its two ends; the same of a loop.
    ends: [u32; 2],
}

/// All lines of a complex.
pub(super) struct Lines {
    courses: Vec<Course>,
    /// Line of each edge, as long as it is on one.
    of_edge: FxHashMap<(u32, u32), u32>,
    /// Place along its line of each vertex inside one.
    place: Vec<f64>,
}

impl Lines {
    /// Chains the edges of the complex that are on lines.
    pub(super) fn new(complex: &Complex, vertices: &[MarkedVertex]) -> Lines {
        let mut lines = Lines {
            courses: Vec::new(),
            of_edge: FxHashMap::default(),
            place: vec![0.0; vertices.len()],
        };
        let edges = complex.line_edges();
        // From corners first, then what is left: loops.
        for loops in [false, true] {
            for &((a, b), class) in &edges {
                for (start, next) in [(a, b), (b, a)] {
                    let from_here = loops || complex.rank(start) == Rank::Corner;
                    if from_here && !lines.of_edge.contains_key(&edge(a, b)) {
                        lines.walk(complex, vertices, [start, next], class.mark);
                    }
                }
            }
        }
        lines
    }

    fn walk(
        &mut self,
        complex: &Complex,
        vertices: &[MarkedVertex],
        [start, next]: [u32; 2],
        kind: Option<Line>,
    ) {
        let number = self.courses.len() as u32;
        let (mut before, mut here) = (start, next);
        let mut path = vec![start];
        let mut at = vec![0.0];
        loop {
            let step = complex.at(before).distance(complex.at(here));
            let length = at[at.len() - 1] + step;
            self.of_edge.insert(edge(before, here), number);
            path.push(here);
            at.push(length);
            if here == start || complex.rank(here) == Rank::Corner {
                break;
            }
            self.place[here as usize] = length;
            let Some([a, b]) = complex.line_through(here) else {
                break;
            };
            (before, here) = (here, if a == before { b } else { a });
        }
        let ends = complex.ends_at(start, next);
        let normal = |v: &u32| match ends {
            true => normal_at(complex, *v),
            false => DVec3::ZERO,
        };
        self.courses.push(Course {
            kind,
            normals: path.iter().map(normal).collect(),
            ends: [start, here],
            numbers: path.clone(),
            vertices: path.iter().map(|&v| vertices[v as usize].clone()).collect(),
            at,
        });
    }

    pub(super) fn course(&self, number: u32) -> &Course {
        &self.courses[number as usize]
    }

    pub(super) fn courses(&self) -> &[Course] {
        &self.courses
    }

    /// Line of an edge.
    pub(super) fn of_edge(&self, a: u32, b: u32) -> Option<u32> {
        self.of_edge.get(&edge(a, b)).copied()
    }

    /// Places of the ends of an edge of a line; on a loop the second may lie
    /// beyond its length, so that what lies between is between them.
    pub(super) fn span(&self, complex: &Complex, number: u32, a: u32, b: u32) -> [f64; 2] {
        let course = self.course(number);
        let length = course.length();
        let known = |v: u32| {
            if complex.rank(v) == Rank::Line {
                self.place[v as usize]
            } else if v == course.ends[0] {
                0.0
            } else {
                length
            }
        };
        let [mut s, mut t] = [known(a), known(b)];
        if course.is_loop() {
            // The shorter way round.
            if t - s > 0.5 * length {
                s += length;
            } else if s - t > 0.5 * length {
                t += length;
            }
        }
        [s, t]
    }

    /// Vertices where lines turn by more than `angle` (radians) within `width`,
    /// the sharpest of those near each other.
    pub(super) fn corners(&self, width: f64, angle: f64) -> Vec<u32> {
        let mut corners = Vec::new();
        for course in &self.courses {
            let turns = course.turns(width.min(0.25 * course.length()));
            // A loop goes on beyond its start.
            let laps: &[f64] = match course.is_loop() {
                true => &[0.0, -1.0, 1.0],
                false => &[0.0],
            };
            for n in 0..turns.len() {
                let mut beside = laps.iter().flat_map(|lap| {
                    let here = course.at[n] + lap * course.length();
                    let from = course.at.partition_point(|&s| s <= here - width);
                    from..course.at.partition_point(|&s| s < here + width)
                });
                let sharper =
                    beside.any(|m| turns[m] > turns[n] || (turns[m] == turns[n] && m < n));
                if turns[n] > angle && !sharper {
                    corners.push(course.numbers[n]);
                }
            }
        }
        corners
    }

    /// Curvature of the lines at vertices inside them.
    pub(super) fn bends(&self, complex: &Complex, width: f64) -> Vec<(u32, f64)> {
        let mut bends = Vec::new();
        for course in &self.courses {
            let width = width.min(0.25 * course.length());
            for (turn, &v) in course.turns(width).into_iter().zip(&course.numbers) {
                if complex.rank(v) == Rank::Line && turn > 0.0 {
                    bends.push((v, turn / width));
                }
            }
        }
        bends
    }

    /// Normal at a vertex inside a line of the sheet that ends there, if one does.
    pub(super) fn normal(&self, number: u32, v: u32) -> DVec3 {
        let course = self.course(number);
        let (after, share) = course.segment(self.place[v as usize]);
        course.normals[if share < 0.5 { after - 1 } else { after }]
    }

    /// Notes that an edge was split by a vertex at a place of its line.
    pub(super) fn split(&mut self, a: u32, b: u32, middle: u32, place: f64) {
        self.place.resize(middle as usize + 1, 0.0);
        if let Some(number) = self.of_edge.remove(&edge(a, b)) {
            self.of_edge.insert(edge(a, middle), number);
            self.of_edge.insert(edge(middle, b), number);
            self.set_place(number, middle, place);
        }
    }

    /// Puts a vertex inside a line elsewhere on it.
    pub(super) fn set_place(&mut self, number: u32, v: u32, place: f64) {
        let length = self.course(number).length();
        let wrapped = if place >= length {
            place - length
        } else {
            place
        };
        self.place[v as usize] = wrapped.max(0.0);
    }

    /// Notes that `u`, inside a line, was contracted onto its neighbour `v`;
    /// `far` is its other neighbour.
    pub(super) fn contract(&mut self, u: u32, v: u32, far: u32) {
        self.of_edge.remove(&edge(u, v));
        if let Some(number) = self.of_edge.remove(&edge(u, far)) {
            self.of_edge.insert(edge(v, far), number);
        }
    }
}

/// Normal of the one sheet at a vertex, by the areas of its triangles; zero at a
/// corner. A triangle with two sides on the border does not count: across a bend
/// of that it may stand upright on the sheet.
fn normal_at(complex: &Complex, v: u32) -> DVec3 {
    if complex.rank(v) == Rank::Corner {
        return DVec3::ZERO;
    }
    let corners = (complex.around(v).iter())
        .filter_map(|&t| complex.corners(t))
        .filter(|c| {
            (0..3)
                .filter(|&k| complex.ends_at(c[k], c[(k + 1) % 3]))
                .count()
                < 2
        });
    let crosses = corners.map(|c| {
        let [p, q, r] = c.map(|w| complex.at(w));
        (q - p).cross(r - p)
    });
    let sum = crosses.fold(DVec3::ZERO, |sum, n| {
        // Either way up.
        if sum.dot(n) < 0.0 { sum - n } else { sum + n }
    });
    sum.normalize_or_zero()
}

impl Course {
    /// Its length as traced.
    pub(super) fn length(&self) -> f64 {
        self.at[self.at.len() - 1]
    }

    fn is_loop(&self) -> bool {
        self.ends[0] == self.ends[1]
    }

    /// Numbers of the vertices at its ends.
    pub(super) fn ends(&self) -> [u32; 2] {
        self.ends
    }

    /// The exact point of the line nearest to a place along it; the point of
    /// the traced polyline, and true, where no exact one is found.
    pub(super) fn point(&self, place: f64, ground: &dyn Ground) -> (MarkedVertex, bool) {
        let length = self.length();
        let place = if place > length {
            place - length
        } else {
            place
        };
        let (after, share) = self.segment(place);
        let [from, to] = [&self.vertices[after - 1], &self.vertices[after]];
        let way = to.at - from.at;
        let mut hints = if share < 0.5 {
            from.clone()
        } else {
            to.clone()
        };
        hints.at = from.at.lerp(to.at, share);
        // The nearer end knows its walls; the other one helps where they change.
        hints
            .walls
            .extend_from_slice(if share < 0.5 { &to.walls } else { &from.walls });
        hints.coping = hints.coping.or(from.coping).or(to.coping);
        let exact = self.kind.and_then(|kind| {
            let along = way.try_normalize()?;
            ground.on_line(kind, hints.at, along, &hints, 0.25 * way.length())
        });
        match exact {
            Some(vertex) => (vertex, false),
            None => {
                let nearer = if share < 0.5 { from } else { to };
                let at = from.at.lerp(to.at, share);
                (
                    MarkedVertex {
                        at,
                        ..nearer.clone()
                    },
                    true,
                )
            }
        }
    }

    /// The turn of the polyline at each of its vertices, radians, between the
    /// ways to it from `width` before and on to `width` after it.
    fn turns(&self, width: f64) -> Vec<f64> {
        let (length, closed) = (self.length(), self.is_loop());
        let at = |place: f64| -> DVec3 {
            let place = if closed {
                place.rem_euclid(length)
            } else {
                place.clamp(0.0, length)
            };
            let (after, share) = self.segment(place);
            self.vertices[after - 1]
                .at
                .lerp(self.vertices[after].at, share)
        };
        (0..self.at.len())
            .map(|n| {
                let here = self.vertices[n].at;
                let back = here - at(self.at[n] - width);
                let on = at(self.at[n] + width) - here;
                let turn = back.angle_between(on);
                if turn.is_finite() { turn } else { 0.0 }
            })
            .collect()
    }

    /// The segment that holds a place, as the number of its later vertex, and
    /// the share of it before the place.
    fn segment(&self, place: f64) -> (usize, f64) {
        let last = self.at.len() - 1;
        let after = self.at.partition_point(|&s| s < place).clamp(1, last);
        let [s, t] = [self.at[after - 1], self.at[after]];
        let share = if t > s { (place - s) / (t - s) } else { 0.0 };
        (after, share.clamp(0.0, 1.0))
    }
}
