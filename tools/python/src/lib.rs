//! The compiled half of the Python package: numbers in and out, everything
//! that takes time outside the interpreter's lock.
//!
//! * `run`: threads, progress, Ctrl-C.
//! * `fault`: errors as exceptions, with the remedies that a caller in Python has.
//! * `arrays`: numpy in and out.
//! * `given`: what functions are told, checked.
//! * `extract`, `surface`, `solids`, `subdivide`, `parts`: the verbs.
//!
//! What people use, with its documentation, is `python/midsurf`.

mod arrays;
mod extract;
mod fault;
mod given;
mod parts;
mod run;
mod solids;
mod subdivide;
mod surface;

use pyo3::prelude::*;

/// The module `midsurf._midsurf`.
#[pymodule]
mod _midsurf {
    #[pymodule_export]
    use super::extract::{extract, merge, shard};
    #[pymodule_export]
    use super::parts::{Tags, detect_coping, info};
    #[pymodule_export]
    use super::solids::{hollow, offset, rethicken, roundtrip, save_solid, thicken};
    #[pymodule_export]
    use super::subdivide::subdivide;
    #[pymodule_export]
    use super::surface::{Surface, read};

    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
