//! Polygons to triangles that do not pass through one another.
//!
//! A tetrahedron is convex and holds its triangles, so triangles of two
//! tetrahedra never cut each other: what is kept clear here is clear in the
//! whole.

use glam::DVec3;
use smallvec::SmallVec;

use super::{InnerKind, Polygon, VertexKey, Work, polygon};
use crate::mesh::clash;
use crate::trace::edge;

/// A polygon on its way to triangles.
struct Piece {
    corners: Vec<VertexKey>,
    points: Vec<DVec3>,
    /// Faces of the tetrahedron that each corner lies on, one bit each.
    on: Vec<u8>,
    /// Diagonals, by numbers of corners, that would pass through another sheet.
    banned: Vec<[usize; 2]>,
    cut: Cut,
}

/// Triangles of a polygon.
#[derive(Clone)]
struct Cut {
    triangles: Vec<[VertexKey; 3]>,
    places: Vec<[DVec3; 3]>,
}

impl Work<'_, '_> {
    /// Cuts all polygons into triangles.
    pub(super) fn cut_polygons(&mut self) {
        let polygons = std::mem::take(&mut self.out.polygons);
        let whole = polygons.iter().filter(|p| p.corners.len() >= 3);
        let mut pieces: Vec<Piece> = whole.map(|p| self.piece(p)).collect();
        if pieces.len() > 1 {
            self.clear(&mut pieces);
        }
        let triangles = pieces.iter().flat_map(|p| &p.cut.triangles);
        self.out.triangles.extend(triangles);
        self.out.polygons = polygons;
    }

    fn piece(&mut self, polygon: &Polygon) -> Piece {
        let corners = polygon.corners.clone();
        let mut piece = Piece {
            points: corners.iter().map(|&v| self.position(v)).collect(),
            on: corners.iter().map(|&v| self.faces_of(v)).collect(),
            corners,
            banned: Vec::new(),
            cut: Cut {
                triangles: Vec::new(),
                places: Vec::new(),
            },
        };
        piece.cut = self.cut(&piece);
        piece
    }

    /// A polygon's triangles; round a vertex in its middle where its own
    /// diagonals will not do.
    fn cut(&mut self, piece: &Piece) -> Cut {
        let banned = |i: usize, j: usize| {
            piece.on[i] & piece.on[j] != 0 || piece.banned.contains(&[i.min(j), i.max(j)])
        };
        match polygon::triangulate(&piece.points, banned) {
            Some(triangles) => Cut {
                triangles: (triangles.iter())
                    .map(|t| t.map(|c| piece.corners[c]))
                    .collect(),
                places: (triangles.iter())
                    .map(|t| t.map(|c| piece.points[c]))
                    .collect(),
            },
            None => self.fan_out(piece),
        }
    }

    fn fan_out(&mut self, piece: &Piece) -> Cut {
        let (middle, at) = self.add_middle(&piece.points);
        let n = piece.points.len();
        let around = |k: usize| (k, (k + 1) % n);
        Cut {
            triangles: (0..n)
                .map(around)
                .map(|(i, j)| [piece.corners[i], piece.corners[j], middle])
                .collect(),
            places: (0..n)
                .map(around)
                .map(|(i, j)| [piece.points[i], piece.points[j], at])
                .collect(),
        }
    }

    /// Cuts polygons anew until no two triangles pass through each other: a
    /// diagonal that does is banned, the one first that leaves the fewest such
    /// pairs, or the polygon gets a vertex in its middle.
    fn clear(&mut self, pieces: &mut [Piece]) {
        const MOST_CHANGES: usize = 12;
        let mut clashes = clashes(pieces);
        for _ in 0..MOST_CHANGES {
            if clashes.is_empty() {
                return;
            }
            let mut best: Option<(usize, usize, Vec<[usize; 2]>, Cut)> = None;
            for (k, change) in changes(pieces, &clashes) {
                let before = pieces[k].cut.clone();
                let cut = match change {
                    Some(diagonal) => {
                        pieces[k].banned.push(diagonal);
                        self.cut(&pieces[k])
                    }
                    None => self.fan_out(&pieces[k]),
                };
                pieces[k].cut = cut;
                let left = self::clashes(pieces).len();
                let cut = std::mem::replace(&mut pieces[k].cut, before);
                let banned = pieces[k].banned.clone();
                if change.is_some() {
                    pieces[k].banned.pop();
                }
                if best.as_ref().is_none_or(|b| left < b.0) {
                    best = Some((left, k, banned, cut));
                }
            }
            let Some((_, k, banned, cut)) = best.filter(|b| b.0 < clashes.len()) else {
                return;
            };
            pieces[k].banned = banned;
            pieces[k].cut = cut;
            clashes = self::clashes(pieces);
        }
    }

    /// A vertex in the middle of a polygon: on the mid-surface if that is found
    /// within the tetrahedron, across the polygon first and then along it.
    fn add_middle(&mut self, points: &[DVec3]) -> (VertexKey, DVec3) {
        let centre = points.iter().sum::<DVec3>() / points.len() as f64;
        let reach = 0.5
            * points
                .iter()
                .map(|p| p.distance(centre))
                .fold(0.0, f64::max);
        let normal = polygon::normal(points).normalize_or_zero();
        let (u, v) = match normal.try_normalize() {
            Some(normal) => normal.any_orthonormal_pair(),
            None => (DVec3::X, DVec3::Y),
        };
        let cage = self.cage;
        let found = [normal, u, v].into_iter().find_map(|way| {
            let found = edge::crossing_near(self.probe, centre, way, reach);
            found.filter(|c| cage.excess(c.at, None) <= 0.0)
        });
        let (at, walls) = match found {
            Some(c) => (c.at, SmallVec::from_slice(&c.walls)),
            None => (centre, SmallVec::new()),
        };
        let number = self.add_inner(at, InnerKind::Middle, walls);
        (VertexKey::Inner(self.key, number), at)
    }

    /// Faces of the tetrahedron that a vertex lies on, one bit each.
    fn faces_of(&self, vertex: VertexKey) -> u8 {
        let on = |f: usize| match vertex {
            VertexKey::Edge(e, _) => self.face_keys[f].edges().contains(&e),
            VertexKey::Face(k, _) => self.face_keys[f] == k,
            VertexKey::Inner(..) => false,
        };
        (0..4).map(|f| (on(f) as u8) << f).sum()
    }
}

/// A triangle by its piece and its number there.
type Member = (usize, usize);

/// Pairs of triangles of different pieces that pass through each other.
fn clashes(pieces: &[Piece]) -> Vec<[Member; 2]> {
    let mut found = Vec::new();
    for (i, a) in pieces.iter().enumerate() {
        for (j, b) in pieces[..i].iter().enumerate() {
            for (s, p) in a.cut.places.iter().enumerate() {
                for (t, q) in b.cut.places.iter().enumerate() {
                    let names = names(a.cut.triangles[s], b.cut.triangles[t]);
                    if has_area(p) && has_area(q) && clash([*p, *q], names) {
                        found.push([(i, s), (j, t)]);
                    }
                }
            }
        }
    }
    found
}

/// Whether a triangle has an area to speak of: others are taken out later.
fn has_area([a, b, c]: &[DVec3; 3]) -> bool {
    /// Height against the longest side.
    const FLAT: f64 = 1e-9;
    let longest = a.distance(*b).max(b.distance(*c)).max(c.distance(*a));
    (b - a).cross(c - a).length() > FLAT * longest * longest
}

/// Numbers for the corners of two triangles, the same for the same vertex.
fn names(a: [VertexKey; 3], b: [VertexKey; 3]) -> [[u32; 3]; 2] {
    let all = [a[0], a[1], a[2], b[0], b[1], b[2]];
    let number = |v: VertexKey| all.iter().position(|&w| w == v).unwrap_or(0) as u32;
    [a.map(number), b.map(number)]
}

/// What may be changed: diagonals of the triangles concerned, by piece, and a
/// vertex in a piece's middle.
fn changes(pieces: &[Piece], clashes: &[[Member; 2]]) -> Vec<(usize, Option<[usize; 2]>)> {
    let mut out = Vec::new();
    for &(k, t) in clashes.iter().flatten() {
        let (piece, n) = (&pieces[k], pieces[k].corners.len());
        let number = |v: VertexKey| piece.corners.iter().position(|&c| c == v);
        let triangle = piece.cut.triangles[t];
        for e in 0..3 {
            let ends = [triangle[e], triangle[(e + 1) % 3]].map(number);
            if let [Some(i), Some(j)] = ends
                && (i + 1) % n != j
                && (j + 1) % n != i
            {
                out.push((k, Some([i.min(j), i.max(j)])));
            }
        }
        out.push((k, None));
    }
    out.sort_unstable();
    out.dedup();
    out
}
