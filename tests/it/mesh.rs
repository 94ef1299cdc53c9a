//! `midsurf mesh`: a written mid-surface remeshed, with its part and without.

use midsurf::io::{read_mesh, read_surface};
use midsurf::mesh::self_intersections;
use midsurf::surface::MidSurface;
use midsurf::surface::graph::{Counts, SheetGraph};
use serde_json::Value;

use crate::common::{Desk, fixture, text};

/// The mid-surface of a fixture as `mid.ply`, and the part's and tags' names.
fn extracted(desk: &Desk, part: &str, more: &[&str]) -> [String; 2] {
    let files = [format!("{part}.obj"), format!("{part}.coping.txt")]
        .map(|name| fixture(&name).to_str().unwrap().to_owned());
    let mut args = vec!["extract", &files[0], "--coping", &files[1], "-q"];
    args.extend(more);
    let output = desk.run(&args);
    assert!(output.status.success(), "{}", text(&output.stderr));
    files
}

fn report(desk: &Desk, args: &[&str]) -> Value {
    let all = [&["mesh"][..], args, &["-q", "--json", "-"]].concat();
    let output = desk.run(&all);
    assert!(
        output.status.success(),
        "{args:?}: {}",
        text(&output.stderr)
    );
    serde_json::from_slice(&output.stdout).unwrap()
}

fn surface(desk: &Desk, name: &str) -> MidSurface {
    read_surface(&desk.path(name), None).unwrap().surface
}

fn topology(surface: &MidSurface) -> Counts {
    Counts {
        vertices: 0,
        edges: 0,
        triangles: 0,
        lone_feet: 0,
        ..*SheetGraph::of(surface).counts()
    }
}

#[test]
fn with_the_part_it_is_as_good_as_remeshed_at_once() {
    for part in ["tee", "open_box", "cylinder_shell"] {
        let desk = Desk::new();
        let [part, tags] = extracted(&desk, part, &["-o", "mid.ply"]);
        extracted_as(&desk, &part, &tags, "at_once.ply");
        let with = ["mid.ply", "--part", &part, "--coping", &tags];
        let size = ["--element-size", "2t", "-o", "later.ply", "-o", "later.bdf"];
        let told = report(&desk, &[&with[..], &size].concat());
        let [once, later] = ["at_once.ply", "later.ply"].map(|name| surface(&desk, name));
        assert_eq!(topology(&once), topology(&later), "{part}");
        let area = |s: &MidSurface| s.mesh().area();
        assert!(
            (area(&once) - area(&later)).abs() < 2e-3 * area(&once),
            "{part}"
        );
        let count = |s: &MidSurface| s.triangles().len() as f64;
        assert!((count(&once) / count(&later) - 1.0).abs() < 0.1, "{part}");
        assert_eq!(self_intersections(&later.mesh()), []);
        assert_eq!(told["work"]["remeshing"]["chords"], 0, "{part}");
        // Every vertex is in the middle again.
        let check = ["check", &part, "later.ply", "--coping", &tags];
        let exact = ["--fail-on", "nodes_off_middle", "--tolerance", "0.001"];
        let exact = [&check[..], &exact, &["--near-seams", "0.001"]].concat();
        let output = desk.run(&exact);
        assert!(output.status.success(), "{}", text(&output.stderr));
        let model = read_mesh(desk.path("later.bdf")).unwrap();
        assert_eq!(model.mesh.triangles.len(), later.triangles().len());
    }
}

fn extracted_as(desk: &Desk, part: &str, tags: &str, name: &str) {
    let args = ["extract", part, "--coping", tags, "-q", "-o", name];
    let output = desk.run(&[&args[..], &["--element-size", "2t"]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
}

#[test]
fn without_the_part_it_lies_on_what_was_written() {
    for part in ["tee", "open_box", "plate_tapered", "hemisphere_shell"] {
        let desk = Desk::new();
        extracted(&desk, part, &["-o", "mid.ply"]);
        let size = ["mid.ply", "--element-size", "2t", "--quads"];
        let told = report(
            &desk,
            &[&size[..], &["-o", "new.ply", "-o", "new.inp"]].concat(),
        );
        let [old, new] = ["mid.ply", "new.ply"].map(|name| surface(&desk, name));
        assert_eq!(topology(&old), topology(&new), "{part}");
        assert_eq!(self_intersections(&new.mesh()), [], "{part}");
        assert!(told["quads"].as_u64().unwrap() > 0);
        assert!(
            told["result"]["quality"]["least"].as_f64().unwrap() > 15.0,
            "{part}: {}",
            told["result"]["quality"]
        );
        // On the triangles written, as thick as they are there.
        let field = midsurf::internals::field::Field::of_mesh(&old.mesh());
        let thick = |s: &MidSurface| {
            let all = s.vertices().iter().map(|v| v.ball.thickness);
            (
                all.clone().fold(f64::INFINITY, f64::min),
                all.fold(0.0, f64::max),
            )
        };
        let (least, most) = thick(&old);
        for vertex in new.vertices() {
            let foot = field.footpoint(vertex.position);
            assert!(foot.distance < 1e-9 * most, "{part}: {}", foot.distance);
            let own = vertex.ball.thickness;
            assert!(own >= least - 1e-9 && own <= most + 1e-9, "{part}: {own}");
        }
    }
}

#[test]
fn creases_come_back_from_a_ply() {
    let desk = Desk::new();
    extracted(&desk, "ell", &["-o", "mid.ply", "-o", "mid.vtu"]);
    assert_eq!(surface(&desk, "mid.ply").creases().len(), 1);
    report(&desk, &["mid.ply", "--element-size", "2t", "-o", "new.ply"]);
    assert_eq!(surface(&desk, "new.ply").creases().len(), 1);
}

#[test]
fn what_cannot_be_meshed_is_named() {
    let desk = Desk::new();
    let [part, tags] = extracted(&desk, "plate", &["-o", "mid.ply", "-o", "mid.stl"]);
    let other = fixture("enclosure.obj");
    let other = other.to_str().unwrap();
    let before = desk.files();
    let straight = ["mid.ply", "--element-size", "2t", "--junctions", "straight"];
    for (args, words) in [
        (&["mid.ply"][..], &["--element-size"][..]),
        (&["mid.ply", "--element-size", "0"], &["positive"]),
        (
            &["mid.ply", "--element-size", "1e-7"],
            &["triangles", "smallest size"],
        ),
        (
            &["mid.ply", "--element-size", "1", "-o", "mid.ply"],
            &["named twice"],
        ),
        (
            &["mid.ply", "--element-size", "1", "-o", "new.xyz"],
            &["new.xyz", "suffix"],
        ),
        (&["mid.stl", "--element-size", "1"], &["no thickness"]),
        (&["none.ply", "--element-size", "1"], &["none.ply"]),
        (
            &["mid.ply", "--element-size", "1", "--coping", &tags],
            &["--part"],
        ),
        (
            &["mid.ply", "--element-size", "1", "--part", other],
            &["in the middle of walls"],
        ),
        (&straight, &["--part"]),
    ] {
        let all = [&["mesh"][..], args, &["--json", "report.json"]].concat();
        let output = desk.run(&all);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {said}");
        for word in words {
            assert!(said.contains(word), "{args:?}: no {word:?} in {said}");
        }
        assert_eq!(desk.files(), before, "{args:?}");
    }
    // Without thickness the part gives it.
    let with = [
        "mid.stl",
        "--part",
        &part,
        "--coping",
        &tags,
        "--element-size",
        "2t",
    ];
    let told = report(&desk, &with);
    assert!(told["result"]["thickness"]["p50"].as_f64().unwrap() > 0.0);
    // So does an extraction refuse elements that would not fit.
    let tiny = [
        "extract",
        &part,
        "--coping",
        &tags,
        "--element-size",
        "1e-7",
    ];
    let output = desk.run(&tiny);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("smallest size"));
}
