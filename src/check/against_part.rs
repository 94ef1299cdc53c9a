//! A mid-surface of any origin, held against its part.

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use super::ball::{Touching, touching};
use super::bends::Bends;
use super::measures::{Defect, LEAST_ANGLE, Measure, Outcome};
use crate::field::{Field, Footpoint, Hit};
use crate::mesh::samples::spread;
use crate::mesh::sets::Sets;
use crate::mesh::{Part, TriMesh, self_intersections, smallest_angle};
use crate::surface::MidSurface;
use crate::surface::edges::Edges;
use crate::walls::{Separation, Walls};

/// How close a surface has to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Greatest deviation that passes, as a share of the wall's thickness.
    pub tolerance: f64,
    /// The same within a thickness of seams and bends, where the middle of the
    /// walls and the middle of the ball that touches them are two things.
    pub near_seams: f64,
    /// Smallest object angle of a sheet, degrees.
    pub min_angle: f64,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits {
            tolerance: 0.1,
            near_seams: 0.5,
            min_angle: crate::extract::DEFAULT_ANGLE,
        }
    }
}

/// Points on the part's walls at which coverage is measured.
const SAMPLES: usize = 20_000;

/// A wall is covered if the surface comes within so many thicknesses of it:
/// half of one is right, corners and rims are farther.
const COVERED: f64 = 1.0;

/// Neighbours that bend more than this, degrees, are folded.
const FOLD: f64 = 150.0;

/// Free edges nearer to other elements than this share of the thickness were
/// meant to be joined to them.
const MEANT: f64 = 0.05;

/// Points nearer to a coping face than this share of their distance from the
/// walls are measured from inside it.
const STEP: f64 = 1e-3;

/// All measures of a surface.
#[derive(Clone, Debug)]
pub struct Check {
    /// One for each measure, in their order.
    pub outcomes: Vec<Outcome>,
    /// Median thickness of the walls where the surface is.
    pub thickness: f64,
    /// Share of the part's walls, by area, with the surface beside it.
    pub covered: f64,
    /// Distance from the middle at each node, as a share of the thickness;
    /// not a number where no wall is across.
    pub off_middle: Vec<f64>,
    /// Defects of each triangle, as bits.
    pub marks: Vec<u32>,
}

impl Check {
    /// Measures a surface against its part; `with_thickness` tells whether its
    /// balls mean anything.
    pub fn of(part: &Part, surface: &MidSurface, with_thickness: bool, limits: &Limits) -> Check {
        let field = Field::new(part);
        let separation = Separation {
            min_angle: limits.min_angle,
            keep_fins_from: None,
        };
        let walls = Walls::new(part, &field, separation);
        Checker::new(part, surface, &walls, limits).run(with_thickness)
    }
}

/// What is known of one point of the surface.
#[derive(Clone, Copy)]
struct Probe {
    at: DVec3,
    /// Positive inside the part, as the point was given.
    clearance: f64,
    foot: Footpoint,
    /// The ball through that foot.
    ball: Option<Touching>,
}

struct Checker<'c> {
    part: &'c Part,
    surface: &'c MidSurface,
    mesh: TriMesh,
    walls: &'c Walls<'c>,
    field: &'c Field,
    edges: Edges,
    /// The first triangle at each vertex.
    triangle_at: Vec<Option<u32>>,
    limits: &'c Limits,
}

impl<'c> Checker<'c> {
    fn new(
        part: &'c Part,
        surface: &'c MidSurface,
        walls: &'c Walls<'c>,
        limits: &'c Limits,
    ) -> Checker<'c> {
        let mesh = surface.mesh();
        let mut triangle_at = vec![None; mesh.positions.len()];
        for (t, corners) in (0..).zip(&mesh.triangles) {
            for &v in corners {
                triangle_at[v as usize].get_or_insert(t);
            }
        }
        Checker {
            triangle_at,
            part,
            surface,
            edges: Edges::new(&mesh.triangles),
            mesh,
            walls,
            field: walls.field(),
            limits,
        }
    }

    fn run(&self, with_thickness: bool) -> Check {
        let nodes: Vec<Probe> = (self.mesh.positions.par_iter())
            .map_init(Vec::new, |hits, &at| self.probe(at, hits))
            .collect();
        let centre = |t: &[u32; 3]| t.iter().map(|&v| self.at(v)).sum::<DVec3>() / 3.0;
        let centres: Vec<Probe> = (self.mesh.triangles.par_iter())
            .map_init(Vec::new, |hits, t| self.probe(centre(t), hits))
            .collect();
        let thickness = median(nodes.iter().filter_map(|p| Some(2.0 * p.ball?.radius)));
        let bends = Bends::of(&self.edges, |v| self.at(v), |e| self.bend(e), thickness);
        let (uncovered, covered) = self.uncovered(thickness);
        let of = |measure, all| Outcome::of(measure, all, self.limit(measure));
        let one_of = |v: usize| self.triangle_at[v];
        let outcomes = vec![
            of(
                Measure::NodesOffMiddle,
                self.off_middle(&nodes, &one_of, &bends),
            ),
            of(Measure::NodesOffSides, self.off_sides(thickness, false)),
            of(
                Measure::NodesOutside,
                self.outside(&nodes, &one_of, thickness),
            ),
            of(Measure::EdgesOffSides, self.off_sides(thickness, true)),
            of(
                Measure::CentresOffMiddle,
                self.off_middle(&centres, &|t| Some(t as u32), &bends),
            ),
            of(Measure::Uncovered, uncovered),
            of(Measure::Excess, self.excess(&centres, thickness)),
            of(Measure::Unwelded, self.unwelded(thickness)),
            of(Measure::Pieces, self.pieces()),
            of(Measure::SeamsOff, self.seams_off()),
            of(
                Measure::ThicknessOff,
                match with_thickness {
                    true => self.thickness_off(&nodes, &bends),
                    false => Vec::new(),
                },
            ),
            of(Measure::SmallAngles, self.small_angles()),
            of(Measure::Folds, self.folds()),
            of(Measure::Crossings, self.crossings()),
        ];
        let mut marks = vec![0; self.mesh.triangles.len()];
        for outcome in &outcomes {
            for t in outcome.defects.iter().filter_map(|d| d.triangle) {
                marks[t as usize] |= outcome.measure.bit();
            }
        }
        let share = |p: &Probe| off(p).unwrap_or(f64::NAN);
        Check {
            outcomes,
            thickness,
            covered,
            off_middle: nodes.iter().map(share).collect(),
            marks,
        }
    }

    fn limit(&self, measure: Measure) -> f64 {
        match measure {
            // Told as the share of the limit that is used up.
            Measure::NodesOffMiddle | Measure::CentresOffMiddle | Measure::ThicknessOff => 1.0,
            Measure::NodesOffSides | Measure::EdgesOffSides | Measure::NodesOutside => {
                self.limits.tolerance
            }
            Measure::Uncovered => COVERED,
            Measure::SeamsOff => self.limits.near_seams,
            Measure::Folds => FOLD,
            Measure::Excess
            | Measure::Unwelded
            | Measure::Pieces
            | Measure::SmallAngles
            | Measure::Crossings => 0.0,
        }
    }

    fn at(&self, v: u32) -> DVec3 {
        self.mesh.positions[v as usize]
    }

    fn middle(&self, edge: usize) -> DVec3 {
        let [a, b] = self.edges.ends[edge];
        self.at(a).midpoint(self.at(b))
    }

    fn probe(&self, at: DVec3, hits: &mut Vec<Hit>) -> Probe {
        let clearance = self.field.signed_clearance(at);
        let mut at = at;
        let mut foot = self.field.footpoint(at);
        // On a coping face feet and rays run along edges of the walls, where
        // rounding decides what they meet: step inside.
        let step = STEP * foot.distance;
        if let Some(cope) = self.field.nearest_coping(at, step) {
            at -= 2.0 * step * self.field.normal(cope.face);
            foot = self.field.footpoint(at);
        }
        let away = at - foot.point;
        let inward = match self.field.inside(at) && foot.distance > 0.0 {
            true => away / foot.distance,
            false => -self.field.normal(foot.face),
        };
        Probe {
            at,
            clearance,
            foot,
            ball: touching(self.field, &foot, inward, hits),
        }
    }

    /// Distance from the middle over what is let pass there.
    fn off_middle(
        &self,
        probes: &[Probe],
        triangle: &(dyn Fn(usize) -> Option<u32> + Sync),
        bends: &Bends,
    ) -> Vec<Defect> {
        let one = |(n, probe): (usize, &Probe)| {
            let limit = match bends.near(probe.at) {
                true => self.limits.near_seams,
                false => self.limits.tolerance,
            };
            Some(Defect {
                at: probe.at,
                value: off(probe)? / limit,
                triangle: triangle(n),
            })
        };
        probes.iter().enumerate().filter_map(one).collect()
    }

    fn thickness_off(&self, nodes: &[Probe], bends: &Bends) -> Vec<Defect> {
        let vertices = self.surface.vertices();
        let one = |(n, (probe, vertex)): (usize, (&Probe, &crate::surface::MidVertex))| {
            let wall = 2.0 * probe.ball?.radius;
            let off = (vertex.ball.thickness - wall).abs() / wall;
            (!bends.near(probe.at)).then_some(Defect {
                at: probe.at,
                value: off / self.limits.tolerance,
                triangle: self.triangle_at[n],
            })
        };
        nodes
            .iter()
            .zip(vertices)
            .enumerate()
            .filter_map(one)
            .collect()
    }

    fn outside(
        &self,
        nodes: &[Probe],
        triangle: &dyn Fn(usize) -> Option<u32>,
        thickness: f64,
    ) -> Vec<Defect> {
        let one = |(n, probe): (usize, &Probe)| Defect {
            at: probe.at,
            value: (-probe.clearance).max(0.0) / thickness,
            triangle: triangle(n),
        };
        nodes.iter().enumerate().map(one).collect()
    }

    /// Edges with one triangle.
    fn free(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.edges.len()).filter(|&e| self.edges.uses(e).len() == 1)
    }

    /// How far the free boundary is from the sides of the part: its coping
    /// faces, or where it has none, its surface.
    fn off_sides(&self, thickness: f64, edges: bool) -> Vec<Defect> {
        let mut places: Vec<(DVec3, u32)> = Vec::new();
        let mut seen = vec![false; self.mesh.positions.len()];
        for e in self.free() {
            let triangle = self.edges.uses(e)[0] / 3;
            if edges {
                places.push((self.middle(e), triangle));
                continue;
            }
            for v in self.edges.ends[e] {
                if !std::mem::replace(&mut seen[v as usize], true) {
                    places.push((self.at(v), triangle));
                }
            }
        }
        let tagged = self.part.coping_count() > 0;
        let one = |&(at, triangle): &(DVec3, u32)| Defect {
            at,
            value: match self
                .field
                .nearest_coping(at, f64::INFINITY)
                .filter(|_| tagged)
            {
                Some(foot) => foot.distance,
                None => self.field.signed_clearance(at).abs(),
            } / thickness,
            triangle: Some(triangle),
        };
        places.par_iter().map(one).collect()
    }

    /// Walls without a surface beside them, and the share that has one.
    fn uncovered(&self, thickness: f64) -> (Vec<Defect>, f64) {
        let own = Field::of_mesh(&self.mesh);
        let samples = spread(self.part.mesh(), SAMPLES);
        let walls: Vec<_> = (samples.into_iter())
            .filter(|(face, _)| !self.part.coping()[face.index()])
            .collect();
        let one = |hits: &mut Vec<Hit>, &(face, point): &(_, DVec3)| {
            let foot = Footpoint {
                face,
                point,
                distance: 0.0,
            };
            let ball = touching(self.field, &foot, -self.field.normal(face), hits);
            let wall = ball.map_or(thickness, |b| (2.0 * b.radius).max(thickness));
            Defect {
                at: point,
                value: own.footpoint(point).distance / wall,
                triangle: None,
            }
        };
        let all: Vec<Defect> = walls.par_iter().map_init(Vec::new, one).collect();
        let bare = all.iter().filter(|d| d.value > COVERED).count();
        let covered = 1.0 - bare as f64 / all.len().max(1) as f64;
        (all, covered)
    }

    /// Elements outside the part, and fins: the ball touches two faces of one
    /// wall round an edge.
    fn excess(&self, centres: &[Probe], thickness: f64) -> Vec<Defect> {
        let one = |(t, probe): (usize, &Probe)| {
            let fin = || {
                probe.ball.is_some_and(|ball| {
                    let foot = Footpoint {
                        distance: ball.radius,
                        ..probe.foot
                    };
                    off(probe).is_some_and(|o| o < self.limits.tolerance)
                        && !self.walls.separate(ball.centre, &foot, &ball.other)
                })
            };
            let outside = -probe.clearance / thickness;
            Defect {
                at: probe.at,
                value: match outside > self.limits.tolerance {
                    true => outside,
                    false => f64::from(u8::from(fin())),
                },
                triangle: Some(t as u32),
            }
        };
        centres.par_iter().enumerate().map(one).collect()
    }

    /// Free edges on other elements.
    fn unwelded(&self, thickness: f64) -> Vec<Defect> {
        let own = Field::of_mesh(&self.mesh);
        let free: Vec<usize> = self.free().collect();
        let reach = MEANT * thickness;
        let one = |near: &mut Vec<Footpoint>, &e: &usize| {
            let [a, b] = self.edges.ends[e];
            own.footpoints_within(self.middle(e), reach, near);
            // Elements that hang together with the edge's own on the way are no strangers,
            // though small ones share no node with it.
            let mut welded: FxHashSet<u32> = [a, b].into_iter().collect();
            loop {
                let before = near.len();
                near.retain(|foot| {
                    let corners = self.mesh.triangles[foot.face.index()];
                    let strange = corners.iter().all(|v| !welded.contains(v));
                    if !strange {
                        welded.extend(corners);
                    }
                    strange
                });
                if near.len() == before {
                    break;
                }
            }
            // A gap of nothing is a defect as well: told from the other end.
            let gap = near.iter().map(|foot| foot.distance).reduce(f64::min);
            Defect {
                at: self.middle(e),
                value: gap.map_or(0.0, |gap| (reach - gap).max(f64::MIN_POSITIVE) / thickness),
                triangle: Some(self.edges.uses(e)[0] / 3),
            }
        };
        free.par_iter().map_init(Vec::new, one).collect()
    }

    /// Pieces of the surface beyond those of the part.
    fn pieces(&self) -> Vec<Defect> {
        let own = components(&self.mesh);
        let wanted = components(self.part.mesh()).len().max(1);
        let extra = own.into_iter().skip(wanted);
        extra
            .map(|triangle| Defect {
                at: self.at(self.mesh.triangles[triangle][0]),
                value: 1.0,
                triangle: Some(triangle as u32),
            })
            .collect()
    }

    /// How much farther than the nearest the third wall is, at seams.
    fn seams_off(&self) -> Vec<Defect> {
        let seams: Vec<usize> = (0..self.edges.len())
            .filter(|&e| self.edges.uses(e).len() > 2)
            .collect();
        let one = |near: &mut Vec<Footpoint>, &e: &usize| {
            let at = self.middle(e);
            let nearest = self.field.footpoint(at).distance;
            self.field.footpoints_within(at, 3.0 * nearest, near);
            near.sort_by(|a, b| a.distance.total_cmp(&b.distance));
            let mut feet: Vec<&Footpoint> = Vec::new();
            for foot in near.iter() {
                // Feet in about one direction are of one wall.
                let apart =
                    |other: &&Footpoint| (foot.point - at).angle_between(other.point - at) > 0.5;
                if feet.iter().all(apart) {
                    feet.push(foot);
                }
            }
            let third = feet.get(2).map_or(3.0 * nearest, |foot| foot.distance);
            Defect {
                at,
                value: 0.5 * (third - nearest) / nearest.max(f64::MIN_POSITIVE),
                triangle: Some(self.edges.uses(e)[0] / 3),
            }
        };
        seams.par_iter().map_init(Vec::new, one).collect()
    }

    fn small_angles(&self) -> Vec<Defect> {
        let one = |(t, corners): (usize, &[u32; 3])| {
            let p = corners.map(|v| self.at(v));
            Defect {
                at: (p[0] + p[1] + p[2]) / 3.0,
                value: (LEAST_ANGLE - smallest_angle(p)).max(0.0),
                triangle: Some(t as u32),
            }
        };
        self.mesh.triangles.iter().enumerate().map(one).collect()
    }

    /// Angle between the normals of neighbours in a sheet, degrees.
    fn bend(&self, e: usize) -> Option<f64> {
        let [a, b] = self.edges.pair(e)?;
        let corner = |t: u32| {
            let [p, q] = self.edges.ends[e];
            let far = self.mesh.triangles[t as usize]
                .into_iter()
                .find(|&v| v != p && v != q);
            far.map(|v| self.at(v))
        };
        let [p, q] = self.edges.ends[e].map(|v| self.at(v));
        let along = (q - p).try_normalize()?;
        // Directions away from the edge, square to it: opposite in the flat.
        let away = |t: u32| Some((corner(t)? - p).reject_from_normalized(along));
        Some(180.0 - away(a)?.angle_between(away(b)?).to_degrees())
    }

    fn folds(&self) -> Vec<Defect> {
        let one = |e: usize| {
            Some(Defect {
                at: self.middle(e),
                value: self.bend(e).filter(|bend| bend.is_finite())?,
                triangle: Some(self.edges.uses(e)[0] / 3),
            })
        };
        (0..self.edges.len()).filter_map(one).collect()
    }

    fn crossings(&self) -> Vec<Defect> {
        let pairs = self_intersections(&self.mesh);
        let mut out: Vec<Defect> = (pairs.iter())
            .map(|(a, _)| {
                let [p, q, r] = self.mesh.corners(*a);
                Defect {
                    at: (p + q + r) / 3.0,
                    value: 1.0,
                    triangle: Some(a.0),
                }
            })
            .collect();
        out.dedup_by_key(|d| d.triangle);
        out
    }
}

/// Distance from the middle, as a share of the thickness there; none outside,
/// which is a defect of its own, or where no wall is across.
fn off(probe: &Probe) -> Option<f64> {
    let ball = probe
        .ball
        .filter(|_| probe.clearance > 0.0 || probe.foot.distance > 0.0)?;
    Some(probe.at.distance(ball.centre) / (2.0 * ball.radius))
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut all: Vec<f64> = values.collect();
    all.sort_unstable_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(1.0)
}

/// First triangle of each piece that hangs together by vertices, the largest
/// piece first.
fn components(mesh: &TriMesh) -> Vec<usize> {
    let mut sets = Sets::new(mesh.positions.len());
    for &[a, b, c] in &mesh.triangles {
        sets.join(a, b);
        sets.join(b, c);
    }
    let mut size: FxHashMap<u32, (usize, usize)> = FxHashMap::default();
    for (t, c) in mesh.triangles.iter().enumerate() {
        size.entry(sets.find(c[0])).or_insert((0, t)).0 += 1;
    }
    let mut all: Vec<(usize, usize)> = size.into_values().collect();
    all.sort_unstable_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
    all.into_iter().map(|(_, first)| first).collect()
}
