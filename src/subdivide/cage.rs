//! The checked control mesh.
//!
//! A *corner* `h` is one vertex of one face, and at the same time the
//! half-edge from it to the next corner of that face. Faces run
//! counter-clockwise seen from outside.

use std::borrow::Cow;

use glam::DVec3;
use smallvec::SmallVec;

use super::error::CageError;
use super::sharp::Sharpness;
use crate::mesh::{Bounds, Frame};

/// No half-edge runs the other way: the edge is on the boundary.
pub(super) const NONE: u32 = u32::MAX;

/// Corners that a mesh may have at most, so that one step more still numbers.
const MOST_CORNERS: usize = 1 << 28;

/// A polygon as a list of vertices.
pub type Polygon = SmallVec<[u32; 4]>;

/// A checked control mesh of polygons.
///
/// Invariants, held by [`Cage::new`]: coordinates finite; faces of three or
/// more different vertices in range; an edge has one face or two, which run
/// over it in opposite directions; the faces around a vertex hang together by
/// edges; every vertex has a face.
#[derive(Clone, Debug)]
pub struct Cage {
    positions: Vec<DVec3>,
    /// Vertex of every corner, face after face.
    corners: Vec<u32>,
    /// First corner of every face, and the end.
    starts: Vec<u32>,
    face_of: Vec<u32>,
    /// Half-edge that runs the other way, or [`NONE`].
    twins: Vec<u32>,
    /// First half-edge of the fan around each vertex, counter-clockwise; on
    /// the boundary the one without a face on its right.
    leaving: Vec<u32>,
    /// Faces around each vertex.
    degrees: Vec<u32>,
    boundary: Vec<bool>,
    pub(super) sharpness: Sharpness,
}

impl Cage {
    /// Checks and links polygons.
    ///
    /// # Errors
    ///
    /// [`CageError`] names the face or vertex.
    pub fn new(positions: Vec<DVec3>, faces: &[Polygon]) -> Result<Cage, CageError> {
        if faces.is_empty() {
            return Err(CageError::Empty);
        }
        if let Some(vertex) = positions.iter().position(|p| !p.is_finite()) {
            return Err(CageError::NotFinite { vertex });
        }
        let total: usize = faces.iter().map(|face| face.len()).sum();
        if total.max(positions.len()) > MOST_CORNERS {
            return Err(CageError::TooLarge { corners: total });
        }
        let mut corners = Vec::with_capacity(total);
        let mut starts = vec![0];
        for (face, polygon) in faces.iter().enumerate() {
            if polygon.len() < 3 {
                return Err(CageError::FewCorners { face });
            }
            let mut sorted = polygon.clone();
            sorted.sort_unstable();
            if let Some(&last) = sorted.last()
                && last as usize >= positions.len()
            {
                let vertex = last as usize;
                return Err(CageError::NoSuchVertex { face, vertex });
            }
            if let Some(pair) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
                let vertex = pair[0] as usize;
                return Err(CageError::RepeatedCorner { face, vertex });
            }
            corners.extend_from_slice(polygon);
            starts.push(corners.len() as u32);
        }
        let mut cage = Cage::assemble(positions, corners, starts, vec![NONE; total]);
        cage.link()?;
        cage.index();
        if let Some(vertex) = cage.degrees.iter().position(|&n| n == 0) {
            return Err(CageError::Isolated { vertex });
        }
        cage.check_fans()?;
        Ok(cage)
    }

    fn bounds(&self) -> Bounds {
        Bounds::of(self.positions.iter().copied())
    }

    /// The frame for the mesh and its surface.
    pub(super) fn frame(&self) -> Frame {
        Frame::around(&self.bounds())
    }

    /// The mesh in a frame.
    pub(super) fn in_frame(&self, frame: Frame) -> Cow<'_, Cage> {
        if frame.is_identity() {
            return Cow::Borrowed(self);
        }
        let mut cage = self.clone();
        frame.enter(&mut cage.positions);
        Cow::Owned(cage)
    }

    /// A mesh whose links are known to be sound; `twins` as described above.
    pub(super) fn linked(
        positions: Vec<DVec3>,
        corners: Vec<u32>,
        starts: Vec<u32>,
        twins: Vec<u32>,
        sharpness: Sharpness,
    ) -> Cage {
        let mut cage = Cage::assemble(positions, corners, starts, twins);
        cage.sharpness = sharpness;
        cage.index();
        cage
    }

    fn assemble(
        positions: Vec<DVec3>,
        corners: Vec<u32>,
        starts: Vec<u32>,
        twins: Vec<u32>,
    ) -> Cage {
        let mut face_of = vec![0; corners.len()];
        for (face, range) in starts.windows(2).enumerate() {
            face_of[range[0] as usize..range[1] as usize].fill(face as u32);
        }
        let vertices = positions.len();
        Cage {
            positions,
            corners,
            starts,
            face_of,
            twins,
            leaving: vec![NONE; vertices],
            degrees: vec![0; vertices],
            boundary: vec![false; vertices],
            sharpness: Sharpness::default(),
        }
    }

    /// Joins half-edges to twins; edges in the order of their ends.
    fn link(&mut self) -> Result<(), CageError> {
        let ends = |h: u32| (self.origin(h), self.origin(self.next(h)));
        let key = |h: u32| {
            let (a, b) = ends(h);
            (a.min(b), a.max(b), h)
        };
        let mut order: Vec<u32> = (0..self.corners.len() as u32).collect();
        order.sort_unstable_by_key(|&h| key(h));
        let mut twins = vec![NONE; order.len()];
        for run in order.chunk_by(|&g, &h| (key(g).0, key(g).1) == (key(h).0, key(h).1)) {
            let (from, to) = ends(run[0]);
            let [from, to] = [from as usize, to as usize];
            let face = |h: u32| self.face_of[h as usize] as usize;
            match *run {
                [_] => {}
                [g, h] if ends(g) == ends(h) => {
                    return Err(CageError::Inconsistent {
                        face: face(h),
                        other: face(g),
                        from,
                        to,
                    });
                }
                [g, h] => {
                    twins[g as usize] = h;
                    twins[h as usize] = g;
                }
                _ => {
                    return Err(CageError::CrowdedEdge {
                        face: face(run[2]),
                        first: face(run[0]),
                        second: face(run[1]),
                        from,
                        to,
                    });
                }
            }
        }
        self.twins = twins;
        Ok(())
    }

    /// Fills what is known of vertices.
    fn index(&mut self) {
        for h in (0..self.corners.len() as u32).rev() {
            let v = self.origin(h) as usize;
            self.degrees[v] += 1;
            let open = self.twins[h as usize] == NONE;
            // The lowest half-edge, unless another starts at the boundary.
            if open || !self.boundary[v] {
                self.leaving[v] = h;
            }
            self.boundary[v] |= open;
        }
        // The end of a boundary edge is on the boundary too; as every fan has a
        // first half-edge, it was seen above already.
    }

    /// Every fan must reach all faces of its vertex.
    fn check_fans(&self) -> Result<(), CageError> {
        let mut seen = vec![false; self.corners.len()];
        for v in 0..self.positions.len() as u32 {
            for h in self.fan(v) {
                seen[h as usize] = true;
            }
        }
        match seen.iter().position(|&seen| !seen) {
            None => Ok(()),
            Some(h) => Err(CageError::Pinched {
                face: self.face_of[h] as usize,
                vertex: self.corners[h] as usize,
            }),
        }
    }

    /// Positions of the control vertices.
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// Number of faces.
    pub fn face_count(&self) -> usize {
        self.starts.len() - 1
    }

    /// Number of face corners, which is that of half-edges.
    pub fn corner_count(&self) -> usize {
        self.corners.len()
    }

    /// Number of edges.
    pub fn edge_count(&self) -> usize {
        let inner = self.twins.iter().filter(|&&twin| twin != NONE).count();
        self.corners.len() - inner / 2
    }

    /// V - E + F.
    pub fn euler(&self) -> i64 {
        self.positions.len() as i64 - self.edge_count() as i64 + self.face_count() as i64
    }

    /// Whether the surface has no rim: no edge on the boundary or at a hole.
    pub fn is_closed(&self) -> bool {
        (0..self.corners.len() as u32).all(|h| !self.is_rim(h))
    }

    /// Whether all faces have four corners.
    pub fn is_quads(&self) -> bool {
        self.starts.windows(2).all(|pair| pair[1] - pair[0] == 4)
    }

    /// Vertices of a face.
    pub fn face(&self, face: usize) -> &[u32] {
        &self.corners[self.starts[face] as usize..self.starts[face + 1] as usize]
    }

    /// Faces around a vertex.
    pub fn degree(&self, vertex: u32) -> u32 {
        self.degrees[vertex as usize]
    }

    /// Whether a vertex is on the boundary.
    pub fn on_boundary(&self, vertex: u32) -> bool {
        self.boundary[vertex as usize]
    }

    /// Diagonal of the box around the control vertices.
    pub fn diagonal(&self) -> f64 {
        self.bounds().diagonal()
    }

    /// The same mesh with some faces turned over.
    pub(super) fn turned_over(&self, wrong: impl Fn(usize) -> bool) -> Cage {
        let faces: Vec<Polygon> = (0..self.face_count())
            .map(|face| {
                let mut ring = Polygon::from_slice(self.face(face));
                if wrong(face) {
                    // The first corner stays first.
                    ring[1..].reverse();
                }
                ring
            })
            .collect();
        // Turning whole shells over breaks none of the invariants.
        Cage::new(self.positions.clone(), &faces)
            .and_then(|cage| cage.tagged(&self.tags()))
            .unwrap_or_else(|_| self.clone())
    }

    #[inline]
    pub(super) fn origin(&self, h: u32) -> u32 {
        self.corners[h as usize]
    }

    #[inline]
    pub(super) fn position(&self, vertex: u32) -> DVec3 {
        self.positions[vertex as usize]
    }

    #[inline]
    pub(super) fn twin(&self, h: u32) -> Option<u32> {
        Some(self.twins[h as usize]).filter(|&twin| twin != NONE)
    }

    #[inline]
    pub(super) fn face_of(&self, h: u32) -> usize {
        self.face_of[h as usize] as usize
    }

    /// First corner of a face.
    #[inline]
    pub(super) fn start(&self, face: usize) -> u32 {
        self.starts[face]
    }

    #[inline]
    pub(super) fn next(&self, h: u32) -> u32 {
        let face = self.face_of(h);
        if h + 1 == self.starts[face + 1] {
            self.starts[face]
        } else {
            h + 1
        }
    }

    #[inline]
    pub(super) fn prev(&self, h: u32) -> u32 {
        let face = self.face_of(h);
        if h == self.starts[face] {
            self.starts[face + 1] - 1
        } else {
            h - 1
        }
    }

    /// Vertex at the end of a half-edge.
    #[inline]
    pub(super) fn end(&self, h: u32) -> u32 {
        self.origin(self.next(h))
    }

    /// Half-edges that leave a vertex, counter-clockwise, one for each face
    /// that hangs together with the first by edges.
    pub(super) fn fan(&self, vertex: u32) -> impl Iterator<Item = u32> + '_ {
        let first = self.leaving[vertex as usize];
        let around = move |&h: &u32| self.twin(self.prev(h)).filter(|&next| next != first);
        std::iter::successors(Some(first).filter(|&h| h != NONE), around)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cage(vertices: usize, faces: &[&[u32]]) -> Result<Cage, CageError> {
        let positions = (0..vertices)
            .map(|k| DVec3::new(k as f64, (k * k) as f64, 1.0))
            .collect();
        let faces: Vec<Polygon> = faces.iter().map(|face| Polygon::from_slice(face)).collect();
        Cage::new(positions, &faces)
    }

    fn refused(vertices: usize, faces: &[&[u32]], expected: CageError) {
        assert_eq!(cage(vertices, faces).err(), Some(expected));
    }

    #[test]
    fn a_sound_cage_knows_its_fans() {
        let sheet = cage(6, &[&[0, 1, 2, 3], &[1, 4, 5, 2]]).expect("sound");
        assert_eq!((sheet.euler(), sheet.edge_count()), (1, 7));
        assert!(!sheet.is_closed() && sheet.is_quads());
        assert_eq!(sheet.fan(1).collect::<Vec<_>>(), [4, 1]);
        assert_eq!(sheet.fan(2).collect::<Vec<_>>(), [2, 7]);
        assert_eq!((sheet.degree(1), sheet.degree(0)), (2, 1));
        assert!((0..6).all(|v| sheet.on_boundary(v)));
        let over = sheet.turned_over(|_| true);
        assert_eq!(over.face(0), [0, 3, 2, 1]);
    }

    #[test]
    fn every_fault_is_named() {
        refused(4, &[], CageError::Empty);
        refused(3, &[&[0, 1]], CageError::FewCorners { face: 0 });
        let (face, vertex) = (0, 7);
        refused(3, &[&[0, 1, 7]], CageError::NoSuchVertex { face, vertex });
        let (face, vertex) = (1, 2);
        refused(
            4,
            &[&[0, 1, 2], &[2, 3, 0, 2]],
            CageError::RepeatedCorner { face, vertex },
        );
        refused(
            5,
            &[&[0, 1, 2], &[1, 0, 3], &[0, 1, 4]],
            CageError::CrowdedEdge {
                face: 2,
                first: 0,
                second: 1,
                from: 0,
                to: 1,
            },
        );
        refused(
            4,
            &[&[0, 1, 2], &[0, 1, 3]],
            CageError::Inconsistent {
                face: 1,
                other: 0,
                from: 0,
                to: 1,
            },
        );
        refused(
            5,
            &[&[0, 1, 2], &[0, 3, 4]],
            CageError::Pinched { face: 1, vertex: 0 },
        );
        refused(4, &[&[0, 1, 2]], CageError::Isolated { vertex: 3 });
        let nan = Cage::new(
            vec![DVec3::ZERO, DVec3::X, DVec3::NAN],
            &[Polygon::from_slice(&[0, 1, 2])],
        );
        assert_eq!(nan.err(), Some(CageError::NotFinite { vertex: 2 }));
    }
}
