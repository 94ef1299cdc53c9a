//! Mid-surface of a thin-wall part, as one connected non-manifold triangle
//! mesh with thickness (after Bloomenthal, "Triangulation of Implicitly
//! Defined Mid-Surfaces").
//!
//! [`extract()`] turns a [`Part`] into an [`Extraction`]; its source is the
//! table of contents. Data flows one way:
//!
//! ```text
//!   file        part         asked by all that follows        traced      edited      the result
//!    io  ──────▶ mesh ──────▶ field ──────▶ walls ──────────▶ trace ────▶ reshape ──▶ surface ──▶ io
//!  coping ────────┘                                            │
//!                                              lattice ────────┘
//! ```
//!
//! | room | holds |
//! | --- | --- |
//! | [`mesh`] | triangles, the checked part, repairs, measures |
//! | `field` | nearest wall, insidedness, segment hits |
//! | `walls` | which footpoints are on one wall, how thick walls are |
//! | `lattice` | integer names of cells, tetrahedra, faces and edges |
//! | `trace` | the paper's sections 3 and 4: the mid-surface followed through the lattice |
//! | [`surface`] | the result as a value: sheets, seams, borders, and what to say of them |
//! | [`reshape`] | what edits it: clean-up, creases, remeshing |
//! | [`check`] | the result held against the part |
//! | [`shard`] | an extraction in pieces computed apart: [`shard::shard`], [`shard::merge`] |
//! | [`inspect`] | what a part is: counts, measures, wall thickness |
//! | [`coping`] | which triangles close a wall: tag files, and finding them |
//! | [`io`] | readers and writers, one file a format |
//! | [`intake`] | files or arrays to a checked part with its tags |
//! | [`report`] | what to say of inputs and results |
//! | [`settings`] | what all engines are told, and how they tell where they are |
//!
//! Beside that pipeline stand the sister engines: [`offset`] grows, shrinks and
//! hollows closed parts, [`thicken`] makes solids of surfaces, [`rethicken`] of
//! mid-surfaces; [`subdivide`] makes hollow solids of Catmull-Clark control
//! meshes. `dual_contour` turns a solid given by a function into a mesh without
//! self-intersections, for all of these. [`roundtrip`] goes from the part to
//! its mid-surface, back to a solid, and says how far that is off. [`shell`] is
//! the mid-surface as a model that solvers take; `view`, a feature, a page in the
//! browser to look, tag and extract.
//!
//! # Who may use whom
//!
//! ```text
//! settings, mesh, lattice <- field <- walls <- trace <- extract <- shard
//! mesh <- surface <- { trace, reshape, check, rethicken, io }
//! mesh <- dual_contour <- { offset, thicken, rethicken, subdivide }
//! { io, coping, mesh } <- intake <- report -> the engines
//! ```
//!
//! *Never*: `surface` the field, `dual_contour` the field, `io` an engine, a
//! stage of the extraction its conductor `extract`, an engine another engine
//! (but `subdivide`'s contour scheme the offset and the thickening, and `roundtrip` all it goes
//! through), anything the command line, which lives in the binary. Rooms after
//! `field` know triangles by number and ask the field for them; none keeps or
//! walks a mesh.
//!
//! # What is public
//!
//! Each engine's verb, settings, result and error, and the types that these are
//! made of. `internals` is for benches and oracles: no promise is made of it.

// The public rooms speak of the private ones; their documentation is read with
// private items.
#![allow(rustdoc::private_intra_doc_links)]
// A library neither prints nor gives up.
#![warn(clippy::print_stdout, clippy::print_stderr)]
#![warn(clippy::unwrap_used, clippy::expect_used)]

pub mod check;
pub mod coping;
mod dual_contour;
pub mod extract;
mod field;
pub mod inspect;
pub mod intake;
pub mod io;
mod lattice;
pub mod mesh;
pub mod offset;
pub mod report;
pub mod reshape;
pub mod rethicken;
pub mod roundtrip;
pub mod settings;
pub mod shard;
pub mod shell;
pub mod subdivide;
pub mod surface;
pub mod thicken;
mod trace;
#[cfg(feature = "view")]
pub mod view;
mod walls;

pub use extract::{ExtractError, Extraction, Settings, extract};
pub use mesh::{Part, PartOptions};
pub use settings::cell::CellSize;
pub use surface::MidSurface;

/// The insides, for benches and oracles. No promise is made of what stands here.
#[doc(hidden)]
pub mod internals {
    pub mod dual_contour {
        pub use crate::dual_contour::*;
    }
    pub mod field {
        pub use crate::field::*;
    }
    pub mod lattice {
        pub use crate::lattice::*;
    }
    pub mod trace {
        pub use crate::trace::*;
    }
    pub mod walls {
        pub use crate::walls::*;
    }
}
