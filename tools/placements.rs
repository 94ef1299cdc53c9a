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
//! Numbers of bad placements are told, so that `--only` repeats one.
//!
//! A part is a file with its `PART.coping.txt`, if there is one, and what is
//! right is its own topology where it lies at cells of one thickness; or one of
//! the families made here, `torus` (a closed tube) and `wye` (three plates along
//! one line), for which it is known.

use std::process::ExitCode;

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

/// A closed tube: two tori one in the other, each of `ROUND` by `ACROSS` quads.
fn torus() -> Given {
    const ROUND: u32 = 64;
    const ACROSS: u32 = 32;
    const RADIUS: f64 = 12.0;
    let turn = |k: u32, n: u32| std::f64::consts::TAU * f64::from(k % n) / f64::from(n);
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for (tube, outwards) in [(4.0, true), (3.0, false)] {
        let first = positions.len() as u32;
        for i in 0..ROUND {
            for j in 0..ACROSS {
                let (u, v) = (turn(i, ROUND), turn(j, ACROSS));
                let from_axis = RADIUS + tube * v.cos();
                positions.push(DVec3::new(
                    from_axis * u.cos(),
                    from_axis * u.sin(),
                    tube * v.sin(),
                ));
            }
        }
        let at = |i: u32, j: u32| first + (i % ROUND) * ACROSS + j % ACROSS;
        for (i, j) in (0..ROUND).flat_map(|i| (0..ACROSS).map(move |j| (i, j))) {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            let halves = [[a, b, c], [a, c, d]];
            triangles.extend(halves.map(|[p, q, r]| if outwards { [p, q, r] } else { [p, r, q] }));
        }
    }
    Given {
        coping: vec![false; triangles.len()],
        mesh: TriMesh {
            positions,
            triangles,
        },
        want: Some(Shape {
            sheets: 1,
            seams: 0,
            junctions: 0,
            fading: 0,
            euler: 0,
        }),
    }
}

/// Three plates that meet along a line, a third of a turn apart.
fn wye() -> Given {
    const LENGTH: f64 = 14.0;
    const HEIGHT: f64 = 12.0;
    let arm = |k: u32| std::f64::consts::TAU * f64::from(k) / 3.0;
    // Counter-clockwise: an arm's two end corners, then the corner between arms.
    let mut outline = Vec::new();
    for k in 0..3 {
        let (sin, cos) = arm(k).sin_cos();
        let (along, left) = (DVec3::new(cos, sin, 0.0), DVec3::new(-sin, cos, 0.0));
        let reflex = 60_f64.to_radians().tan().recip();
        outline.extend([
            LENGTH * along - left,
            LENGTH * along + left,
            reflex * along + left,
        ]);
    }
    let n = outline.len() as u32;
    let top = outline.iter().map(|p| *p + HEIGHT * DVec3::Z);
    let positions: Vec<DVec3> = outline.iter().copied().chain(top).collect();
    let mut caps = vec![[2, 5, 8]];
    for k in 0..3 {
        let [before, a, b, after] = [(3 * k + 8) % 9, 3 * k, 3 * k + 1, 3 * k + 2];
        caps.extend([[before, a, b], [before, b, after]]);
    }
    let (mut triangles, mut coping) = (Vec::new(), Vec::new());
    for [a, b, c] in caps {
        triangles.extend([[a, c, b], [a + n, b + n, c + n]]);
        coping.extend([true; 2]);
    }
    for a in 0..n {
        let b = (a + 1) % n;
        triangles.extend([[a, b, b + n], [a, b + n, a + n]]);
        coping.extend([a % 3 == 0; 2]);
    }
    Given {
        mesh: TriMesh {
            positions,
            triangles,
        },
        coping,
        want: Some(Shape {
            sheets: 3,
            seams: 1,
            junctions: 0,
            fading: 0,
            euler: 1,
        }),
    }
}

fn given(name: &str) -> Given {
    match name {
        "torus" => torus(),
        "wye" => wye(),
        file => read(file),
    }
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

fn judge(part: &Part, e: &Extraction, want: &Shape) -> Faults {
    let mesh = e.surface.mesh();
    let field = Field::new(part);
    let limit = OUTSIDE * part.bounds().diagonal();
    let flat = |&[a, b, c]: &[DVec3; 3]| {
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        (b - a).cross(c - a).length() <= NO_AREA * longest * longest
    };
    Faults {
        cracks: e.graph.cracks().len(),
        outside: (mesh.positions.iter())
            .filter(|p| field.signed_clearance(**p) < -limit)
            .count(),
        cut: self_intersections(&mesh).len(),
        flat: mesh.faces().filter(|f| flat(&mesh.corners(*f))).count(),
        torn: e.work.counts.torn,
        other_shape: shape(e) != *want && e.closed_over.is_empty(),
    }
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
        let given = given(file);
        let (part, plain) = run(&given, |p| p, CellSize::Auto);
        let thickness = plain.work.cell;
        let want = given.want.unwrap_or_else(|| shape(&plain));
        let faults = judge(&part, &plain, &want);
        println!("{file}: t {thickness:.4}, {want:?}");
        if faults.any() {
            println!("  where it lies: {faults:?}");
        }
        let (mut right, mut torn, mut lost, mut matched) = (0, 0, 0, 0);
        let mut bad = [0; 5];
        for k in 0..count {
            if only.is_some_and(|o| o != k) {
                continue;
            }
            let mut random = Random(seed.wrapping_mul(0x1000_0000_01B3) ^ k);
            let turn = random.turn();
            let shift = DVec3::from_array(std::array::from_fn(|_| random.unit())) * thickness;
            let cell = thickness * CELLS[0] * (CELLS[1] / CELLS[0]).powf(random.unit());
            let (part, result) = run(&given, |p| turn * p + shift, CellSize::Length(cell));
            let faults = judge(&part, &result, &want);
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
