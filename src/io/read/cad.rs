//! STEP, IGES and BREP, meshed by Gmsh where it is installed.
//!
//! Gmsh runs as a program of its own; what comes back is MSH 4.1, with a group `face N`
//! for every face of the model and an object `solid N` for every solid. Its Python
//! package also tells the names and colours that faces have in the model, which become
//! groups of their own; its program does not. STEP and IGES come in millimetres,
//! whatever unit their file has.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::io::error::{Located, Place, Problem};
use crate::io::unit::Unit;

/// Segments of a full turn: chords lie off an arc by half a percent of its radius,
/// for a bend as tight as the wall is thick half a percent of the thickness.
const SEGMENTS: f64 = 32.0;

/// Does what the program does with the same arguments, and names faces by what the
/// model calls them and by their colours.
const BY_PYTHON: &str = include_str!("cad.py");

/// How finely a CAD model is meshed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tessellation {
    /// Most that chords may lie off the faces, millimetres. Without, 32 chords go
    /// to a full turn of any radius.
    pub sag: Option<f64>,
}

impl Tessellation {
    /// Longest edge for a sag. A turn of `n` chords at radius `r` strays by
    /// `r pi^2 / (2 n^2)`, edges of length `h` there by `h^2 / (8 r)`; whichever is
    /// the smaller holds, and the greatest of that over all radii is `h pi / (4 n)`.
    fn longest(self) -> Option<f64> {
        self.sag
            .map(|sag| 4.0 * SEGMENTS * sag / std::f64::consts::PI)
    }
}

/// Unit that a model comes in.
pub(super) fn unit(file: &Path) -> Option<Unit> {
    // BREP has none.
    let is_brep = file
        .extension()
        .is_some_and(|s| s.eq_ignore_ascii_case("brep"));
    (!is_brep).then_some(Unit::Millimetre)
}

/// Characters of Gmsh's last words that an error repeats.
const LAST_WORDS: usize = 300;

/// Whether a file is a CAD model, by its suffix.
pub fn is_cad(file: &Path) -> bool {
    let suffix = file.extension().and_then(|suffix| suffix.to_str());
    suffix.is_some_and(|suffix| {
        ["step", "stp", "iges", "igs", "brep"]
            .iter()
            .any(|known| suffix.eq_ignore_ascii_case(known))
    })
}

/// The surface mesh of a model, as a file in MSH 4.1.
pub(super) fn mesh(file: &Path, tessellation: Tessellation) -> Result<Vec<u8>, Located> {
    let fail = |problem| (Place::Whole, problem);
    let folder = tempfile::tempdir().map_err(|error| fail(Problem::Io(error)))?;
    let out = folder.path().join("surface.msh");
    // A path of its own, so that no name is taken for a flag.
    let model = std::path::absolute(file).map_err(|error| fail(Problem::Io(error)))?;
    let longest = tessellation.longest().map(|length| length.to_string());
    let mut heard = None;
    for mut gmsh in programs() {
        let done = gmsh
            .arg(&model)
            .args(["-2", "-format", "msh41", "-v", "2", "-o"])
            .arg(&out)
            .args(["-setnumber", "Mesh.SaveAll", "1"])
            .args(["-setnumber", "Mesh.Binary", "0"])
            .args(["-setnumber", "Mesh.MeshSizeFromCurvature"])
            .arg(SEGMENTS.to_string())
            .args(["-setstring", "Geometry.OCCTargetUnit", "MM"])
            .args(longest.iter().flat_map(|l| ["-clmax", l]))
            .stdin(Stdio::null())
            .output();
        let Ok(done) = done else { continue };
        if let Ok(bytes) = std::fs::read(&out) {
            return Ok(bytes);
        }
        let words = [done.stdout, done.stderr].concat();
        let words = String::from_utf8_lossy(&words).trim().to_owned();
        // That Python has no Gmsh says nothing of the file.
        if !words.contains("ModuleNotFoundError") {
            heard.get_or_insert(words);
        }
    }
    Err(fail(match heard {
        Some(words) => {
            let from = words.char_indices().rev().nth(LAST_WORDS);
            let words = from.map_or(&*words, |(at, _)| &words[at..]);
            Problem::MesherFailed(words.to_owned())
        }
        None => Problem::NoMesher,
    }))
}

/// Ways to start Gmsh, the likeliest first. The environment variable `GMSH` names a
/// program and leaves no other way.
fn programs() -> Vec<Command> {
    if let Some(program) = std::env::var_os("GMSH") {
        return vec![Command::new(PathBuf::from(program))];
    }
    let mut all = Vec::new();
    for python in ["python3", "python"] {
        let mut command = Command::new(python);
        command.args(["-c", BY_PYTHON]);
        all.push(command);
    }
    all.push(Command::new("gmsh"));
    all
}
