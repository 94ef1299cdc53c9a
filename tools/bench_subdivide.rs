//! Hollow solids from control meshes: time of a million points, and how many
//! triangles of the inner surface fold.
//!
//! `cargo bench --bench subdivide`. Times are those of one thread, then of as
//! many as RAYON_NUM_THREADS says.

use std::time::Instant;

use midsurf::io::read_control;
use midsurf::subdivide::{
    Boundary, Cage, Crust, Grid, LimitSurface, Quads, Scheme, fold_free, folded, refine,
};

/// Points that are evaluated at least.
const POINTS: usize = 1_000_000;
/// Runs of which the median and the fastest are told.
const RUNS: usize = 9;
/// Levels of the tables.
const LEVELS: u32 = 4;
/// Samples along a side of a face in the tables, at every level.
const SAMPLES: usize = 8;

fn main() {
    // Neither tests nor a mere listing of them.
    if !std::env::args().any(|arg| arg == "--bench") {
        return;
    }
    println!("points with unit normal and crust");
    println!(
        "| cage | level | points | set-up s | fresh memory s | median s | fastest s | ns a point | threads |"
    );
    println!("|{}", " --- |".repeat(9));
    for (name, level) in [("torus", 1), ("genus3", 1), ("valence_mix", 0), ("head", 1)] {
        let threads = rayon::current_num_threads();
        for threads in [1, threads] {
            million(name, level, threads);
            if threads == 1 && rayon::current_num_threads() == 1 {
                break;
            }
        }
    }
    println!(
        "\ninverted triangles of the inner surface, crust / direct, and the fold-free thickness"
    );
    println!(
        "The paper's Fig. 3: direct offsetting creases, the more the more points and the thicker;\n\
         its Fig. 9: after three subdivisions the crust creases too. Levels 0 to 3:"
    );
    for (name, thickness) in [
        ("spike", 0.1),
        ("spike", 0.15),
        ("head", 0.02),
        ("cube", 0.4),
        ("cube", 0.6),
        ("genus3", 0.25),
    ] {
        folds(name, thickness);
    }
}

fn cage(name: &str, level: u32) -> Quads {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/cages/");
    let control = read_control(format!("{folder}{name}.obj")).expect("fixture");
    let cage = Cage::new(control.positions, &control.faces).expect("a sound cage");
    let mut mesh = Quads::new(cage).expect("quadrilaterals");
    for _ in 0..level {
        mesh = refine(mesh.cage(), Boundary::EdgeAndCorner).expect("a small cage");
    }
    mesh
}

/// A row of the first table.
fn million(name: &str, level: u32, threads: usize) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    let pool = pool.build().expect("threads");
    pool.install(|| {
        let mesh = cage(name, level);
        let start = Instant::now();
        let surface = LimitSurface::new(mesh, Boundary::EdgeAndCorner).expect("a surface");
        let set_up = start.elapsed().as_secs_f64();
        let crust = Crust::offset(&surface, 0.1);
        let mut n = 1;
        while Grid::new(&surface, n).expect("few").len() < POINTS {
            n += 1;
        }
        let grid = Grid::new(&surface, n).expect("few");
        let per_million = POINTS as f64 / grid.len() as f64;
        let start = Instant::now();
        let mut samples = grid.sample(&surface, &crust, Scheme::Crust);
        let fresh = start.elapsed().as_secs_f64() * per_million;
        let mut seconds: Vec<f64> = (0..RUNS)
            .map(|_| {
                let start = Instant::now();
                grid.sample_into(&surface, &crust, Scheme::Crust, &mut samples);
                std::hint::black_box(&samples);
                start.elapsed().as_secs_f64() * per_million
            })
            .collect();
        seconds.sort_by(f64::total_cmp);
        println!(
            "| {name} | {level} | {} | {set_up:.4} | {fresh:.4} | {:.4} | {:.4} | {:.1} | {threads} |",
            grid.len(),
            seconds[RUNS / 2],
            seconds[0],
            seconds[RUNS / 2] * 1e9 / POINTS as f64
        );
    });
}

/// A cage of the second table.
fn folds(name: &str, thickness: f64) {
    println!("\n{name}, thickness {thickness}");
    println!(
        "| level | triangles | crust | direct | crust folds beyond | direct folds beyond | ratio |"
    );
    println!("|{}", " --- |".repeat(7));
    for level in 0..LEVELS {
        let mesh = cage(name, level);
        let surface = LimitSurface::new(mesh, Boundary::EdgeAndCorner).expect("a surface");
        let crust = Crust::offset(&surface, thickness);
        let grid = Grid::new(&surface, SAMPLES).expect("few");
        let triangles = grid.triangles();
        let [by_crust, direct] = [Scheme::Crust, Scheme::Direct].map(|scheme| {
            let samples = grid.sample(&surface, &crust, scheme);
            folded(&triangles, &samples).len()
        });
        let [a, b] = fold_free(&surface).map(|free| free.thickness);
        println!(
            "| {level} | {} | {by_crust} | {direct} | {a:.4} | {b:.4} | {:.3} |",
            triangles.len(),
            a / b
        );
    }
}
