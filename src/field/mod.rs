//! The part as a field: nearest wall point, insidedness, segment hits.
//!
//! Later rooms ask here and never read triangles. Two trees hold the wall and
//! the coping triangles; see `tree` for why their f32 boxes never lose one.
//!
//! # What is promised
//!
//! - Every answer is that of a brute-force search over all triangles, bit for
//!   bit: it depends neither on the tree nor on the warm start.
//! - A wall point that is reached from inside only through coping, across a gap,
//!   is no footpoint; see `screens`.
//! - On a tie of the computed distance the lowest [`FaceId`] wins.
//! - Triangles without area take no part (their points lie on the edges of
//!   their neighbours); [`Field::degenerate_faces`] counts them.
//! - No input makes a query panic. A query point that is not finite gets an
//!   answer whose distance is not finite.
//!
//! # What is not
//!
//! - Triangles more than 1e8 times longer than high are measured by their
//!   edges alone: their interior may be missed by 1e-8 of their length.
//! - True ties: a point equally far from two walls has two computed distances
//!   that may differ in the last bit, and the smaller wins. The answer is
//!   always the same, but the lowest face is sure only when the bits agree, as
//!   they do along a shared edge or corner.
//! - Speed far away: f32 tells triangles apart to 4e-6 of the distance or of the
//!   part, whichever is greater; all that are closer than that to a tie are
//!   measured in f64.

mod along;
mod before;
mod block;
mod frame;
mod hits;
mod missing;
mod nearest;
mod ray;
mod screens;
mod sign;
#[cfg(test)]
mod tests;
mod topology;
mod tree;
mod triangle;

use glam::DVec3;

use crate::mesh::{FaceId, Part, TriMesh};
use frame::Frame;
use nearest::{Best, Hiding, Open};
use screens::{Screened, Screens};
use sign::Sign;
use tree::Tree;
use triangle::Triangle;

pub use missing::Missing;
pub use triangle::Feature;

/// Nearest wall point to a query `p`; the footpoint vector is `point - p`.
///
/// Lengths in part units. On a tie the lowest triangle index wins, so the
/// answer never depends on traversal order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footpoint {
    /// Triangle that holds `point`: a wall triangle, except from
    /// [`Field::nearest_coping`].
    pub face: FaceId,
    /// The nearest point, in part coordinates.
    pub point: DVec3,
    /// Unsigned; the side is `inside`'s to tell.
    pub distance: f64,
}

/// A triangle that a segment touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Where, as a fraction of the way: 0 at the start, 1 at the end.
    pub t: f64,
    /// The triangle, wall or coping.
    pub face: FaceId,
}

/// Nearest-point, insidedness and segment queries on one part.
#[derive(Clone, Debug)]
pub struct Field {
    /// Wall triangles in leaf order, then coping, then degenerate ones.
    triangles: Vec<Triangle>,
    /// Place in `triangles` by face.
    slots: Vec<u32>,
    coping: Vec<bool>,
    wall_tree: Tree,
    coping_tree: Tree,
    /// Lowest wall face that is in the tree.
    first_wall: Option<FaceId>,
    degenerate: usize,
    frame: Frame,
    bounds: (DVec3, DVec3),
    sign: Sign,
    screens: Screens,
}

impl Field {
    /// The field of a part.
    pub fn new(part: &Part) -> Field {
        Field::of_tagged(part.mesh(), part.coping().to_vec())
    }

    /// The field of a plain mesh: all its triangles are wall.
    pub fn of_mesh(mesh: &TriMesh) -> Field {
        Field::of_tagged(mesh, Vec::new())
    }

    /// The field of a mesh; `coping[f]` tags face `f`, missing tags count as
    /// wall.
    pub fn of_tagged(mesh: &TriMesh, coping: Vec<bool>) -> Field {
        let corners = mesh.faces().map(|face| mesh.corners(face)).collect();
        Field::from_triangles(corners, mesh.triangles.clone(), coping)
    }

    /// The field of triangles given one by one.
    ///
    /// `corners[f]` are the corners of face `f`, counter-clockwise from
    /// outside; `indices[f]` names its vertices, to tell which faces share an
    /// edge; `coping[f]` tags it. Missing tags count as wall. If `indices` has
    /// another length than `corners`, equal positions tell which vertices are
    /// shared.
    pub fn from_triangles(
        corners: Vec<[DVec3; 3]>,
        indices: Vec<[u32; 3]>,
        mut coping: Vec<bool>,
    ) -> Field {
        coping.resize(corners.len(), false);
        let bounds = bounds(&corners);
        let frame = Frame::new(bounds.0, bounds.1);

        let copes = coping.iter().filter(|&&cope| cope).count();
        let mut wall = Vec::with_capacity(corners.len() - copes);
        let (mut cope, mut degenerate) = (Vec::with_capacity(copes), Vec::new());
        for (i, corners) in corners.into_iter().enumerate() {
            let triangle = Triangle::new(corners, FaceId(i as u32));
            if triangle.is_degenerate() {
                degenerate.push(triangle);
            } else if coping[i] {
                cope.push(triangle);
            } else {
                wall.push(triangle);
            }
        }
        let first_wall = wall.first().map(|t| t.face);
        let degenerate_count = degenerate.len();

        let wall_tree = Tree::build(&mut wall, frame, 0);
        let coping_tree = Tree::build(&mut cope, frame, wall.len());
        let in_trees = wall.len() + cope.len();
        let mut triangles = wall;
        triangles.append(&mut cope);
        triangles.append(&mut degenerate);
        let mut slots = vec![0; triangles.len()];
        for (slot, triangle) in triangles.iter().enumerate() {
            slots[triangle.face.index()] = slot as u32;
        }
        let trees = [&wall_tree, &coping_tree];
        let sign = Sign::new(&triangles, in_trees, &indices, trees, frame);
        let screens = Screens::new(&triangles, trees, frame);
        Field {
            triangles,
            slots,
            coping,
            wall_tree,
            coping_tree,
            first_wall,
            degenerate: degenerate_count,
            frame,
            bounds,
            sign,
            screens,
        }
    }

    /// The same with insidedness by winding number even if the part is a
    /// closed manifold: for one that cuts through itself, where the normal at
    /// the closest point says nothing about the side.
    pub fn by_winding(mut self) -> Field {
        let in_trees = self.face_count() - self.degenerate;
        self.sign = Sign::winding(
            &self.triangles[..in_trees],
            [&self.wall_tree, &self.coping_tree],
            self.frame,
        );
        self
    }

    /// The nearest point on the wall triangles.
    ///
    /// Without any wall triangle: face 0, a point that is not a number, at an
    /// infinite distance.
    pub fn footpoint(&self, p: DVec3) -> Footpoint {
        self.finish_wall(p, self.search_walls(p, Best::none()))
    }

    /// The same answer as [`footpoint`](Field::footpoint), bit for bit, found
    /// sooner when `hint` is a wall face near the answer.
    ///
    /// A hint that is not a wall face is ignored.
    pub fn footpoint_near(&self, p: DVec3, hint: FaceId) -> Footpoint {
        self.finish_wall(p, self.search_walls(p, self.hinted(p, hint)))
    }

    /// The same as [`footpoint_near`](Field::footpoint_near), and whether `p`
    /// lies inside, told by the wall triangles alone. For parts without coping.
    ///
    /// By a winding number the side costs another search; it is left out, and
    /// not answered, for points nearer to the surface than `sided_from`.
    pub fn sided_footpoint_near(
        &self,
        p: DVec3,
        hint: FaceId,
        sided_from: f64,
    ) -> (Footpoint, Option<bool>) {
        let best = self.search_walls(p, self.hinted(p, hint));
        let behind = best
            .found
            .and_then(|(slot, closest)| self.sign.behind(&self.triangles, slot, &closest));
        let wound = || (best.distance >= sided_from).then(|| self.is_wound_round(p));
        let inside = behind.or_else(wound);
        (self.finish_wall(p, best), inside)
    }

    /// The fraction of the way from `from` to `to` at which the distance to
    /// one face grows to `distance`; none unless it is at most that at the
    /// start and more at the end.
    pub fn leaves(&self, face: FaceId, from: DVec3, to: DVec3, distance: f64) -> Option<f64> {
        let slot = *self.slots.get(face.index())?;
        self.triangles[slot as usize].leaves(from, to, distance)
    }

    /// The wall faces that hold the point of `face` closest to `p`: itself,
    /// its neighbour across an edge, all around a vertex. Itself alone if the
    /// part is no closed manifold.
    pub fn sharing(&self, p: DVec3, face: FaceId, out: &mut Vec<FaceId>) {
        out.clear();
        out.push(face);
        let (Some(normals), Some(slot)) = (self.sign.normals(), self.wall_slot(face)) else {
            return;
        };
        let feature = self.triangles[slot].closest(p).feature;
        normals.around(slot, feature, |other| {
            if other != slot && !self.triangles[other].is_degenerate() {
                out.push(self.triangles[other].face);
            }
        });
    }

    /// The closest point of one triangle, of any kind.
    ///
    /// A face that does not exist has no closest point: the distance is
    /// infinite.
    pub fn footpoint_on(&self, p: DVec3, face: FaceId) -> Footpoint {
        let Some(&slot) = self.slots.get(face.index()) else {
            return no_footpoint(face);
        };
        let closest = self.triangles[slot as usize].closest(p);
        Footpoint {
            face,
            point: closest.point,
            distance: closest.square.sqrt(),
        }
    }

    /// Where on a face its closest point to `p` lies; none if there is no such
    /// face.
    pub fn feature_on(&self, p: DVec3, face: FaceId) -> Option<Feature> {
        let &slot = self.slots.get(face.index())?;
        Some(self.triangles[slot as usize].closest(p).feature)
    }

    /// Puts the closest points of all wall triangles at a distance of at most
    /// `radius` into `out`, sorted by face; what `out` held before is dropped.
    pub fn footpoints_within(&self, p: DVec3, radius: f64, out: &mut Vec<Footpoint>) {
        out.clear();
        if radius.is_nan() || radius < 0.0 {
            return;
        }
        let screened = self.screened();
        nearest::each_near(&self.wall_tree, self.frame, p, radius, |slot| {
            let triangle = &self.triangles[slot];
            let closest = triangle.closest(p);
            let distance = closest.square.sqrt();
            if distance <= radius && !screened.hides(slot, p, closest.point) {
                out.push(Footpoint {
                    face: triangle.face,
                    point: closest.point,
                    distance,
                });
            }
        });
        out.sort_unstable_by_key(|f| f.face);
    }

    /// The nearest point on the coping triangles, if one is at a distance of
    /// at most `max_distance`.
    pub fn nearest_coping(&self, p: DVec3, max_distance: f64) -> Option<Footpoint> {
        if max_distance.is_nan() {
            return None;
        }
        let best = self.search_coping(p, Best::within(max_distance));
        best.found.map(|(slot, closest)| Footpoint {
            face: self.triangles[slot].face,
            point: closest.point,
            distance: best.distance,
        })
    }

    /// Whether `p` lies inside the part; see `sign` for how it is told.
    ///
    /// On the surface itself the answer is either. An inverted closed part
    /// (normals inward) gets inverted answers, but for "outside" where a sliver
    /// is nearest; an open part gets those of the generalised winding number,
    /// which closes its openings smoothly.
    pub fn inside(&self, p: DVec3) -> bool {
        // Outside the box of a closed part there is only outside; an inverted
        // part is not to be told apart here and says "outside" too.
        self.in_box(p)
            && match self.sign.normals() {
                Some(_) => self.signed_clearance(p) > 0.0,
                None => self.sign.wound_round(self, p),
            }
    }

    fn in_box(&self, p: DVec3) -> bool {
        let (low, high) = self.bounds;
        p.cmpge(low).all() && p.cmple(high).all()
    }

    fn is_wound_round(&self, p: DVec3) -> bool {
        self.in_box(p) && self.sign.wound_round(self, p)
    }

    /// Distance to the nearest triangle of any kind: positive inside,
    /// negative outside.
    pub fn signed_clearance(&self, p: DVec3) -> f64 {
        let best = self.search_walls(p, Best::none());
        self.sign_of(p, self.search_coping(p, best))
    }

    /// The distance of the best triangle of any kind, negative outside.
    fn sign_of(&self, p: DVec3, best: Best) -> f64 {
        let Some((slot, closest)) = best.found else {
            return -best.distance;
        };
        let behind = self.sign.behind(&self.triangles, slot, &closest);
        if behind.unwrap_or_else(|| self.is_wound_round(p)) {
            best.distance
        } else {
            -best.distance
        }
    }

    /// [`footpoint_near`](Field::footpoint_near) and
    /// [`signed_clearance`](Field::signed_clearance) in one, with one search of
    /// the walls.
    pub fn cleared_footpoint_near(&self, p: DVec3, hint: FaceId) -> (Footpoint, f64) {
        let wall = self.search_walls(p, self.hinted(p, hint));
        let clearance = self.sign_of(p, self.search_coping(p, wall));
        (self.finish_wall(p, wall), clearance)
    }

    /// Puts every triangle, wall or coping, that the closed segment touches
    /// into `out`, sorted by `(t, face)`; what `out` held before is dropped.
    ///
    /// A triangle is left out only when exact bounds on the rounding prove
    /// that the segment passes by it. So a segment through a shared edge or
    /// vertex reports at least one of the sharers, as a rule all of them, and
    /// a segment that passes within rounding of a triangle may report it too.
    /// A segment that runs in a triangle's plane reports the place where it
    /// first touches the triangle.
    pub fn hits(&self, from: DVec3, to: DVec3, out: &mut Vec<Hit>) {
        hits::hits(self, from, to, out);
    }

    /// The first triangle, wall or coping, that the closed segment touches; of
    /// several at one place the lowest. The same as the first of
    /// [`hits`](Field::hits), found sooner.
    pub fn first_hit(&self, from: DVec3, to: DVec3) -> Option<Hit> {
        ray::first_hit(self, from, to)
    }

    /// Whether the face is tagged as coping.
    pub fn is_coping(&self, face: FaceId) -> bool {
        self.coping.get(face.index()).is_some_and(|&c| c)
    }

    /// The corners of a face as given.
    ///
    /// # Panics
    ///
    /// If there is no such face.
    pub fn corners(&self, face: FaceId) -> [DVec3; 3] {
        self.triangle(face).corners
    }

    /// Unit outward normal; zero for a degenerate triangle.
    ///
    /// # Panics
    ///
    /// If there is no such face.
    pub fn normal(&self, face: FaceId) -> DVec3 {
        self.triangle(face).normal()
    }

    /// Lower and upper corner of the box of all finite corners.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.bounds
    }

    /// Number of triangles, degenerate ones included.
    pub fn face_count(&self) -> usize {
        self.slots.len()
    }

    /// Number of triangles without area (less high than 1e-15 of their longest
    /// side, or with a corner that is not finite), which take no part in any
    /// search.
    pub fn degenerate_faces(&self) -> usize {
        self.degenerate
    }

    /// Whether insidedness comes from pseudonormals, that is, whether the
    /// triangles form a closed manifold, with or without those that have no
    /// area.
    pub fn is_closed_manifold(&self) -> bool {
        self.sign.normals().is_some()
    }

    fn triangle(&self, face: FaceId) -> &Triangle {
        &self.triangles[self.slots[face.index()] as usize]
    }

    /// Slot of a face that is in the wall tree.
    fn wall_slot(&self, face: FaceId) -> Option<usize> {
        let slot = *self.slots.get(face.index())? as usize;
        let wall = !self.coping[face.index()] && !self.triangles[slot].is_degenerate();
        wall.then_some(slot)
    }

    /// The wall triangle of a hint as the best so far.
    fn hinted(&self, p: DVec3, hint: FaceId) -> Best {
        let mut best = Best::none();
        if let Some(slot) = self.wall_slot(hint) {
            let hides = |point| self.screened().hides(slot, p, point);
            best.offer_unless(&self.triangles, slot, p, hides);
        }
        best
    }

    fn screened(&self) -> Screened<'_> {
        Screened {
            screens: &self.screens,
            triangles: &self.triangles,
            coping_tree: &self.coping_tree,
            frame: self.frame,
        }
    }

    fn search_walls(&self, p: DVec3, best: Best) -> Best {
        let screened = &self.screened();
        nearest::search(
            &self.wall_tree,
            &self.triangles,
            self.frame,
            p,
            best,
            screened,
        )
    }

    fn search_coping(&self, p: DVec3, best: Best) -> Best {
        nearest::search(
            &self.coping_tree,
            &self.triangles,
            self.frame,
            p,
            best,
            &Open,
        )
    }

    fn finish_wall(&self, p: DVec3, best: Best) -> Footpoint {
        match (best.found, self.first_wall) {
            (Some((slot, closest)), _) => Footpoint {
                face: self.triangles[slot].face,
                point: closest.point,
                distance: best.distance,
            },
            // Only a query that is not a number finds nothing.
            (None, Some(face)) => self.footpoint_on(p, face),
            (None, None) => no_footpoint(FaceId(0)),
        }
    }
}

fn no_footpoint(face: FaceId) -> Footpoint {
    Footpoint {
        face,
        point: DVec3::NAN,
        distance: f64::INFINITY,
    }
}

fn bounds(corners: &[[DVec3; 3]]) -> (DVec3, DVec3) {
    let finite = corners.iter().flatten().filter(|c| c.is_finite());
    let mut total: Option<(DVec3, DVec3)> = None;
    for &c in finite {
        total = Some(total.map_or((c, c), |(low, high)| (low.min(c), high.max(c))));
    }
    total.unwrap_or((DVec3::ZERO, DVec3::ZERO))
}
