//! What is put right on a part, with and without being asked, and what is said of it.

use glam::DVec3;
use midsurf::mesh::{Mended, Part, PartOptions, TriMesh, mend};
use serde_json::Value;

use crate::common::{Desk, cuboid, join, obj_text, soup, stl_bytes, text};

const ASKED: PartOptions = PartOptions {
    allow_open: false,
    weld: None,
    repair: true,
};

fn plate() -> TriMesh {
    cuboid(DVec3::ZERO, DVec3::new(20.0, 12.0, 2.0))
}

/// A box whose top is a grid of so many squares a side.
fn gridded(side: usize) -> TriMesh {
    let mut mesh = plate();
    // The top's two triangles go; its edges get vertices with the grid.
    mesh.triangles.retain(|t| !t.iter().all(|&v| v >= 4));
    let first = mesh.positions.len() as u32;
    let row = side + 1;
    for k in 0..row * row {
        let at = DVec3::new((k % row) as f64, (k / row) as f64, 0.0) / side as f64;
        mesh.positions
            .push(at * DVec3::new(20.0, 12.0, 0.0) + DVec3::Z * 2.0);
    }
    for k in 0..side * side {
        let a = first + (k / side * row + k % side) as u32;
        let [b, c, d] = [a + 1, a + 1 + row as u32, a + row as u32];
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    mesh
}

fn part(mesh: &TriMesh, options: PartOptions) -> Result<Part, String> {
    let flags = vec![false; mesh.triangles.len()];
    let part = Part::new(mesh.clone(), flags, options);
    part.map(|(part, _)| part)
        .map_err(|error| error.to_string())
}

fn mended(mesh: &TriMesh, options: PartOptions) -> (Mended, Vec<&'static str>) {
    let mended = mend(mesh.clone(), options).unwrap();
    let codes = mended
        .repairs
        .iter()
        .map(|repair| repair.what.code())
        .collect();
    (mended, codes)
}

#[test]
fn a_triangle_given_twice_goes_if_asked() {
    let mut mesh = plate();
    mesh.triangles.push([2, 3, 0]);
    let refused = part(&mesh, PartOptions::default()).unwrap_err();
    assert!(refused.contains("do not pair up"), "{refused}");
    let (mended, codes) = mended(&mesh, ASKED);
    assert_eq!(codes, ["doubled"]);
    assert_eq!(mended.repairs[0].places.len(), 1);
    assert_eq!(mended.mesh, plate());
    assert_eq!(part(&mesh, ASKED).unwrap().volume(), 480.0);
}

/// A wall without thickness that stands on the box.
#[test]
fn triangles_back_to_back_go_if_asked() {
    let mut mesh = plate();
    mesh.positions.push(DVec3::new(10.0, 0.0, 9.0));
    mesh.triangles.extend([[4, 5, 8], [5, 4, 8]]);
    assert_eq!(mended(&mesh, PartOptions::default()).1, [""; 0]);
    let (mended, codes) = mended(&mesh, ASKED);
    assert_eq!(codes, ["doubled"]);
    assert_eq!(mended.mesh, plate());
    assert_eq!(mended.origin, (0..12).collect::<Vec<u32>>());
}

#[test]
fn small_flat_holes_are_filled_if_asked() {
    let whole = gridded(12);
    let hole = [5 * 24 + 10, 5 * 24 + 11, 5 * 24 + 12, 5 * 24 + 13].map(|k| 10 + k);
    let mut mesh = whole.clone();
    let mut index = 0;
    mesh.triangles.retain(|_| {
        index += 1;
        !hole.contains(&(index - 1))
    });
    let refused = part(&mesh, PartOptions::default()).unwrap_err();
    assert!(refused.contains("open"), "{refused}");
    let (mended, codes) = mended(&mesh, ASKED);
    assert!(codes.contains(&"filled"), "{codes:?}");
    let filled = mended.repairs.iter().find(|r| r.what.code() == "filled");
    let [place] = filled.unwrap().places[..] else {
        panic!("one hole");
    };
    // Two squares of 20/12 by 1.
    let middle = whole.positions[whole.triangles[hole[1]][2] as usize];
    assert!(place.distance(middle) < 2.0 && place.z == 2.0, "{place}");
    assert!((mended.mesh.volume() - 480.0).abs() < 1e-9);
    assert!(mended.mesh.edges().census().is_closed());

    // An open box is no box with a small hole.
    let mut open = plate();
    open.triangles.retain(|t| !t.iter().all(|&v| v >= 4));
    assert!(part(&open, ASKED).is_err());
    // A single triangle is.
    let mut lacks = plate();
    lacks.triangles.remove(3);
    assert_eq!(part(&lacks, ASKED).unwrap().volume(), 480.0);
}

/// Fillings of a hole that is not flat would be guesses.
#[test]
fn holes_that_are_not_flat_stay_open() {
    let mut mesh = gridded(12);
    let hole = [
        10 + 5 * 24 + 10,
        10 + 5 * 24 + 11,
        10 + 5 * 24 + 12,
        10 + 5 * 24 + 13,
    ];
    let corner = mesh.triangles[hole[0]][0] as usize;
    mesh.positions[corner].z += 0.3;
    let mut index = 0;
    mesh.triangles.retain(|_| {
        index += 1;
        !hole.contains(&(index - 1))
    });
    assert!(part(&mesh, ASKED).is_err());
}

#[test]
fn fans_that_touch_in_a_vertex_get_their_own() {
    let a = cuboid(DVec3::ZERO, DVec3::ONE);
    let mut mesh = join(&a, &cuboid(DVec3::ONE, DVec3::ONE));
    // Vertex 8 is vertex 7.
    for corner in mesh.triangles.iter_mut().flatten() {
        *corner = match *corner {
            8 => 7,
            v if v > 8 => v - 1,
            v => v,
        };
    }
    mesh.positions.remove(8);
    let (mended, codes) = mended(&mesh, ASKED);
    assert_eq!(codes, ["unpinched"]);
    assert_eq!(mended.repairs[0].places, [DVec3::ONE]);
    assert_eq!(mended.mesh.positions.len(), 16);
    assert_eq!(soup(&mended.mesh), soup(&mesh));
}

/// A vertex written as two places: farther apart than noise, near enough to close.
#[test]
fn wider_gaps_are_welded_if_asked_and_named_if_not() {
    let desk = Desk::new();
    let mut mesh = plate();
    mesh.positions.push(mesh.positions[7] + DVec3::X * 1e-4);
    let corner = mesh.triangles.iter_mut().flatten().find(|v| **v == 7);
    *corner.unwrap() = 8;
    desk.put("gap.stl", stl_bytes(&mesh, "gap"));
    let refused = desk.run(&["extract", "gap.stl", "-o", "mid.obj"]);
    let told = text(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2));
    assert!(
        told.contains("--weld 2.3e-4") && told.contains("--repair"),
        "{told}"
    );
    let args = [
        "extract",
        "gap.stl",
        "--repair",
        "-o",
        "mid.obj",
        "--json",
        "report.json",
    ];
    let done = desk.run(&args);
    assert_eq!(done.status.code(), Some(0), "{}", text(&done.stderr));
    let report: Value =
        serde_json::from_slice(&std::fs::read(desk.path("report.json")).unwrap()).unwrap();
    let warnings = report["warnings"].as_array().unwrap();
    let welded = warnings.iter().find(|w| w["code"] == "welded").unwrap();
    assert_eq!(welded["places"].as_array().unwrap().len(), 1);
    assert_eq!(report["settings"]["repair"], true);
    assert_eq!(report["result"]["counts"]["sheets"], 1);
}

/// In single precision a vertex in the middle of an edge that is not parallel to an
/// axis lies beside it by its last digit.
#[test]
fn t_junctions_of_single_precision_are_closed() {
    let turn = glam::DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
    let mut mesh = plate();
    mesh.positions.push(DVec3::new(7.0, 0.0, 2.0));
    for p in &mut mesh.positions {
        *p = (turn * *p).as_vec3().as_dvec3();
    }
    let front = mesh.triangles.iter().position(|t| *t == [0, 5, 4]).unwrap();
    mesh.triangles[front] = [0, 5, 8];
    mesh.triangles.push([0, 8, 4]);
    let (mended, codes) = mended(&mesh, PartOptions::default());
    assert_eq!(codes, ["stitched"]);
    assert_eq!(mended.repairs[0].places, [mesh.positions[8]]);
    assert!(mended.origin.is_sorted());
    assert!(mended.mesh.edges().census().is_closed());
}

/// Triangles of three vertices in a row close a mesh in name only: they belong to
/// no wall, whatever normal rounding gives them.
#[test]
fn tips_of_triangles_without_area_split_the_edge() {
    let mut mesh = plate();
    let front = mesh.triangles.iter().position(|t| *t == [0, 5, 4]).unwrap();
    mesh.positions.push(DVec3::new(7.0, 0.0, 2.0));
    mesh.positions.push(DVec3::new(13.0, 0.0, 2.0));
    mesh.triangles[front] = [0, 5, 9];
    mesh.triangles
        .extend([[0, 9, 8], [0, 8, 4], [5, 4, 8], [5, 8, 9]]);
    for k in 0..8 {
        let turn = glam::DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), k as f64);
        let mut mesh = mesh.clone();
        for p in &mut mesh.positions {
            *p = turn * *p;
        }
        let (mended, codes) = mended(&mesh, PartOptions::default());
        assert_eq!(codes, ["flipped"]);
        assert_eq!(mended.repairs[0].places.len(), 2);
        assert!(mended.origin.is_sorted());
        assert!(mended.mesh.edges().census().is_closed());
        assert_eq!(mended.mesh.triangles.len(), mesh.triangles.len());
        // The four sides, caps among them, are coping.
        let upright = |t: &[u32; 3]| {
            let z = t.map(|v| (turn.inverse() * mesh.positions[v as usize]).z);
            z.iter().any(|z| *z < 1.0) && z.iter().any(|z| *z > 1.0)
        };
        let caps = mesh.triangles.len() - 2;
        let coping: Vec<bool> = (mesh.triangles.iter().enumerate())
            .map(|(i, t)| i >= caps || upright(t))
            .collect();
        let (part, _) = Part::new(mesh, coping, PartOptions::default()).unwrap();
        let settings = midsurf::Settings {
            cell: midsurf::CellSize::Length(1.3),
            ..midsurf::Settings::default()
        };
        let result = midsurf::extract(&part, &settings, &|_, _, _| ()).unwrap();
        assert!(result.graph.cracks().is_empty());
        assert_eq!(result.surface.sheet_count(), 1);
        assert!((result.graph.area() - 240.0).abs() < 1e-6);
        assert_eq!(result.work.counts.lost + result.work.counts.torn, 0);
    }
}

/// Tags are found on the mended mesh: an open one has none.
#[test]
fn detection_sees_the_mended_part() {
    let desk = Desk::new();
    let mut mesh = plate();
    desk.put("whole.obj", obj_text(&mesh));
    mesh.positions.push(DVec3::new(10.0, 0.0, 2.0));
    let front = mesh.triangles.iter().position(|t| *t == [0, 5, 4]).unwrap();
    mesh.triangles[front] = [0, 5, 8];
    mesh.triangles.push([0, 8, 4]);
    desk.put("junction.obj", obj_text(&mesh));
    let area = |file: &str| {
        let done = desk.run(&["extract", file, "--json", "-", "-q"]);
        assert_eq!(done.status.code(), Some(0), "{}", text(&done.stderr));
        let report: Value = serde_json::from_slice(&done.stdout).unwrap();
        assert_eq!(report["result"]["counts"]["coping_borders"], 1);
        report["result"]["area"].as_f64().unwrap()
    };
    assert!((area("junction.obj") - area("whole.obj")).abs() < 1e-9);
}
