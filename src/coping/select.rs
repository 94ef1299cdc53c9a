//! Holds rules against a mesh.

use glam::DVec3;

use super::error::TagProblem;
use super::error::{Located, Span};
use super::glob::fits;
use super::rule::{BoxMode, Condition, FacetRange, NameKind};
use crate::io::quote::shown;
use crate::io::{LoadedMesh, NameSet};
use crate::mesh::{FaceId, TriMesh, weld_exact};

/// Slack for cosines, so that rounding does not part triangles of one plane
/// or lose a right angle; 1e-12 is an angle of 1e-4 degrees near zero.
const COSINE_NOISE: f64 = 1e-12;

/// Triangles at one edge that a flood fill compares each with each.
const MOST_PAIRED: usize = 16;

/// A mesh with what selections need, made on first use.
pub(super) struct Selector<'a> {
    loaded: &'a LoadedMesh,
    /// First triangle of each facet, and the end.
    first_triangle: Vec<u32>,
    neighbours: Option<Vec<Vec<FaceId>>>,
}

impl<'a> Selector<'a> {
    pub(super) fn new(loaded: &'a LoadedMesh) -> Selector<'a> {
        let facets = loaded.facet_count() as u32;
        let first_triangle = (0..=facets)
            .map(|facet| loaded.source.partition_point(|&f| f < facet) as u32)
            .collect();
        Selector {
            loaded,
            first_triangle,
            neighbours: None,
        }
    }

    fn mesh(&self) -> &'a TriMesh {
        &self.loaded.mesh
    }

    /// One flag a triangle for a condition of the named rule.
    pub(super) fn select(
        &mut self,
        condition: &Condition,
        rule: &str,
        strict_names: bool,
    ) -> Result<Vec<bool>, Located> {
        match condition {
            Condition::Facets(ranges) => self.facets(ranges),
            Condition::Names { kind, patterns } => self.names(*kind, patterns, strict_names),
            Condition::Plane {
                point,
                normal,
                tolerance,
                max_angle,
            } => {
                let tolerance = tolerance.unwrap_or_else(|| 1e-6 * self.mesh().bounds().diagonal());
                Ok(self.plane(*point, *normal, tolerance, *max_angle))
            }
            Condition::Box { min, max, mode } => Ok(self.in_box(*min, *max, *mode)),
            Condition::Near {
                point,
                grow_angle,
                max_area,
                span,
            } => self
                .near(*point, *grow_angle, *max_area, rule)
                .map_err(|problem| (span.clone(), problem)),
        }
    }

    fn none(&self) -> Vec<bool> {
        vec![false; self.mesh().triangles.len()]
    }

    fn facets(&self, ranges: &[FacetRange]) -> Result<Vec<bool>, Located> {
        let count = self.loaded.facet_count();
        let mut flags = self.none();
        for range in ranges {
            if range.last >= count as u64 {
                let index = if range.first >= count as u64 {
                    range.first
                } else {
                    range.last
                };
                let problem = TagProblem::OutOfRange {
                    index,
                    facets: count,
                };
                return Err((range.span.clone(), problem));
            }
            // In range of the facets, hence of usize.
            let step = usize::try_from(range.step).unwrap_or(usize::MAX);
            for facet in (range.first as usize..=range.last as usize).step_by(step) {
                let triangles = self.first_triangle[facet]..self.first_triangle[facet + 1];
                for triangle in triangles {
                    flags[triangle as usize] = true;
                }
            }
        }
        Ok(flags)
    }

    fn names(
        &self,
        kind: NameKind,
        patterns: &[(String, Span)],
        strict: bool,
    ) -> Result<Vec<bool>, Located> {
        let sets = self.loaded.names.sets();
        let mut chosen = vec![false; sets.len()];
        for (pattern, span) in patterns {
            let mut found = false;
            for (set, chosen) in sets.iter().zip(&mut chosen) {
                if names_of_kind(set, kind).any(|name| fits(pattern, name)) {
                    *chosen = true;
                    found = true;
                }
            }
            if !found && strict {
                let problem = TagProblem::NoSuchName {
                    kind: match kind {
                        NameKind::Any => "group, object or material",
                        NameKind::Group => "group",
                        NameKind::Object => "object",
                        NameKind::Material => "material",
                    },
                    pattern: pattern.clone(),
                    known: known_names(sets, kind),
                };
                return Err((span.clone(), problem));
            }
        }
        let names = &self.loaded.names;
        let source = self.loaded.source.iter();
        Ok(source
            .map(|&facet| chosen[names.set_of(facet) as usize])
            .collect())
    }

    fn plane(&self, point: DVec3, normal: DVec3, tolerance: f64, max_angle: f64) -> Vec<bool> {
        let least_cosine = max_angle.to_radians().cos();
        let mesh = self.mesh();
        mesh.faces()
            .map(|face| {
                let corners = mesh.corners(face);
                let close = corners
                    .iter()
                    .all(|&p| (p - point).dot(normal).abs() <= tolerance);
                // A triangle without area has no direction to object to.
                close
                    && mesh
                        .area_vector(face)
                        .try_normalize()
                        .is_none_or(|n| n.dot(normal).abs() >= least_cosine - COSINE_NOISE)
            })
            .collect()
    }

    fn in_box(&self, min: DVec3, max: DVec3, mode: BoxMode) -> Vec<bool> {
        let inside = |p: DVec3| p.cmpge(min).all() && p.cmple(max).all();
        let mesh = self.mesh();
        mesh.faces()
            .map(|face| {
                let corners = mesh.corners(face);
                match mode {
                    BoxMode::All => corners.into_iter().all(inside),
                    BoxMode::Any => corners.into_iter().any(inside),
                    BoxMode::Centroid => inside(corners.iter().sum::<DVec3>() / 3.0),
                }
            })
            .collect()
    }

    fn near(
        &mut self,
        point: DVec3,
        grow_angle: f64,
        max_area: Option<f64>,
        rule: &str,
    ) -> Result<Vec<bool>, TagProblem> {
        let mesh = self.mesh();
        let mut flags = self.none();
        let seed = mesh.faces().min_by(|&a, &b| {
            let distance = |face| distance_squared(point, mesh.corners(face));
            distance(a).total_cmp(&distance(b))
        });
        let Some(seed) = seed else {
            return Ok(flags);
        };
        let least_cosine = grow_angle.to_radians().cos();
        let neighbours = self.neighbours.get_or_insert_with(|| neighbours(mesh));
        let normal = |face| mesh.area_vector(face).try_normalize();
        let mut area = 0.0;
        let mut queue = vec![seed];
        flags[seed.index()] = true;
        let mut next = 0;
        while next < queue.len() {
            let face = queue[next];
            next += 1;
            area += mesh.triangle_area(face);
            for &other in &neighbours[face.index()] {
                if flags[other.index()] {
                    continue;
                }
                let smooth = match (normal(face), normal(other)) {
                    (Some(a), Some(b)) => a.dot(b) >= least_cosine - COSINE_NOISE,
                    _ => true,
                };
                if smooth {
                    flags[other.index()] = true;
                    queue.push(other);
                }
            }
        }
        match max_area {
            Some(max_area) if area > max_area => Err(TagProblem::FloodTooLarge {
                rule: rule.to_owned(),
                max_area,
                area,
                triangles: queue.len(),
            }),
            _ => Ok(flags),
        }
    }
}

fn names_of_kind(set: &NameSet, kind: NameKind) -> Box<dyn Iterator<Item = &str> + '_> {
    match kind {
        NameKind::Any => Box::new(set.all()),
        NameKind::Group => Box::new(set.groups.iter().map(String::as_str)),
        NameKind::Object => Box::new(set.object.iter().map(String::as_str)),
        NameKind::Material => Box::new(set.material.iter().map(String::as_str)),
    }
}

/// The first few names of a kind, for a message.
fn known_names(sets: &[NameSet], kind: NameKind) -> String {
    const SHOWN: usize = 6;
    let mut names: Vec<&str> = Vec::new();
    for name in sets.iter().flat_map(|set| names_of_kind(set, kind)) {
        if !names.contains(&name) {
            names.push(name);
        }
        if names.len() > SHOWN {
            break;
        }
    }
    match names.len() {
        0 => "; it has no such names at all".to_owned(),
        n if n <= SHOWN => format!("; there are {}", listed(&names)),
        _ => format!("; there are {} and more", listed(&names[..SHOWN])),
    }
}

fn listed(names: &[&str]) -> String {
    let names: Vec<String> = names.iter().map(|name| shown(name)).collect();
    names.join(", ")
}

/// Triangles across edges; equal vertices count as one, since files may
/// repeat them.
fn neighbours(mesh: &TriMesh) -> Vec<Vec<FaceId>> {
    let welded = weld_exact(&mesh.positions).apply(mesh);
    let mut neighbours = vec![Vec::new(); mesh.triangles.len()];
    for uses in welded.edges().by_edge() {
        for (k, a) in uses.iter().enumerate() {
            // At edges of very many triangles a chain does, lest the pairs
            // fill the memory.
            let reach = if uses.len() > MOST_PAIRED {
                1
            } else {
                uses.len()
            };
            for b in uses.iter().skip(k + 1).take(reach) {
                neighbours[a.face.index()].push(b.face);
                neighbours[b.face.index()].push(a.face);
            }
        }
    }
    neighbours
}

/// Squared distance from a point to a triangle, by the regions of Ericson,
/// Real-Time Collision Detection (2005), section 5.1.5.
fn distance_squared(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let to_segment = |from: DVec3, to: DVec3| {
        let along = to - from;
        let length = along.length_squared();
        let s = if length > 0.0 {
            ((p - from).dot(along) / length).clamp(0.0, 1.0)
        } else {
            0.0
        };
        p.distance_squared(from + s * along)
    };
    let rim = to_segment(a, b).min(to_segment(b, c)).min(to_segment(c, a));
    let normal = (b - a).cross(c - a);
    let square = normal.length_squared();
    if square <= 0.0 {
        return rim;
    }
    let within = |from: DVec3, to: DVec3| (to - from).cross(p - from).dot(normal) >= 0.0;
    if within(a, b) && within(b, c) && within(c, a) {
        let height = (p - a).dot(normal);
        height * height / square
    } else {
        rim
    }
}
