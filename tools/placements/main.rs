//! Random placements: does a part give the same mid-surface however it lies
//! in the lattice?
//!
//! `cargo run --release --example placements -- [--count N] [--seed S] [--only K] PART ...`
//!
//! Each part is shifted, turned and extracted at a cell of a quarter to four
//! wall thicknesses, `N` times, and each result is judged from outside: no
//! crack, no vertex outside the part, no triangles that cut each other, no
//! triangle without area, and the right topology, unless the result says that a
//! feature is too small for the cell. Borders where no wall ends (torn) are told.
//! Numbers of bad placements are told, so that `--only` repeats one, and then the
//! places, where they are in the part as it was given.
//!
//! A part is a file with its `PART.coping.txt`, if there is one, and right is
//! what it has where it lies at cells of one thickness, features of two cells and
//! more; or one of the [`families`] made here, for which it is known. Of most of these each
//! placement has other dimensions: thicknesses, angles, numbers of webs.

mod families;

use std::process::ExitCode;

use families::{FAMILIES, THICKNESS, make};
use glam::{DMat3, DVec3};
use midsurf::coping::read_tags;
use midsurf::extract::{Extraction, Settings, extract};
use midsurf::internals::field::Field;
use midsurf::io::read_mesh;
use midsurf::mesh::self_intersections;
use midsurf::mesh::{Part, PartOptions, TriMesh};
use midsurf::settings::cell::CellSize;

/// Smallest and largest cell, in wall thicknesses.
const CELLS: [f64; 2] = [0.25, 4.0];

/// How far outside the part a vertex may lie, in part sizes: a tie of single
/// precision input.
const OUTSIDE: f64 = 1e-6;

/// Height over longest side below which a triangle has no area.
const NO_AREA: f64 = 1e-9;

/// What must not change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Shape {
    sheets: u32,
    seams: usize,
    junctions: usize,
    fading: usize,
    euler: i64,
}

/// What an observer finds wrong in one result.
#[derive(Clone, Copy, Debug, Default)]
struct Faults {
    cracks: usize,
    outside: usize,
    cut: usize,
    flat: usize,
    torn: usize,
    other_shape: bool,
}

impl Faults {
    fn any(&self) -> bool {
        self.cracks + self.outside + self.cut + self.flat > 0 || self.other_shape
    }
}

/// Numbers between 0 and 1 from a seed (SplitMix64).
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn turn(&mut self) -> DMat3 {
        let height = 2.0 * self.unit() - 1.0;
        let round = std::f64::consts::TAU * self.unit();
        let side = (1.0 - height * height).sqrt();
        let axis = DVec3::new(side * round.cos(), side * round.sin(), height);
        DMat3::from_axis_angle(axis, std::f64::consts::TAU * self.unit())
    }
}

struct Given {
    mesh: TriMesh,
    coping: Vec<bool>,
    /// What is right, where it is known.
    want: Option<Shape>,
}

fn read(file: &str) -> Given {
    let loaded = read_mesh(file).expect("a mesh");
    let tags = file.replace(".obj", ".coping.txt");
    let coping = if std::path::Path::new(&tags).exists() {
        read_tags(&tags, &loaded, file.as_ref())
            .expect("tags")
            .flags
    } else {
        vec![false; loaded.mesh.triangles.len()]
    };
    Given {
        mesh: loaded.mesh,
        coping,
        want: None,
    }
}

fn run(given: &Given, place: impl Fn(DVec3) -> DVec3, cell: CellSize) -> (Part, Extraction) {
    let mut mesh = given.mesh.clone();
    mesh.positions.iter_mut().for_each(|p| *p = place(*p));
    let (part, _) = Part::new(mesh, given.coping.clone(), PartOptions::default()).expect("a part");
    let settings = Settings {
        cell,
        ..Settings::default()
    };
    let result = extract(&part, &settings, &|_, _, _| ()).expect("a mid-surface");
    (part, result)
}

fn shape(e: &Extraction) -> Shape {
    let mut edges: Vec<[u32; 2]> = (e.surface.triangles().iter())
        .flat_map(|t| (0..3).map(move |k| [t.corners[k], t.corners[(k + 1) % 3]]))
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    let fading = |b: &&midsurf::surface::Border| b.kind == midsurf::surface::BorderKind::Fading;
    Shape {
        sheets: e.surface.sheet_count(),
        seams: e.surface.seams().len(),
        junctions: e.surface.junctions().len(),
        fading: e.surface.borders().iter().filter(fading).count(),
        euler: e.surface.vertices().len() as i64 - edges.len() as i64
            + e.surface.triangles().len() as i64,
    }
}

/// What is right.
enum Truth {
    Known(Shape),
    /// What the part has where it lies, as far as cells resolve it.
    AtRest(Box<Extraction>),
}

impl Truth {
    fn agrees(&self, e: &Extraction) -> bool {
        match self {
            Truth::Known(shape) => *shape == self::shape(e),
            Truth::AtRest(rest) => {
                let cell = rest.work.cell.max(e.work.cell);
                let [a, b] = [&**rest, e].map(|e| [1.0, 2.0].map(|n| features(e, n * cell)));
                (0..3).all(|i| a[1][i] <= b[0][i] && b[1][i] <= a[0][i])
            }
        }
    }
}

/// Sheets, seams and fading borders at least so wide or long.
fn features(e: &Extraction, least: f64) -> [usize; 3] {
    let graph = &e.graph;
    let borders = e.surface.borders().iter().zip(graph.borders());
    let long_fading = borders.filter(|(border, data)| {
        border.kind == midsurf::surface::BorderKind::Fading && data.length >= least
    });
    [
        (graph.sheets().iter())
            .filter(|s| s.area >= least * least)
            .count(),
        (graph.seams().iter()).filter(|s| s.length >= least).count(),
        long_fading.count(),
    ]
}

fn judge(part: &Part, e: &Extraction, truth: &Truth) -> Faults {
    let mesh = e.surface.mesh();
    let field = Field::new(part);
    let limit = OUTSIDE * part.bounds().diagonal();
    Faults {
        cracks: e.graph.cracks().len(),
        outside: (mesh.positions.iter())
            .filter(|p| field.signed_clearance(**p) < -limit)
            .count(),
        cut: self_intersections(&mesh).len(),
        flat: mesh
            .faces()
            .filter(|f| has_no_area(&mesh.corners(*f)))
            .count(),
        torn: e.work.counts.torn,
        other_shape: !truth.agrees(e) && e.closed_over.is_empty(),
    }
}

/// Where cracks, triangles that cut each other and those without area are, by the
/// way back to the part as it was given.
fn places(e: &Extraction, back: impl Fn(DVec3) -> DVec3) {
    let mesh = e.surface.mesh();
    let tell = |what: &str, at: DVec3, size: f64| {
        println!("    {what} at {:.4}, {size:.2e} long", back(at))
    };
    for crack in e.graph.cracks() {
        tell("crack", crack.at, crack.length);
    }
    for (f, g) in self_intersections(&mesh) {
        let corners = [f, g].map(|f| mesh.corners(f));
        let middle = corners.iter().flatten().sum::<DVec3>() / 6.0;
        tell(
            "cut",
            middle,
            longest(&corners[0]).min(longest(&corners[1])),
        );
    }
    for corners in mesh.faces().map(|f| mesh.corners(f)).filter(has_no_area) {
        tell(
            "flat",
            corners.iter().sum::<DVec3>() / 3.0,
            longest(&corners),
        );
    }
}

fn longest(&[a, b, c]: &[DVec3; 3]) -> f64 {
    a.distance(b).max(b.distance(c)).max(c.distance(a))
}

fn has_no_area(corners: &[DVec3; 3]) -> bool {
    let [a, b, c] = *corners;
    (b - a).cross(c - a).length() <= NO_AREA * longest(corners).powi(2)
}

/// A part where it lies, with its thickness and shape there; tells what is wrong.
fn at_rest(name: &str, given: Given) -> (Given, f64, Truth) {
    let (part, plain) = run(&given, |p| p, CellSize::Auto);
    let thickness = plain.work.cell;
    println!(
        "{name}: t {thickness:.4}, {:?}",
        given.want.unwrap_or_else(|| shape(&plain))
    );
    let truth = match given.want {
        Some(want) => Truth::Known(want),
        None => Truth::AtRest(Box::new(plain.clone())),
    };
    let faults = judge(&part, &plain, &truth);
    if faults.any() {
        println!("  where it lies: {faults:?}");
    }
    (given, thickness, truth)
}

fn main() -> ExitCode {
    let (mut count, mut seed, mut only, mut files) = (20u64, 1u64, None, Vec::new());
    let mut dump = None;
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        let mut number = || args.next().and_then(|v| v.parse().ok()).expect("a number");
        match arg.as_str() {
            "--count" => count = number(),
            "--seed" => seed = number(),
            "--only" => only = Some(number()),
            "--dump" => dump = args.next(),
            file => files.push(file.to_owned()),
        }
    }
    let mut all_right = true;
    for file in &files {
        let family = FAMILIES.iter().find(|f| f.0 == file);
        let varies = family.is_some_and(|f| f.1);
        let start = |k: u64| Random(seed.wrapping_mul(0x1000_0000_01B3) ^ k);
        let make = |random: &mut Random| make(file, random).unwrap_or_else(|| read(file));
        let fixed = (!varies).then(|| at_rest(file, make(&mut start(0))));
        let (mut right, mut torn, mut lost, mut matched) = (0, 0, 0, 0);
        let mut bad = [0; 5];
        for k in 0..count {
            if only.is_some_and(|o| o != k) {
                continue;
            }
            let mut random = start(k);
            let turn = random.turn();
            let shift = DVec3::from_array(std::array::from_fn(|_| random.unit()));
            let cell = CELLS[0] * (CELLS[1] / CELLS[0]).powf(random.unit());
            let made;
            let known;
            let (given, thickness, truth) = match &fixed {
                Some((given, thickness, truth)) => (given, *thickness, truth),
                None => {
                    made = make(&mut random);
                    known = Truth::Known(made.want.expect("a family's shape"));
                    (&made, THICKNESS, &known)
                }
            };
            let (shift, cell) = (shift * thickness, cell * thickness);
            let (part, result) = run(given, |p| turn * p + shift, CellSize::Length(cell));
            let faults = judge(&part, &result, truth);
            torn += usize::from(faults.torn > 0);
            lost += result.work.counts.lost;
            matched += result.work.counts.matched;
            if let Some(name) = &dump {
                write(name, part.mesh(), &given.coping, &result);
            }
            if !faults.any() {
                right += 1;
                continue;
            }
            let found = [
                faults.cracks > 0,
                faults.outside > 0,
                faults.cut > 0,
                faults.flat > 0,
                faults.other_shape,
            ];
            (0..5).for_each(|i| bad[i] += found[i] as usize);
            println!(
                "  {k}: cell {:.3} t, cracks {} outside {} cut {} flat {} torn {} {}; lost {} matched {}",
                cell / thickness,
                faults.cracks,
                faults.outside,
                faults.cut,
                faults.flat,
                faults.torn,
                if faults.other_shape {
                    format!("{:?}", shape(&result))
                } else {
                    String::new()
                },
                result.work.counts.lost,
                result.work.counts.matched,
            );
            if only.is_some() {
                places(&result, |p| turn.transpose() * (p - shift));
            }
            all_right = false;
        }
        println!(
            "{file}: right {right} of {count}; cracks {} outside {} cut {} flat {} shape {}; \
             torn {torn} lost {lost} matched {matched}",
            bad[0], bad[1], bad[2], bad[3], bad[4]
        );
    }
    ExitCode::from(!all_right as u8)
}

/// Writes a placed part, its tags and its mid-surface, to be looked at.
fn write(name: &str, part: &TriMesh, coping: &[bool], result: &Extraction) {
    let text = |mesh: &TriMesh| {
        let mut text = String::new();
        for p in &mesh.positions {
            text += &format!("v {} {} {}\n", p.x, p.y, p.z);
        }
        for [a, b, c] in &mesh.triangles {
            text += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
        }
        text
    };
    let tags: String = (coping.iter().enumerate().filter(|(_, c)| **c))
        .map(|(f, _)| format!("{f}\n"))
        .collect();
    for (end, text) in [
        (".obj", text(part)),
        (".coping.txt", tags),
        (".mid.obj", text(&result.surface.mesh())),
    ] {
        std::fs::write(format!("{name}{end}"), text).expect("a file to write");
    }
}
