//! The commands, one file each.

pub(crate) mod check;
mod closed_part;
pub(crate) mod completions;
pub(crate) mod detect;
pub(crate) mod explain;
pub(crate) mod extract;
mod extract_args;
mod extract_report;
pub(crate) mod hollow;
pub(crate) mod info;
pub(crate) mod merge;
pub(crate) mod mesh;
pub(crate) mod offset;
pub(crate) mod rethicken;
pub(crate) mod roundtrip;
pub(crate) mod schema;
pub(crate) mod subdivide;
mod subdivide_report;
pub(crate) mod tags;
pub(crate) mod thicken;
#[cfg(feature = "view")]
pub(crate) mod view;
