//! The result in words and figures.

use std::fmt::Write;

use glam::DVec3;
use serde::Serialize;

use super::graph::{Counts, SeamEnd, SheetData, SheetGraph, Span};
use super::quality::Quality;
use super::{BorderKind, MidSurface};

/// Decimals of coordinates.
const DECIMALS: i32 = 4;

/// Significant digits of lengths, areas and angles.
const DIGITS: i32 = 5;

/// Places closer than this share of the surface's extent sort as one.
const SORT_GRID: f64 = 1e-4;

/// Figures of the result, for the report.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Counts.
    pub counts: Counts,
    /// Area of all sheets, square part units.
    pub area: f64,
    /// Length of all seams, part units.
    pub seam_length: f64,
    /// Length of the borders at coping faces.
    pub coping_border_length: f64,
    /// Length of the borders where the object angle fades.
    pub fading_border_length: f64,
    /// Thickness at all vertices, part units.
    pub thickness: Span,
    /// Shape of the triangles.
    pub quality: Quality,
    /// Sheets, by number.
    pub sheets: Vec<SheetData>,
}

/// Figures of the result.
pub fn summary(surface: &MidSurface, graph: &SheetGraph) -> Summary {
    let border_length = |kind| {
        (surface.borders().iter().zip(graph.borders()))
            .filter(|(line, _)| line.kind == kind)
            .map(|(_, data)| data.length)
            .sum()
    };
    Summary {
        counts: *graph.counts(),
        area: graph.area(),
        seam_length: graph.seams().iter().map(|s| s.length).sum(),
        coping_border_length: border_length(BorderKind::Coping),
        fading_border_length: border_length(BorderKind::Fading),
        thickness: Span::of(surface.vertices().iter().map(|v| v.ball.thickness)),
        quality: Quality::of(surface),
        sheets: graph.sheets().to_vec(),
    }
}

/// The sheets, seams, borders and junctions as text.
///
/// Sorted by place, not by number, and rounded, so that the text stays the
/// same when vertices, triangles or sheets are numbered otherwise. Sheets are
/// called by letters in that order. `surface` and `graph` are of one build.
pub fn listing(surface: &MidSurface, graph: &SheetGraph) -> String {
    let places = Places::new(surface);
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write(surface, graph, &places, &mut text);
    text
}

fn write(
    surface: &MidSurface,
    graph: &SheetGraph,
    places: &Places,
    out: &mut String,
) -> std::fmt::Result {
    let counts = graph.counts();
    writeln!(
        out,
        "{}, {}, {}; area {}, Euler characteristic {}, {}, boundary in {}",
        plural(counts.sheets, "sheet"),
        plural(counts.seams, "seam"),
        plural(counts.junctions, "junction"),
        rounded(graph.area()),
        counts.euler,
        plural(counts.components, "component"),
        plural(counts.boundary_components, "piece"),
    )?;
    for &sheet in &places.order {
        let data = &graph.sheets()[sheet as usize];
        writeln!(
            out,
            "sheet {}: area {}, Euler {}, {}, thickness {}, median angle {}{}",
            places.name(sheet),
            rounded(data.area),
            data.euler,
            plural(data.boundary_loops, "loop"),
            range(data.thickness),
            rounded(data.angle.median),
            if data.orientable { "" } else { ", one-sided" },
        )?;
    }
    write_sorted(out, seam_lines(surface, graph, places))?;
    write_sorted(out, border_lines(surface, graph, places))?;
    let junctions = (surface.junctions().iter()).map(|&v| {
        let at = surface.vertices()[v as usize].position;
        (sort_key(at, places.grid), format!("junction {}", place(at)))
    });
    write_sorted(out, junctions.collect())?;
    for (count, what) in [
        (counts.cracks, "crack edge"),
        (counts.irregular_edges, "unmarked seam edge"),
        (counts.pinches, "pinch"),
        (counts.non_orientable_sheets, "one-sided sheet"),
        (counts.degenerate_triangles, "degenerate triangle"),
        (counts.lone_feet, "vertex without a second footpoint"),
    ] {
        if count > 0 {
            writeln!(out, "problem: {count} x {what}")?;
        }
    }
    Ok(())
}

type Key = [i64; 3];

fn write_sorted(out: &mut String, mut lines: Vec<(Key, String)>) -> std::fmt::Result {
    lines.sort();
    lines
        .iter()
        .try_for_each(|(_, line)| writeln!(out, "{line}"))
}

fn seam_lines(surface: &MidSurface, graph: &SheetGraph, places: &Places) -> Vec<(Key, String)> {
    let line = |(n, seam): (usize, &super::Seam)| {
        let data = &graph.seams()[n];
        let at = |v: u32| surface.vertices()[v as usize].position;
        let mut sheets: Vec<String> = seam.sheets.iter().map(|&s| places.name(s)).collect();
        sheets.sort_by_key(|name| (name.len(), name.clone()));
        let mut ends = Vec::new();
        if let (Some(kinds), Some(&first), Some(&last)) =
            (data.ends, seam.path.first(), seam.path.last())
        {
            for (v, kind) in [(first, kinds[0]), (last, kinds[1])] {
                let text = format!("{} {}", place(at(v)), end_name(kind));
                ends.push((sort_key(at(v), places.grid), text));
            }
        }
        ends.sort();
        let key = match ends.first() {
            Some(end) => end.0,
            None => lowest_key(&seam.path, surface, places.grid),
        };
        let course = match ends.as_slice() {
            [a, b] => format!("from {} to {}", a.1, b.1),
            _ => "closed".to_owned(),
        };
        let text = format!(
            "seam of {} ({}): length {}, {course}{}",
            sheets.len(),
            sheets.join(" "),
            rounded(data.length),
            if seam.unmarked > 0 {
                ", not followed"
            } else {
                ""
            },
        );
        (key, text)
    };
    surface.seams().iter().enumerate().map(line).collect()
}

fn border_lines(surface: &MidSurface, graph: &SheetGraph, places: &Places) -> Vec<(Key, String)> {
    let line = |(n, border): (usize, &super::Border)| {
        let kind = match border.kind {
            BorderKind::Coping => "coping",
            BorderKind::Fading => "fading",
        };
        let at = |v: u32| surface.vertices()[v as usize].position;
        let mut ends = match (border.closed, border.path.as_slice()) {
            (false, &[first, .., last]) => {
                vec![first, last]
            }
            _ => Vec::new(),
        };
        ends.sort_by_key(|&v| sort_key(at(v), places.grid));
        let course = match *ends {
            [a, b] => format!("from {} to {}", place(at(a)), place(at(b))),
            _ => "closed".to_owned(),
        };
        let text = format!(
            "{kind} border of {}: length {}, {course}",
            places.name(border.sheet),
            rounded(graph.borders()[n].length),
        );
        let key = match ends.first() {
            Some(&v) => sort_key(at(v), places.grid),
            None => lowest_key(&border.path, surface, places.grid),
        };
        (key, text)
    };
    surface.borders().iter().enumerate().map(line).collect()
}

fn end_name(end: SeamEnd) -> &'static str {
    match end {
        SeamEnd::Coping => "on coping",
        SeamEnd::Junction => "at a junction",
        SeamEnd::Fading => "on a fading border",
        SeamEnd::Crack => "at a crack",
    }
}

/// Sheets in order of place.
struct Places {
    /// Sheet numbers, sorted by the sheets' centroids, then by area.
    order: Vec<u32>,
    /// Place in `order` by sheet number.
    rank: Vec<usize>,
    grid: f64,
}

impl Places {
    fn new(surface: &MidSurface) -> Places {
        let positions = || surface.vertices().iter().map(|v| v.position);
        let low = positions().reduce(DVec3::min).unwrap_or_default();
        let high = positions().reduce(DVec3::max).unwrap_or_default();
        let extent = (high - low).max_element();
        let grid = if extent > 0.0 {
            SORT_GRID * extent
        } else {
            1.0
        };
        let mut sums = vec![(DVec3::ZERO, 0.0); surface.sheet_count() as usize];
        for t in surface.triangles() {
            let [a, b, c] = t.corners.map(|v| surface.vertices()[v as usize].position);
            let area = 0.5 * (b - a).cross(c - a).length();
            let sum = &mut sums[t.sheet as usize];
            sum.0 += area / 3.0 * (a + b + c);
            sum.1 += area;
        }
        let mut order: Vec<u32> = (0..surface.sheet_count()).collect();
        order.sort_by_cached_key(|&s| {
            let (sum, area) = sums[s as usize];
            let centre = if area > 0.0 { sum / area } else { DVec3::ZERO };
            (
                sort_key(centre, grid),
                (area / (grid * grid)).round() as i64,
            )
        });
        let mut rank = vec![0; order.len()];
        for (n, &s) in order.iter().enumerate() {
            rank[s as usize] = n;
        }
        Places { order, rank, grid }
    }

    /// A to Z, then A1 to Z1 and so on.
    fn name(&self, sheet: u32) -> String {
        let n = self.rank[sheet as usize];
        let letter = char::from(b'A' + (n % 26) as u8);
        match n / 26 {
            0 => letter.to_string(),
            round => format!("{letter}{round}"),
        }
    }
}

fn sort_key(at: DVec3, grid: f64) -> Key {
    (at / grid).to_array().map(|x| x.round() as i64)
}

fn lowest_key(path: &[u32], surface: &MidSurface, grid: f64) -> Key {
    let keys = path
        .iter()
        .map(|&v| sort_key(surface.vertices()[v as usize].position, grid));
    keys.min().unwrap_or_default()
}

fn plural(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// A point with rounded coordinates.
fn place(at: DVec3) -> String {
    let scale = 10f64.powi(DECIMALS);
    // Adding zero turns -0 into 0.
    let [x, y, z] = at.to_array().map(|c| (c * scale).round() / scale + 0.0);
    format!("({x}, {y}, {z})")
}

/// A figure with a few significant digits.
fn rounded(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return format!("{x}");
    }
    let digits = (DIGITS - 1 - x.abs().log10().floor() as i32).clamp(0, 12);
    let text = format!("{x:.*}", digits as usize);
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

fn range(span: Span) -> String {
    let (low, high) = (rounded(span.min), rounded(span.max));
    if low == high {
        low
    } else {
        format!("{low} to {high}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Field;
    use crate::reshape::clean::clean;
    use crate::surface::marked::Line;
    use crate::surface::shapes::{book, built, marked, no_field, part, raw};

    fn of_part(name: &str, cell: f64) -> (MidSurface, SheetGraph) {
        let part = part(name);
        let field = Field::new(&part);
        built(&clean(raw(&part, &field, cell), cell), &field)
    }

    #[test]
    fn a_cross_is_listed_alike_at_any_cell() {
        let text = |cell| {
            let (surface, graph) = of_part("cross", cell);
            listing(&surface, &graph)
        };
        // Sheets of straight walls are flat: nothing depends on the cell.
        assert_eq!(text(2.0), text(6.0));
        insta::assert_snapshot!(text(2.0));
    }

    #[test]
    fn a_book_is_listed_with_its_problems() {
        let (surface, graph) = built(&book(3, 1, 2), &no_field());
        insta::assert_snapshot!(listing(&surface, &graph));
    }

    #[test]
    fn a_summary_adds_up() {
        let (surface, graph) = of_part("plate", 3.0);
        let summary = summary(&surface, &graph);
        assert!((summary.area - 2400.0).abs() < 1e-6);
        assert!((summary.coping_border_length - 200.0).abs() < 1e-6);
        assert_eq!(summary.fading_border_length, 0.0);
        assert_eq!(summary.sheets.len(), 1);
        assert!(summary.quality.least <= summary.quality.percentile_1);
        assert!(serde_json::to_string(&summary).is_ok());
    }

    #[test]
    fn figures_are_rounded_to_their_size() {
        for (x, text) in [
            (0.0, "0"),
            (2.0, "2"),
            (1999.99996, "2000"),
            (123456.7, "123457"),
            (0.000123456, "0.00012346"),
            (2.345678, "2.3457"),
        ] {
            assert_eq!(rounded(x), text);
        }
        assert_eq!(place(DVec3::new(-1e-9, 0.5, 1.00004)), "(0, 0.5, 1)");
    }

    #[test]
    fn quality_of_known_triangles() {
        let surface = built(&marked(book(3, 1, 1), Line::CopingBorder), &no_field()).0;
        let quality = Quality::of(&surface);
        assert!((quality.least - 45.0).abs() < 1e-9 && quality.share_below_5 == 0.0);
    }
}
