//! Feature lines by the length along them: seams, borders and creases between
//! their corners, as they were traced.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::complex::{Complex, Rank};
use super::project::Projector;
use crate::surface::marked::{Line, RawVertex, edge};

/// One line between corners, or a loop.
pub(super) struct Course {
    /// What it is; `None` for an edge of odd valence that no follower marked.
    kind: Option<Line>,
    /// Its traced vertices in order; a loop repeats its first at the end.
    vertices: Vec<RawVertex>,
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
    pub(super) fn new(complex: &Complex, vertices: &[RawVertex]) -> Lines {
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
        vertices: &[RawVertex],
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
        self.courses.push(Course {
            kind,
            ends: [start, here],
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
        let is_loop = course.ends[0] == course.ends[1];
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
        if is_loop {
            // The shorter way round.
            if t - s > 0.5 * length {
                s += length;
            } else if s - t > 0.5 * length {
                t += length;
            }
        }
        [s, t]
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

impl Course {
    /// What it is.
    pub(super) fn kind(&self) -> Option<Line> {
        self.kind
    }

    /// Its length as traced.
    pub(super) fn length(&self) -> f64 {
        self.at[self.at.len() - 1]
    }

    /// Numbers of the vertices at its ends.
    pub(super) fn ends(&self) -> [u32; 2] {
        self.ends
    }

    /// The exact point of the line nearest to a place along it; the point of
    /// the traced polyline where no exact one is found.
    pub(super) fn point(&self, place: f64, projector: &Projector) -> RawVertex {
        let length = self.length();
        let place = if place > length {
            place - length
        } else {
            place
        };
        let after = self
            .at
            .partition_point(|&s| s < place)
            .clamp(1, self.at.len() - 1);
        let [s, t] = [self.at[after - 1], self.at[after]];
        let share = if t > s {
            ((place - s) / (t - s)).clamp(0.0, 1.0)
        } else {
            0.0
        };
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
            projector.on_line(kind, hints.at, along, &hints, 0.25 * way.length())
        });
        exact.unwrap_or_else(|| {
            let nearer = if share < 0.5 { from } else { to };
            RawVertex {
                at: from.at.lerp(to.at, share),
                ..nearer.clone()
            }
        })
    }

    /// Middle point and direction of the polyline, a window of `width` long at
    /// each vertex inside: the turn there, degrees.
    pub(super) fn turns(&self, width: f64) -> Vec<f64> {
        let at = |place: f64| -> DVec3 {
            let place = place.clamp(0.0, self.length());
            let after = self
                .at
                .partition_point(|&s| s < place)
                .clamp(1, self.at.len() - 1);
            let [s, t] = [self.at[after - 1], self.at[after]];
            let share = if t > s { (place - s) / (t - s) } else { 0.0 };
            self.vertices[after - 1]
                .at
                .lerp(self.vertices[after].at, share)
        };
        (0..self.at.len())
            .map(|n| {
                let here = self.vertices[n].at;
                let (back, on) = (here - at(self.at[n] - width), at(self.at[n] + width) - here);
                back.angle_between(on).to_degrees()
            })
            .map(|turn| if turn.is_finite() { turn } else { 0.0 })
            .collect()
    }
}
