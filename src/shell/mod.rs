//! The mid-surface as a shell model: what a solver takes.
//!
//! * [`ShellModel`]: nodes with thickness, elements of three or four corners
//!   and of first or second order with a normal at every corner, and named
//!   sets: one for every sheet, seam, border and crease, and for every coping
//!   face of the part that a border ends on.
//! * [`normals`](self): those of the footpoints, averaged over a share of the
//!   thickness within a sheet, never across a seam or a crease.
//! * [`properties`]: thickness classes, and the walls on both sides of a sheet.
//! * [`mass`]: mass, centre of gravity and inertia, beside the part's.
//! * [`placement`]: nodes on a wall instead of the middle.
//!
//! Nodes and elements are numbered as the vertices and triangles of the
//! surface; mid-side nodes follow, in order of their edges.

pub mod mass;
mod names;
mod normals;
pub mod placement;
pub mod properties;
mod sets;
#[cfg(test)]
mod tests;
mod thickness;

use glam::DVec3;
use rustc_hash::FxHashMap;
use serde::Serialize;
use smallvec::SmallVec;

use crate::field::Field;
use crate::mesh::{FaceId, Part};
use crate::surface::edges::Edges;
use crate::surface::{MidSurface, MidVertex};
pub use properties::{SheetProperty, ThicknessClass};
pub use sets::{LineSet, SetKind, coping_patches};

/// Default of [`ShellSettings::normal_reach`]: wide enough that no triangle
/// turns inside out on raw meshes, narrow against the bend of a thin wall.
pub const NORMAL_REACH: f64 = 0.75;

/// Default of [`ShellSettings::thickness_tolerance`].
pub const THICKNESS_TOLERANCE: f64 = 0.05;

/// Order of the elements: the degree of the lines along their sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize)]
pub enum Order {
    /// Nodes at the corners.
    #[default]
    Linear,
    /// Nodes at the middle of the sides too.
    Quadratic,
}

/// Which length is a node's thickness.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ThicknessFrom {
    /// The diameter of the ball that touches the walls.
    ///
    /// Equal to the other between two walls; at a seam or bend it gives the
    /// corner block some of its stiffness back, and comes closer to the solid.
    /// What it has more than the wall there is fitted to the elements' size.
    #[default]
    Ball,
    /// The largest distance between two footpoints.
    Footpoints,
}

/// How a model is made.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ShellSettings {
    /// Order of the elements.
    pub order: Order,
    /// Which length is a node's thickness.
    pub thickness: ThicknessFrom,
    /// Radius within which normals are averaged, in thicknesses; 0 for those
    /// of the footpoints alone.
    pub normal_reach: f64,
    /// Sheets whose median thickness differs by at most this share are of one
    /// class.
    pub thickness_tolerance: f64,
}

impl Default for ShellSettings {
    fn default() -> ShellSettings {
        ShellSettings {
            order: Order::Linear,
            thickness: ThicknessFrom::Ball,
            normal_reach: NORMAL_REACH,
            thickness_tolerance: THICKNESS_TOLERANCE,
        }
    }
}

/// What a remesher adds to a surface of triangles.
#[derive(Clone, Debug, Default)]
pub struct Faces {
    /// Pairs of neighbouring triangles of one sheet, each to become a
    /// quadrilateral without the edge between them; each triangle once at
    /// most.
    pub quads: Vec<[u32; 2]>,
    /// Middles of sides, low vertex first, where they are not the chord's.
    pub middles: FxHashMap<[u32; 2], DVec3>,
}

/// A node.
#[derive(Clone, Debug, PartialEq)]
pub struct ShellNode {
    /// Where, part units.
    pub position: DVec3,
    /// Thickness of the wall, part units.
    pub thickness: f64,
    /// The wall points on both sides, where there are exactly two: on the side
    /// against the normal first.
    pub feet: Option<[DVec3; 2]>,
}

/// An element.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShellElement {
    /// Corners in order, then the middles of the sides from the first corner
    /// on: 3, 6, 4 or 8.
    pub nodes: SmallVec<[u32; 8]>,
    /// Places in [`ShellModel::normals`], one for each node.
    pub normals: SmallVec<[u32; 8]>,
    /// Sheet that holds it.
    pub sheet: u32,
}

impl ShellElement {
    /// Number of corners, 3 or 4.
    pub fn sides(&self) -> usize {
        match self.nodes.len() {
            3 | 6 => 3,
            _ => 4,
        }
    }

    /// Its corners without the middles.
    pub fn corners(&self) -> &[u32] {
        &self.nodes[..self.sides()]
    }
}

/// The mid-surface as nodes, elements and sets.
#[derive(Clone, Debug, Default)]
pub struct ShellModel {
    /// Nodes.
    pub nodes: Vec<ShellNode>,
    /// Elements, in the order of the triangles.
    pub elements: Vec<ShellElement>,
    /// Unit normals, each for all corners at a node that share it.
    pub normals: Vec<DVec3>,
    /// What is known of each sheet.
    pub sheets: Vec<SheetProperty>,
    /// Classes of sheets by thickness, thin ones first.
    pub classes: Vec<ThicknessClass>,
    /// Seams, borders, creases, coping faces.
    pub lines: Vec<LineSet>,
    /// Where the nodes lie between the walls: 0.5 in the middle.
    pub placement: f64,
    /// Elements that lean more than [`LEANING`] from one of their normals: a
    /// solver may find them inside out.
    pub leaning: Vec<u32>,
    /// Nodes whose thickness is not known and was taken from their neighbours.
    pub guessed: usize,
}

/// Angle between an element and its normals, degrees, beyond which a solver
/// may turn it inside out.
pub const LEANING: f64 = 75.0;

impl ShellModel {
    /// The model of a surface.
    pub fn of(surface: &MidSurface, faces: &Faces, settings: &ShellSettings) -> ShellModel {
        let corners: Vec<[u32; 3]> = surface.triangles().iter().map(|t| t.corners).collect();
        let edges = Edges::new(&corners);
        let corner_normals =
            normals::CornerNormals::of(surface, &edges, 2.0 * settings.normal_reach);
        let length = |v: &MidVertex| match settings.thickness {
            ThicknessFrom::Ball => 2.0 * v.ball.radius,
            ThicknessFrom::Footpoints => v.ball.thickness,
        };
        let mut nodes: Vec<ShellNode> = (surface.vertices().iter())
            .map(|v| ShellNode {
                position: v.position,
                thickness: length(v),
                feet: None,
            })
            .collect();
        let mut elements = elements(surface, faces, &corner_normals);
        let mut normals = corner_normals.normals;
        orient_feet(surface, &elements, &normals, &mut nodes);
        let guessed = thickness::fill(&elements, &mut nodes);
        if settings.thickness == ThicknessFrom::Ball {
            thickness::fit(surface, &elements, &mut nodes);
        }
        let mut middles = FxHashMap::default();
        if settings.order == Order::Quadratic {
            middles = add_middles(&mut nodes, &mut elements, &mut normals, &faces.middles);
        }
        let lines = sets::lines(surface, &middles);
        let leaning = leaning(&nodes, &elements, &normals);
        let (sheets, classes) = properties::of(surface, &length, settings.thickness_tolerance);
        ShellModel {
            nodes,
            elements,
            normals,
            sheets,
            classes,
            lines,
            placement: 0.5,
            leaning,
            guessed,
        }
    }

    /// Adds a set for every coping face of the part on which a border ends, and
    /// names the walls on both sides of every sheet, as `coping` and `wall` tell
    /// the names of the part's triangles.
    pub fn name_faces(
        &mut self,
        part: &Part,
        coping: &dyn Fn(FaceId) -> String,
        wall: &(dyn Fn(FaceId) -> Option<String> + Sync),
    ) {
        let field = Field::new(part);
        self.name_copings(&field, coping);
        self.name_walls(&field, wall);
    }

    /// Numbers of the elements of each sheet, ascending.
    pub fn by_sheet(&self) -> Vec<Vec<usize>> {
        let mut of = vec![Vec::new(); self.sheets.len()];
        for (e, element) in self.elements.iter().enumerate() {
            of[element.sheet as usize].push(e);
        }
        of
    }

    /// Positions of an element's corners.
    pub fn corners(&self, element: &ShellElement) -> SmallVec<[DVec3; 4]> {
        let at = |&n: &u32| self.nodes[n as usize].position;
        element.corners().iter().map(at).collect()
    }
}

/// Elements of first order: quads where the remesher paired triangles, placed
/// where the first of the two stood; the other triangles as they are.
fn elements(
    surface: &MidSurface,
    faces: &Faces,
    normals: &normals::CornerNormals,
) -> Vec<ShellElement> {
    const ALONE: u32 = u32::MAX;
    let triangles = surface.triangles();
    let mut partner = vec![ALONE; triangles.len()];
    for &[a, b] in &faces.quads {
        partner[a as usize] = b;
        partner[b as usize] = a;
    }
    let corner = |t: usize, k: usize| (triangles[t].corners[k % 3], normals.of[t][k % 3]);
    let mut out = Vec::with_capacity(triangles.len());
    for (t, triangle) in triangles.iter().enumerate() {
        let other = partner[t];
        if other != ALONE && (other as usize) < t {
            continue;
        }
        let mut found: SmallVec<[(u32, u32); 4]> = (0..3).map(|k| corner(t, k)).collect();
        if other != ALONE {
            // The corner of the other triangle goes between the two shared.
            let far = (0..3).find(|&k| {
                let v = triangles[other as usize].corners[k];
                !triangle.corners.contains(&v)
            });
            let first = (0..3).find(|&k| {
                let side = [triangle.corners[k], triangle.corners[(k + 1) % 3]];
                let shared = |v: &u32| triangles[other as usize].corners.contains(v);
                side.iter().all(shared)
            });
            if let (Some(far), Some(first)) = (far, first) {
                found.insert(first + 1, corner(other as usize, far));
            }
        }
        out.push(ShellElement {
            nodes: found.iter().map(|c| c.0).collect(),
            normals: found.iter().map(|c| c.1).collect(),
            sheet: triangle.sheet,
        });
    }
    out
}

/// Gives nodes with two footpoints their feet, the one against the normal
/// first.
fn orient_feet(
    surface: &MidSurface,
    elements: &[ShellElement],
    normals: &[DVec3],
    nodes: &mut [ShellNode],
) {
    for element in elements {
        for (&node, &normal) in element.nodes.iter().zip(&element.normals) {
            let vertex = &surface.vertices()[node as usize];
            let (&[a, b], None) = (&vertex.ball.footpoints[..], nodes[node as usize].feet) else {
                continue;
            };
            let ahead = (b - a).dot(normals[normal as usize]) >= 0.0;
            nodes[node as usize].feet = Some(if ahead { [a, b] } else { [b, a] });
        }
    }
}

/// Adds nodes at the middle of the sides; where they are, by edge.
fn add_middles(
    nodes: &mut Vec<ShellNode>,
    elements: &mut [ShellElement],
    normals: &mut Vec<DVec3>,
    given: &FxHashMap<[u32; 2], DVec3>,
) -> FxHashMap<[u32; 2], u32> {
    let side = |e: &ShellElement, k: usize| {
        let (a, b) = (e.nodes[k], e.nodes[(k + 1) % e.sides()]);
        [a.min(b), a.max(b)]
    };
    let mut sides: Vec<[u32; 2]> = (elements.iter())
        .flat_map(|e| (0..e.sides()).map(move |k| side(e, k)))
        .collect();
    sides.sort_unstable();
    sides.dedup();
    let mut middles = FxHashMap::default();
    for ends in sides {
        let [a, b] = ends.map(|n| &nodes[n as usize]);
        let middle = ShellNode {
            position: (given.get(&ends).copied())
                .unwrap_or_else(|| a.position.midpoint(b.position)),
            thickness: 0.5 * (a.thickness + b.thickness),
            feet: match (a.feet, b.feet) {
                (Some(a), Some(b)) => Some([a[0].midpoint(b[0]), a[1].midpoint(b[1])]),
                _ => None,
            },
        };
        middles.insert(ends, nodes.len() as u32);
        nodes.push(middle);
    }
    let mut normal_of: FxHashMap<[u32; 2], u32> = FxHashMap::default();
    for element in elements {
        let count = element.sides();
        let sides: SmallVec<[[u32; 2]; 4]> = (0..count).map(|k| side(element, k)).collect();
        for (k, ends) in sides.iter().enumerate() {
            let (a, b) = (element.normals[k], element.normals[(k + 1) % count]);
            let normal = *normal_of.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                let [a, b] = [a, b].map(|n| normals[n as usize]);
                normals.push((a + b).try_normalize().unwrap_or(a));
                normals.len() as u32 - 1
            });
            element.nodes.extend(middles.get(ends).copied());
            element.normals.push(normal);
        }
    }
    middles
}

fn leaning(nodes: &[ShellNode], elements: &[ShellElement], normals: &[DVec3]) -> Vec<u32> {
    let least = LEANING.to_radians().cos();
    let leans = |e: &ShellElement| {
        let at = |k: usize| nodes[e.nodes[k] as usize].position;
        let last = e.sides() - 1;
        // Diagonals of a quad, two sides of a triangle.
        let up = (at(2) - at(0)).cross(at(last) - at(1));
        let up = if last == 2 {
            (at(1) - at(0)).cross(at(2) - at(0))
        } else {
            up
        };
        let cosine = |n: &u32| up.dot(normals[*n as usize]);
        !e.normals.iter().all(|n| cosine(n) >= least * up.length())
    };
    (0..elements.len() as u32)
        .filter(|&e| leans(&elements[e as usize]))
        .collect()
}
