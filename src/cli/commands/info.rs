//! `midsurf info`: what a part is.

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use midsurf::field::Field;
use midsurf::mesh::{EdgeCensus, Part, PartOptions};
use midsurf::walls::thickness::ThicknessProfile;
use serde::Serialize;

use crate::cli::shared::coping::CopingSource;
use crate::cli::shared::failure::Failure;
use crate::cli::shared::input::{Input, Warning, print_warnings};
use crate::cli::shared::numbers::figure;
use crate::cli::shared::pool;
use crate::cli::shared::report::named;
use midsurf::io::quote::shown;

const EXAMPLES: &str = "\
Examples:
  midsurf info bracket.stl
  midsurf info bracket.obj --coping bracket.coping.txt --json

Wall thickness is measured from the wall triangles, weighted by area. The two
checksums can be put under [mesh] in a TOML tag file, so that the tags are
refused for another mesh: sha256 is that of the file, geometry stays the same
when the mesh is converted between formats or its triangles are reordered.

Exit codes: 0 done, 2 wrong usage or bad input.";

/// Names shown before the list is cut short.
const NAMES_SHOWN: usize = 20;

/// Show what a part is: triangles, closedness, volume, box, names, thickness.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The part (.obj, .stl, .ply, .off)
    part: PathBuf,
    /// Coping tags: a file (text, or TOML if the name ends in .toml), `auto` to
    /// find them, or `none`
    #[arg(long, value_name = "FILE", default_value = "auto")]
    coping: CopingSource,
    /// Merge vertices within this distance
    #[arg(long, value_name = "LENGTH", value_parser = crate::cli::shared::numbers::positive)]
    weld: Option<f64>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Info {
    part: String,
    sha256: String,
    geometry: String,
    facets: usize,
    triangles: usize,
    vertices: usize,
    coping_triangles: usize,
    watertight: bool,
    open_edges: usize,
    non_manifold_edges: usize,
    components: usize,
    euler: i64,
    volume: f64,
    area: f64,
    wall_area: f64,
    min: [f64; 3],
    max: [f64; 3],
    diagonal: f64,
    groups: Vec<String>,
    objects: Vec<String>,
    materials: Vec<String>,
    thickness: Option<Thickness>,
    warnings: Vec<Warning>,
}

/// Wall thickness by share of the wall area, in part units.
#[derive(Clone, Copy, Debug, Serialize)]
struct Thickness {
    p5: f64,
    p25: f64,
    p50: f64,
    p75: f64,
    p95: f64,
}

/// Points of the walls at which the thickness is measured.
const THICKNESS_SAMPLES: usize = 4000;

/// Wall thickness percentiles of a part; none where no wall faces another.
fn wall_thickness(part: &Part) -> Option<Thickness> {
    let profile = ThicknessProfile::measure(&Field::new(part), THICKNESS_SAMPLES);
    Some(Thickness {
        p5: profile.percentile(5.0)?,
        p25: profile.percentile(25.0)?,
        p50: profile.percentile(50.0)?,
        p75: profile.percentile(75.0)?,
        p95: profile.percentile(95.0)?,
    })
}

pub(crate) fn run(args: Args) -> Result<ExitCode, Failure> {
    pool::start(None);
    let options = PartOptions {
        allow_open: true,
        weld: args.weld,
    };
    let mut input = Input::read(&args.part, &args.coping, options)?;
    // Where no tags were asked for none are missing; and what `info` says does
    // not hang on single faces.
    let asked = args.coping != CopingSource::None;
    input.warnings.retain(|warning| match warning.code {
        "no_coping" => asked,
        "coping_doubt" | "coping_doubts" => false,
        _ => true,
    });
    let info = Info::of(&input);
    print_warnings(&info.warnings);
    let mut out = io::stdout().lock();
    if args.json {
        serde_json::to_writer_pretty(&mut out, &info).map_err(io::Error::from)?;
        writeln!(out)?;
    } else {
        info.print(&mut out)?;
    }
    out.flush()?;
    Ok(ExitCode::SUCCESS)
}

impl Info {
    fn of(input: &Input) -> Info {
        let part = &input.part;
        let mesh = part.mesh();
        let uses = mesh.edges();
        let EdgeCensus {
            open,
            balanced,
            unbalanced,
            ..
        } = uses.census();
        let (_, components) = uses.components(mesh.triangles.len());
        let edges = uses.by_edge().count() as i64;
        let bounds = part.bounds();
        let wall_area = mesh
            .faces()
            .filter(|face| !part.coping()[face.index()])
            .map(|face| mesh.triangle_area(face))
            .sum();
        let sets = input.names.sets();
        let object = |set: &midsurf::io::NameSet| set.object.clone();
        let material = |set: &midsurf::io::NameSet| set.material.clone();
        Info {
            part: named(&input.file),
            sha256: input.sha256.clone(),
            geometry: input.geometry.clone(),
            facets: input.facets,
            triangles: part.triangle_count(),
            vertices: mesh.positions.len(),
            coping_triangles: part.coping_count(),
            watertight: part.is_closed(),
            open_edges: open,
            non_manifold_edges: balanced + unbalanced,
            components,
            euler: mesh.positions.len() as i64 - edges + mesh.triangles.len() as i64,
            volume: part.volume(),
            area: part.area(),
            wall_area,
            min: bounds.min.to_array(),
            max: bounds.max.to_array(),
            diagonal: bounds.diagonal(),
            groups: unique(sets.iter().flat_map(|set| set.groups.clone())),
            objects: unique(sets.iter().filter_map(object)),
            materials: unique(sets.iter().filter_map(material)),
            thickness: wall_thickness(part),
            warnings: input.warnings.clone(),
        }
    }

    fn print(&self, out: &mut impl Write) -> io::Result<()> {
        let [a, b] = [self.min, self.max];
        writeln!(out, "part         {}", shown(&self.part))?;
        write!(out, "triangles    {}", self.triangles)?;
        if self.facets != self.triangles {
            write!(out, " from {} faces", self.facets)?;
        }
        writeln!(out, ", {} of them coping", self.coping_triangles)?;
        writeln!(out, "vertices     {}", self.vertices)?;
        if self.watertight {
            writeln!(out, "watertight   yes")?;
        } else {
            writeln!(out, "watertight   no, {} open edges", self.open_edges)?;
        }
        if self.non_manifold_edges > 0 {
            writeln!(
                out,
                "non-manifold {} edges with more than two triangles",
                self.non_manifold_edges
            )?;
        }
        writeln!(out, "components   {}", self.components)?;
        writeln!(out, "euler        {}", self.euler)?;
        writeln!(out, "volume       {}", figure(self.volume))?;
        writeln!(
            out,
            "area         {}, of it wall {}",
            figure(self.area),
            figure(self.wall_area)
        )?;
        writeln!(
            out,
            "box          ({}, {}, {}) to ({}, {}, {})",
            a[0], a[1], a[2], b[0], b[1], b[2]
        )?;
        writeln!(
            out,
            "size         {} x {} x {}, diagonal {}",
            figure(b[0] - a[0]),
            figure(b[1] - a[1]),
            figure(b[2] - a[2]),
            figure(self.diagonal)
        )?;
        match self.thickness {
            Some(t) => writeln!(
                out,
                "thickness    5 % {}, 25 % {}, median {}, 75 % {}, 95 % {}",
                figure(t.p5),
                figure(t.p25),
                figure(t.p50),
                figure(t.p75),
                figure(t.p95)
            )?,
            None => writeln!(out, "thickness    unknown, no wall faces another")?,
        }
        for (kind, names) in [
            ("groups", &self.groups),
            ("objects", &self.objects),
            ("materials", &self.materials),
        ] {
            if !names.is_empty() {
                let names_shown = names.iter().take(NAMES_SHOWN).map(|name| shown(name));
                let list = names_shown.collect::<Vec<_>>().join(", ");
                let more = if names.len() > NAMES_SHOWN {
                    ", …"
                } else {
                    ""
                };
                writeln!(out, "{kind:<12} {}: {list}{more}", names.len())?;
            }
        }
        writeln!(out, "sha256       {}", self.sha256)?;
        writeln!(out, "geometry     {}", self.geometry)
    }
}

/// Each name once, in order of first use.
fn unique(names: impl Iterator<Item = String>) -> Vec<String> {
    let mut seen = std::collections::HashSet::new();
    names.filter(|name| seen.insert(name.clone())).collect()
}
