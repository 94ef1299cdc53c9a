//! A solid as output: the flag for its files, their check, the writing.

use std::path::{Path, PathBuf};

use midsurf::io::write::{Shade, SolidFormat, Staged, stage_solid};
use midsurf::mesh::{Simplify, TriMesh};
use midsurf::settings::precision::Precision;
use midsurf::settings::quote::figure;

use super::console::say;
use super::failure::Failure;
use super::run::RunArgs;

/// Files of a solid.
#[derive(clap::Args)]
pub(crate) struct SolidArgs {
    /// Output file (.stl, .obj, .ply); repeat for several formats
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Vec<PathBuf>,
}

impl SolidArgs {
    /// Refuses file names that could not be written or are named twice.
    pub(crate) fn check_names(
        &self,
        inputs: &[(&Path, &'static str)],
        run: &RunArgs,
    ) -> Result<(), Failure> {
        for file in &self.output {
            SolidFormat::of(file).map_err(Failure::input)?;
        }
        run.check_names(inputs, self.output.clone())
    }

    /// The files, for reports.
    pub(crate) fn outputs(&self) -> Vec<&Path> {
        self.output.iter().map(PathBuf::as_path).collect()
    }

    /// Numbers that every file can hold.
    pub(crate) fn precision(&self) -> Precision {
        let single = |file: &PathBuf| SolidFormat::of(file).is_ok_and(|f| !f.is_double());
        if self.output.iter().any(single) {
            Precision::Single
        } else {
            Precision::Double
        }
    }

    /// Writes the solid under passing names.
    pub(crate) fn stage(
        &self,
        mesh: &TriMesh,
        shade: Option<Shade>,
    ) -> Result<Vec<Staged>, Failure> {
        let write = |file: &PathBuf| stage_solid(mesh, shade, file).map_err(Failure::output);
        self.output.iter().map(write).collect()
    }
}

/// Fewer triangles of a solid that was contoured.
#[derive(clap::Args)]
pub(crate) struct SimplifyArgs {
    /// Fewer triangles where the solid is flat or bends one way, within the tolerance
    #[arg(long)]
    pub(crate) simplify: bool,
    /// So many triangles of what is contoured at most, as near to it as they let; implies --simplify
    #[arg(long, value_name = "N")]
    pub(crate) triangles: Option<usize>,
}

impl SimplifyArgs {
    /// How far to go; none where it was not asked for.
    pub(crate) fn within(&self, tolerance: f64) -> Option<Simplify> {
        self.wanted().then_some(Simplify {
            tolerance,
            triangles: self.triangles,
        })
    }

    /// Whether it was asked for.
    pub(crate) fn wanted(&self) -> bool {
        self.simplify || self.triangles.is_some()
    }
}

/// Tells people the size of a solid.
pub(crate) fn summary(mesh: &TriMesh) {
    say(format_args!(
        "{} vertices, {} triangles, volume {}, area {}",
        mesh.positions.len(),
        mesh.triangles.len(),
        figure(mesh.volume()),
        figure(mesh.area())
    ));
}
