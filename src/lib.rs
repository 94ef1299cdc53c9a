//! Mid-surface of a thin-wall part, as one connected non-manifold triangle
//! mesh with thickness (after Bloomenthal, "Triangulation of Implicitly
//! Defined Mid-Surfaces").
//!
//! [`extract::extract`] turns a [`mesh::Part`] into an
//! [`extract::Extraction`]; its source is the table of contents. Data flows one
//! way through the rooms:
//!
//! ```text
//! io, coping -> mesh -> field -> walls -> trace -> reshape -> surface -> io
//! ```
//!
//! * [`io`] and [`coping`] read and write files; nothing else touches any.
//! * [`mesh`]: the checked part.
//! * [`field`]: nearest wall, insidedness, segment hits.
//! * [`walls`]: what is one wall.
//! * [`lattice`]: integer names of cells, tetrahedra, faces and edges.
//! * [`trace`]: walks the lattice where the mid-surface leads.
//! * [`reshape`] edits the traced mesh: clean-up.
//! * [`surface`]: the result: sheets, seams, borders and what to say of them.
//!
//! Beside that pipeline:
//!
//! * [`check`]: what a result fails to do, held against the part.
//! * [`dual_contour`]: a solid given by a function, as a mesh without
//!   self-intersections; what the next three share.
//! * [`offset`]: closed parts grown, shrunk and hollowed.
//! * [`thicken`]: solids of surfaces, on one side.
//! * [`rethicken`]: solids of mid-surfaces with a ball at every vertex.
//! * [`roundtrip`]: part to mid-surface to solid, and how far that is off.
//! * [`shell`]: the mid-surface as a model that solvers take.
//! * [`subdivide`]: hollow solids from Catmull-Clark control meshes.
//! * `view`, a feature: a page in the browser to look, tag and extract.
//! * [`settings`]: what all of these are told, and how they tell where they are
//!   and refuse what would not fit.

// A library neither prints nor gives up.
#![warn(clippy::print_stdout, clippy::print_stderr)]
#![warn(clippy::unwrap_used, clippy::expect_used)]

pub mod check;
pub mod coping;
pub mod dual_contour;
pub mod extract;
pub mod field;
pub mod io;
pub mod lattice;
pub mod mesh;
pub mod offset;
pub mod reshape;
pub mod rethicken;
pub mod roundtrip;
pub mod settings;
pub mod shell;
pub mod subdivide;
pub mod surface;
pub mod thicken;
pub mod trace;
#[cfg(feature = "view")]
pub mod view;
pub mod walls;

pub use extract::{ExtractError, Extraction, Settings, extract};
pub use mesh::{Part, PartOptions};
pub use settings::cell::CellSize;
pub use surface::MidSurface;
