//! The patch: an oriented two-manifold surface with or without boundary, and
//! on which side of it a point lies.

use glam::DVec3;
use rustc_hash::FxHashMap;

use crate::field::{Feature, Field};
use crate::mesh::{FaceId, TriMesh, angle};

use super::ThickenError;

/// No triangle across an edge.
const NONE: u32 = u32::MAX;

/// Sine of the angle from which on an inner edge counts as bent.
const BENT: f64 = 1e-9;

/// A checked patch, oriented so that the solid lies against the normals.
///
/// The paper speaks of that side alone: the other one is had by flipping all
/// triangles.
pub(super) struct Patch {
    pub mesh: TriMesh,
    pub field: Field,
    /// Unit normals of the faces.
    normals: Vec<DVec3>,
    /// Across edge `i` (corner `i` to `i + 1`).
    neighbours: Vec<[u32; 3]>,
    /// Weighted by angle (Baerentzen and Aanaes, 2005); not of unit length.
    vertex_normals: Vec<DVec3>,
    pub rim: Rim,
}

/// The boundary curves.
#[derive(Default)]
pub(super) struct Rim {
    /// Curve by curve, in the order in which the triangles run them.
    pub edges: Vec<RimEdge>,
    /// First and last edge (exclusive) of each curve.
    pub loops: Vec<[u32; 2]>,
    /// Fans of the cross-section, by vertex.
    pub sectors: Vec<Sector>,
    /// By vertex: edge that starts there.
    starts: FxHashMap<u32, u32>,
    /// By vertex: range in `sectors`.
    sectors_of: FxHashMap<u32, [u32; 2]>,
}

/// A boundary edge and the strip of the cross-section on it: the edge swept
/// against its triangle's normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct RimEdge {
    pub face: u32,
    pub from: u32,
    pub to: u32,
    pub curve: u32,
    /// Unit normal of the strip, out of the solid.
    pub outward: DVec3,
    /// Unit direction from the edge into the strip.
    pub down: DVec3,
}

/// A flat fan of the cross-section: where an inner edge ends at the boundary
/// and the solid opens around it, the points across the edge at its end.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sector {
    pub vertex: u32,
    /// A face that has the vertex and the edge.
    pub face: u32,
    /// Unit normal of the fan, out of the solid: from the edge's other end to
    /// the vertex.
    pub outward: DVec3,
}

/// On which boundary feature a closest point lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum OnRim {
    Edge(u32),
    Vertex(u32),
}

/// The closest point of the patch.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foot {
    pub face: u32,
    pub feature: Feature,
    pub point: DVec3,
    pub distance: f64,
    /// Signed like Definition 1's distance; its size means nothing.
    pub side: f64,
    pub rim: Option<OnRim>,
}

impl Patch {
    /// Checks the triangles and finds the boundary.
    ///
    /// # Errors
    ///
    /// Triangles without area, edges or vertices where the surface is no
    /// manifold, neighbours that disagree about the side.
    pub fn new(mesh: TriMesh) -> Result<Patch, ThickenError> {
        let field = Field::of_mesh(&mesh);
        let normals: Vec<DVec3> = mesh.faces().map(|f| field.normal(f)).collect();
        if let Some(face) = normals.iter().position(|&n| n == DVec3::ZERO) {
            return Err(ThickenError::NoArea {
                triangle: face,
                count: normals.iter().filter(|&&n| n == DVec3::ZERO).count(),
            });
        }
        let neighbours = neighbours(&mesh)?;
        let mut vertex_normals = vec![DVec3::ZERO; mesh.positions.len()];
        for (face, &normal) in mesh.faces().zip(&normals) {
            let (c, vertices) = (mesh.corners(face), mesh.triangles[face.index()]);
            for i in 0..3 {
                let (u, v) = (c[(i + 1) % 3] - c[i], c[(i + 2) % 3] - c[i]);
                vertex_normals[vertices[i] as usize] += angle(u, v) * normal;
            }
        }
        let mut patch = Patch {
            mesh,
            field,
            normals,
            neighbours,
            vertex_normals,
            rim: Rim::default(),
        };
        patch.find_rim();
        patch.check_fans()?;
        patch.find_sectors();
        Ok(patch)
    }

    /// The closest point; `hint` is a face likely near it.
    pub fn foot(&self, p: DVec3, hint: u32) -> Foot {
        let found = self.field.footpoint_near(p, FaceId(hint));
        let face = found.face.0;
        let feature = self.field.feature_on(p, found.face);
        // The face comes from the field itself.
        let feature = feature.unwrap_or(Feature::Face);
        let f = face as usize;
        let (normal, rim) = match feature {
            Feature::Face => (self.normals[f], None),
            Feature::Edge(i) => match self.neighbours[f][usize::from(i)] {
                NONE => {
                    let start = self.mesh.triangles[f][usize::from(i)];
                    (
                        self.normals[f],
                        self.rim.starts.get(&start).map(|&e| OnRim::Edge(e)),
                    )
                }
                other => (self.normals[f] + self.normals[other as usize], None),
            },
            Feature::Corner(i) => {
                let v = self.mesh.triangles[f][usize::from(i)];
                let rim = self.rim.starts.contains_key(&v).then_some(OnRim::Vertex(v));
                (self.vertex_normals[v as usize], rim)
            }
        };
        Foot {
            face,
            feature,
            point: found.point,
            distance: found.distance,
            side: (p - found.point).dot(normal),
            rim,
        }
    }

    pub fn position(&self, vertex: u32) -> DVec3 {
        self.mesh.positions[vertex as usize]
    }

    pub fn normal(&self, face: u32) -> DVec3 {
        self.normals[face as usize]
    }

    /// The strips of the boundary edges of a face.
    pub fn strips_of(&self, face: u32) -> impl Iterator<Item = u32> + '_ {
        let f = face as usize;
        (0..3).filter_map(move |i| {
            let open = self.neighbours[f][i] == NONE;
            let start = self.mesh.triangles[f][i];
            open.then(|| self.rim.starts.get(&start).copied()).flatten()
        })
    }

    /// The sectors that bound the points nearest to an inner edge.
    pub fn sectors_of_edge(&self, face: u32, edge: u8) -> impl Iterator<Item = u32> + '_ {
        let t = self.mesh.triangles[face as usize];
        let [a, b] = [t[usize::from(edge)], t[(usize::from(edge) + 1) % 3]];
        [(a, b), (b, a)].into_iter().flat_map(move |(v, u)| {
            let away = (self.position(v) - self.position(u)).normalize_or_zero();
            self.rim
                .sectors_at(v)
                .filter(move |&s| self.rim.sectors[s as usize].outward == away)
        })
    }

    fn find_rim(&mut self) {
        let mut next: FxHashMap<u32, (u32, u32)> = FxHashMap::default();
        let mut order = Vec::new();
        for (face, across) in self.neighbours.iter().enumerate() {
            for i in (0..3).filter(|&i| across[i] == NONE) {
                let t = self.mesh.triangles[face];
                next.insert(t[i], (t[(i + 1) % 3], face as u32));
                order.push(t[i]);
            }
        }
        let rim = &mut self.rim;
        for start in order {
            if rim.starts.contains_key(&start) {
                continue;
            }
            let (curve, first) = (rim.loops.len() as u32, rim.edges.len() as u32);
            let mut from = start;
            while let Some(&(to, face)) = next.get(&from)
                && !rim.starts.contains_key(&from)
            {
                rim.starts.insert(from, rim.edges.len() as u32);
                let along = self.mesh.positions[to as usize] - self.mesh.positions[from as usize];
                let normal = self.normals[face as usize];
                rim.edges.push(RimEdge {
                    face,
                    from,
                    to,
                    curve,
                    outward: along.cross(normal).normalize_or_zero(),
                    down: -normal,
                });
                from = to;
            }
            rim.loops.push([first, rim.edges.len() as u32]);
        }
    }

    /// Every vertex has one fan of triangles: as many boundary edges start
    /// there as do around a manifold's vertex, and the fan reaches all faces.
    fn check_fans(&self) -> Result<(), ThickenError> {
        let mut count = vec![0_u32; self.mesh.positions.len()];
        let mut any = vec![NONE; self.mesh.positions.len()];
        for (face, t) in self.mesh.triangles.iter().enumerate() {
            for &v in t {
                count[v as usize] += 1;
                any[v as usize] = face as u32;
            }
        }
        for (v, (&count, &face)) in count.iter().zip(&any).enumerate() {
            if count > 0 && self.fan(v as u32, face).len() as u32 != count {
                return Err(ThickenError::PinchedVertex(self.mesh.positions[v]));
            }
        }
        Ok(())
    }

    /// The faces around a vertex, in order against the clock; begins at the
    /// boundary if the vertex is on it.
    fn fan(&self, vertex: u32, face: u32) -> Vec<u32> {
        let corner = |f: u32| {
            let t = self.mesh.triangles[f as usize];
            t.iter().position(|&v| v == vertex).unwrap_or(0)
        };
        let first = match self.rim.starts.get(&vertex) {
            Some(&edge) => self.rim.edges[edge as usize].face,
            None => face,
        };
        let mut fan = vec![first];
        loop {
            let f = fan[fan.len() - 1];
            // The edge that ends at the vertex; against the clock across it.
            let next = self.neighbours[f as usize][(corner(f) + 2) % 3];
            if next == NONE || next == first || fan.len() > self.mesh.triangles.len() {
                return fan;
            }
            fan.push(next);
        }
    }

    fn find_sectors(&mut self) {
        let mut sectors = Vec::new();
        let mut ranges = FxHashMap::default();
        for edge in &self.rim.edges {
            let (v, first) = (edge.from, sectors.len() as u32);
            for pair in self.fan(v, edge.face).windows(2) {
                let (f, g) = (pair[0], pair[1]);
                // The vertex that both have besides this one.
                let [t, s] = [f, g].map(|f| self.mesh.triangles[f as usize]);
                let Some(&u) = t.iter().find(|&&u| u != v && s.contains(&u)) else {
                    continue;
                };
                let Some(&w) = s.iter().find(|&&w| w != v && w != u) else {
                    continue;
                };
                let to_w = self.position(w) - self.position(u);
                if to_w.dot(self.normal(f)) > BENT * to_w.length() {
                    sectors.push(Sector {
                        vertex: v,
                        face: f,
                        outward: (self.position(v) - self.position(u)).normalize_or_zero(),
                    });
                }
            }
            ranges.insert(v, [first, sectors.len() as u32]);
        }
        self.rim.sectors = sectors;
        self.rim.sectors_of = ranges;
    }
}

impl Rim {
    /// Sectors at a boundary vertex.
    pub fn sectors_at(&self, vertex: u32) -> std::ops::Range<u32> {
        let [from, to] = self.sectors_of.get(&vertex).copied().unwrap_or([0, 0]);
        from..to
    }

    /// The boundary edges that end and start at a boundary vertex.
    pub fn edges_at(&self, vertex: u32) -> Option<[u32; 2]> {
        let &after = self.starts.get(&vertex)?;
        Some([self.before(after), after])
    }

    /// The edge before another on its curve.
    pub fn before(&self, edge: u32) -> u32 {
        let [from, to] = self.loops[self.edges[edge as usize].curve as usize];
        if edge == from { to - 1 } else { edge - 1 }
    }
}

fn neighbours(mesh: &TriMesh) -> Result<Vec<[u32; 3]>, ThickenError> {
    let mut neighbours = vec![[NONE; 3]; mesh.triangles.len()];
    let place = |face: FaceId, edge: [u32; 2], forward: bool| {
        let start = if forward { edge[0] } else { edge[1] };
        let t = mesh.triangles[face.index()];
        t.iter().position(|&v| v == start).unwrap_or(0)
    };
    for uses in mesh.edges().by_edge() {
        let between = uses[0].edge.map(|v| mesh.positions[v as usize]);
        match uses {
            [_] => {}
            [a, b] if a.forward != b.forward => {
                for (one, other) in [(a, b), (b, a)] {
                    let i = place(one.face, one.edge, one.forward);
                    neighbours[one.face.index()][i] = other.face.0;
                }
            }
            [_, _] if is_orientable(mesh) => return Err(ThickenError::Sides(between)),
            [_, _] => return Err(ThickenError::OneSided),
            _ => {
                return Err(ThickenError::NotManifold {
                    triangles: uses.len(),
                    between,
                });
            }
        }
    }
    Ok(neighbours)
}

/// Whether triangles could be turned so that all neighbours agree.
fn is_orientable(mesh: &TriMesh) -> bool {
    let mut across: Vec<Vec<(u32, bool)>> = vec![Vec::new(); mesh.triangles.len()];
    for uses in mesh.edges().by_edge() {
        if let [a, b] = uses {
            let differ = a.forward == b.forward;
            across[a.face.index()].push((b.face.0, differ));
            across[b.face.index()].push((a.face.0, differ));
        }
    }
    let mut turned: Vec<Option<bool>> = vec![None; mesh.triangles.len()];
    for seed in 0..turned.len() {
        if turned[seed].is_some() {
            continue;
        }
        turned[seed] = Some(false);
        let mut open = vec![(seed, false)];
        while let Some((face, own)) = open.pop() {
            for &(other, differ) in &across[face] {
                let wanted = own != differ;
                match turned[other as usize] {
                    Some(found) if found != wanted => return false,
                    Some(_) => {}
                    None => {
                        turned[other as usize] = Some(wanted);
                        open.push((other as usize, wanted));
                    }
                }
            }
        }
    }
    true
}
