//! Extraction in shards: pieces of the lattice computed apart, on machines that
//! know nothing of each other, and joined by the keys of the lattice.
//!
//! [`shard`] makes one, [`merge`] joins all to the same [`Extraction`], bit for
//! bit, that [`extract`](crate::extract()) makes of the whole part.
//!
//! The part's box is cut into as many boxes of cells as there are shards, so
//! that each holds about as much wall. A shard walks its box and a margin of
//! [`MARGIN`] cells around it, and keeps what lies in the box. What a simplex of
//! the lattice holds follows from its key, so two shards find the same where
//! they meet; only what followers ask of their neighbours travels, one cell a
//! round, and seldom more than one or two rounds. The margin covers that, and
//! [`merge`] compares every vertex that two shards share, to the last bit.
//!
//! The mid-surface may come into a box from outside, and need not lead to a
//! place in it that the walls point to. So a shard also enters wherever the
//! rim of its margin cuts a contour, and [`merge`] drops what turns out to be
//! led to from nowhere.
//!
//! The first shard carries the part, which cleaning, creases and thickness ask;
//! `merge` needs memory for the whole result.

mod error;
mod file;
#[cfg(test)]
mod tests;

use std::time::Instant;

use sha2::{Digest, Sha256};

pub use self::error::{MergeError, ShardFileError};
use crate::extract::{ExtractError, Extraction, Scene, Settings, finish, with_scene};
use crate::lattice::CellBox;
use crate::mesh::Part;
use crate::reshape::ElementSettings;
use crate::settings::cell::CellSize;
use crate::settings::progress::{Progress, Stop};
use crate::trace::walk::{Counts, Share, Tracer, block_bits};

/// Cells around its box that a shard walks besides.
pub const MARGIN: i32 = 6;

/// Most shards that a part may be cut into.
pub const MOST_SHARDS: u32 = 65_536;

/// Which of how many shards, counted from 1: the `3/16` of the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShardOf {
    index: u32,
    count: u32,
}

impl ShardOf {
    /// Shard `index` of `count`; none unless `1 <= index <= count <=`
    /// [`MOST_SHARDS`].
    pub fn new(index: u32, count: u32) -> Option<ShardOf> {
        let fits = (1..=count).contains(&index) && count <= MOST_SHARDS;
        fits.then_some(ShardOf { index, count })
    }

    /// Which one, from 1.
    pub fn index(self) -> u32 {
        self.index
    }

    /// Of how many.
    pub fn count(self) -> u32 {
        self.count
    }
}

impl std::fmt::Display for ShardOf {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl std::str::FromStr for ShardOf {
    type Err = String;

    fn from_str(text: &str) -> Result<ShardOf, String> {
        let numbers = text.split_once('/');
        let numbers =
            numbers.and_then(|(a, b)| Some((a.trim().parse().ok()?, b.trim().parse().ok()?)));
        numbers
            .and_then(|(index, count)| ShardOf::new(index, count))
            .ok_or_else(|| {
                format!("expected which of how many shards, as 3/16, of at most {MOST_SHARDS}")
            })
    }
}

/// One shard of an extraction.
#[derive(Clone, Debug, PartialEq)]
pub struct Shard {
    which: ShardOf,
    task: Task,
    part: Option<Carried>,
    share: Share,
    counts: Counts,
}

/// What all shards of one extraction have in common.
#[derive(Clone, Debug, PartialEq)]
struct Task {
    /// Version of the program.
    version: String,
    /// Checksum of the part's triangles and coping.
    part: [u8; 32],
    /// Triangles of the solid that is walked.
    faces: u32,
    /// Cell size, a length.
    cell: f64,
    min_angle: f64,
    keep_fins: bool,
}

/// A part as a shard carries it.
#[derive(Clone, Debug)]
struct Carried(Part);

impl PartialEq for Carried {
    fn eq(&self, other: &Carried) -> bool {
        checksum(&self.0) == checksum(&other.0)
    }
}

impl Shard {
    /// Which of how many.
    pub fn which(&self) -> ShardOf {
        self.which
    }

    /// Counts of the work that it took.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// The part, in the first shard.
    pub fn part(&self) -> Option<&Part> {
        self.part.as_ref().map(|p| &p.0)
    }
}

/// Computes one shard of an extraction. [`Settings::elements`] are left to
/// [`merge`].
///
/// # Errors
///
/// As [`extract`](crate::extract()); a cell is refused where this shard would not
/// fit.
pub fn shard(
    part: &Part,
    settings: &Settings,
    which: ShardOf,
    progress: &Progress,
    stop: &Stop,
) -> Result<Shard, ExtractError> {
    let of_shard = Settings {
        memory_limit: settings.memory_limit.saturating_mul(u64::from(which.count)),
        ..*settings
    };
    with_scene(part, &of_shard, progress, |scene| {
        stop.heed()?;
        let own = own_box(&scene, which);
        let tracer = Tracer::new(
            scene.walls,
            scene.lattice,
            block_bits(settings.memory_limit),
        );
        let mut tracer = tracer.within(own.grown(MARGIN));
        tracer.run(progress, stop)?;
        let counts = tracer.counts();
        Ok(Shard {
            which,
            task: Task {
                version: env!("CARGO_PKG_VERSION").to_owned(),
                part: checksum(part),
                faces: scene.field.face_count() as u32,
                cell: scene.lattice.cell(),
                min_angle: settings.min_angle,
                keep_fins: settings.keep_fins,
            },
            part: (which.index == 1).then(|| Carried(part.clone())),
            share: tracer.share(&own),
            counts,
        })
    })
}

/// The cells of a shard: the box cut so that each has about as much wall.
fn own_box(scene: &Scene, which: ShardOf) -> CellBox {
    let points = scene.wall_points();
    let boxes = CellBox::ALL.cut(points, which.count as usize);
    boxes[which.index as usize - 1]
}

/// Joins all shards of an extraction.
///
/// # Errors
///
/// [`MergeError`] where one is missing, there twice, or of another part, of
/// other settings or of another version; and what a whole extraction refuses.
pub fn merge(
    mut shards: Vec<Shard>,
    elements: Option<ElementSettings>,
    progress: &Progress,
    stop: &Stop,
) -> Result<Extraction, MergeError> {
    let start = Instant::now();
    shards.sort_by_key(|s| s.which.index);
    check(&shards)?;
    let first = shards.first_mut().ok_or(MergeError::None)?;
    let task = first.task.clone();
    // The first of a whole set carries it.
    let part = first.part.take().ok_or(MergeError::None)?.0;
    let settings = Settings {
        cell: CellSize::Length(task.cell),
        min_angle: task.min_angle,
        keep_fins: task.keep_fins,
        memory_limit: u64::MAX,
        elements,
    };
    let mut counts = Counts::default();
    for shard in &shards {
        counts.add(&shard.counts);
    }
    let shares = shards.into_iter().map(|s| s.share).collect();
    let (mesh, cells) = Share::join(shares).ok_or(MergeError::Apart)?;
    counts.cells = cells;
    let seconds = start.elapsed().as_secs_f64();
    with_scene(&part, &settings, progress, |scene| {
        // Its numbers name faces of the solid.
        if scene.field.face_count() != task.faces as usize {
            return Err(MergeError::Apart);
        }
        Ok(finish(&scene, mesh, counts, seconds, progress, stop)?)
    })
}

/// Checks that sorted shards are those of one extraction, each once.
fn check(shards: &[Shard]) -> Result<(), MergeError> {
    let first = shards.first().ok_or(MergeError::None)?;
    for shard in shards {
        let (which, task) = (shard.which, &shard.task);
        if task.version != first.task.version {
            return Err(MergeError::OtherVersion {
                which,
                version: task.version.clone(),
                first: first.task.version.clone(),
            });
        }
        if task.part != first.task.part {
            return Err(MergeError::OtherPart {
                which,
                first: first.which,
            });
        }
        if task != &first.task || which.count != first.which.count {
            return Err(MergeError::OtherSettings {
                which,
                settings: task.settings(),
                first: first.which,
                first_settings: first.task.settings(),
            });
        }
    }
    for pair in shards.windows(2) {
        if pair[0].which == pair[1].which {
            return Err(MergeError::Doubled {
                which: pair[0].which,
            });
        }
    }
    let count = first.which.count;
    let there = |index: &u32| {
        shards
            .binary_search_by_key(index, |s| s.which.index)
            .is_ok()
    };
    let missing: Vec<u32> = (1..=count).filter(|index| !there(index)).collect();
    match missing.first() {
        Some(&index) => Err(MergeError::Missing {
            which: ShardOf { index, count },
            others: missing.len() - 1,
        }),
        None => Ok(()),
    }
}

impl Task {
    fn settings(&self) -> String {
        let fins = if self.keep_fins { ", fins kept" } else { "" };
        format!("cell {}, angle {}{fins}", self.cell, self.min_angle)
    }
}

/// Checksum of all that an extraction reads of a part.
fn checksum(part: &Part) -> [u8; 32] {
    let mut sum = Sha256::new();
    for p in &part.mesh().positions {
        for x in p.to_array() {
            sum.update(x.to_le_bytes());
        }
    }
    for (corners, &coping) in part.mesh().triangles.iter().zip(part.coping()) {
        for v in corners {
            sum.update(v.to_le_bytes());
        }
        sum.update([u8::from(coping)]);
    }
    sum.finalize().into()
}
