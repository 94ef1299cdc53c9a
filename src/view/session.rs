//! What one page works on: a part with its tags, and the last mid-surface.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard};

use glam::DVec3;
use miette::Diagnostic;
use rustc_hash::FxHashSet;
use serde_json::{Value, json};

use super::{scene, tags};
use crate::coping::detect::Detection;
use crate::extract::{ExtractError, Extraction, Settings, extract_until};
use crate::field::Field;
use crate::io::write::{WriteError, stage};
use crate::mesh::{FaceId, Part, PartError, PartOptions, TriMesh};
use crate::settings::cell::CellSize;
use crate::settings::progress::{Progress, Stop};
use crate::surface::MidSurface;
use crate::surface::graph::SheetGraph;
use crate::walls::thickness::{ThicknessProfile, thickness_at};

/// Samples of the wall thickness that the page shows, and by which it counts cells.
const SAMPLES: usize = 20_000;

/// Active cells of a lattice for each that is crossed, about, as
/// [`expected_cells`](crate::extract::expected_cells) has it: how the lattice lies
/// against the walls is not known before.
const ACTIVE: f64 = 1.6;

/// Samples that stand for a cell, so that hardly one is passed over.
const PER_CELL: f64 = 4.0;

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
    /// Tags as the page had them last: saved, extracted with, or told.
    coping: Mutex<Vec<bool>>,
    /// Walls as they were measured last; none until then.
    walls: Mutex<Option<Arc<Field>>>,
    shown: Mutex<Option<Arc<Shown>>>,
    heavy: Mutex<()>,
}

impl Session {
    pub(super) fn new(mut subject: Subject) -> Session {
        let origin = scene::origin(&subject.mesh);
        let shown = subject.surface.take().map(|surface| {
            let graph = SheetGraph::of(&surface);
            let pack = scene::surface(&surface, &graph, origin).finish();
            Arc::new(Shown { surface, pack })
        });
        Session {
            saved: Mutex::new(subject.tags_are_ours),
            coping: Mutex::new(subject.coping.clone()),
            walls: Mutex::new(None),
            shown: Mutex::new(shown),
            heavy: Mutex::new(()),
            subject,
        }
    }

    pub(super) fn subject(&self) -> &Subject {
        &self.subject
    }

    /// The tags that the page has now.
    pub(super) fn coping(&self) -> Vec<bool> {
        lock(&self.coping).clone()
    }

    /// Takes the tags that the page has now.
    pub(super) fn tag(&self, coping: &[bool]) {
        *lock(&self.coping) = coping.to_vec();
    }

    /// The mid-surface that is shown now.
    pub(super) fn shown(&self) -> Option<Arc<Shown>> {
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
        let mut pack = scene::part(&subject.mesh, &self.coping(), &subject.source, true);
        pack.fact("title", subject.title.clone());
        pack.fact("tag_file", subject.tag_file.display().to_string());
        pack.fact("tags_are_saved", *lock(&self.saved));
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
        match self.part(self.coping()) {
            Ok(part) => {
                let field = Field::new(&part);
                let profile = ThicknessProfile::measure(&field, SAMPLES);
                let thickness = profile.percentile(50.0);
                let cells = thickness.map(|t| cells(&field, &profile, part.area(), t));
                *lock(&self.walls) = Some(Arc::new(field));
                json!({ "thickness": thickness, "cells_at_thickness": cells })
            }
            Err(error) => {
                let help = error.help().map(|help| help.to_string());
                json!({ "problem": { "message": error.to_string(), "help": help } })
            }
        }
    }

    /// Wall thickness at a point of a triangle of the part; none where no wall faces
    /// it, or before the part was measured.
    pub(super) fn thickness(&self, triangle: u32, at: DVec3) -> Option<f64> {
        let walls = lock(&self.walls).clone()?;
        let known = (triangle as usize) < walls.face_count() && at.is_finite();
        known
            .then(|| thickness_at(&walls, FaceId(triangle), at))
            .flatten()
    }

    /// Extracts with the flags given; what comes out is shown from then on.
    pub(super) fn extract(
        &self,
        coping: Vec<bool>,
        cell: CellSize,
        progress: &Progress,
        stop: &Stop,
    ) -> Result<Value, Failed> {
        self.tag(&coping);
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
        let told = json!({
            "seconds": seconds(&result),
            "cells": result.work.counts.cells,
            "cell": result.work.cell,
        });
        let surface = result.surface;
        *lock(&self.shown) = Some(Arc::new(Shown { surface, pack }));
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
        self.tag(coping);
        Ok(Saved::Written)
    }
}

/// Active cells of a size: those that the mid-surface crosses, counted by the centres of maximal
/// balls in cells so large that some centres lie in each, and taken to that size by
/// the inverse square.
fn cells(field: &Field, profile: &ThicknessProfile, area: f64, size: f64) -> f64 {
    let coarse = size.max((PER_CELL * area / SAMPLES as f64).sqrt());
    let mut crossed = FxHashSet::default();
    for sample in profile.samples() {
        let centre = sample.at - 0.5 * sample.thickness * field.normal(sample.face);
        crossed.insert((centre / coarse).floor().as_i64vec3());
    }
    ACTIVE * crossed.len() as f64 * (coarse / size).powi(2)
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
