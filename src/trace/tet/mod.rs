//! What the mid-surface does inside one tetrahedron: contours of its faces,
//! seams and borders through it, chained to polygons
//! (Bloomenthal 2011, section 4.4).
//!
//! Contours, seam sides and borders are *strands*. Every strand end plugs into
//! a *port*: a vertex on an edge, a spoke of a face vertex, or a sheet at an
//! inner vertex. A port takes exactly two strand ends, so the strands chain to
//! closed loops like dominoes, and a loop that does not close shows as a port
//! with one end: a missing answer that can be counted.
//!
//! * [`curves`]: follows seams and borders from end to [end](ends).
//! * [`vertices`]: what lies inside, where curves meet.
//! * [`loops`]: strands to loops.
//! * [`cut`]: loops to triangles, [one by one](polygon), clear of each other.

mod curves;
mod cut;
mod ends;
mod loops;
mod polygon;
mod vertices;

use glam::DVec3;
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use self::ends::CurveEnd;
use crate::lattice::{EdgeKey, FaceKey, TetKey};
use crate::mesh::FaceId;
use crate::surface::marked::Line;
use crate::trace::edge::Crossing;
use crate::trace::follow::cage::Cage;
use crate::trace::follow::face::{ArcEnd, FaceContours, FaceSeed};
use crate::trace::probe::Probe;
use crate::trace::tolerances::Tolerances;

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
    /// Loops closed by matching ports instead of following, fading borders
    /// between faces aside.
    pub matched: u32,
    /// Those among them that end a sheet where no wall ends.
    pub torn: u32,
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
    work.close_curves();
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
}
