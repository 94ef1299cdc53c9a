//! Parts of several bodies: shells that nest, overlap or touch, cavities, and
//! T-junctions.

use glam::DVec3;
use midsurf::extract::{Settings as ExtractSettings, extract};
use midsurf::mesh::{Part, PartOptions, PartWarning, TriMesh, closed_shells, self_intersections};
use midsurf::offset::{Offset, OffsetWarning, Settings, Voids, hollowed, offset};
use serde_json::Value;

use crate::common::{Desk, cuboid, inverted, join, obj_text};

fn part(mesh: &TriMesh) -> (Part, Vec<PartWarning>) {
    let flags = vec![false; mesh.triangles.len()];
    let (part, mut warnings) = Part::new(mesh.clone(), flags, PartOptions::default()).unwrap();
    warnings.retain(|warning| *warning != PartWarning::NoCoping);
    (part, warnings)
}

fn cube(low: f64, high: f64) -> TriMesh {
    cuboid(DVec3::splat(low), DVec3::splat(high - low))
}

/// A plate of 40 x 24 x 2 with a lug of 4 x 4 x 11 that stands 1 deep in it.
fn plate_and_lug() -> TriMesh {
    let plate = cuboid(DVec3::ZERO, DVec3::new(40.0, 24.0, 2.0));
    let lug = cuboid(DVec3::new(10.0, 10.0, 1.0), DVec3::new(4.0, 4.0, 11.0));
    join(&plate, &lug)
}

fn run(part: &Part, distance: f64, cell: f64, voids: Voids) -> Offset {
    let settings = Settings {
        cell,
        voids,
        ..Settings::new(part, distance)
    };
    let result = offset(part, &settings, &|_, _, _| ()).unwrap();
    assert_eq!(self_intersections(&result.mesh), []);
    result
}

/// Volumes of bodies and of cavities.
fn volumes(mesh: &TriMesh) -> (Vec<f64>, Vec<f64>) {
    let shells = closed_shells(mesh, &mesh.edges());
    shells
        .iter()
        .map(|shell| shell.volume)
        .partition(|&v| v > 0.0)
}

fn near(a: f64, b: f64, share: f64) {
    assert!((a / b - 1.0).abs() < share, "{a} for {b}");
}

#[test]
fn nested_shells_are_read_one_way() {
    let (outer, inner) = (cube(0.0, 40.0), cube(12.0, 28.0));
    let cavity = 40_f64.powi(3) - 16_f64.powi(3);
    for (mesh, turned) in [
        (join(&outer, &inner), true),
        (join(&outer, &inverted(&inner)), false),
        (join(&inverted(&inner), &outer), false),
        (join(&inverted(&outer), &inverted(&inner)), true),
    ] {
        let (part, warnings) = part(&mesh);
        assert_eq!(part.volume(), cavity);
        let nested = |w: &PartWarning| {
            let PartWarning::ShellsNested { shells, triangles } = w else {
                return false;
            };
            assert_eq!((*shells, *triangles), (1, 12));
            true
        };
        assert_eq!(warnings.iter().any(nested), turned);
    }
    // A body in a cavity in a body, however they are turned.
    let kernel = cube(16.0, 24.0);
    for turn in 0..8 {
        let turned = |mesh: &TriMesh, bit: i32| match turn & bit {
            0 => mesh.clone(),
            _ => inverted(mesh),
        };
        let mesh = join(
            &turned(&kernel, 1),
            &join(&turned(&outer, 2), &turned(&inner, 4)),
        );
        assert_eq!(part(&mesh).0.volume(), cavity + 512.0, "{turn}");
    }
}

#[test]
fn shells_that_cross_or_touch_nest_in_nothing() {
    // Within the plate's height, from the inside of its top, and on its top.
    for lift in [1.5, 1.0, 2.0] {
        let plate = cuboid(DVec3::ZERO, DVec3::new(40.0, 24.0, 2.0));
        let lug = cuboid(DVec3::new(10.0, 10.0, lift), DVec3::new(4.0, 4.0, 1.0));
        let (_, warnings) = part(&join(&plate, &lug));
        assert_eq!(warnings, [], "{lift}");
    }
}

#[test]
fn overlapping_bodies_are_one_solid_first() {
    let (part, warnings) = part(&plate_and_lug());
    assert_eq!(warnings, []);
    let united = part.united().unwrap();
    near(united.volume(), 2080.0, 1e-12);
    near(united.area(), 2336.0, 1e-12);
    assert_eq!(self_intersections(united.mesh()), []);

    let shrunk = run(&part, -0.5, 0.23, Voids::Keep);
    assert!(matches!(
        shrunk.warnings[..],
        [OffsetWarning::United { .. }]
    ));
    near(shrunk.mesh.volume(), 987.69, 1e-4);
    assert_eq!(volumes(&shrunk.mesh).0.len(), 1);

    let cavity = run(&part, -0.4, 0.23, Voids::Keep);
    let hollow = hollowed(cavity.solid.as_ref().unwrap(), &cavity.mesh);
    near(hollow.volume(), 885.8, 1e-4);
    assert_eq!(self_intersections(&hollow), []);
    let (bodies, cavities) = volumes(&hollow);
    assert_eq!((bodies.len(), cavities.len()), (1, 1));
    near(-cavities[0], 1194.2, 1e-4);
}

#[test]
fn touching_bodies_are_one_solid_too() {
    // A face of one on a part of a face of the other.
    let low = cuboid(DVec3::ZERO, DVec3::new(10.0, 10.0, 4.0));
    let high = cuboid(DVec3::new(2.0, 3.0, 4.0), DVec3::new(5.0, 5.0, 6.0));
    let (part, _) = part(&join(&low, &high));
    let united = part.united().unwrap();
    near(united.volume(), 550.0, 1e-12);
    near(united.area(), 360.0 + 4.0 * 30.0, 1e-12);
    let shrunk = run(&part, -1.0, 0.31, Voids::Keep);
    assert_eq!(volumes(&shrunk.mesh).0.len(), 1);
    // The neck begins at the shrunk plate, rounded off where it meets it.
    near(
        shrunk.mesh.volume(),
        8.0 * 8.0 * 2.0 + 3.0 * 3.0 * 6.0,
        0.03,
    );
}

#[test]
fn coping_goes_along() {
    let plate = cuboid(DVec3::ZERO, DVec3::new(40.0, 24.0, 2.0));
    let other = cuboid(DVec3::new(30.0, 0.0, 0.0), DVec3::new(40.0, 24.0, 2.0));
    let mesh = join(&plate, &other);
    // All sides but top and bottom, which are the first four of twelve.
    let coping: Vec<bool> = (0..24).map(|face| face % 12 >= 4).collect();
    let (part, _) = Part::new(mesh, coping, PartOptions::default()).unwrap();
    let result = extract(&part, &ExtractSettings::default(), &|_, _, _| ()).unwrap();
    assert!(result.solid.is_some());
    assert_eq!(result.surface.sheet_count(), 1);
    assert_eq!(result.graph.cracks().len(), 0);
    near(result.surface.mesh().area(), 70.0 * 24.0, 1e-9);
}

#[test]
fn a_tin_of_two_outward_shells_has_one_sheet() {
    let outer = cuboid(DVec3::ZERO, DVec3::new(40.0, 30.0, 20.0));
    let inner = cuboid(DVec3::splat(2.0), DVec3::new(36.0, 26.0, 16.0));
    let (part, warnings) = part(&join(&outer, &inner));
    assert!(matches!(warnings[..], [PartWarning::ShellsNested { .. }]));
    let result = extract(&part, &ExtractSettings::default(), &|_, _, _| ()).unwrap();
    assert_eq!(result.surface.sheet_count(), 1);
    assert_eq!(result.graph.cracks().len(), 0);
    near(result.surface.mesh().area(), 4398.7, 1e-3);
}

#[test]
fn voids_are_listed_kept_or_filled() {
    let (part, _) = part(&join(&cube(0.0, 40.0), &inverted(&cube(12.0, 28.0))));
    let kept = run(&part, -3.0, 0.9, Voids::Keep);
    assert_eq!(kept.voids.len(), 1);
    assert_eq!(
        (kept.voids[0].volume, kept.voids[0].at),
        (4096.0, DVec3::splat(20.0))
    );
    let hollow = hollowed(&part, &kept.mesh);
    let (bodies, cavities) = volumes(&hollow);
    // The wall around the void hangs free.
    assert_eq!((bodies.len(), cavities.len()), (2, 2));

    let filled = run(&part, -3.0, 0.9, Voids::Fill);
    assert_eq!(filled.voids, []);
    let hollow = hollowed(filled.solid.as_ref().unwrap(), &filled.mesh);
    near(hollow.volume(), 24_696.0, 1e-6);
}

#[test]
fn t_junctions_are_closed_where_they_are() {
    // A box of 20 x 12 x 2; its upper edge at the front has a vertex in the
    // middle that the top does not have.
    let mut mesh = cuboid(DVec3::ZERO, DVec3::new(20.0, 12.0, 2.0));
    mesh.positions.push(DVec3::new(10.0, 0.0, 2.0));
    let front = mesh.triangles.iter().position(|t| *t == [0, 5, 4]).unwrap();
    mesh.triangles[front] = [0, 5, 8];
    mesh.triangles.push([0, 8, 4]);
    let triangles = mesh.triangles.len();
    let (part, warnings) = part(&mesh);
    let expected = PartWarning::Stitched {
        edges: 1,
        triangles: 1,
    };
    assert_eq!(warnings, [expected]);
    assert!(part.is_closed());
    assert_eq!(part.triangle_count(), triangles + 1);
    assert_eq!(part.volume(), 480.0);
    let cavity = run(&part, -0.5, 0.11, Voids::Keep);
    near(cavity.mesh.volume(), 19.0 * 11.0, 1e-6);
    // Beside the edge by no more than single precision tells it lies on it still;
    // farther off it is a gap.
    let build = |beside: f64| {
        let mut mesh = mesh.clone();
        mesh.positions[8].y = beside;
        let flags = vec![false; mesh.triangles.len()];
        Part::new(mesh, flags, PartOptions::default())
    };
    assert_eq!(build(1e-9).unwrap().1[0].code(), "stitched");
    assert!(build(1e-3).is_err());
}

#[test]
fn the_commands_say_what_they_made() {
    let desk = Desk::new();
    desk.put(
        "nested.obj",
        obj_text(&join(&cube(0.0, 40.0), &cube(12.0, 28.0))),
    );
    desk.put("lug.obj", obj_text(&plate_and_lug()));
    let report = |args: &[&str]| {
        let out = desk.run(&[args, &["--json", "report.json", "--cell", "0.8"]].concat());
        assert_eq!(out.status.code(), Some(0), "{out:?}");
        let bytes = std::fs::read(desk.path("report.json")).unwrap();
        let report: Value = serde_json::from_slice(&bytes).unwrap();
        let warnings = report["warnings"].as_array().unwrap().clone();
        let codes: Vec<String> = (warnings.iter())
            .map(|w| w["code"].as_str().unwrap().to_owned())
            .collect();
        (report, codes)
    };
    let (kept, codes) = report(&["hollow", "nested.obj", "--thickness", "3"]);
    assert_eq!(codes, ["shells_nested", "voids", "loose_pieces"]);
    assert_eq!(kept["result"]["pieces"], 2);
    let filled = [
        "hollow",
        "nested.obj",
        "--thickness",
        "3",
        "--voids",
        "fill",
    ];
    let (filled, codes) = report(&filled);
    assert_eq!(codes, ["shells_nested"]);
    assert_eq!(filled["result"]["pieces"], 1);
    assert_eq!(filled["result"]["cavities"].as_array().unwrap().len(), 1);
    let (_, codes) = report(&["offset", "lug.obj", "--distance", "1"]);
    assert_eq!(codes, ["united"]);
}
