//! Strands to loops.

use glam::DVec3;

use super::{Line, Plugs, Polygon, Port, Strand, VertexKey, Work};
use crate::mesh::FaceId;
use crate::trace::follow::face::FaceNodeKind;
use crate::trace::follow::fan::unlike;
use crate::trace::probe::Pair;

impl Work<'_, '_> {
    /// The common name of a port, where a crease joins two.
    pub(super) fn common(&self, port: Port) -> Port {
        self.bridges
            .iter()
            .find(|b| b.1 == port)
            .map_or(port, |b| b.0)
    }

    /// Strand ends by port: a tetrahedron has a handful.
    pub(super) fn plugged(&self) -> Plugs {
        let mut ends: Vec<(Port, usize, usize)> = Vec::with_capacity(2 * self.strands.len());
        for (s, strand) in self.strands.iter().enumerate() {
            for side in 0..2 {
                ends.push((self.common(strand.ports[side]), s, side));
            }
        }
        ends.sort_unstable();
        Plugs { ends }
    }

    /// Where a curve was lost, or a sheet stops being one on the way: closes
    /// each sheet's loop from its face contours alone. Ports with one strand
    /// are joined in pairs, those first whose walls lie most alike, each seen
    /// from its port or all from between the two: round a corner the same walls
    /// lie in other directions.
    pub(super) fn match_open_ports(&mut self) {
        let plugged = self.plugged();
        let mut open: Vec<(Port, VertexKey, DVec3, [FaceId; 2])> = Vec::new();
        for ends in plugged.ends.chunk_by(|a, b| a.0 == b.0) {
            if let [(port, strand, side)] = ends[..] {
                let vertex = self.strands[strand].vertices[side];
                let at = self.position(vertex);
                if let Some(pair) = self.pair_at(port) {
                    open.push((port, vertex, at, [pair.left, pair.right]));
                }
            }
        }
        let field = self.probe.field();
        let gap = |i: usize, j: usize| {
            let ((_, _, p, v), (_, _, q, w)) = (open[i], open[j]);
            unlike([p, q], field, v, w).min(unlike([p.midpoint(q); 2], field, v, w))
        };
        let mut candidates: Vec<(f64, usize, usize)> = Vec::new();
        for i in 0..open.len() {
            for j in i + 1..open.len() {
                candidates.push((gap(i, j), i, j));
            }
        }
        candidates.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut taken = vec![false; open.len()];
        for (_, i, j) in candidates {
            if taken[i] || taken[j] {
                continue;
            }
            taken[i] = true;
            taken[j] = true;
            let fading = [i, j].map(|k| self.fades(open[k].0));
            self.out.matched += u32::from(fading != [true; 2]);
            if open[i].1 == open[j].1 {
                self.bridges.push((open[i].0, open[j].0));
                continue;
            }
            // A contour missing in a face is missing for the neighbour too:
            // unless both close it alike it shows as a crack.
            let in_face = |p: Port| matches!(p, Port::Crossing(..));
            let line = if in_face(open[i].0) || in_face(open[j].0) {
                Line::Sheet
            } else {
                Line::FadingBorder
            };
            // From where it fades a border may run to a seam that its sheet leaves.
            self.out.torn += u32::from(fading == [false; 2] && line == Line::FadingBorder);
            self.strands.push(Strand {
                ports: [open[i].0, open[j].0],
                vertices: [open[i].1, open[j].1],
                between: Vec::new(),
                line,
            });
        }
    }

    /// Whether the contour of a face fades at a port: borders run from there
    /// to the next such place.
    fn fades(&self, port: Port) -> bool {
        match port {
            Port::Spoke { face, node, .. } => (self.faces[face as usize].nodes)
                .get(node as usize)
                .is_some_and(|n| n.kind == FaceNodeKind::Fading),
            _ => false,
        }
    }

    /// The walls of the sheet at a port.
    fn pair_at(&self, port: Port) -> Option<Pair> {
        match port {
            Port::Crossing(edge, n) => {
                let c = self.crossings.get(&edge)?.get(n as usize)?;
                Some(Pair {
                    left: c.walls[0],
                    right: c.walls[1],
                })
            }
            Port::Spoke { face, node, spoke } => Some(
                self.faces[face as usize]
                    .nodes
                    .get(node as usize)?
                    .spokes
                    .get(spoke as usize)?
                    .pair,
            ),
            Port::Sheet { .. } => self
                .ends
                .iter()
                .flat_map(|e| &e.sheets)
                .find(|s| s.0 == port)
                .map(|s| s.1),
        }
    }

    /// Joins strands to loops.
    pub(super) fn chain(&mut self) {
        let plugged = self.plugged();
        let mut used = vec![false; self.strands.len()];
        for first in 0..self.strands.len() {
            if used[first] {
                continue;
            }
            let mut polygon = Polygon::default();
            let (mut strand, mut side) = (first, 0);
            let closed = loop {
                used[strand] = true;
                let s = &self.strands[strand];
                // Walk the strand from `side` to the other end.
                polygon.corners.push(s.vertices[side]);
                polygon.lines.push(s.line);
                let way: Vec<VertexKey> = if side == 0 {
                    s.between.clone()
                } else {
                    s.between.iter().rev().copied().collect()
                };
                for v in way {
                    polygon.corners.push(v);
                    polygon.lines.push(s.line);
                }
                let others = plugged.at(self.common(s.ports[1 - side]));
                let [p, q] = others else { break false };
                let here = (strand, 1 - side);
                let next = if (p.1, p.2) == here {
                    (q.1, q.2)
                } else {
                    (p.1, p.2)
                };
                if used[next.0] {
                    break next == (first, 0);
                }
                (strand, side) = next;
            };
            if closed {
                self.out.polygons.push(polygon);
            } else {
                let s = &self.strands[strand];
                let v = s.vertices[1 - side];
                self.out.open.push(self.position(v));
            }
        }
    }

    pub(super) fn position(&self, vertex: VertexKey) -> DVec3 {
        match vertex {
            VertexKey::Face(key, n) => (0..4)
                .find(|&f| self.face_keys[f] == key)
                .and_then(|f| self.faces[f].nodes.get(n as usize))
                .map_or(DVec3::NAN, |node| node.at),
            VertexKey::Inner(_, n) => self.out.inner.get(n as usize).map_or(DVec3::NAN, |v| v.at),
            VertexKey::Edge(e, n) => self
                .crossings
                .get(&e)
                .and_then(|l| l.get(n as usize))
                .map_or(DVec3::NAN, |c| c.at),
        }
    }
}
