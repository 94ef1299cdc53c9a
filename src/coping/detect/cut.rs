//! Faces of two minds: coplanar, but rim in one place and wall in another.
//!
//! The cheapest cut over the face's triangles, evidence against length of the
//! cut (a minimum cut, as in Boykov, Veksler and Zabih, "Fast Approximate
//! Energy Minimization via Graph Cuts", 2001).

use petgraph::algo::dinics;
use petgraph::graph::{DiGraph, NodeIndex};
use petgraph::visit::EdgeRef;

use super::faces::{Faces, Kind};
use super::probes::{Across, Probe};
use super::samples::Sample;
use super::surface::Surface;
use crate::mesh::sets::Sets;

/// Log2 of depth over chord from which a piece may be cut from a face, and
/// over which width the evidence grows to its whole weight.
const STRONG: [f64; 2] = [0.9, 0.7];

/// Area of a piece, in squared thicknesses.
const AREA: f64 = 3.0;

/// What a strip between the sides of a wall says.
const STRIP: f64 = 0.5;

/// Mean evidence of a piece.
const CLEAR: f64 = 0.3;

/// Share of a rim that speaks for it: triangles that are themselves rim in one place
/// and wall in another cannot be tagged either way, and stay what the face is.
const PURE: f64 = 0.8;

/// Doubt about a face only because it was cut out of another.
pub(super) const DOUBT: f64 = 0.5;

/// Steps of a capacity: flows are whole numbers, so that no rounding is met.
const STEPS: f64 = 1e12;

/// Cuts the faces that need it; returns how many pieces were added, which have
/// the last numbers.
pub(super) fn cut(
    surface: &Surface,
    samples: &[Sample],
    probes: &[Probe],
    faces: &mut Faces,
) -> usize {
    let before = faces.len();
    let mut told = vec![Told::default(); surface.len()];
    let mut sums = vec![Sum::default(); before];
    for (sample, probe) in samples.iter().zip(probes) {
        let own = strong(probe);
        told[sample.face as usize].add(own, sample.weight);
        let own = sample.weight * own;
        let sum = &mut sums[faces.of(sample.face)];
        sum.coping += own.max(0.0);
        sum.wall += (-own).max(0.0);
        sum.log += sample.weight * probe.thickness.ln();
        sum.weight += sample.weight;
    }
    let needs = |face: usize| {
        let sum = &sums[face];
        // Less evidence than this cannot be that of a piece.
        let least = CLEAR * AREA * sum.thickness().powi(2);
        faces.kinds[face] == Kind::Flat && sum.coping.min(sum.wall) > least
    };
    let undecided: Vec<usize> = (0..before).filter(|&face| needs(face)).collect();
    if undecided.is_empty() {
        return 0;
    }
    let mut members = vec![Vec::new(); before];
    for (triangle, &face) in faces.of.iter().enumerate() {
        members[face as usize].push(triangle as u32);
    }
    let mut inner = vec![Vec::new(); before];
    for (index, edge) in surface.edges.iter().enumerate() {
        let [a, b] = edge.faces.map(|t| faces.of(t));
        if a == b {
            inner[a].push(index);
        }
    }
    for face in undecided {
        let piece = Piece {
            surface,
            triangles: &members[face],
            edges: &inner[face],
            told: &told,
            thickness: sums[face].thickness(),
        };
        for part in piece.cut() {
            let number = faces.len() as u32;
            faces.kinds.push(Kind::Flat);
            for triangle in part {
                faces.of[triangle as usize] = number;
            }
        }
    }
    faces.len() - before
}

/// What a sample says when a cut is asked for. Weak signs of a rim say nothing;
/// a strip that still runs between the two sides of a wall speaks for a rim,
/// though the wall behind it be shallow, as where a rib runs out into a plate.
fn strong(probe: &Probe) -> f64 {
    let strip = probe.across.as_ref().map_or(0.0, Across::strip);
    if probe.score <= 0.0 && strip > 0.0 {
        STRIP * strip
    } else if probe.score > 0.0 {
        probe.score * ((probe.ratio - STRONG[0]) / STRONG[1]).clamp(0.0, 1.0)
    } else {
        probe.score
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    coping: f64,
    wall: f64,
    log: f64,
    weight: f64,
}

impl Sum {
    fn thickness(&self) -> f64 {
        (self.log / self.weight.max(f64::MIN_POSITIVE)).exp()
    }
}

struct Piece<'a> {
    surface: &'a Surface,
    triangles: &'a [u32],
    edges: &'a [usize],
    told: &'a [Told],
    thickness: f64,
}

impl Piece<'_> {
    /// Triangles of the parts that go; none if the face stays whole.
    fn cut(&self) -> Vec<Vec<u32>> {
        let sides = self.sides();
        let place = |t: u32| self.triangles.partition_point(|&other| other < t) as u32;
        let mut sets = Sets::new(self.triangles.len());
        for &edge in self.edges {
            let [a, b] = self.surface.edges[edge].faces.map(place);
            if sides[a as usize] == sides[b as usize] {
                sets.join(a, b);
            }
        }
        let (part_of, count) = sets.labels();
        let mut parts = vec![Part::default(); count];
        for (at, &part) in part_of.iter().enumerate() {
            let part = &mut parts[part as usize];
            let triangle = self.triangles[at];
            part.triangles.push(triangle);
            part.area += self.surface.areas[triangle as usize];
            part.told.join(self.told[triangle as usize]);
            part.coping = sides[at];
        }
        let least = AREA * self.thickness * self.thickness;
        parts.retain(|part| part.area > least && part.is_clear());
        let Some(largest) = parts
            .iter()
            .enumerate()
            .max_by(|(i, a), (j, b)| a.area.total_cmp(&b.area).then(j.cmp(i)))
            .map(|(_, part)| part.coping)
        else {
            return Vec::new();
        };
        parts.retain(|part| part.coping != largest);
        parts.into_iter().map(|part| part.triangles).collect()
    }

    /// Which triangles a cheapest cut leaves on the side of coping.
    fn sides(&self) -> Vec<bool> {
        let place = |t: u32| self.triangles.partition_point(|&other| other < t);
        let told = |&t: &u32| self.told[t as usize].evidence;
        let cost = |edge: usize| self.surface.edges[edge].length * self.thickness;
        let whole: f64 = self.triangles.iter().map(|t| told(t).abs()).sum::<f64>()
            + self.edges.iter().map(|&edge| cost(edge)).sum::<f64>();
        let steps = |value: f64| (value.abs() * STEPS / whole).round() as u64;

        let count = self.triangles.len();
        let mut graph: DiGraph<(), u64> = DiGraph::with_capacity(count + 2, 2 * count);
        let nodes: Vec<NodeIndex> = (0..count + 2).map(|_| graph.add_node(())).collect();
        let (coping, wall) = (nodes[count], nodes[count + 1]);
        for (at, triangle) in self.triangles.iter().enumerate() {
            let value = told(triangle);
            if value > 0.0 {
                graph.add_edge(coping, nodes[at], steps(value));
            } else if value < 0.0 {
                graph.add_edge(nodes[at], wall, steps(value));
            }
        }
        for &edge in self.edges {
            let [a, b] = self.surface.edges[edge].faces.map(|t| nodes[place(t)]);
            graph.add_edge(a, b, steps(cost(edge)));
            graph.add_edge(b, a, steps(cost(edge)));
        }
        let (_, flow) = dinics(&graph, coping, wall);

        // What can still be reached from the source lies on its side.
        let mut reached = vec![false; count + 2];
        reached[coping.index()] = true;
        let mut open = vec![coping];
        while let Some(node) = open.pop() {
            let out = graph
                .edges(node)
                .filter(|e| flow[e.id().index()] < *e.weight());
            let back = graph
                .edges_directed(node, petgraph::Direction::Incoming)
                .filter(|e| flow[e.id().index()] > 0);
            let next = out.map(|e| e.target()).chain(back.map(|e| e.source()));
            for other in next {
                if !reached[other.index()] {
                    reached[other.index()] = true;
                    open.push(other);
                }
            }
        }
        reached.truncate(count);
        reached
    }
}

#[derive(Clone, Debug, Default)]
struct Part {
    triangles: Vec<u32>,
    area: f64,
    told: Told,
    coping: bool,
}

impl Part {
    fn is_clear(&self) -> bool {
        let Told {
            evidence,
            rim,
            weight,
        } = self.told;
        if self.coping {
            evidence > CLEAR * self.area && rim >= PURE * weight
        } else {
            -evidence > CLEAR * self.area
        }
    }
}

/// What samples say, summed.
#[derive(Clone, Copy, Debug, Default)]
struct Told {
    /// Positive for coping.
    evidence: f64,
    /// Weight of the samples that see a rim.
    rim: f64,
    weight: f64,
}

impl Told {
    fn add(&mut self, evidence: f64, weight: f64) {
        self.evidence += weight * evidence;
        self.weight += weight;
        if evidence > 0.0 {
            self.rim += weight;
        }
    }

    fn join(&mut self, other: Told) {
        self.evidence += other.evidence;
        self.rim += other.rim;
        self.weight += other.weight;
    }
}
