//! What a mesh lies on while it is edited.

use std::f64::consts::PI;

use glam::DVec3;

use super::project::Projector;
use crate::mesh::FaceId;
use crate::surface::marked::{Line, MarkedVertex};
use crate::walls::Walls;

/// The surface that vertices are put back onto: the exact mid-surface of a part
/// ([`Projector`]), or a mid-surface as it was written
/// ([`Facets`](super::facets::Facets)). [`MarkedVertex::walls`] names its faces.
pub(crate) trait Ground: Sync {
    /// The point of a sheet nearest to a guess, at most `reach` away. `hints`
    /// are faces of vertices near by.
    fn on_sheet(&self, guess: DVec3, hints: &[FaceId], reach: f64) -> Option<MarkedVertex>;

    /// The point of a line near a guess, in the plane across `along`.
    fn on_line(
        &self,
        line: Line,
        guess: DVec3,
        along: DVec3,
        hints: &MarkedVertex,
        reach: f64,
    ) -> Option<MarkedVertex>;

    /// Unit normal of the sheet at a vertex, either way up; zero where it is
    /// not known.
    fn normal(&self, vertex: &MarkedVertex) -> DVec3;

    /// How far the two walls at `from` turn on the way to `to`, radians; the
    /// dip of a sheet beside a seam, where one footpoint sits on an edge, turns
    /// one of them only.
    fn turns(&self, from: &MarkedVertex, to: &MarkedVertex) -> [f64; 2];

    /// The part's walls, where they are known.
    fn walls(&self) -> Option<&Walls<'_>>;
}

impl Ground for Projector<'_> {
    fn on_sheet(&self, guess: DVec3, hints: &[FaceId], reach: f64) -> Option<MarkedVertex> {
        Projector::on_sheet(self, guess, hints, reach)
    }

    fn on_line(
        &self,
        line: Line,
        guess: DVec3,
        along: DVec3,
        hints: &MarkedVertex,
        reach: f64,
    ) -> Option<MarkedVertex> {
        Projector::on_line(self, line, guess, along, hints, reach)
    }

    fn normal(&self, vertex: &MarkedVertex) -> DVec3 {
        match vertex.walls.as_slice() {
            &[a, b, ..] => Projector::normal(self, vertex.at, a, b),
            _ => DVec3::ZERO,
        }
    }

    fn turns(&self, from: &MarkedVertex, to: &MarkedVertex) -> [f64; 2] {
        let field = Projector::walls(self).field();
        // Where both footpoints sit on edges, their triangles may be those to
        // either side: no wall turns more than the sheet does.
        let sheet = Ground::normal(self, from).angle_between(Ground::normal(self, to));
        let sheet = if sheet.is_finite() {
            sheet.min(PI - sheet)
        } else {
            PI
        };
        let mut turns = [0.0; 2];
        for (turn, &face) in turns.iter_mut().zip(&from.walls) {
            let normal = field.normal(face);
            *turn = (to.walls.iter())
                .map(|&f| normal.angle_between(field.normal(f)))
                .filter(|a| a.is_finite())
                .fold(sheet, f64::min);
        }
        turns
    }

    fn walls(&self) -> Option<&Walls<'_>> {
        Some(Projector::walls(self))
    }
}
