//! What one page works on: a part with its tags, and the last mid-surface.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard};

use miette::Diagnostic;
use serde_json::{Value, json};

use super::{scene, tags};
use crate::coping::detect::Detection;
use crate::extract::{ExtractError, Extraction, Settings, expected_cells, extract_until};
use crate::field::Field;
use crate::io::write::{WriteError, stage};
use crate::mesh::{Part, PartError, PartOptions, TriMesh};
use crate::settings::cell::CellSize;
use crate::settings::progress::{Progress, Stop};
use crate::surface::MidSurface;
use crate::surface::graph::SheetGraph;
use crate::walls::thickness::ThicknessProfile;

/// Samples of the wall thickness that the page shows.
const SAMPLES: usize = 2000;

/// A part to look at.
#[derive(Debug)]
pub struct Subject {
    /// What the page calls it: the file's name.
    pub title: String,
    /// The triangles as read, welded or not.
    pub mesh: TriMesh,
    /// Facet of the file that each triangle comes from, ascending.
    pub source: Vec<u32>,
    /// Checksum for tag files; see [`crate::coping::geometry_checksum`].
    pub geometry: String,
    /// One flag a triangle: true for coping.
    pub coping: Vec<bool>,
    /// Where the flags were detected, what was found: its doubts become questions.
    pub detection: Option<Detection>,
    /// How doubtful meshes are treated.
    pub options: PartOptions,
    /// Where tags are saved: the only file that is ever written.
    pub tag_file: PathBuf,
    /// Whether that file is where the flags come from, so that it may be replaced
    /// unasked.
    pub tags_are_ours: bool,
    /// A mid-surface made before.
    pub surface: Option<MidSurface>,
}

/// What happened to tags that should be saved.
#[derive(Debug)]
pub(super) enum Saved {
    Written,
    /// The file is there and somebody else's.
    Exists,
}

/// The mid-surface that is shown.
#[derive(Debug)]
pub(super) struct Shown {
    pub(super) surface: MidSurface,
    pub(super) pack: Vec<u8>,
}

/// Why nothing came of an extraction, in words.
#[derive(Debug)]
pub(super) struct Failed {
    pub(super) message: String,
    pub(super) help: Option<String>,
}

/// The part, and what the page does to it.
#[derive(Debug)]
pub(super) struct Session {
    subject: Subject,
    saved: Mutex<bool>,
    shown: Mutex<Option<std::sync::Arc<Shown>>>,
    heavy: Mutex<()>,
}

impl Session {
    pub(super) fn new(mut subject: Subject) -> Session {
        let origin = scene::origin(&subject.mesh);
        let shown = subject.surface.take().map(|surface| {
            let graph = SheetGraph::of(&surface);
            let pack = scene::surface(&surface, &graph, origin).finish();
            std::sync::Arc::new(Shown { surface, pack })
        });
        Session {
            saved: Mutex::new(subject.tags_are_ours),
            shown: Mutex::new(shown),
            heavy: Mutex::new(()),
            subject,
        }
    }

    pub(super) fn subject(&self) -> &Subject {
        &self.subject
    }

    /// The mid-surface that is shown now.
    pub(super) fn shown(&self) -> Option<std::sync::Arc<Shown>> {
        lock(&self.shown).clone()
    }

    /// The right to do something heavy; none while somebody has it.
    pub(super) fn heavy(&self) -> Option<MutexGuard<'_, ()>> {
        self.heavy.try_lock().ok()
    }

    fn part(&self, coping: Vec<bool>) -> Result<Part, PartError> {
        let mesh = self.subject.mesh.clone();
        Part::new(mesh, coping, self.subject.options).map(|(part, _)| part)
    }

    /// The part for the page, as it was read.
    pub(super) fn part_pack(&self) -> Vec<u8> {
        let subject = &self.subject;
        let mut pack = scene::part(&subject.mesh, &subject.coping, &subject.source, true);
        pack.fact("title", subject.title.clone());
        pack.fact("tag_file", subject.tag_file.display().to_string());
        pack.fact("tags_are_saved", subject.tags_are_ours);
        if let Some(detection) = &subject.detection {
            let origin = scene::origin(&subject.mesh);
            pack.fact("doubts", scene::doubts(detection, origin));
            pack.fact("verdict", detection.verdict().text());
        }
        pack.finish()
    }

    /// Wall thickness and what an extraction will cost, or why the part cannot be
    /// extracted. Takes a while on large parts, so it is asked for by itself.
    pub(super) fn measure(&self) -> Value {
        match self.part(self.subject.coping.clone()) {
            Ok(part) => {
                let profile = ThicknessProfile::measure(&Field::new(&part), SAMPLES);
                let thickness = profile.percentile(50.0);
                let cells = thickness.map(|t| expected_cells(&part, t, t));
                json!({ "thickness": thickness, "cells_at_thickness": cells })
            }
            Err(error) => {
                let help = error.help().map(|help| help.to_string());
                json!({ "problem": { "message": error.to_string(), "help": help } })
            }
        }
    }

    /// Extracts with the flags given; what comes out is shown from then on.
    pub(super) fn extract(
        &self,
        coping: Vec<bool>,
        cell: CellSize,
        progress: &Progress,
        stop: &Stop,
    ) -> Result<Value, Failed> {
        let part = self.part(coping).map_err(|error| Failed {
            message: error.to_string(),
            help: error.help().map(|help| help.to_string()),
        })?;
        let settings = Settings {
            cell,
            ..Settings::default()
        };
        let result = extract_until(&part, &settings, progress, stop)?;
        if result.surface.triangles().is_empty() {
            return Err(Failed {
                message: "no mid-surface was found".to_owned(),
                help: Some("check which faces are coping, and take a smaller cell".to_owned()),
            });
        }
        let pack = scene::extraction(&result, scene::origin(&self.subject.mesh)).finish();
        let told = json!({ "seconds": seconds(&result), "cells": result.work.counts.cells });
        let surface = result.surface;
        *lock(&self.shown) = Some(std::sync::Arc::new(Shown { surface, pack }));
        Ok(told)
    }

    /// Writes the tag file; one that the page has not read or written before is
    /// replaced only if `replace`.
    pub(super) fn save(&self, coping: &[bool], replace: bool) -> Result<Saved, WriteError> {
        let subject = &self.subject;
        let mut ours = lock(&self.saved);
        if subject.tag_file.exists() && !*ours && !replace {
            return Ok(Saved::Exists);
        }
        let text = tags::tag_file(
            &subject.mesh,
            &subject.source,
            coping,
            &subject.title,
            &subject.geometry,
        );
        stage(&subject.tag_file, |out| out.write_all(text.as_bytes()))?.commit()?;
        *ours = true;
        Ok(Saved::Written)
    }
}

fn seconds(result: &Extraction) -> f64 {
    let work = &result.work;
    work.field_seconds + work.trace_seconds + work.mesh_seconds
}

/// A lock whose holder died still guards whole values.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex
        .lock()
        .unwrap_or_else(|poisoned| poisoned.into_inner())
}

impl From<ExtractError> for Failed {
    fn from(error: ExtractError) -> Failed {
        let help = match &error {
            ExtractError::TooFine(_) => Some("Take a larger cell.".to_owned()),
            error => error.help().map(|help| help.to_string()),
        };
        Failed {
            message: error.to_string(),
            help,
        }
    }
}
