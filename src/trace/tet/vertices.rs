//! Vertices inside a tetrahedron, with the ends of the curves that leave them.

use glam::DVec3;
use smallvec::SmallVec;

use super::ends::{CurveEnd, EndKind};
use super::{InnerKind, InnerVertex, Port, VertexKey, Work};
use crate::mesh::FaceId;
use crate::trace::follow::border::Kink;
use crate::trace::follow::fan::{Spoke, Star};
use crate::trace::follow::seam;
use crate::trace::probe::{Pair, Probe};
use crate::trace::solve::distance_to;

impl Work<'_, '_> {
    pub(super) fn add_inner(
        &mut self,
        at: DVec3,
        kind: InnerKind,
        walls: SmallVec<[FaceId; 6]>,
    ) -> u16 {
        self.out.inner.push(InnerVertex { at, kind, walls });
        (self.out.inner.len() - 1) as u16
    }

    pub(super) fn add_kink(&mut self, kink: &Kink) -> VertexKey {
        let walls = SmallVec::from_slice(&[kink.pair.left, kink.pair.right]);
        VertexKey::Inner(self.key, self.add_inner(kink.at, InnerKind::Kink, walls))
    }

    /// A vertex on coping: borders leave along the coping, and a seam (or a
    /// fading border) into the part.
    pub(super) fn add_coping_vertex(
        &mut self,
        at: DVec3,
        coping: FaceId,
        spokes: &[Spoke],
        walls: &[FaceId],
    ) {
        let inner = self.add_inner(at, InnerKind::OnCoping(coping), SmallVec::from_slice(walls));
        self.places.push((inner, at));
        let vertex = VertexKey::Inner(self.key, inner);
        let port = |s: usize| Port::Sheet {
            inner,
            sheet: s as u16,
        };
        for (s, spoke) in spokes.iter().enumerate() {
            self.ends.push(CurveEnd {
                vertex,
                at,
                sheets: SmallVec::from_slice(&[(port(s), spoke.pair)]),
                kind: EndKind::Border {
                    coping,
                    towards: spoke.direction,
                },
                done: false,
            });
        }
        if spokes.len() == 2 {
            return;
        }
        let normal = self.probe.field().normal(coping);
        let walls = curve_walls(self.probe, at, spokes, walls);
        self.ends.push(CurveEnd {
            vertex,
            at,
            sheets: spokes
                .iter()
                .enumerate()
                .map(|(s, spoke)| (port(s), spoke.pair))
                .collect(),
            kind: EndKind::Tie {
                walls,
                towards: -normal,
            },
            done: false,
        });
    }

    pub(super) fn add_junction(&mut self, star: &Star) {
        let mut walls: SmallVec<[FaceId; 6]> = star
            .rays
            .iter()
            .flat_map(|r| r.walls.iter().copied())
            .collect();
        walls.sort();
        walls.dedup();
        let inner = self.add_inner(star.at, InnerKind::Junction, walls);
        self.places.push((inner, star.at));
        let vertex = VertexKey::Inner(self.key, inner);
        // A sheet that passes a crease is one sheet.
        let mut root: Vec<usize> = (0..star.sheets).collect();
        for ray in &star.rays {
            if let [a, b] = ray.sheets[..] {
                let (keep, drop) = (root[a.2].min(root[b.2]), root[a.2].max(root[b.2]));
                root.iter_mut()
                    .filter(|r| **r == drop)
                    .for_each(|r| *r = keep);
            }
        }
        for ray in &star.rays {
            if ray.sheets.len() == 2 {
                continue;
            }
            let sheets: SmallVec<[(Port, Pair); 4]> = ray
                .sheets
                .iter()
                .map(|&(i, j, sheet)| {
                    let pair = Pair {
                        left: ray.walls[i],
                        right: ray.walls[j],
                    };
                    (
                        Port::Sheet {
                            inner,
                            sheet: root[sheet] as u16,
                        },
                        pair,
                    )
                })
                .collect();
            let spokes: SmallVec<[Spoke; 4]> = sheets
                .iter()
                .map(|s| Spoke {
                    pair: s.1,
                    direction: ray.direction,
                })
                .collect();
            let walls = curve_walls(self.probe, star.at, &spokes, &ray.walls);
            self.ends.push(CurveEnd {
                vertex,
                at: star.at,
                sheets,
                kind: EndKind::Tie {
                    walls,
                    towards: ray.direction,
                },
                done: false,
            });
        }
    }
}

/// The walls by which to follow the curve of a vertex: those of its sheets,
/// and for a fading border the further wall that fixes its direction best.
pub(super) fn curve_walls(
    probe: &Probe,
    at: DVec3,
    spokes: &[Spoke],
    tied: &[FaceId],
) -> seam::Walls {
    let mut walls = seam::Walls::new();
    for spoke in spokes {
        for wall in [spoke.pair.left, spoke.pair.right] {
            if !walls.contains(&wall) {
                walls.push(wall);
            }
        }
    }
    if walls.len() == 2 {
        let field = probe.field();
        let away = |w: FaceId| distance_to(field, at, w).1;
        let (a, b) = (away(walls[0]), away(walls[1]));
        let spread = |w: FaceId| (b - a).cross(away(w) - a).length();
        let third = tied
            .iter()
            .copied()
            .filter(|w| !walls.contains(w))
            .max_by(|&p, &q| spread(p).total_cmp(&spread(q)).then(q.cmp(&p)));
        walls.extend(third);
    }
    walls
}
