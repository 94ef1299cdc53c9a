//! What is solved of the lattice near one place, each simplex once under its key.
//!
//! A store answers *what does the mid-surface do here?* for nodes, edges, faces
//! and tetrahedra alike: it solves what it lacks, from the corners up. Each
//! answer follows from the key and from what was [`Asked`] by then, never from
//! the order of questions. So any two stores agree, and one may be let go of
//! wherever it stands in the way: blocks share faces without sharing memory.

use glam::DVec3;
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use super::asked::Asked;
use crate::lattice::{EdgeKey, FaceKey, Lattice, NodeKey, TetKey};
use crate::mesh::FaceId;
use crate::surface::marked::MarkedVertex;
use crate::trace::edge::{Crossing, NodeSample, crossings, sample_node_near};
use crate::trace::follow::cage::Cage;
use crate::trace::follow::face::{FaceContours, FaceNodeKind, solve_face};
use crate::trace::follow::region::{Barrier, Region};
use crate::trace::probe::Probe;
use crate::trace::tet::{InnerKind, InnerVertex, TetSurface, VertexKey, solve_tet};
use crate::walls::Walls;

/// What solving took.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Effort {
    /// Closest-point queries.
    pub(super) queries: u64,
    /// Of them for nodes and edges.
    pub(super) edge_queries: u64,
    /// Edges solved.
    pub(super) edges: usize,
    /// Faces solved.
    pub(super) faces: usize,
}

impl Effort {
    pub(super) fn add(&mut self, other: Effort) {
        self.queries += other.queries;
        self.edge_queries += other.edge_queries;
        self.edges += other.edges;
        self.faces += other.faces;
    }
}

/// Solved simplices, each under its key.
pub(super) struct Store<'a> {
    lattice: Lattice,
    asked: &'a Asked,
    probe: Probe<'a>,
    /// A wall near the last node: the walk goes from neighbour to neighbour.
    hint: FaceId,
    nodes: FxHashMap<NodeKey, NodeSample>,
    edges: FxHashMap<EdgeKey, SmallVec<[Crossing; 1]>>,
    faces: FxHashMap<FaceKey, FaceContours>,
    edge_queries: u64,
}

impl<'a> Store<'a> {
    /// With nothing solved yet.
    pub(super) fn new(walls: &'a Walls<'a>, lattice: Lattice, asked: &'a Asked) -> Store<'a> {
        Store {
            lattice,
            asked,
            probe: Probe::new(walls),
            hint: FaceId(0),
            nodes: FxHashMap::default(),
            edges: FxHashMap::default(),
            faces: FxHashMap::default(),
            edge_queries: 0,
        }
    }

    /// Forgets everything but the room that it took, and tells the effort.
    pub(super) fn clear(&mut self) -> Effort {
        let effort = Effort {
            queries: self.probe.queries(),
            edge_queries: self.edge_queries,
            edges: self.edges.len(),
            faces: self.faces.len(),
        };
        self.probe = Probe::new(self.probe.walls());
        self.edge_queries = 0;
        self.nodes.clear();
        self.edges.clear();
        self.faces.clear();
        effort
    }

    fn node(&mut self, key: NodeKey) -> NodeSample {
        if let Some(&known) = self.nodes.get(&key) {
            return known;
        }
        let sample = sample_node_near(&mut self.probe, self.lattice.position(key), self.hint);
        self.hint = sample.wall;
        self.nodes.insert(key, sample);
        sample
    }

    /// The vertices on an edge, in order from its low node.
    pub(super) fn edge(&mut self, key: EdgeKey) -> &SmallVec<[Crossing; 1]> {
        if !self.edges.contains_key(&key) {
            let solved = match self.asked.edge(key) {
                Some(grown) => grown.clone(),
                None => {
                    let before = self.probe.queries();
                    let nodes = key.nodes();
                    let samples = nodes.map(|n| self.node(n));
                    let ends = nodes.map(|n| self.lattice.position(n));
                    let solved = crossings(&mut self.probe, ends, [&samples[0], &samples[1]]);
                    self.edge_queries += self.probe.queries() - before;
                    solved
                }
            };
            self.edges.insert(key, solved);
        }
        &self.edges[&key]
    }

    /// The contours of a face.
    pub(super) fn face(&mut self, key: FaceKey) -> &FaceContours {
        if !self.faces.contains_key(&key) {
            for edge in key.edges() {
                self.edge(edge);
            }
            let solved = self.contours(key);
            self.faces.insert(key, solved);
        }
        &self.faces[&key]
    }

    fn contours(&mut self, key: FaceKey) -> FaceContours {
        let edges = key.edges();
        let sides = edges.map(|e| &self.edges[&e][..]);
        let seeds = self.asked.seeds(key);
        if seeds.is_empty() && sides.iter().all(|s| s.is_empty()) {
            return FaceContours::default();
        }
        let corners: SmallVec<[DVec3; 8]> =
            (key.nodes().iter().map(|&n| self.lattice.position(n))).collect();
        let middle = corners.iter().sum::<DVec3>() / 3.0;
        let barrier = match self.has_coping(middle, 1.2) {
            true => Barrier::Coping,
            false => Barrier::None,
        };
        match Region::new(corners, barrier) {
            Some(region) => solve_face(&mut self.probe, region, sides, [true, true, false], seeds),
            None => FaceContours::default(),
        }
    }

    /// Whether coping is nearer than so many cells.
    fn has_coping(&self, middle: DVec3, cells: f64) -> bool {
        let reach = cells * self.lattice.cell();
        self.probe.field().nearest_coping(middle, reach).is_some()
    }

    /// The mid-surface inside a tetrahedron; none as long as one of its faces
    /// asks for a vertex on an edge.
    pub(super) fn tet(&mut self, key: TetKey) -> Option<TetSurface> {
        let keys = key.faces();
        for face in keys {
            self.face(face);
        }
        let faces = keys.map(|f| &self.faces[&f]);
        if faces.iter().any(|f| !f.found.is_empty()) {
            return None;
        }
        if !faces.iter().any(|f| is_crossed(f)) {
            return Some(TetSurface::default());
        }
        let corners = key.nodes().map(|n| self.lattice.position(n));
        let cage = Cage::new(
            corners,
            self.has_coping(0.5 * (corners[0] + corners[3]), 0.9),
        );
        Some(solve_tet(&mut self.probe, key, &cage, faces, &self.edges))
    }

    /// A vertex on an edge or in a face; of an inner one only its tetrahedron
    /// knows. None if nothing has that name.
    pub(super) fn vertex(&mut self, key: VertexKey) -> Option<MarkedVertex> {
        match key {
            VertexKey::Edge(edge, n) => self.edge(edge).get(n as usize).map(|c| MarkedVertex {
                at: c.at,
                walls: SmallVec::from_slice(&c.walls),
                coping: None,
            }),
            VertexKey::Face(face, n) => {
                let node = self.face(face).nodes.get(n as usize)?;
                Some(MarkedVertex {
                    at: node.at,
                    walls: node.walls.iter().copied().collect(),
                    coping: match node.kind {
                        FaceNodeKind::Coping(c) => Some(c),
                        _ => None,
                    },
                })
            }
            VertexKey::Inner(..) => None,
        }
    }
}

/// A vertex inside a tetrahedron, as one of the mesh.
pub(super) fn inner_vertex(v: &InnerVertex) -> MarkedVertex {
    MarkedVertex {
        at: v.at,
        walls: v.walls.iter().copied().collect(),
        coping: match v.kind {
            InnerKind::OnCoping(c) => Some(c),
            _ => None,
        },
    }
}

/// Whether the mid-surface comes through a face.
pub(super) fn is_crossed(face: &FaceContours) -> bool {
    !face.arcs.is_empty() || !face.nodes.is_empty()
}
