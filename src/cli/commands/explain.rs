//! `midsurf tags explain`: every face of a part, and what speaks for its tag.

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use midsurf::coping::detect;
use midsurf::coping::detect::{DetectedFace, Detection, Options};
use serde_json::{Value, json};

use crate::cli::shared::coping::{CopingSource, facets, shown_ranges};
use crate::cli::shared::failure::Failure;
use crate::cli::shared::input::{load_tags, print_warnings};
use crate::cli::shared::pool;
use crate::cli::shared::reading::{ReadingArgs, SelectArgs};
use crate::cli::shared::report::named;

const EXAMPLES: &str = "\
Examples:
  midsurf tags explain bracket.stl bracket.coping.toml
  midsurf tags explain bracket.stl auto --json

Faces that the program would tag otherwise come first, then those in doubt.
The score is the face's own: -1 is the side of a wall, 1 a face that closes one;
neighbours add to it.

Exit codes: 0 done, 2 wrong usage or bad input.";

/// Say of every face whether it is coping or wall, and what speaks for it.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The part (.obj, .stl, .ply, .off, .3mf, .glb, .msh, .inp, .bdf; .step, .iges, .brep with Gmsh)
    part: PathBuf,
    /// The tag file, `auto` or `none`
    tags: CopingSource,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    reading: ReadingArgs,
    #[command(flatten)]
    select: SelectArgs,
}

/// A face and what the tags make of it.
struct Explained<'a> {
    face: &'a DetectedFace,
    /// Share of its area that is tagged as coping.
    tagged: f64,
    facets: Vec<u32>,
}

impl Explained<'_> {
    /// The part of the face that the program would tag otherwise.
    fn against(&self) -> f64 {
        if self.face.coping {
            1.0 - self.tagged
        } else {
            self.tagged
        }
    }

    fn words(&self) -> String {
        let taken = match self.tagged {
            t if t >= 0.995 => "coping".to_owned(),
            t if t <= 0.005 => "wall".to_owned(),
            t => format!("coping by {:.0} %", 100.0 * t),
        };
        let verdict = match (self.against() > 0.005, self.face.coping) {
            (false, _) => String::new(),
            (true, true) => "; it looks like the end of a wall".to_owned(),
            (true, false) => "; it looks like the side of a wall".to_owned(),
        };
        format!(
            "face {}: {taken}{verdict}; {}; triangles {}",
            self.face.number,
            self.face.summary(),
            shown_ranges(&self.facets)
        )
    }

    fn json(&self) -> Value {
        json!({
            "face": self.face.number,
            "tagged": self.tagged,
            "detected": self.face.coping,
            "score": self.face.score,
            "by_neighbours": self.face.by_neighbours,
            "doubt": self.face.doubt,
            "reasons": self.face.reasons,
            "text": self.words(),
        })
    }
}

pub(crate) fn run(args: &Args) -> Result<ExitCode, Failure> {
    pool::start(None);
    let (loaded, mut warnings) = args.reading.load(&args.part, Some(&args.select))?;
    let (coping, more) = load_tags(&args.tags, &loaded, &args.part)?;
    warnings.extend(
        more.into_iter()
            .filter(|w| !w.code.starts_with("coping_doubt")),
    );
    print_warnings(&warnings);
    let detection = match coping.detection {
        Some(detection) => detection,
        None => detect(&loaded.mesh, &Options::default()),
    };
    let areas: Vec<f64> = loaded
        .mesh
        .faces()
        .map(|f| loaded.mesh.triangle_area(f))
        .collect();
    let mut faces: Vec<Explained> = detection
        .faces
        .iter()
        .map(|face| {
            let tagged = face.triangles.iter().filter(|&&t| coping.flags[t as usize]);
            let tagged: f64 = tagged.map(|&t| areas[t as usize]).sum();
            Explained {
                face,
                tagged: if face.area > 0.0 {
                    tagged / face.area
                } else {
                    0.0
                },
                facets: facets(&loaded.source, &face.triangles),
            }
        })
        .collect();
    let rank = |e: &Explained| (e.against(), e.face.doubt);
    faces.sort_by(|a, b| {
        let ((p, q), (r, s)) = (rank(a), rank(b));
        r.total_cmp(&p)
            .then(s.total_cmp(&q))
            .then(a.face.number.cmp(&b.face.number))
    });
    let mut out = io::stdout().lock();
    if args.json {
        let report = json!({
            "part": named(&args.part),
            "tags": args.tags,
            "verdict": detection.verdict(),
            "faces": faces.iter().map(Explained::json).collect::<Vec<_>>(),
        });
        writeln!(out, "{report:#}")?;
    } else {
        print(&faces, &detection, &mut out)?;
    }
    out.flush()?;
    Ok(ExitCode::SUCCESS)
}

fn print(faces: &[Explained], detection: &Detection, out: &mut impl Write) -> io::Result<()> {
    if let Some(words) = detection.verdict().text() {
        writeln!(out, "{words}")?;
    }
    for face in faces {
        writeln!(out, "{}", face.words())?;
    }
    Ok(())
}
