//! Properties of sheets: thickness classes, and the walls on both sides.

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use super::ShellModel;
use crate::field::Field;
use crate::mesh::FaceId;
use crate::surface::graph::Span;
use crate::surface::{MidSurface, MidVertex, VertexKind};

/// What is known of a sheet.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SheetProperty {
    /// Thickness at its vertices, part units; vertices on seams are left out
    /// as long as there are others.
    pub thickness: Span,
    /// Place in [`ShellModel::classes`].
    pub class: u32,
    /// Names of the part's faces on the side against the normal, and on the
    /// side of the normal, those that hold most footpoints first.
    pub walls: [Vec<String>; 2],
}

/// Sheets of one thickness, within a tolerance.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ThicknessClass {
    /// Mean of the sheets' median thickness, weighted by area.
    pub thickness: f64,
    /// Its sheets, ascending.
    pub sheets: Vec<u32>,
    /// Area of its sheets.
    pub area: f64,
}

/// Properties of all sheets, and their classes.
///
/// A class begins with the thinnest sheet that is in none, and takes those
/// that are thicker by at most the share `tolerance`: so the spread within a
/// class is bounded, and the classes do not depend on the order of the sheets.
pub(super) fn of(
    surface: &MidSurface,
    thickness: &dyn Fn(&MidVertex) -> f64,
    tolerance: f64,
) -> (Vec<SheetProperty>, Vec<ThicknessClass>) {
    let count = surface.sheet_count() as usize;
    let mut inner = vec![Vec::new(); count];
    let mut all = vec![Vec::new(); count];
    let mut area = vec![0.0; count];
    for triangle in surface.triangles() {
        let sheet = triangle.sheet as usize;
        let [a, b, c] = triangle.corners.map(|v| surface.position(v));
        area[sheet] += 0.5 * (b - a).cross(c - a).length();
        for v in triangle.corners {
            let vertex = &surface.vertices()[v as usize];
            all[sheet].push(thickness(vertex));
            if !matches!(vertex.kind, VertexKind::Seam | VertexKind::Junction) {
                inner[sheet].push(thickness(vertex));
            }
        }
    }
    let mut sheets: Vec<SheetProperty> = (inner.into_iter().zip(all))
        .map(|(inner, all)| SheetProperty {
            thickness: Span::of(if inner.is_empty() { all } else { inner }),
            ..SheetProperty::default()
        })
        .collect();
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by(|&a, &b| {
        let median = |s: usize| sheets[s].thickness.median;
        median(a).total_cmp(&median(b)).then(a.cmp(&b))
    });
    let mut classes: Vec<ThicknessClass> = Vec::new();
    let mut thinnest = f64::NEG_INFINITY;
    for sheet in order {
        let median = sheets[sheet].thickness.median;
        if classes.is_empty() || median > thinnest * (1.0 + tolerance) {
            thinnest = median;
            classes.push(ThicknessClass::default());
        }
        sheets[sheet].class = classes.len() as u32 - 1;
        if let Some(class) = classes.last_mut() {
            class.sheets.push(sheet as u32);
            class.thickness += area[sheet] * median;
            class.area += area[sheet];
        }
    }
    for class in &mut classes {
        class.sheets.sort_unstable();
        class.thickness /= class.area.max(f64::MIN_POSITIVE);
    }
    (sheets, classes)
}

impl ShellModel {
    /// Names the walls on both sides of every sheet: the part's faces that
    /// hold the footpoints of its nodes, as `name` tells them.
    pub(super) fn name_walls(
        &mut self,
        field: &Field,
        name: &(dyn Fn(FaceId) -> Option<String> + Sync),
    ) {
        let named = |foot: DVec3| name(field.footpoint(foot).face);
        let names: Vec<Option<[Option<String>; 2]>> = (self.nodes.par_iter())
            .map(|node| node.feet.map(|feet| feet.map(named)))
            .collect();
        let mut found: Vec<[Vec<&str>; 2]> = vec![Default::default(); self.sheets.len()];
        for element in &self.elements {
            for &node in element.corners() {
                let Some(both) = &names[node as usize] else {
                    continue;
                };
                for (name, list) in both.iter().zip(&mut found[element.sheet as usize]) {
                    list.extend(name.as_deref());
                }
            }
        }
        for (sheet, both) in self.sheets.iter_mut().zip(found) {
            sheet.walls = both.map(by_frequency);
        }
    }
}

/// Each name once, frequent ones first.
fn by_frequency(mut names: Vec<&str>) -> Vec<String> {
    names.sort_unstable();
    let mut counted: Vec<(usize, &str)> = (names.chunk_by(|a, b| a == b))
        .map(|same| (same.len(), same[0]))
        .collect();
    counted.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(b.1)));
    counted.into_iter().map(|c| c.1.to_owned()).collect()
}
