//! What can be wrong with shards.

use std::io;

use miette::Diagnostic;
use thiserror::Error;

use super::ShardOf;
use crate::extract::ExtractError;

/// Why shards do not join.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum MergeError {
    /// No shard was given.
    #[error("no shard was given")]
    #[diagnostic(help("name all shards of one extraction"))]
    None,
    /// One is not there.
    #[error("shard {which} is missing{}", and_others(*.others))]
    #[diagnostic(help("make it with `midsurf extract PART --shard {which} -o FILE.shard`"))]
    Missing {
        /// The first that is missing.
        which: ShardOf,
        /// Further ones that are missing.
        others: usize,
    },
    /// One is there twice.
    #[error("shard {which} was given twice")]
    #[diagnostic(help("name each shard once"))]
    Doubled {
        /// Which.
        which: ShardOf,
    },
    /// One is of another part.
    #[error("shard {which} is of another part, or of other coping tags, than shard {first}")]
    #[diagnostic(help("make all shards of one part with the same tags"))]
    OtherPart {
        /// Which.
        which: ShardOf,
        /// The one it was held against.
        first: ShardOf,
    },
    /// One was made with other settings.
    #[error(
        "shard {which} was made with other settings than shard {first}: {settings}; there {first_settings}"
    )]
    #[diagnostic(help("make all shards with the same settings and the same number of shards"))]
    OtherSettings {
        /// Which.
        which: ShardOf,
        /// Its settings.
        settings: String,
        /// The one it was held against.
        first: ShardOf,
        /// Settings of that one.
        first_settings: String,
    },
    /// One was made by another version of the program.
    #[error("shard {which} was made by version {version}, another by version {first}")]
    #[diagnostic(help("make all shards with one version of the program"))]
    OtherVersion {
        /// Which.
        which: ShardOf,
        /// Its version.
        version: String,
        /// The other's.
        first: String,
    },
    /// Two shards differ in a vertex that they share.
    #[error("shards differ where they meet")]
    #[diagnostic(help(
        "make all shards with one build of the program; if they were, take fewer shards, and please report it"
    ))]
    Apart,
    /// The extraction was refused or stopped.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Extract(#[from] ExtractError),
}

fn and_others(others: usize) -> String {
    match others {
        0 => String::new(),
        n => format!(", and {n} more"),
    }
}

/// Why a file is no shard.
#[derive(Debug, Error, Diagnostic)]
#[non_exhaustive]
pub enum ShardFileError {
    /// It could not be read.
    #[error("{0}")]
    #[diagnostic(help("check the name"))]
    Io(#[from] io::Error),
    /// It is something else.
    #[error("not a shard")]
    #[diagnostic(help("`midsurf extract PART --shard 1/4 -o FILE.shard` makes one"))]
    NoShard,
    /// Its format is newer or older.
    #[error("a shard of format {found}; this program reads format {known}")]
    #[diagnostic(help("make and merge shards with one version of the program"))]
    OtherFormat {
        /// Of the file.
        found: u32,
        /// Of this program.
        known: u32,
    },
    /// The checksum does not fit, or what it holds makes no sense.
    #[error("a damaged shard: {0}")]
    #[diagnostic(help("make it again, or copy it again"))]
    Damaged(&'static str),
}
