//! The walk over the lattice: solves edges, faces and tetrahedra wherever the
//! mid-surface leads, wave by wave, each once under its key.

#[cfg(test)]
mod tests;

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};
use serde::Serialize;
use smallvec::SmallVec;

use crate::lattice::{EdgeKey, FaceKey, Lattice, NodeKey, TetKey};
use crate::mesh::FaceId;
use crate::settings::progress::{Progress, Stop, Stopped};
use crate::surface::marked::Line;
use crate::surface::marked::{MarkedMesh, MarkedVertex, edge};
use crate::trace::edge::{Crossing, NodeSample, crossings, sample_node};
use crate::trace::follow::cage::Cage;
use crate::trace::follow::face::{FaceContours, FaceNodeKind, FaceSeed, solve_face};
use crate::trace::follow::fan::alike;
use crate::trace::follow::region::{Barrier, Region};
use crate::trace::probe::Probe;
use crate::trace::tet::{InnerKind, TetSurface, VertexKey, solve_tet};
use crate::trace::tolerances::Tolerances;
use crate::walls::Walls;
use crate::walls::thickness::{maximal_ball, spread};

/// Everything found on the lattice, each under its key.
#[derive(Default)]
pub struct Found {
    nodes: FxHashMap<NodeKey, NodeSample>,
    edges: FxHashMap<EdgeKey, SmallVec<[Crossing; 1]>>,
    faces: FxHashMap<FaceKey, FaceContours>,
    seeds: FxHashMap<FaceKey, Vec<FaceSeed>>,
    tets: FxHashMap<TetKey, TetSurface>,
    /// Closest-point queries asked.
    pub queries: u64,
    /// Lattice edges solved.
    pub edges_solved: usize,
    /// Queries for nodes and edges.
    pub edge_queries: u64,
    /// Faces that still changed when the rounds were over.
    pub unsettled: usize,
}

/// Counts of what the walk took.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Counts {
    /// Lattice cells that hold a piece of the mid-surface.
    pub cells: usize,
    /// Tetrahedra solved.
    pub tetrahedra: usize,
    /// Faces solved.
    pub faces: usize,
    /// Lattice edges solved.
    pub edges: usize,
    /// Closest-point queries in all.
    pub queries: u64,
    /// Closest-point queries a lattice edge, its nodes included.
    pub queries_per_edge: f64,
    /// Places where a follower could not go on; they show as cracks unless
    /// they closed otherwise.
    pub lost: usize,
    /// Loops closed by matching what was left open, where a curve was lost or
    /// a sheet stops being one on the way.
    pub matched: usize,
    /// Borders where no wall ends: following was lost between walls that are
    /// separate, in a face whose small triangles did not tell how it goes on,
    /// or on a seam through a tetrahedron.
    pub torn: usize,
    /// Faces that still changed when the rounds were over: two followers
    /// that do not agree.
    pub unsettled: usize,
}

/// Rounds of asking neighbours again after which the walk goes on. Each adds
/// a vertex that was missing on an edge or in a face, and a face seldom lacks
/// more than two; what is left is told.
const MOST_ROUNDS: usize = 24;

/// The lattice walk over one part.
pub struct Tracer<'a> {
    walls: &'a Walls<'a>,
    lattice: Lattice,
    found: Found,
}

impl<'a> Tracer<'a> {
    /// A walk with nothing found yet.
    pub fn new(walls: &'a Walls<'a>, lattice: Lattice) -> Tracer<'a> {
        Tracer {
            walls,
            lattice,
            found: Found::default(),
        }
    }

    /// Solves one batch of keys in parallel, results in the order of the keys.
    fn batch<K: Sync + Send + Copy, R: Send>(
        &mut self,
        keys: &[K],
        stop: &Stop,
        solve: impl Fn(&Tracer, &mut Probe, K) -> R + Sync,
    ) -> Result<Vec<R>, Stopped> {
        let this = &*self;
        let chunks: Vec<(Vec<R>, u64)> = keys
            .par_chunks(16)
            .map(|chunk| {
                stop.heed()?;
                let mut probe = Probe::new(this.walls);
                let out = chunk.iter().map(|&k| solve(this, &mut probe, k)).collect();
                Ok((out, probe.queries()))
            })
            .collect::<Result<_, Stopped>>()?;
        let mut out = Vec::with_capacity(keys.len());
        for (part, queries) in chunks {
            out.extend(part);
            self.found.queries += queries;
        }
        Ok(out)
    }

    /// Tetrahedra in which the walls' maximal balls have their centres.
    fn seeds(&self) -> Vec<TetKey> {
        let field = self.walls.field();
        let spacing = 3.0 * self.lattice.cell();
        let walls: Vec<FaceId> = (0..field.face_count() as u32)
            .map(FaceId)
            .filter(|&f| !field.is_coping(f))
            .collect();
        let mut tets: Vec<TetKey> = walls
            .par_iter()
            .flat_map_iter(|&face| {
                spread(field.corners(face), spacing, 64)
                    .filter_map(move |p| maximal_ball(field, face, p))
            })
            .map(|(centre, _)| self.lattice.locate(centre))
            .collect();
        tets.par_sort_unstable();
        tets.dedup();
        tets
    }

    /// Follows the mid-surface from tetrahedron to tetrahedron until nothing is left to follow,
    /// or until asked to stop; what was found by then is of no use.
    ///
    /// Each wave solves edges, then faces, then tetrahedra. A curve that a 3D
    /// follower meets is seen first inside a tetrahedron, when it comes out
    /// through a face; but the vertex there belongs to the face, which both its
    /// tetrahedra read. So the tetrahedron only leaves a *seed*, and the face is
    /// solved again with it, its contours starting from the new vertex. In the
    /// same way a contour that arrives at an edge where no vertex is known adds
    /// one, and all faces round the edge are solved again.
    ///
    /// The rounds end because they only ever add: a seed or a crossing that is
    /// there already, to a tolerance, asks for nothing.
    pub fn run(&mut self, progress: &Progress, stop: &Stop) -> Result<(), Stopped> {
        let mut frontier = self.seeds();
        while !frontier.is_empty() {
            let done = self.found.tets.len();
            progress("trace", done as u64, (done + frontier.len()) as u64);
            self.solve_nodes_and_edges(&frontier, stop)?;
            let mut faces: Vec<FaceKey> = frontier.iter().flat_map(|t| t.faces()).collect();
            faces.sort_unstable();
            faces.dedup();
            faces.retain(|f| !self.found.faces.contains_key(f));
            let mut todo = frontier;
            let mut reached: Vec<FaceKey> = todo.iter().flat_map(|t| t.faces()).collect();
            for _ in 0..24 {
                let touched = self.solve_faces(faces, stop)?;
                reached.extend(&touched);
                // Tetrahedra solved before whose faces changed.
                for face in &touched {
                    todo.extend(
                        face.tetrahedra()
                            .filter(|t| self.found.tets.contains_key(t)),
                    );
                }
                todo.sort_unstable();
                todo.dedup();
                faces = self.solve_tets(&todo, stop)?;
                if faces.is_empty() {
                    break;
                }
                todo = faces
                    .iter()
                    .flat_map(|f| f.tetrahedra())
                    .filter(|t| self.found.tets.contains_key(t))
                    .collect();
            }
            frontier = self.next_frontier(reached);
        }
        Ok(())
    }

    /// Unsolved tetrahedra beside faces that the mid-surface crosses.
    fn next_frontier(&self, mut faces: Vec<FaceKey>) -> Vec<TetKey> {
        faces.sort_unstable();
        faces.dedup();
        let crossed = |f: &FaceKey| {
            self.found
                .faces
                .get(f)
                .is_some_and(|c| !c.arcs.is_empty() || !c.nodes.is_empty())
        };
        let mut next: Vec<TetKey> = faces
            .into_iter()
            .filter(crossed)
            .flat_map(|f| f.tetrahedra())
            .filter(|t| !self.found.tets.contains_key(t))
            .collect();
        next.sort_unstable();
        next.dedup();
        next
    }

    fn solve_nodes_and_edges(&mut self, tets: &[TetKey], stop: &Stop) -> Result<(), Stopped> {
        let mut edges: Vec<EdgeKey> = tets.iter().flat_map(|t| t.edges()).collect();
        edges.sort_unstable();
        edges.dedup();
        edges.retain(|e| !self.found.edges.contains_key(e));
        let mut nodes: Vec<NodeKey> = edges.iter().flat_map(|e| e.nodes()).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes.retain(|n| !self.found.nodes.contains_key(n));
        let before = self.found.queries;
        let samples = self.batch(&nodes, stop, |t, probe, n| {
            sample_node(probe, t.lattice.position(n))
        })?;
        self.found.nodes.extend(nodes.into_iter().zip(samples));
        let solved = self.batch(&edges, stop, |t, probe, e| {
            let [a, b] = e.nodes();
            let ends = [t.lattice.position(a), t.lattice.position(b)];
            crossings(probe, ends, [&t.found.nodes[&a], &t.found.nodes[&b]])
        })?;
        self.found.edges_solved += edges.len();
        self.found.edges.extend(edges.into_iter().zip(solved));
        self.found.edge_queries += self.found.queries - before;
        Ok(())
    }

    /// Solves faces, and again those whose edges turn out to have further
    /// vertices. Returns all that were solved.
    fn solve_faces(&mut self, faces: Vec<FaceKey>, stop: &Stop) -> Result<Vec<FaceKey>, Stopped> {
        let mut todo = faces;
        let mut touched: FxHashSet<FaceKey> = FxHashSet::default();
        for round in 0.. {
            if todo.is_empty() {
                break;
            }
            if round == MOST_ROUNDS {
                self.found.unsettled += todo.len();
                break;
            }
            debug_assert!(
                todo.iter()
                    .flat_map(|f| f.edges())
                    .all(|e| self.found.edges.contains_key(&e))
            );
            let solved = self.batch(&todo, stop, |t, probe, f| t.solve_face(probe, f))?;
            let mut grown: Vec<EdgeKey> = Vec::new();
            for (&face, contours) in todo.iter().zip(&solved) {
                for &(side, crossing) in &contours.found {
                    let edge = face.edges()[side as usize];
                    if self.add_crossing(edge, crossing) {
                        grown.push(edge);
                    }
                }
            }
            touched.extend(&todo);
            self.found.faces.extend(todo.into_iter().zip(solved));
            grown.sort_unstable();
            grown.dedup();
            todo = grown
                .iter()
                .flat_map(|e| e.faces())
                .filter(|f| self.found.faces.contains_key(f))
                .collect();
            todo.sort_unstable();
            todo.dedup();
        }
        let mut touched: Vec<FaceKey> = touched.into_iter().collect();
        touched.sort_unstable();
        Ok(touched)
    }

    fn add_crossing(&mut self, edge: EdgeKey, crossing: Crossing) -> bool {
        let near = self.lengths().same_point;
        let low = self.lattice.position(edge.nodes()[0]);
        let field = self.walls.field();
        let list = self.found.edges.entry(edge).or_default();
        let same = |c: &Crossing| {
            c.at.distance(crossing.at) <= near && alike(field, crossing.at, c.walls, crossing.walls)
        };
        if list.iter().any(same) {
            return false;
        }
        // In the order along the edge, whoever found it.
        let place = |c: &Crossing| c.at.distance(low);
        let after = list.partition_point(|c| place(c) <= place(&crossing));
        list.insert(after, crossing);
        true
    }

    fn lengths(&self) -> Tolerances {
        Tolerances::new(self.walls.tolerances(), self.lattice.cell())
    }

    fn solve_face(&self, probe: &mut Probe, face: FaceKey) -> FaceContours {
        let edges = face.edges();
        let sides = edges.map(|e| self.found.edges.get(&e).map_or(&[][..], |l| &l[..]));
        let seeds = self.found.seeds.get(&face).map_or(&[][..], |s| &s[..]);
        if seeds.is_empty() && sides.iter().all(|s| s.is_empty()) {
            return FaceContours::default();
        }
        let corners: SmallVec<[DVec3; 8]> = face
            .nodes()
            .iter()
            .map(|&n| self.lattice.position(n))
            .collect();
        let middle = corners.iter().sum::<DVec3>() / 3.0;
        let coping = probe
            .field()
            .nearest_coping(middle, 1.2 * self.lattice.cell())
            .is_some();
        match Region::new(
            corners,
            if coping {
                Barrier::Coping
            } else {
                Barrier::None
            },
        ) {
            Some(region) => solve_face(probe, region, sides, [true, true, false], seeds),
            None => FaceContours::default(),
        }
    }

    /// Solves tetrahedra; returns faces that need solving again.
    fn solve_tets(&mut self, tets: &[TetKey], stop: &Stop) -> Result<Vec<FaceKey>, Stopped> {
        let solved = self.batch(tets, stop, |t, probe, key| {
            let faces = key.faces().map(|f| &t.found.faces[&f]);
            if faces
                .iter()
                .all(|f| f.arcs.is_empty() && f.nodes.is_empty())
            {
                return TetSurface::default();
            }
            let corners = key.nodes().map(|n| t.lattice.position(n));
            let middle = 0.5 * (corners[0] + corners[3]);
            let coping = probe
                .field()
                .nearest_coping(middle, 0.9 * t.lattice.cell())
                .is_some();
            solve_tet(
                probe,
                key,
                &Cage::new(corners, coping),
                faces,
                &t.found.edges,
            )
        })?;
        let mut faces = Vec::new();
        let near = self.lengths().same_point;
        for surface in &solved {
            for &(face, seed) in &surface.seeds {
                let list = self.found.seeds.entry(face).or_default();
                if list.iter().all(|s| s.at.distance(seed.at) > near) {
                    list.push(seed);
                    faces.push(face);
                }
            }
        }
        self.found.tets.extend(tets.iter().copied().zip(solved));
        faces.sort_unstable();
        faces.dedup();
        // A face of an unsolved neighbour is solved when its turn comes.
        faces.retain(|f| self.found.faces.contains_key(f));
        Ok(faces)
    }

    /// Counts of the work done.
    pub fn counts(&self) -> Counts {
        let active = self.found.tets.iter().filter(|t| !t.1.triangles.is_empty());
        let cells: FxHashSet<NodeKey> = active.map(|t| t.0.cell()).collect();
        let lost: usize = self
            .found
            .faces
            .values()
            .map(|f| f.lost.len())
            .sum::<usize>()
            + self
                .found
                .tets
                .values()
                .map(|t| t.open.len())
                .sum::<usize>();
        Counts {
            cells: cells.len(),
            tetrahedra: self.found.tets.len(),
            faces: self.found.faces.len(),
            edges: self.found.edges_solved,
            queries: self.found.queries,
            queries_per_edge: self.found.edge_queries as f64
                / self.found.edges_solved.max(1) as f64,
            lost,
            matched: {
                let faces = self.found.faces.values().map(|f| f.matched as usize);
                let tets = self.found.tets.values().map(|t| t.matched as usize);
                faces.sum::<usize>() + tets.sum::<usize>()
            },
            torn: {
                let nodes = self.found.faces.values().flat_map(|f| &f.nodes);
                let tets = self.found.tets.values().map(|t| t.torn as usize);
                nodes.filter(|n| n.kind == FaceNodeKind::Torn).count() + tets.sum::<usize>()
            },
            unsettled: self.found.unsettled,
        }
    }

    fn vertex(&self, key: VertexKey) -> MarkedVertex {
        match key {
            VertexKey::Edge(e, i) => {
                let c = &self.found.edges[&e][i as usize];
                MarkedVertex {
                    at: c.at,
                    walls: SmallVec::from_slice(&c.walls),
                    coping: None,
                }
            }
            VertexKey::Face(f, i) => {
                let n = &self.found.faces[&f].nodes[i as usize];
                let coping = match n.kind {
                    FaceNodeKind::Coping(c) => Some(c),
                    _ => None,
                };
                MarkedVertex {
                    at: n.at,
                    walls: n.walls.iter().copied().collect(),
                    coping,
                }
            }
            VertexKey::Inner(t, i) => {
                let v = &self.found.tets[&t].inner[i as usize];
                let coping = match v.kind {
                    InnerKind::OnCoping(c) => Some(c),
                    _ => None,
                };
                MarkedVertex {
                    at: v.at,
                    walls: v.walls.iter().copied().collect(),
                    coping,
                }
            }
        }
    }

    /// Joins the pieces of all tetrahedra to one mesh, vertices numbered in
    /// the order of their keys.
    pub fn assemble(&self) -> MarkedMesh {
        let mut tets: Vec<TetKey> = self
            .found
            .tets
            .iter()
            .filter(|t| !t.1.polygons.is_empty())
            .map(|t| *t.0)
            .collect();
        tets.par_sort_unstable();
        let mut keys: Vec<VertexKey> = tets
            .iter()
            .flat_map(|t| self.found.tets[t].triangles.iter().flatten().copied())
            .collect();
        keys.par_sort_unstable();
        keys.dedup();
        let number = |k: &VertexKey| keys.binary_search(k).ok().map(|n| n as u32);
        let mut mesh = MarkedMesh {
            vertices: keys.iter().map(|&k| self.vertex(k)).collect(),
            ..MarkedMesh::default()
        };
        for tet in &tets {
            let surface = &self.found.tets[tet];
            for t in &surface.triangles {
                // Every key was collected above.
                if let [Some(a), Some(b), Some(c)] = [number(&t[0]), number(&t[1]), number(&t[2])] {
                    mesh.triangles.push([a, b, c]);
                }
            }
            for polygon in &surface.polygons {
                let n = polygon.corners.len();
                for k in 0..n {
                    let line = polygon.lines[k];
                    if line == Line::Sheet {
                        continue;
                    }
                    let ends = (
                        number(&polygon.corners[k]),
                        number(&polygon.corners[(k + 1) % n]),
                    );
                    if let (Some(a), Some(b)) = ends {
                        mesh.lines.insert(edge(a, b), line);
                    }
                }
            }
        }
        mesh.drop_pillows();
        mesh.drop_stray_lines();
        mesh
    }
}
