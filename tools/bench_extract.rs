//! Extraction, in time and memory: the moulded enclosure at the size of the
//! paper's example, and a ribbed plate of a million triangles at four cell sizes.
//!
//! Beside it, what a nearest-point query of parry3d takes on the enclosure along a
//! walk: machines differ, and processor time for each active cell over that
//! does not. Shards of the enclosure are computed one after the other and joined.
//!
//! `cargo bench --bench extract`; with numbers after `--`, these wall thicknesses
//! are the cells of the plate (default 2, 1, 0.5, 0.25). Each plate is extracted in a process
//! of its own, so that its peak memory is its own. Threads as RAYON_NUM_THREADS says.

use std::process::Command;
use std::time::Instant;

use glam::DVec3;
use midsurf::coping::read_tags;
use midsurf::extract::{Extraction, Settings, extract};
use midsurf::io::read_mesh;
use midsurf::mesh::{Part, PartOptions, TriMesh};
use midsurf::settings::progress::Stop;
use midsurf::shard::{ShardOf, merge, shard};
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQuery;

/// Active cells in the paper's example of 2,600 triangles.
const PAPER_CELLS: f64 = 8500.0;
/// Triangles that the plate has at least.
const PLATE_TRIANGLES: usize = 1_000_000;
/// First argument of the child processes.
const CHILD: &str = "--one-plate";

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    match args.first().map(String::as_str) {
        Some(CHILD) => one_plate(args[1].parse().expect("a cell size")),
        // Neither tests nor a mere listing of them.
        _ if !args.iter().any(|arg| arg == "--bench") => (),
        _ => {
            enclosure();
            let cells: Vec<f64> = args.iter().filter_map(|arg| arg.parse().ok()).collect();
            plates(if cells.is_empty() {
                &[2.0, 1.0, 0.5, 0.25]
            } else {
                &cells
            });
        }
    }
}

fn run(part: &Part, cell: f64) -> (Extraction, f64) {
    let settings = Settings {
        cell: midsurf::CellSize::Length(cell),
        memory_limit: u64::MAX,
        ..Settings::default()
    };
    let start = Instant::now();
    let result = extract(part, &settings, &|_, _, _| ()).expect("a mid-surface");
    (result, start.elapsed().as_secs_f64())
}

/// The enclosure at the cell size that gives the paper's number of active cells.
fn enclosure() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/");
    let file = format!("{folder}enclosure.obj");
    let loaded = read_mesh(&file).expect("fixture");
    let tags = format!("{folder}enclosure.coping.txt");
    let coping = read_tags(&tags, &loaded, file.as_ref()).expect("tags");
    let (part, _) =
        Part::new(loaded.mesh, coping.flags, PartOptions::default()).expect("a sound part");

    // The number of cells goes with the inverse square of the size.
    let mut cell = 2.0;
    for _ in 0..4 {
        let (result, _) = run(&part, cell);
        cell *= (result.work.counts.cells as f64 / PAPER_CELLS).sqrt();
    }
    let mut seconds = Vec::new();
    let mut work = None;
    let before = processor_seconds();
    for _ in 0..5 {
        let (result, time) = run(&part, cell);
        seconds.push(time);
        work = Some(result.work);
    }
    let spent = before.zip(processor_seconds()).map(|(a, b)| (b - a) / 5.0);
    seconds.sort_by(f64::total_cmp);
    let work = work.expect("five runs");
    println!(
        "enclosure: {} triangles, cell {cell:.3}, {} active cells, {:.2} queries an edge: \
         median {:.3} s, fastest {:.3} s, of it trace {:.3} s; peak {} MB",
        part.triangle_count(),
        work.counts.cells,
        work.counts.queries_per_edge,
        seconds[2],
        seconds[0],
        work.trace_seconds,
        memory("VmHWM:").map_or("?".into(), |bytes| format!("{:.0}", bytes / 1e6)),
    );
    if let Some(spent) = spent {
        let query = parry_query(part.mesh());
        let a_cell = spent / work.counts.cells as f64;
        println!(
            "processor: {:.1} microseconds a cell, {:.0} walking queries of parry3d ({:.2} microseconds)",
            1e6 * a_cell,
            a_cell / query,
            1e6 * query
        );
    }
    shards(&part, cell);
}

/// Seconds of a nearest-point query of parry3d along walks between neighbouring
/// points of the mesh.
fn parry_query(mesh: &TriMesh) -> f64 {
    let point = |p: DVec3| Vector::new(p.x, p.y, p.z);
    let vertices = mesh.positions.iter().copied().map(point).collect();
    let solid = parry3d_f64::shape::TriMesh::new(vertices, mesh.triangles.clone());
    let solid = solid.expect("a sound part");
    let walk: Vec<DVec3> = (mesh.faces())
        .flat_map(|face| {
            let [a, b, c] = mesh.corners(face);
            let inwards = (b - a).cross(c - a).normalize_or_zero();
            (0..20).map(move |k| a.lerp(b.midpoint(c), f64::from(k) / 20.0) - 0.4 * inwards)
        })
        .collect();
    let start = Instant::now();
    for &p in &walk {
        std::hint::black_box(solid.project_local_point(point(p), false));
    }
    start.elapsed().as_secs_f64() / walk.len() as f64
}

/// Processor time of this process so far, user and system; on Linux.
fn processor_seconds() -> Option<f64> {
    /// Of the kernel's clock in `/proc`.
    const TICKS: f64 = 100.0;
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = stat.rsplit(')').next()?.split_whitespace().collect();
    let ticks = |k: usize| fields.get(k)?.parse::<f64>().ok();
    Some((ticks(11)? + ticks(12)?) / TICKS)
}

/// The same in shards, one after the other.
fn shards(part: &Part, cell: f64) {
    println!("\n| shards | slowest seconds | all seconds | bytes in all | merge seconds |");
    println!("|{}", " --- |".repeat(5));
    let settings = Settings {
        cell: midsurf::CellSize::Length(cell),
        ..Settings::default()
    };
    for count in [1, 4, 16] {
        let (mut slowest, mut all, mut bytes) = (0.0_f64, 0.0, 0);
        let mut made = Vec::new();
        for index in 1..=count {
            let which = ShardOf::new(index, count).expect("one of them");
            let start = Instant::now();
            let one = shard(part, &settings, which, &|_, _, _| (), &Stop::default());
            let seconds = start.elapsed().as_secs_f64();
            (slowest, all) = (slowest.max(seconds), all + seconds);
            let one = one.expect("a shard");
            let mut file = Vec::new();
            one.write(&mut file).expect("memory");
            bytes += file.len();
            made.push(one);
        }
        let start = Instant::now();
        merge(made, None, &|_, _, _| (), &Stop::default()).expect("a whole set");
        let merging = start.elapsed().as_secs_f64();
        println!("| {count} | {slowest:.3} | {all:.3} | {bytes} | {merging:.3} |");
    }
}

/// The table of the plate, a child process a row.
fn plates(cells: &[f64]) {
    println!("\nribbed plate, {} threads", rayon::current_num_threads());
    println!(
        "| cell / t | part triangles | active cells | triangles out | cracks | seconds | trace | peak MB \
         | microseconds a cell | bytes a cell |"
    );
    println!("|{}", " --- |".repeat(10));
    let program = std::env::current_exe().expect("own name");
    let mut rows: Vec<[f64; 3]> = Vec::new();
    for cell in cells {
        let child = Command::new(&program)
            .args([CHILD, &cell.to_string()])
            .output();
        match child {
            Ok(output) if output.status.success() => {
                let row = String::from_utf8_lossy(&output.stdout);
                print!("{row}");
                let columns: Vec<&str> = row.split('|').map(str::trim).collect();
                // Active cells, seconds, peak megabytes.
                let figure = |column: usize| columns[column].parse().unwrap_or(f64::NAN);
                rows.push([figure(3), figure(6), figure(8)]);
            }
            Ok(output) => println!("| {cell} | {} |", output.status),
            Err(error) => println!("| {cell} | {error} |"),
        }
    }
    for pair in rows.windows(2) {
        let [cells, seconds, megabytes] = [0, 1, 2].map(|k| pair[1][k] - pair[0][k]);
        println!(
            "from {} to {} cells: {:.1} microseconds and {:.0} bytes for each further cell",
            pair[0][0],
            pair[1][0],
            1e6 * seconds / cells,
            1e6 * megabytes / cells
        );
    }
}

fn one_plate(cell: f64) {
    let (mesh, coping) = ribbed_plate(8, 8, PLATE_TRIANGLES);
    let (part, _) = Part::new(mesh, coping, PartOptions::default()).expect("a sound part");
    // What the part itself takes is not the lattice's.
    let before = memory("VmRSS:");
    let (result, seconds) = run(&part, cell * PLATE_THICKNESS);
    let peak = memory("VmHWM:");
    let cells = result.work.counts.cells as f64;
    let own = peak
        .zip(before)
        .map(|(peak, before)| (peak - before) / cells);
    let shown = |value: Option<f64>| value.map_or("?".into(), |value| format!("{value:.0}"));
    println!(
        "| {cell} | {} | {} | {} | {} | {seconds:.2} | {:.2} | {} | {:.1} | {} |",
        part.triangle_count(),
        result.work.counts.cells,
        result.surface.triangles().len(),
        result.graph.cracks().len(),
        result.work.trace_seconds,
        shown(peak.map(|bytes| bytes / 1e6)),
        1e6 * seconds / cells,
        shown(own),
    );
}

/// A line of the process' memory figures, in bytes; on Linux. `VmRSS:` is what
/// it holds, `VmHWM:` the most it ever held.
fn memory(line: &str) -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let text = status.lines().find_map(|l| l.strip_prefix(line))?;
    let kibibytes: f64 = text.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024.0 * kibibytes)
}

/// Thickness of plate and ribs.
const PLATE_THICKNESS: f64 = 2.0;
/// Distance from rib to rib, middle to middle.
const PITCH: f64 = 40.0;
/// Height of the ribs over the plate.
const RIB_HEIGHT: f64 = 20.0;

/// A flat plate with `nx` ribs across x and `ny` across y, of at least
/// `triangles` triangles, and its coping: the rims of the plate, the tops and
/// the ends of the ribs.
///
/// The ribs run from rim to rim. Seen from above, the part is a grid of boxes,
/// rib columns and rows thin, the rest wide; a box is solid up to the plate's
/// top, over ribs up to theirs. Each box is cut into smaller ones as finely as
/// the number of triangles asks, and every outer face gives two triangles.
fn ribbed_plate(nx: usize, ny: usize, triangles: usize) -> (TriMesh, Vec<bool>) {
    let mut step = PLATE_THICKNESS;
    loop {
        let (mesh, coping) = ribbed_plate_of_step(nx, ny, step);
        if mesh.triangles.len() >= triangles {
            return (mesh, coping);
        }
        // Faces go with the inverse square; a little more, to get there.
        step *= 0.99 * (mesh.triangles.len() as f64 / triangles as f64).sqrt();
    }
}

fn ribbed_plate_of_step(nx: usize, ny: usize, step: f64) -> (TriMesh, Vec<bool>) {
    let (xs, rib_x) = stations(nx, step);
    let (ys, rib_y) = stations(ny, step);
    let mut zs = cut(0.0, PLATE_THICKNESS, step);
    let plate_layers = zs.len();
    zs.extend(cut(PLATE_THICKNESS, PLATE_THICKNESS + RIB_HEIGHT, step));
    zs.push(PLATE_THICKNESS + RIB_HEIGHT);

    let size = [xs.len() - 1, ys.len() - 1, zs.len() - 1];
    // Whether a small box is solid; outside the grid nothing is.
    let solid = |at: [usize; 3]| {
        (0..3).all(|k| at[k] < size[k]) && (at[2] < plate_layers || rib_x[at[0]] || rib_y[at[1]])
    };
    let mut number = rustc_hash::FxHashMap::default();
    let mut mesh = TriMesh::default();
    let mut coping = Vec::new();
    for i in 0..size[0] {
        for j in 0..size[1] {
            // Inside a broad stretch of plate there is nothing above it.
            for k in 0..size[2] {
                let at = [i, j, k];
                if !solid(at) {
                    break;
                }
                for axis in 0..3 {
                    for up in [false, true] {
                        let mut beyond = at;
                        // Wraps below zero, which is outside too.
                        beyond[axis] = at[axis].wrapping_add(if up { 1 } else { usize::MAX });
                        if solid(beyond) {
                            continue;
                        }
                        let on_rim = axis < 2 && beyond[axis] >= size[axis];
                        let on_top = axis == 2 && up && k >= plate_layers;
                        let corners = face(at, axis, up).map(|corner| {
                            *number.entry(corner).or_insert_with(|| {
                                let [x, y, z] = corner;
                                mesh.positions.push(DVec3::new(xs[x], ys[y], zs[z]));
                                mesh.positions.len() as u32 - 1
                            })
                        });
                        let [a, b, c, d] = corners;
                        mesh.triangles.extend([[a, b, c], [a, c, d]]);
                        coping.extend([on_rim || on_top; 2]);
                    }
                }
            }
        }
    }
    (mesh, coping)
}

/// Corners of a box's face, counter-clockwise from outside.
fn face(at: [usize; 3], axis: usize, up: bool) -> [[usize; 3]; 4] {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let steps = if up {
        [(0, 0), (1, 0), (1, 1), (0, 1)]
    } else {
        [(0, 0), (0, 1), (1, 1), (1, 0)]
    };
    steps.map(|(du, dv)| {
        let mut corner = at;
        corner[axis] += usize::from(up);
        corner[u] += du;
        corner[v] += dv;
        corner
    })
}

/// Grid lines along one axis with `ribs` ribs, and for each stretch between
/// two lines whether a rib is there.
fn stations(ribs: usize, step: f64) -> (Vec<f64>, Vec<bool>) {
    let half = 0.5 * PLATE_THICKNESS;
    let mut lines = Vec::new();
    let mut rib = Vec::new();
    let mut from = 0.0;
    for n in 0..ribs {
        let middle = PITCH * (n as f64 + 0.5);
        for (to, is_rib) in [(middle - half, false), (middle + half, true)] {
            lines.extend(cut(from, to, step));
            rib.resize(lines.len(), is_rib);
            from = to;
        }
    }
    let end = PITCH * ribs as f64;
    lines.extend(cut(from, end, step));
    rib.resize(lines.len(), false);
    lines.push(end);
    (lines, rib)
}

/// Points from `from` up to but without `to`, at most `step` apart.
fn cut(from: f64, to: f64, step: f64) -> Vec<f64> {
    let count = ((to - from) / step).ceil().max(1.0);
    (0..count as usize)
        .map(|i| from + (to - from) * i as f64 / count)
        .collect()
}
