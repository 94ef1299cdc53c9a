//! Holds rules against a mesh.

use std::collections::BTreeMap;

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::error::TagProblem;
use super::error::{Located, Span};
use super::glob::{fits, literal_start};
use super::rule::{BoxMode, Condition, FacetRange, NameKind};
use crate::io::{LoadedMesh, NameSet};
use crate::mesh::{FaceId, TriMesh, weld_exact};
use crate::settings::quote::shown;

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
    names: FxHashMap<NameKind, Names<'a>>,
    /// Triangles of each set of names.
    of_set: Option<Vec<Vec<u32>>>,
}

/// Names in order, each with the sets that hold it.
type Names<'a> = Vec<(&'a str, Vec<u32>)>;

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
            names: FxHashMap::default(),
            of_set: None,
        }
    }

    fn mesh(&self) -> &'a TriMesh {
        &self.loaded.mesh
    }

    /// Triangles that a condition of the named rule selects, in order.
    pub(super) fn select(
        &mut self,
        condition: &Condition,
        rule: &str,
        strict_names: bool,
    ) -> Result<Vec<u32>, Located> {
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

    fn facets(&self, ranges: &[FacetRange]) -> Result<Vec<u32>, Located> {
        let count = self.loaded.facet_count();
        let mut sorted: Vec<(u64, u64, u64)> = Vec::with_capacity(ranges.len());
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
            sorted.push((range.step, range.first, range.last));
        }
        sorted.sort_unstable();
        let mut facets: Vec<u32> = Vec::new();
        // First facet that no range of this step and remainder has given yet,
        // so that ranges that repeat each other cost nothing.
        let mut next: FxHashMap<(u64, u64), u64> = FxHashMap::default();
        for (step, first, last) in sorted {
            let next = next.entry((step, first % step)).or_default();
            let mut facet = first.max(*next);
            while facet <= last {
                facets.push(facet as u32);
                facet = facet.saturating_add(step);
            }
            *next = (*next).max(facet);
            if facets.len() > 4 * count {
                facets.sort_unstable();
                facets.dedup();
            }
        }
        facets.sort_unstable();
        facets.dedup();
        let triangles = |&facet: &u32| {
            let facet = facet as usize;
            self.first_triangle[facet]..self.first_triangle[facet + 1]
        };
        Ok(facets.iter().flat_map(triangles).collect())
    }

    fn names(
        &mut self,
        kind: NameKind,
        patterns: &[(String, Span)],
        strict: bool,
    ) -> Result<Vec<u32>, Located> {
        let loaded = self.loaded;
        let names = self.names_of_kind(kind);
        let mut chosen: Vec<u32> = Vec::new();
        for (pattern, span) in patterns {
            let start = literal_start(pattern);
            let from = names.partition_point(|(name, _)| *name < start);
            let before = chosen.len();
            for (name, sets) in names[from..]
                .iter()
                .take_while(|(n, _)| n.starts_with(start))
            {
                if fits(pattern, name) {
                    chosen.extend(sets);
                }
            }
            if chosen.len() == before && strict {
                let problem = TagProblem::NoSuchName {
                    kind: match kind {
                        NameKind::Any => "group, object or material",
                        NameKind::Group => "group",
                        NameKind::Object => "object",
                        NameKind::Material => "material",
                    },
                    pattern: pattern.clone(),
                    known: known_names(loaded.names.sets(), kind),
                };
                return Err((span.clone(), problem));
            }
        }
        chosen.sort_unstable();
        chosen.dedup();
        let of_set = self.triangles_of_set();
        let mut triangles: Vec<u32> = Vec::new();
        for set in chosen {
            triangles.extend(&of_set[set as usize]);
        }
        triangles.sort_unstable();
        Ok(triangles)
    }

    /// All names of a kind in order, each with the sets that hold it.
    fn names_of_kind(&mut self, kind: NameKind) -> &Names<'a> {
        let sets = self.loaded.names.sets();
        self.names.entry(kind).or_insert_with(|| {
            let mut names: BTreeMap<&str, Vec<u32>> = BTreeMap::new();
            for (number, set) in sets.iter().enumerate() {
                for name in names_of_kind(set, kind) {
                    names.entry(name).or_default().push(number as u32);
                }
            }
            names.into_iter().collect()
        })
    }

    fn triangles_of_set(&mut self) -> &[Vec<u32>] {
        let LoadedMesh { names, source, .. } = self.loaded;
        self.of_set.get_or_insert_with(|| {
            let mut of_set = vec![Vec::new(); names.sets().len()];
            for (triangle, &facet) in source.iter().enumerate() {
                of_set[names.set_of(facet) as usize].push(triangle as u32);
            }
            of_set
        })
    }

    fn plane(&self, point: DVec3, normal: DVec3, tolerance: f64, max_angle: f64) -> Vec<u32> {
        let least_cosine = max_angle.to_radians().cos();
        let mesh = self.mesh();
        mesh.faces()
            .filter(|&face| {
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
            .map(|face| face.0)
            .collect()
    }

    fn in_box(&self, min: DVec3, max: DVec3, mode: BoxMode) -> Vec<u32> {
        let inside = |p: DVec3| p.cmpge(min).all() && p.cmple(max).all();
        let mesh = self.mesh();
        mesh.faces()
            .filter(|&face| {
                let corners = mesh.corners(face);
                match mode {
                    BoxMode::All => corners.into_iter().all(inside),
                    BoxMode::Any => corners.into_iter().any(inside),
                    BoxMode::Centroid => inside(corners.iter().sum::<DVec3>() / 3.0),
                }
            })
            .map(|face| face.0)
            .collect()
    }

    fn near(
        &mut self,
        point: DVec3,
        grow_angle: f64,
        max_area: Option<f64>,
        rule: &str,
    ) -> Result<Vec<u32>, TagProblem> {
        let mesh = self.mesh();
        let mut flags = vec![false; mesh.triangles.len()];
        let seed = mesh.faces().min_by(|&a, &b| {
            let distance = |face| distance_squared(point, mesh.corners(face));
            distance(a).total_cmp(&distance(b))
        });
        let Some(seed) = seed else {
            return Ok(Vec::new());
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
            _ => {
                let mut selected: Vec<u32> = queue.iter().map(|face| face.0).collect();
                selected.sort_unstable();
                Ok(selected)
            }
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
