//! Tables I to VII of Liu and Wang, "Fast Intersection-free Offset Surface
//! Generation from Freeform Models with Triangular Meshes", on models of our own,
//! the paper's figures beside ours. Theirs are of other models, of eight cores of
//! 2008 and of 512 cells unless a table says otherwise.
//!
//! `cargo bench --bench offset`; with a number after `--`, so many cells along the
//! result instead of 256. Threads as RAYON_NUM_THREADS says.

use midsurf::io::{read_control, read_mesh};
use midsurf::mesh::{Part, PartOptions, TriMesh};
use midsurf::offset::Filters;
use midsurf::offset::{Offset, Settings, offset};
use midsurf::subdivide::{Boundary, Cage, tessellate};

/// A model and its name.
struct Model {
    name: &'static str,
    part: Part,
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    // Neither tests nor a mere listing of them.
    if !args.iter().any(|arg| arg == "--bench") {
        return;
    }
    let cells = args.iter().find_map(|arg| arg.parse().ok());
    let cells = cells.unwrap_or(256.0);
    println!(
        "{cells} cells along the result, {} threads",
        rayon::current_num_threads()
    );
    let models = [
        file("bracket"),
        file("enclosure"),
        cage("genus3", 2, 6),
        cage("head", 2, 3),
    ];
    times(&models, cells);
    resolutions();
    distances(&models[3], cells);
    filters(&models[3], cells);
    splits(&models[3], cells);
    rings(&models, cells);
    errors(&models, cells);
}

fn part(name: &'static str, mesh: TriMesh) -> Model {
    let flags = vec![false; mesh.triangles.len()];
    let (part, _) = Part::new(mesh, flags, PartOptions::default()).expect("a closed model");
    Model { name, part }
}

fn file(name: &'static str) -> Model {
    let file = format!("{}/fixtures/{name}.obj", env!("CARGO_MANIFEST_DIR"));
    part(name, read_mesh(file).expect("fixture").mesh)
}

/// A limit surface.
fn cage(name: &'static str, level: u32, samples: usize) -> Model {
    let file = format!("{}/fixtures/cages/{name}.obj", env!("CARGO_MANIFEST_DIR"));
    let control = read_control(file).expect("fixture");
    let cage = Cage::new(control.positions, &control.faces).expect("a cage");
    let (mesh, _) = tessellate(&cage, level, samples, Boundary::default()).expect("a surface");
    part(name, mesh)
}

/// `r` relative to the diagonal, as in the paper.
fn run(model: &Model, r: f64, cells: f64, change: impl Fn(&mut Settings)) -> Option<Offset> {
    let distance = r * model.part.bounds().diagonal();
    let mut settings = Settings::new(&model.part, distance);
    settings.cell *= Settings::CELLS / cells;
    settings.memory_limit = u64::MAX;
    change(&mut settings);
    // Nothing may be left of a thin part.
    offset(&model.part, &settings, &|_, _, _| ()).ok()
}

fn thousands(n: usize) -> String {
    format!("{:.1}k", n as f64 / 1000.0)
}

fn times(models: &[Model], cells: f64) {
    println!(
        "\nTable I: seconds. Paper: 7k to 400k triangles, T_s 0.06 to 4.2, T_d 5 to 17, T_c 13 to 18, total 17 to 38"
    );
    println!(
        "{:<12} {:>8} {:>6} {:>7} {:>7} {:>7} {:>7} {:>9}",
        "model", "F#", "r", "T_s", "T_d", "T_c", "total", "triangles"
    );
    for model in models {
        for r in [-0.01, 0.01, 0.03] {
            let Some(o) = run(model, r, cells, |_| ()) else {
                println!("{:<12} {r:>15} nothing is left", model.name);
                continue;
            };
            let [s, d, c] = [o.field_seconds, o.work.band_seconds, o.work.contour_seconds];
            println!(
                "{:<12} {:>8} {r:>6} {s:>7.3} {d:>7.3} {c:>7.3} {:>7.3} {:>9}",
                model.name,
                thousands(model.part.triangle_count()),
                s + d + c,
                o.mesh.triangles.len()
            );
        }
    }
}

fn total(o: &Offset) -> f64 {
    o.field_seconds + o.work.band_seconds + o.work.contour_seconds
}

fn resolutions() {
    println!(
        "\nTable II: seconds by cells, r = 0.02. Paper: 40k 0.53 0.98 3.34 21.6; 400k 4.6 5.3 8.4 28.7"
    );
    println!("{:>8} {:>7} {:>7} {:>7} {:>7}", "F#", 64, 128, 256, 512);
    for (level, samples) in [(2, 4), (3, 7)] {
        let model = cage("genus3", level, samples);
        let row = [64.0, 128.0, 256.0, 512.0]
            .map(|cells| run(&model, 0.02, cells, |_| ()).map_or(f64::NAN, |o| total(&o)));
        let shown = row.map(|s| format!("{s:>7.2}")).join(" ");
        println!("{:>8} {shown}", thousands(model.part.triangle_count()));
    }
}

fn distances(model: &Model, cells: f64) {
    println!(
        "\nTable III: seconds by r, {}. Paper, 200k: 19.7 21.2 23.1 26.6 31.7 50.7 for 0.01 to 0.32 of another model",
        model.name
    );
    for r in [-0.02, -0.01, 0.01, 0.02, 0.04, 0.08, 0.16, 0.32] {
        match run(model, r, cells, |_| ()) {
            Some(o) => println!("{r:>6} {:>7.3}", total(&o)),
            None => println!("{r:>6} nothing is left"),
        }
    }
}

fn filters(model: &Model, cells: f64) {
    println!(
        "\nTable IV: distance computations by filters, {}, thousands, tests of boxes in brackets.",
        model.name
    );
    println!(
        "Paper, 60k, 512 cells, r = 0.02: BB8 6029 BB16 3113 BB32 2073 BB64 1506, with SD the same, BB128 + OT 775 (169), BB128 + SD + OT 534 (139)"
    );
    println!(
        "      r = -0.02: BB8 5243 BB16 2785 BB32 1790 BB64 1322, with SD 4194 2228 1307 819, BB128 + OT 620 (152), BB128 + SD + OT 240 (72)"
    );
    for r in [-0.02, -0.01, 0.01, 0.02, 0.08, 0.32] {
        print!("{r:>6}");
        for (octree, signed) in [(false, false), (false, true), (true, false), (true, true)] {
            let name = match (octree, signed) {
                (false, false) => "BB",
                (false, true) => "BB+SD",
                (true, false) => "BB+OT",
                (true, true) => "BB+SD+OT",
            };
            let sides: &[i32] = if octree { &[128] } else { &[8, 16, 32, 64] };
            for &box_cells in sides {
                let filters = Filters {
                    box_cells,
                    signed,
                    octree,
                };
                match run(model, r, cells, |s| s.filters = filters) {
                    Some(o) => {
                        let f = o.work.filters;
                        print!(" {name}{box_cells} {}", f.distances / 1000);
                        if octree {
                            print!(" ({})", f.box_tests / 1000);
                        }
                    }
                    None => print!(" {name}{box_cells} -"),
                }
            }
        }
        println!();
    }
}

fn splits(model: &Model, cells: f64) {
    println!(
        "\nTable V: crossings found after 0, 1, 2 and up to 6 splits, {}. Bisection: under 7 % within 6.",
        model.name
    );
    println!(
        "Paper: r = -0.02 52 19.8 13.4 98.8; 0.02 71.5 15.4 7 99.5; 0.32 97.6 1.2 0.6 99.9; 64 cells 6.2 15.5 27 97.7"
    );
    let line = |what: String, o: Option<Offset>| {
        let Some(o) = o else { return };
        let c = o.work.crossings;
        let share = |n: u64| 100.0 * n as f64 / c.edges.max(1) as f64;
        println!(
            "{what:<12} {:>8} {:>6.1} {:>6.1} {:>6.1} {:>6.1}",
            c.edges,
            share(c.by_splits[0]),
            share(c.by_splits[1]),
            share(c.by_splits[2]),
            share(c.by_splits[..=6].iter().sum())
        );
    };
    for r in [-0.02, -0.01, 0.01, 0.02, 0.08, 0.32] {
        line(format!("r {r}"), run(model, r, cells, |_| ()));
    }
    for cells in [64.0, 128.0, 256.0] {
        line(format!("{cells} cells"), run(model, 0.02, cells, |_| ()));
    }
}

fn rings(models: &[Model], cells: f64) {
    println!(
        "\nTable VI: triangles around crossed edges. Paper, 60k to 1M: 325k to 1,041k triangles in 0.015 to 0.062 s (0.031 to 0.11 s by edge and polygon tests)"
    );
    println!(
        "{:<12} {:>9} {:>9} {:>8} {:>8}",
        "model", "edges", "triangles", "concave", "s"
    );
    for model in models {
        // Without the error-driven step, as theirs.
        let Some(o) = run(model, 0.02, cells, |s| s.tolerance = f64::INFINITY) else {
            continue;
        };
        println!(
            "{:<12} {:>9} {:>9} {:>8} {:>8.3}",
            model.name,
            o.work.rings.rings,
            o.mesh.triangles.len(),
            o.work.rings.concave,
            o.work.ring_seconds
        );
    }
}

fn errors(models: &[Model], cells: f64) {
    println!(
        "\nTable VII: errors over r: vertices mean and max, centres of triangles mean and max."
    );
    println!(
        "Paper, mean and max: sharp models 2e-5 to 7e-4 and 7e-4 to 0.033, freeform 9e-5 to 8e-4 and 0.027 to 0.094"
    );
    println!("(the same without the error-driven step in brackets)");
    for model in models {
        for r in [-0.01, 0.01, 0.03] {
            let Some(o) = run(model, r, cells, |_| ()) else {
                continue;
            };
            let plain = run(model, r, cells, |s| s.tolerance = f64::INFINITY);
            let distance = r.abs() * model.part.bounds().diagonal();
            let show = |o: &Offset| {
                let all = [o.corner_deviation, o.centre_deviation];
                all.map(|d| format!("{:.1e} {:.1e}", d.mean / distance, d.max / distance))
                    .join(" ")
            };
            let plain = plain.map_or(String::new(), |o| show(&o));
            println!("{:<12} {r:>6} {} ({plain})", model.name, show(&o));
        }
    }
}
