//! The report of an extraction: as JSON, and as a summary for people.

use std::path::PathBuf;

use midsurf::extract::{Extraction, Work};
use midsurf::intake::Input;
use midsurf::report::detection;
use midsurf::report::extraction::{account, warnings};
use midsurf::report::words::place;
use midsurf::settings::memory::{Bytes, peak};
use midsurf::settings::quote::figure;
use midsurf::settings::warning::Warning;
use serde::Serialize;
use serde_json::{Value, json};

use super::extract_args::Args;
use crate::cli::shared::figures::Figures;
use crate::cli::shared::report::{Envelope, named};

/// Cracks that the report states with their place; all are counted.
const CRACKS_SHOWN: usize = 1000;

/// Wall-clock seconds that the command itself measured.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Seconds {
    /// Reading and checking the input.
    pub(crate) read: f64,
    /// Writing the output files.
    pub(crate) write: f64,
    /// All up to the report.
    pub(crate) total: f64,
}

impl Seconds {
    /// Seconds of the extraction's stages.
    pub(crate) fn of_work(work: &Work) -> f64 {
        work.field_seconds + work.trace_seconds + work.mesh_seconds + work.remesh_seconds
    }
}

/// What is worth telling of an extraction.
pub(crate) struct Report {
    figures: Figures,
    seconds: Seconds,
    peak: Option<Bytes>,
    /// Those of the result; the input has its own.
    pub(crate) warnings: Vec<Warning>,
}

impl Report {
    pub(crate) fn new(input: &Input, result: &Extraction, seconds: Seconds) -> Report {
        Report {
            figures: Figures::of(&result.surface, &result.graph),
            warnings: warnings(input, result),
            seconds,
            peak: peak(),
        }
    }

    /// The report as JSON.
    pub(crate) fn json(&self, args: &Args, input: &Input, result: &Extraction) -> Value {
        let Extraction { work, graph, .. } = result;
        let cracks = graph.cracks();
        let bounds = input.part.bounds();
        Envelope {
            command: "extract",
            input: json!({
                "part": named(&input.file),
                "unit": input.unit,
                "sha256": input.sha256,
                "geometry": input.geometry,
                "coping": args.coping,
                "triangles": input.part.triangle_count(),
                "coping_triangles": input.part.coping_count(),
                "closed": input.part.is_closed(),
                "volume": input.part.volume(),
                "area": input.part.area(),
                "min": bounds.min,
                "max": bounds.max,
                "coping_rules": input.rules.len(),
            }),
            settings: args.reading.beside(
                Some(&args.select),
                json!({
                    "cell": args.cell,
                    "cell_length": work.cell,
                    "angle": args.angle,
                    "keep_fins": args.keep_fins,
                    "elements": args.elements.settings(),
                    "memory_limit": args.memory.memory_limit,
                    "allow_open": args.allow_open,
                    "obj_lines": args.obj_lines,
                }),
            ),
            seconds: json!({
                "read": self.seconds.read,
                "field": work.field_seconds,
                "trace": work.trace_seconds,
                "mesh": work.mesh_seconds,
                "remesh": work.remesh_seconds,
                "write": self.seconds.write,
                "total": self.seconds.total,
            }),
            outputs: args.output.iter().map(PathBuf::as_path).collect(),
            warnings: input.warnings.iter().chain(&self.warnings).collect(),
        }
        .around(json!({
            "coping": input.detection.as_ref().map(detection::account),
            "result": account(&result.surface, graph),
            "cracks": cracks.len(),
            "crack_places": &cracks[..cracks.len().min(CRACKS_SHOWN)],
            "closed_over": result.closed_over,
            "work": {
                "cells": work.counts.cells,
                "tetrahedra": work.counts.tetrahedra,
                "faces": work.counts.faces,
                "edges": work.counts.edges,
                "queries": work.counts.queries,
                "queries_per_edge": work.counts.queries_per_edge,
                "lost": work.counts.lost,
                "matched": work.counts.matched,
                "torn": work.counts.torn,
                "unsettled": work.counts.unsettled,
                "remeshing": work.edits,
            },
        }))
    }

    /// The report in lines for stderr.
    pub(crate) fn summary(&self, result: &Extraction, verbose: u8) -> Vec<String> {
        let Extraction { work, graph, .. } = result;
        let mut lines = self.figures.lines(graph);
        lines.push(format!(
            "cell         {}, {} active",
            figure(work.cell),
            work.counts.cells
        ));
        lines.push(format!(
            "queries      {}, {:.2} an edge",
            work.counts.queries, work.counts.queries_per_edge
        ));
        let stages = [
            ("read", self.seconds.read),
            ("field", work.field_seconds),
            ("trace", work.trace_seconds),
            ("mesh", work.mesh_seconds),
            ("remesh", work.remesh_seconds),
            ("write", self.seconds.write),
        ];
        let stages = stages
            .map(|(name, seconds)| format!("{name} {seconds:.3}"))
            .join(", ");
        lines.push(format!("seconds      {:.3}: {stages}", self.seconds.total));
        if let Some(peak) = self.peak {
            lines.push(format!("memory       {peak} at the peak"));
        }
        if verbose > 0 {
            for (number, sheet) in self.figures.summary.sheets.iter().enumerate() {
                let [area, min, max] =
                    [sheet.area, sheet.thickness.min, sheet.thickness.max].map(figure);
                lines.push(format!(
                    "sheet {number:<6} area {area}, thickness {min} to {max}"
                ));
            }
        }
        if verbose > 1 {
            lines.push(format!(
                "lattice      {} tetrahedra, {} faces, {} edges solved",
                work.counts.tetrahedra, work.counts.faces, work.counts.edges
            ));
            for crack in graph.cracks() {
                lines.push(format!(
                    "crack        at {}, {} long",
                    place(crack.at),
                    figure(crack.length)
                ));
            }
        }
        lines
    }
}
