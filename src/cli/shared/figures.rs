//! Figures of a mid-surface in lines for people.

use midsurf::report::words::counted;
use midsurf::settings::quote::figure;
use midsurf::surface::MidSurface;
use midsurf::surface::graph::SheetGraph;
use midsurf::surface::listing::{Summary, summary};
use midsurf::surface::thickness::Thickness;

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

fn with_length(count: usize, length: f64) -> String {
    match count {
        0 => "0".to_owned(),
        _ => format!("{count} of length {}", figure(length)),
    }
}
