//! Files: mesh readers, mid-surface writers.
//!
//! Readers take what real programs write and refuse the rest with the file,
//! the line or byte, and what to do. Writers put a file in place only when it
//! is complete.

mod checksum;
mod error;
mod names;
mod read;
mod text;
mod unit;
pub mod write;

pub use checksum::geometry_checksum;
pub use error::{Place, Problem, ReadError};
pub use names::{FacetNames, NameSet};
pub(crate) use read::read_bytes;
pub use read::{
    BoundaryTag, ControlMesh, ControlTags, LoadedMesh, LoadedSurface, MAX_INPUT, MeshFormat,
    NoSolid, PlyValues, RadiusSource, ReadWarning, SurfaceReadError, TagKind, Tessellation, is_cad,
    limit_input, read_any_surface, read_control, read_control_bytes, read_mesh, read_mesh_bytes,
    read_mesh_with, read_surface,
};
pub(crate) use text::decode;
pub use unit::Unit;
