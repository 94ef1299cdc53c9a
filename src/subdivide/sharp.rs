//! Creases, corners and holes of a control mesh.
//!
//! Sharpness follows DeRose, Kass and Truong, "Subdivision Surfaces in
//! Character Animation": the number of steps for which an edge or a vertex is
//! sharp, less one with every step, a fraction of a step blending the two
//! rules. An infinite one stays. Where an edge is infinitely sharp the surface
//! on either side does not depend on the other, as at a boundary: such edges
//! are *cut*, and the faces around a vertex fall into *sectors* between them.

use glam::DVec3;

use super::cage::Cage;
use super::error::CageError;
use super::refine::Boundary;

/// Sharpness from which on an edge or a vertex is sharp for ever, as the
/// programs hold it that write it.
pub const INFINITELY_SHARP: f64 = 10.0;

/// What a file says of its control mesh besides vertices and faces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tags {
    /// Edges by their ends, with sharpness.
    pub creases: Vec<([u32; 2], f64)>,
    /// Vertices with sharpness.
    pub corners: Vec<(u32, f64)>,
    /// Faces that shape the surface around them but have none themselves.
    pub holes: Vec<u32>,
    /// Thickness of the wall at each vertex, over the one asked for; none where
    /// it is one all over.
    pub shares: Vec<f64>,
}

/// [`Tags`] as a mesh keeps them. Each list is empty where all is as usual.
#[derive(Clone, Debug, Default)]
pub(super) struct Sharpness {
    /// Of half-edges, the same for both of an edge.
    pub edges: Vec<f64>,
    pub vertices: Vec<f64>,
    pub holes: Vec<bool>,
    /// Of vertices, of the thickness asked for.
    pub shares: Vec<f64>,
}

/// Sharpness one step later.
pub(super) fn decayed(sharpness: f64) -> f64 {
    (sharpness - 1.0).max(0.0)
}

/// How a vertex moves, by the sharp edges that end there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    /// None.
    Smooth,
    /// One: as a smooth one.
    Dart,
    /// Two: along the curve of both.
    Crease,
    /// More, or the vertex itself is sharp: held in place.
    Corner,
}

/// Rule of a vertex, and the sum of the far ends of its sharp edges.
pub(super) struct Around {
    pub rule: Rule,
    pub ends: DVec3,
}

/// Faces around a vertex between two cut edges, or all of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sector {
    /// Half-edge that leaves the vertex first, counter-clockwise.
    pub first: u32,
    pub faces: u32,
    /// Whether the last face joins the first without a cut.
    pub closed: bool,
    pub rule: Rule,
}

impl Sector {
    /// Whether the surface there is that of a regular grid: four faces inside,
    /// two beside a cut, one in a corner.
    pub fn is_regular(&self) -> bool {
        match self.rule {
            Rule::Smooth => self.faces == 4,
            Rule::Dart => false,
            Rule::Crease => self.faces == 2,
            Rule::Corner => !self.closed && self.faces == 1,
        }
    }
}

/// The sectors of a mesh. Sector `v` is the first of vertex `v`; further ones
/// of creased vertices follow.
#[derive(Clone, Debug)]
pub(super) struct Sectors {
    pub list: Vec<Sector>,
    /// Sector of every half-edge's origin in its face.
    pub of: Vec<u32>,
}

impl Sectors {
    pub fn new(cage: &Cage, boundary: Boundary) -> Sectors {
        let mut of = vec![0; cage.corner_count()];
        let (mut list, mut further) = (Vec::with_capacity(cage.positions().len()), Vec::new());
        let mut starts = Vec::new();
        for v in 0..cage.positions().len() as u32 {
            let rule = cage.around(v, boundary, 0).rule;
            starts.clear();
            starts.extend(cage.fan(v).filter(|&h| cage.across(h).is_none()));
            let closed = starts.is_empty();
            if closed {
                starts.extend(cage.fan(v).next());
            }
            for (k, &first) in starts.iter().enumerate() {
                let faces = cage.sector(first).count() as u32;
                let sector = Sector {
                    first,
                    faces,
                    closed,
                    rule,
                };
                let all = if k == 0 { &mut list } else { &mut further };
                all.push(sector);
            }
        }
        list.append(&mut further);
        for (number, sector) in list.iter().enumerate() {
            for h in cage.sector(sector.first) {
                of[h as usize] = number as u32;
            }
        }
        Sectors { list, of }
    }
}

impl Cage {
    /// The mesh with creases, corners and holes.
    ///
    /// # Errors
    ///
    /// [`CageError`] for what is not in the mesh, and for holes that leave
    /// nothing, or faces that meet at one vertex alone.
    pub fn tagged(mut self, tags: &Tags) -> Result<Cage, CageError> {
        let (vertices, faces) = (self.positions().len(), self.face_count());
        let endless = |sharpness: f64| {
            if sharpness >= INFINITELY_SHARP {
                f64::INFINITY
            } else {
                sharpness.max(0.0)
            }
        };
        let mut sharpness = Sharpness::default();
        if !tags.creases.is_empty() {
            sharpness.edges = vec![0.0; self.corner_count()];
        }
        for (tag, &([a, b], sharp)) in tags.creases.iter().enumerate() {
            let known = |v: u32| (v as usize) < vertices;
            let edge = (known(a) && known(b)).then(|| self.edge(a, b)).flatten();
            let Some(h) = edge else {
                return Err(CageError::NoSuchEdge {
                    tag,
                    from: a,
                    to: b,
                });
            };
            // A boundary is sharp for ever without a tag.
            if let Some(twin) = self.twin(h) {
                sharpness.edges[h as usize] = endless(sharp);
                sharpness.edges[twin as usize] = endless(sharp);
            }
        }
        if !tags.corners.is_empty() {
            sharpness.vertices = vec![0.0; vertices];
        }
        for (tag, &(vertex, sharp)) in tags.corners.iter().enumerate() {
            match sharpness.vertices.get_mut(vertex as usize) {
                Some(slot) => *slot = endless(sharp),
                None => return Err(CageError::NoSuchCorner { tag, vertex }),
            }
        }
        if !tags.holes.is_empty() {
            sharpness.holes = vec![false; faces];
        }
        for (tag, &face) in tags.holes.iter().enumerate() {
            match sharpness.holes.get_mut(face as usize) {
                Some(slot) => *slot = true,
                None => return Err(CageError::NoSuchHole { tag, face }),
            }
        }
        let sound = |&share: &f64| share > 0.0 && share.is_finite();
        if let Some(vertex) = tags.shares.iter().position(|share| !sound(share)) {
            return Err(CageError::BadShare { vertex });
        }
        if !tags.shares.is_empty() {
            sharpness.shares.clone_from(&tags.shares);
            sharpness.shares.resize(vertices, 1.0);
        }
        self.sharpness = sharpness;
        self.check_holes()?;
        Ok(self)
    }

    /// The mesh with all faces at its boundary made holes: what is left depends
    /// on no boundary rule.
    pub(super) fn without_rim(&self) -> Result<Cage, CageError> {
        let at_rim = |face: usize| self.face(face).iter().any(|&v| self.on_boundary(v));
        let mut cage = self.clone();
        cage.sharpness.holes = (0..self.face_count())
            .map(|face| self.is_hole(face) || at_rim(face))
            .collect();
        cage.check_holes()?;
        Ok(cage)
    }

    /// Faces that are no holes must be there, and hang together by edges around
    /// every vertex.
    fn check_holes(&self) -> Result<(), CageError> {
        if self.sharpness.holes.is_empty() {
            return Ok(());
        }
        if self.sharpness.holes.iter().all(|&hole| hole) {
            return Err(CageError::AllHoles);
        }
        for vertex in 0..self.positions().len() as u32 {
            let shown = |h: &u32| !self.is_hole(self.face_of(*h));
            // Runs begin where the face to the right is a hole, or none.
            let begins = |h: &u32| {
                let right = self.twin(*h).map(|twin| self.face_of(twin));
                right.is_none_or(|face| self.is_hole(face))
            };
            let runs = self.fan(vertex).filter(shown).filter(begins).count();
            if runs > 1 {
                let vertex = vertex as usize;
                return Err(CageError::PinchedHole { vertex });
            }
        }
        Ok(())
    }

    /// What [`Cage::tagged`] was given, as far as it says anything.
    pub(super) fn tags(&self) -> Tags {
        let halves = 0..self.sharpness.edges.len() as u32;
        let first = |h: &u32| self.twin(*h).is_none_or(|twin| *h < twin);
        let sharp = |h: u32| {
            (
                [self.origin(h), self.end(h)],
                self.sharpness.edges[h as usize],
            )
        };
        let vertices = self.sharpness.vertices.iter().zip(0..);
        let holes = self.sharpness.holes.iter().zip(0..);
        Tags {
            creases: halves
                .filter(first)
                .map(sharp)
                .filter(|(_, s)| *s > 0.0)
                .collect(),
            corners: vertices
                .filter(|(s, _)| **s > 0.0)
                .map(|(&s, v)| (v, s))
                .collect(),
            holes: holes
                .filter(|(hole, _)| **hole)
                .map(|(_, face)| face)
                .collect(),
            shares: self.sharpness.shares.clone(),
        }
    }

    /// A half-edge between two vertices, in either direction.
    fn edge(&self, a: u32, b: u32) -> Option<u32> {
        let at = |v: u32, w: u32| self.fan(v).find(|&h| self.end(h) == w);
        at(a, b).or_else(|| at(b, a))
    }

    /// Sharpness of an edge after some steps; boundaries are sharp for ever.
    pub(super) fn edge_sharpness(&self, h: u32) -> f64 {
        match self.twin(h) {
            Some(_) => self.sharpness.edges.get(h as usize).copied().unwrap_or(0.0),
            None => f64::INFINITY,
        }
    }

    fn vertex_sharpness(&self, v: u32, boundary: Boundary) -> f64 {
        if self.on_boundary(v) && boundary.holds(self.degree(v)) {
            return f64::INFINITY;
        }
        self.sharpness
            .vertices
            .get(v as usize)
            .copied()
            .unwrap_or(0.0)
    }

    /// Whether a face has no surface.
    pub(super) fn is_hole(&self, face: usize) -> bool {
        self.sharpness.holes.get(face).copied().unwrap_or(false)
    }

    /// Thickness of the wall at a vertex, over the one asked for.
    pub(super) fn share(&self, vertex: u32) -> f64 {
        let shares = &self.sharpness.shares;
        shares.get(vertex as usize).copied().unwrap_or(1.0)
    }

    /// Whether the wall has more than one thickness.
    pub(super) fn has_shares(&self) -> bool {
        !self.sharpness.shares.is_empty()
    }

    /// Whether the surface is there on one side of an edge alone.
    pub(super) fn is_rim(&self, h: u32) -> bool {
        let beyond = self.twin(h).map(|twin| self.face_of(twin));
        !self.is_hole(self.face_of(h)) && beyond.is_none_or(|face| self.is_hole(face))
    }

    /// Steps after which all sharpness is gone or endless.
    pub(super) fn steps_to_sharp(&self) -> u32 {
        let Sharpness {
            edges, vertices, ..
        } = &self.sharpness;
        let finite = edges.iter().chain(vertices).filter(|s| s.is_finite());
        finite.fold(0.0_f64, |most, &s| most.max(s)).ceil() as u32
    }

    /// The half-edge on the other side of an edge that is not cut.
    pub(super) fn across(&self, h: u32) -> Option<u32> {
        self.twin(h).filter(|_| self.edge_sharpness(h).is_finite())
    }

    /// Half-edges that leave a vertex from one on, counter-clockwise, up to a
    /// cut.
    pub(super) fn sector(&self, first: u32) -> impl Iterator<Item = u32> + '_ {
        let next = move |&h: &u32| self.across(self.prev(h)).filter(|&next| next != first);
        std::iter::successors(Some(first), next)
    }

    /// Ends of the edges at a vertex, with their sharpness.
    fn spokes(&self, vertex: u32) -> impl Iterator<Item = (u32, f64)> + '_ {
        self.fan(vertex).flat_map(move |h| {
            let last = self.prev(h);
            let open = self.twin(last).is_none();
            let own = (self.end(h), self.edge_sharpness(h));
            [Some(own), open.then(|| (self.origin(last), f64::INFINITY))]
                .into_iter()
                .flatten()
        })
    }

    /// What holds at a vertex after `steps` steps more have taken their share of
    /// sharpness.
    pub(super) fn around(&self, vertex: u32, boundary: Boundary, steps: u32) -> Around {
        let left = |sharpness: f64| sharpness - f64::from(steps) > 0.0;
        let (mut sharp, mut ends) = (0, DVec3::ZERO);
        if self.on_boundary(vertex) || !self.sharpness.edges.is_empty() {
            for (end, _) in self.spokes(vertex).filter(|&(_, sharp)| left(sharp)) {
                sharp += 1;
                ends += self.position(end);
            }
        }
        let rule = match sharp {
            _ if left(self.vertex_sharpness(vertex, boundary)) => Rule::Corner,
            0 => Rule::Smooth,
            1 => Rule::Dart,
            2 => Rule::Crease,
            _ => Rule::Corner,
        };
        Around { rule, ends }
    }

    /// Share of a vertex's present rule in its next place, where the rule of the
    /// step after is another: the mean of what is left of the sharpness that
    /// runs out.
    pub(super) fn fading(&self, vertex: u32, boundary: Boundary) -> f64 {
        let own = self.vertex_sharpness(vertex, boundary);
        let all = self.spokes(vertex).map(|(_, sharp)| sharp).chain([own]);
        let runs_out = all.filter(|&sharp| sharp > 0.0 && decayed(sharp) == 0.0);
        let (count, sum) = runs_out.fold((0.0, 0.0), |(n, sum), s| (n + 1.0, sum + s));
        if count > 0.0 {
            (sum / count).min(1.0)
        } else {
            0.0
        }
    }
}
