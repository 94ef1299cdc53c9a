//! A page in the browser: the part and its mid-surface to look at, coping faces to
//! tag.
//!
//! ```text
//! scene -> pack -> server -> page (HTML, CSS and script, embedded)
//! scene -> pack -> page::write: the same page as one file, to look only
//! ```
//!
//! The page draws with WebGL 2 and asks nothing of any network but the server that
//! sent it. Where nothing is served, it finds its packs in itself.

mod guard;
mod http;
mod job;
mod pack;
mod page;
mod scene;
mod server;
mod session;
mod tags;

use std::io::{self, Write};

pub use server::Server;
pub use session::Subject;

use crate::extract::Extraction;
use crate::mesh::{Part, TriMesh};

/// Writes a part and its mid-surface as one HTML file that needs nothing else.
///
/// # Errors
///
/// Those of the sink.
pub fn write_page(
    title: &str,
    part: &Part,
    result: &Extraction,
    out: &mut dyn Write,
) -> io::Result<()> {
    let mesh: &TriMesh = part.mesh();
    let pack = scene::extraction(result, scene::origin(mesh)).finish();
    page::write(title, mesh, part.coping(), &pack, out)
}
