//! Element meshes of solvers and meshers, as surfaces: shell elements as they are,
//! of solid elements the skin.

use glam::DVec3;
use rustc_hash::FxHashMap;
use smallvec::SmallVec;

use super::loaded::{FacetPlaces, RawMesh};
use super::polygon::FacetSink;
use crate::io::error::{Located, Place, Problem};
use crate::io::names::NamesBuilder;

/// Corners of an element's face, in order around it.
type Face = SmallVec<[u32; 4]>;

/// Shape of an element; midside nodes of second-order elements follow the corners
/// and are not used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    Triangle,
    Quad,
    Tetrahedron,
    Pyramid,
    Prism,
    Hexahedron,
}

impl Shape {
    /// Number of corners.
    pub(super) fn corners(self) -> usize {
        match self {
            Shape::Triangle => 3,
            Shape::Quad | Shape::Tetrahedron => 4,
            Shape::Pyramid => 5,
            Shape::Prism => 6,
            Shape::Hexahedron => 8,
        }
    }

    /// Faces of a solid by its corners, seen from outside counter-clockwise, with
    /// corners numbered as Gmsh, Abaqus and Nastran do; none of a shell.
    fn faces(self) -> &'static [&'static [usize]] {
        match self {
            Shape::Triangle | Shape::Quad => &[],
            Shape::Tetrahedron => &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[0, 3, 2]],
            Shape::Pyramid => &[
                &[0, 3, 2, 1],
                &[0, 1, 4],
                &[1, 2, 4],
                &[2, 3, 4],
                &[3, 0, 4],
            ],
            Shape::Prism => &[
                &[0, 2, 1],
                &[3, 4, 5],
                &[0, 1, 4, 3],
                &[1, 2, 5, 4],
                &[2, 0, 3, 5],
            ],
            Shape::Hexahedron => &[
                &[0, 3, 2, 1],
                &[4, 5, 6, 7],
                &[0, 1, 5, 4],
                &[1, 2, 6, 5],
                &[2, 3, 7, 6],
                &[3, 0, 4, 7],
            ],
        }
    }
}

/// Names of an element.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct ElementNames {
    /// Sets and entities that it belongs to.
    pub(super) groups: Vec<String>,
    /// Solid or part that it belongs to.
    pub(super) object: Option<String>,
}

struct Element {
    shape: Shape,
    corners: SmallVec<[u32; 8]>,
    names: u32,
    place: Place,
}

/// Nodes and elements as a file states them.
#[derive(Default)]
pub(super) struct Elements {
    positions: Vec<DVec3>,
    node_of: FxHashMap<u64, u32>,
    names: Vec<ElementNames>,
    elements: Vec<Element>,
    /// Sum and number of the thicknesses given for a node.
    thickness: FxHashMap<u32, (f64, u32)>,
}

impl Elements {
    /// A node by its number; a number given twice keeps the later place.
    pub(super) fn node(&mut self, number: u64, at: DVec3) {
        let next = self.positions.len() as u32;
        let index = *self.node_of.entry(number).or_insert(next);
        if index == next {
            self.positions.push(at);
        } else {
            self.positions[index as usize] = at;
        }
    }

    /// The thickness of a shell at a node that is there; of several, as of the
    /// elements at a seam, the mean counts.
    pub(super) fn thickness(&mut self, number: u64, thickness: f64) {
        if let Some(&node) = self.node_of.get(&number) {
            let (sum, count) = self.thickness.entry(node).or_default();
            *sum += thickness;
            *count += 1;
        }
    }

    /// Thickness of all nodes; none unless each corner of an element has one. A
    /// node inside a side needs none.
    fn thicknesses(&self) -> Vec<f64> {
        let known = |v: u32| {
            self.thickness
                .get(&v)
                .map(|(sum, count)| sum / f64::from(*count))
        };
        let mut corners = self.elements.iter().flat_map(|e| &e.corners);
        if self.thickness.is_empty() || corners.any(|&v| known(v).is_none()) {
            return Vec::new();
        }
        let all = 0..self.positions.len() as u32;
        all.map(|v| known(v).unwrap_or(0.0)).collect()
    }

    /// Names for elements to come; gives their number.
    pub(super) fn names(&mut self, names: ElementNames) -> u32 {
        match self.names.last() {
            Some(last) if *last == names => self.names.len() as u32 - 1,
            _ => {
                self.names.push(names);
                self.names.len() as u32 - 1
            }
        }
    }

    /// An element by the numbers of its nodes, of which the corners come first.
    pub(super) fn element(
        &mut self,
        shape: Shape,
        nodes: &[u64],
        names: u32,
        place: Place,
    ) -> Result<(), Located> {
        if nodes.len() < shape.corners() {
            let corners = nodes.len();
            return Err((place, Problem::FewCorners { corners }));
        }
        let corners = nodes[..shape.corners()].iter().map(|number| {
            self.node_of.get(number).copied().ok_or_else(|| {
                let message = format!("node {number} is not defined");
                (place, Problem::Syntax(message))
            })
        });
        self.elements.push(Element {
            shape,
            corners: corners.collect::<Result<_, Located>>()?,
            names,
            place,
        });
        Ok(())
    }

    /// The surface: if there are solids, their skin, with the names of the shell
    /// elements that lie on it; if not, the shell elements.
    pub(super) fn finish(self) -> Result<RawMesh, Located> {
        let solid = (self.elements.iter()).any(|element| !element.shape.faces().is_empty());
        let facets = if solid { self.skin() } else { self.shells() };
        let mut sink = FacetSink::with_capacity(facets.len());
        let mut builder = NamesBuilder::default();
        let mut lines = Vec::with_capacity(facets.len());
        let mut bytes = Vec::new();
        for (corners, names, place) in facets {
            sink.push(&corners, &self.positions, place)?;
            let names = self.names.get(names as usize).cloned().unwrap_or_default();
            builder.set_groups(names.groups);
            builder.set_object(names.object);
            builder.push_facet();
            match place {
                Place::Line(line) => lines.push(line),
                Place::Byte(byte) => bytes.push(byte),
                Place::Whole => {}
            }
        }
        let places = match bytes.is_empty() {
            true => FacetPlaces::Lines(lines),
            false => FacetPlaces::Bytes(bytes),
        };
        let thickness = match solid {
            true => Vec::new(),
            false => self.thicknesses(),
        };
        let mut raw = sink.finish(self.positions, builder.finish(), places, Vec::new());
        raw.values.thickness = thickness;
        Ok(raw)
    }

    fn shells(&self) -> Vec<(Face, u32, Place)> {
        let shells = self.elements.iter();
        shells
            .map(|e| (e.corners.iter().copied().collect(), e.names, e.place))
            .collect()
    }

    /// Faces of one solid only, in the order of the solids.
    fn skin(&self) -> Vec<(Face, u32, Place)> {
        let key = |face: &Face| {
            let mut key = face.clone();
            key.sort_unstable();
            key
        };
        let mut uses: FxHashMap<Face, (u32, Option<u32>)> = FxHashMap::default();
        for element in &self.elements {
            let faces = element.shape.faces();
            for face in faces {
                let face: Face = face.iter().map(|&k| element.corners[k]).collect();
                uses.entry(key(&face)).or_default().0 += 1;
            }
            if faces.is_empty() {
                let face: Face = element.corners.iter().copied().collect();
                uses.entry(key(&face)).or_default().1 = Some(element.names);
            }
        }
        let mut skin = Vec::new();
        for element in &self.elements {
            for face in element.shape.faces() {
                let face: Face = face.iter().map(|&k| element.corners[k]).collect();
                if let Some((1, shell)) = uses.get(&key(&face)) {
                    skin.push((face, shell.unwrap_or(element.names), element.place));
                }
            }
        }
        skin
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::{ElementNames, Elements, Shape};
    use crate::io::Place;

    /// Every solid of one element is closed and outward; two that share a face are
    /// one skin.
    #[test]
    fn skins_are_closed_and_outward() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let at = |k: usize, z: f64| DVec3::new(square[k][0], square[k][1], z);
        let cube: Vec<DVec3> = (0..8).map(|k| at(k % 4, (k / 4) as f64)).collect();
        let prism = vec![
            at(0, 0.0),
            at(1, 0.0),
            at(2, 0.0),
            at(0, 1.0),
            at(1, 1.0),
            at(2, 1.0),
        ];
        let top = DVec3::new(0.5, 0.5, 1.0);
        let pyramid = vec![at(0, 0.0), at(1, 0.0), at(2, 0.0), at(3, 0.0), top];
        let tet = vec![at(0, 0.0), at(1, 0.0), at(2, 0.0), top];
        for (shape, nodes, volume) in [
            (Shape::Hexahedron, cube, 1.0),
            (Shape::Prism, prism, 0.5),
            (Shape::Pyramid, pyramid, 1.0 / 3.0),
            (Shape::Tetrahedron, tet, 1.0 / 6.0),
        ] {
            let mut elements = Elements::default();
            for (n, &at) in nodes.iter().enumerate() {
                elements.node(n as u64 + 10, at);
            }
            let numbers: Vec<u64> = (0..nodes.len() as u64).map(|n| n + 10).collect();
            elements
                .element(shape, &numbers, 0, Place::Line(1))
                .unwrap();
            let mesh = elements.finish().unwrap().mesh;
            assert!(mesh.edges().census().is_closed(), "{shape:?}");
            assert!((mesh.volume() - volume).abs() < 1e-12, "{shape:?}");
        }
    }

    #[test]
    fn inner_faces_go_and_names_of_shells_come() {
        let mut elements = Elements::default();
        for (n, at) in [
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [1.0; 3],
        ]
        .into_iter()
        .enumerate()
        {
            elements.node(n as u64, DVec3::from(at));
        }
        let body = elements.names(ElementNames::default());
        let named = elements.names(ElementNames {
            groups: vec!["rim".to_owned()],
            object: None,
        });
        elements
            .element(Shape::Tetrahedron, &[0, 1, 2, 3], body, Place::Line(1))
            .unwrap();
        elements
            .element(Shape::Tetrahedron, &[1, 4, 2, 3], body, Place::Line(2))
            .unwrap();
        elements
            .element(Shape::Triangle, &[0, 1, 2], named, Place::Line(3))
            .unwrap();
        let raw = elements.finish().unwrap();
        assert_eq!(raw.mesh.triangles.len(), 6);
        assert!(raw.mesh.edges().census().is_closed());
        let named = (0..6)
            .filter(|&f| raw.names.of(f).groups == ["rim"])
            .count();
        assert_eq!(named, 1);
    }

    #[test]
    fn nodes_must_be_defined() {
        let mut elements = Elements::default();
        elements.node(1, DVec3::ZERO);
        assert!(
            elements
                .element(Shape::Triangle, &[1, 2, 3], 0, Place::Whole)
                .is_err()
        );
        assert!(
            elements
                .element(Shape::Triangle, &[1, 1], 0, Place::Whole)
                .is_err()
        );
    }
}
