//! Figures of a mid-surface, as JSON and in lines for people.

use glam::DVec3;
use midsurf::surface::MidSurface;
use midsurf::surface::graph::SheetGraph;
use midsurf::surface::listing::{Summary, summary};
use midsurf::surface::thickness::Thickness;
use serde_json::{Value, json};

use super::numbers::figure;

/// Places that a warning names before the list is cut short.
const PLACES_NAMED: usize = 5;

/// Figures of a mid-surface.
pub(crate) struct Figures {
    pub(crate) summary: Summary,
    pub(crate) thickness: Option<Thickness>,
}

impl Figures {
    pub(crate) fn of(surface: &MidSurface, graph: &SheetGraph) -> Figures {
        Figures {
            summary: summary(surface, graph),
            thickness: Thickness::of(surface),
        }
    }

    /// What a report says of the surface.
    pub(crate) fn json(&self, surface: &MidSurface, graph: &SheetGraph) -> Value {
        let seams = surface.seams().iter().zip(graph.seams());
        let seams = seams.map(|(line, data)| {
            json!({
                "sheets": line.sheets,
                "length": data.length,
                "closed": line.closed,
                "ends": data.ends,
            })
        });
        let borders = surface.borders().iter().zip(graph.borders());
        let borders = borders.map(|(line, data)| {
            json!({
                "sheet": line.sheet,
                "kind": line.kind,
                "length": data.length,
                "closed": line.closed,
            })
        });
        let Summary {
            counts,
            area,
            seam_length,
            coping_border_length,
            fading_border_length,
            quality,
            sheets,
            ..
        } = &self.summary;
        json!({
            "counts": counts,
            "area": area,
            "seam_length": seam_length,
            "coping_border_length": coping_border_length,
            "fading_border_length": fading_border_length,
            "thickness": self.thickness,
            "quality": quality,
            "sheets": sheets,
            "seams": seams.collect::<Vec<Value>>(),
            "borders": borders.collect::<Vec<Value>>(),
        })
    }

    /// The figures in lines.
    pub(crate) fn lines(&self, graph: &SheetGraph) -> Vec<String> {
        let Summary { counts, .. } = &self.summary;
        let mut lines = vec![
            format!(
                "sheets       {}, area {}",
                counts.sheets,
                figure(self.summary.area)
            ),
            format!(
                "seams        {}",
                with_length(counts.seams, self.summary.seam_length)
            ),
            format!("junctions    {}", counts.junctions),
            format!(
                "borders      {} coping, {} fading, in {}",
                with_length(counts.coping_borders, self.summary.coping_border_length),
                with_length(counts.fading_borders, self.summary.fading_border_length),
                counted(counts.boundary_components, "connected piece"),
            ),
            format!("creases      {}", counts.creases),
            format!("cracks       {}", graph.cracks().len()),
        ];
        if let Some(t) = self.thickness {
            let [min, median, max] = [t.min, t.p50, t.max].map(figure);
            lines.push(format!("thickness    {min} to {max}, median {median}"));
        }
        lines.push(format!(
            "mesh         {} vertices, {} triangles, {}, Euler characteristic {}",
            counts.vertices,
            counts.triangles,
            counted(counts.components, "component"),
            counts.euler
        ));
        let angles = self.summary.quality;
        lines.push(format!(
            "angles       smallest {:.1} degrees, 1 % below {:.1}, median {:.1}",
            angles.least, angles.percentile_1, angles.median
        ));
        lines
    }
}

/// The first few of some places.
pub(crate) fn listed(places: impl ExactSizeIterator<Item = DVec3>) -> String {
    let more = if places.len() > PLACES_NAMED {
        " and more"
    } else {
        ""
    };
    let places: Vec<String> = places.take(PLACES_NAMED).map(place).collect();
    format!("{}{more}", places.join(" "))
}

/// A place in brackets.
pub(crate) fn place(p: DVec3) -> String {
    let [x, y, z] = p.to_array().map(figure);
    format!("({x}, {y}, {z})")
}

/// A number with its noun.
pub(crate) fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

fn with_length(count: usize, length: f64) -> String {
    match count {
        0 => "0".to_owned(),
        _ => format!("{count} of length {}", figure(length)),
    }
}
