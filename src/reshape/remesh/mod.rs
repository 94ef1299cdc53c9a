//! Remeshing to an element size.
//!
//! Edges are split, contracted and flipped and vertices moved until edges have
//! their target lengths ([`size`](super::size)) and triangles good angles
//! (Botsch and Kobbelt, "A remeshing approach to multiresolution modeling",
//! 2004). We deviate in this: seams, borders and creases are divided once and
//! shared by all their sheets, so the result conforms; every vertex is put back
//! onto the exact mid-surface by its footpoints ([`project`](super::project)),
//! not onto the mesh given, wherever the part is known; and an edit must keep the topology, the direction
//! of each triangle and, within [`Settings::sag`], the place of the surface.
//!
//! # What is promised
//!
//! - The result is homeomorphic to the mesh given, lines to lines and corners
//!   to corners: no crack, no fold.
//! - The same mesh and settings give the same result, bit for bit.
//!
//! # What is not
//!
//! - Good angles where lines themselves meet at small ones, or run closer
//!   together than [`Settings::grading`] can make up for.

mod edits;
mod faces;
mod halve;
mod matching;
mod quads;
mod relax;
mod straight;

use glam::DVec3;
use serde::Serialize;

use super::complex::{Complex, Rank};
use super::ground::Ground;
use super::lines::Lines;
use super::shape::Shape;
pub use super::size::{Junctions, Settings};
use super::size::{Wanted, sizes};
use super::uncut::{Kept, fewest_cuts};
use crate::surface::Ball;
use crate::surface::marked::{MarkedMesh, MarkedVertex};
use straight::Support;

/// A mesh of elements.
#[derive(Clone, Debug, Default)]
pub struct Meshed {
    /// Its triangles.
    pub mesh: MarkedMesh,
    /// Pairs of triangles that make a quadrilateral without the edge between
    /// them, lower number first; each triangle once at most.
    pub quads: Vec<[u32; 2]>,
    /// Middles of edges on their sheets and lines, low vertex first.
    pub middles: Vec<([u32; 2], DVec3)>,
    /// Balls of vertices that were carried off the medial surface, by number.
    pub balls: Vec<(u32, Ball)>,
    /// What was done.
    pub edits: Edits,
}

/// What was done, and what could not be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Edits {
    /// Edges split.
    pub split: usize,
    /// Edges contracted.
    pub contracted: usize,
    /// Edges flipped.
    pub flipped: usize,
    /// Vertices that lie on a chord, as no exact point was found for them.
    pub chords: usize,
}

/// Rounds of splitting, contracting, flipping and moving.
const ROUNDS: usize = 6;

/// Rounds that better what is poor after that.
const POLISH: usize = 4;

/// Tries to keep elements from passing through each other.
const TRIES: i32 = 4;

/// A line has a corner where it turns by more, degrees.
const CORNER: f64 = 30.0;

/// Cosine of the angle by which a triangle may lean against the sheet at its
/// corners: 60 degrees, more than a sheet turns in its dip towards a seam.
const LEANING: f64 = 0.5;

/// The same at a corner where the sheet ends, which may be beside a bend.
const LEANING_AT_END: f64 = 0.2;

/// Turns within this share of the element size count as one corner.
const CORNER_WIDTH: f64 = 0.1;

/// Remeshes towards an element size. Where elements of that size would pass
/// through each other they are made smaller, or the mesh given stays where those do too; junctions
/// stay as they are.
pub(crate) fn remesh(mesh: &MarkedMesh, ground: &dyn Ground, settings: &Settings) -> Meshed {
    let make = |kept: &Kept| remesh_with(mesh, ground, settings, kept);
    fewest_cuts(mesh, TRIES, make, |meshed| &meshed.mesh).0
}

fn remesh_with(mesh: &MarkedMesh, ground: &dyn Ground, settings: &Settings, kept: &Kept) -> Meshed {
    let mut remesher = Remesher::new(mesh, ground, settings, kept);
    remesher.lay_down();
    for _ in 0..ROUNDS {
        remesher.contract_short();
        remesher.split_long();
        remesher.flip_poor();
        remesher.relax();
    }
    let straight = settings.junctions == Junctions::Straight;
    if straight && !settings.quads {
        remesher.straighten(&|this| {
            this.contract_poor();
            this.flip_poor();
            this.relax();
        });
    }
    for _ in 0..POLISH {
        remesher.approach(1.0);
        remesher.contract_poor();
        remesher.flip_poor();
        remesher.relax();
        remesher.nudge_poor();
    }
    let quads = match settings.quads {
        true => remesher.quadrilaterals(straight),
        false => Vec::new(),
    };
    let middles = remesher.middles();
    let balls = remesher.straight_balls();
    let (mesh, edits) = remesher.finish();
    Meshed {
        mesh,
        quads,
        middles,
        balls,
        edits,
    }
}

/// A mesh being remeshed.
struct Remesher<'a> {
    complex: Complex,
    vertices: Vec<MarkedVertex>,
    /// Whether a vertex lies on a chord only.
    chord: Vec<bool>,
    /// Normal of the sheet at each vertex inside one or where one alone ends,
    /// either way up; zero elsewhere.
    normals: Vec<DVec3>,
    /// Target edge length at each vertex.
    size: Vec<f64>,
    /// That of the elements that these are to be halved to, for quadrilaterals.
    fine: Vec<f64>,
    lines: Lines,
    /// The wall carried on to a vertex, once junctions are straight.
    straight: Vec<Option<Support>>,
    /// Where vertices go for that.
    targets: Vec<(u32, DVec3)>,
    /// Whether lines stay where they are.
    frozen: bool,
    /// Vertices of the mesh given that stay, and the edges between them.
    left: Vec<bool>,
    /// Where elements came to pass through each other.
    kept: &'a Kept,
    ground: &'a dyn Ground,
    sag: f64,
    edits: Edits,
}

impl<'a> Remesher<'a> {
    fn new(
        mesh: &MarkedMesh,
        ground: &'a dyn Ground,
        settings: &Settings,
        kept: &'a Kept,
    ) -> Remesher<'a> {
        let wanted = settings.wanted();
        // Quadrilaterals come of halving.
        let first = match settings.quads {
            true => settings.coarse(),
            false => settings.wanted(),
        };
        let mut complex = Complex::new(mesh);
        let angle = CORNER.to_radians();
        for v in Lines::new(&complex, &mesh.vertices).corners(CORNER_WIDTH * first.size, angle) {
            complex.pin(v);
        }
        let left: Vec<bool> = (mesh.vertices.iter()).map(|v| kept.is_left(v.at)).collect();
        for (v, left) in (0..).zip(&left) {
            if *left {
                complex.pin(v);
            }
        }
        let lines = Lines::new(&complex, &mesh.vertices);
        let sizes = |wanted: &Wanted| sizes(&complex, &mesh.vertices, &lines, ground, wanted, kept);
        let size = sizes(&first);
        let fine = match settings.quads {
            true => sizes(&wanted),
            false => size.clone(),
        };
        let mut remesher = Remesher {
            vertices: mesh.vertices.clone(),
            normals: vec![DVec3::ZERO; mesh.vertices.len()],
            chord: vec![false; mesh.vertices.len()],
            straight: vec![None; mesh.vertices.len()],
            targets: Vec::new(),
            frozen: false,
            left,
            kept,
            size,
            fine,
            lines,
            complex,
            ground,
            sag: first.sag,
            edits: Edits::default(),
        };
        for v in 0..mesh.vertices.len() as u32 {
            remesher.note_normal(v);
        }
        remesher
    }

    /// Keeps the normal of the sheet at a vertex that has a new place.
    fn note_normal(&mut self, v: u32) {
        let vertex = &self.vertices[v as usize];
        if let Some(support) = self.support_of(v) {
            self.normals[v as usize] = support.normal;
            return;
        }
        if let Some((line, _)) = self.line_at(v) {
            self.normals[v as usize] = match self.frozen {
                true => DVec3::ZERO,
                false => self.lines.normal(line, v),
            };
            return;
        }
        // Where three walls tie, the sheet bends.
        let plain = vertex.walls.len() <= 2 && self.complex.rank(v) == Rank::Inner;
        self.normals[v as usize] = if plain {
            self.ground.normal(vertex)
        } else {
            DVec3::ZERO
        };
    }

    /// Whether a triangle lies along the sheet at each corner inside it. None
    /// can turn over without standing upright on the way.
    fn upright(&self, corners: [u32; 3], shape: &Shape) -> bool {
        corners.iter().all(|&v| {
            let normal = self.normals[v as usize];
            let least = match self.complex.rank(v) {
                Rank::Inner => LEANING,
                _ => LEANING_AT_END,
            };
            normal == DVec3::ZERO || normal.dot(shape.normal).abs() >= least
        })
    }

    fn finish(mut self) -> (MarkedMesh, Edits) {
        let used = |v: u32| !self.complex.around(v).is_empty();
        let chords = (0..self.vertices.len()).filter(|&v| self.chord[v] && used(v as u32));
        self.edits.chords = chords.count();
        (self.complex.into_mesh(&self.vertices), self.edits)
    }

    /// Whether an edge of the mesh given stays as it is.
    fn is_left(&self, a: u32, b: u32) -> bool {
        let left = |v: u32| self.left.get(v as usize).is_some_and(|left| *left);
        left(a) && left(b)
    }

    fn length(&self, a: u32, b: u32) -> f64 {
        self.complex.at(a).distance(self.complex.at(b))
    }

    /// Length of an edge against the one wanted there.
    fn ratio(&self, a: u32, b: u32) -> f64 {
        let wanted = 0.5 * (self.size[a as usize] + self.size[b as usize]);
        self.length(a, b) / wanted
    }

    /// Puts a vertex to its new place.
    fn settle(&mut self, v: u32, vertex: MarkedVertex, chord: bool) {
        self.complex.put(v, vertex.at);
        self.vertices[v as usize] = vertex;
        self.chord[v as usize] = chord;
        self.note_normal(v);
    }

    /// Whether a vertex moves along a line, and on which.
    fn line_at(&self, v: u32) -> Option<(u32, [u32; 2])> {
        if self.complex.rank(v) != Rank::Line {
            return None;
        }
        let [a, b] = self.complex.line_through(v)?;
        Some((self.lines.of_edge(v, a)?, [a, b]))
    }

    /// The point of a line at a place, and whether it is on a chord only.
    fn line_point(&self, line: u32, place: f64) -> (MarkedVertex, bool) {
        let course = self.lines.course(line);
        course.point(place, self.ground)
    }
}
