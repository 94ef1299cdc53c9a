//! What makes a mesh a part, and what is put right on the way.

use glam::DVec3;
use midsurf::mesh::{FaceId, Part, PartError, PartOptions, PartWarning, TriMesh};

use crate::common::{cuboid, inverted, join};

fn plate() -> TriMesh {
    cuboid(DVec3::ZERO, DVec3::new(10.0, 10.0, 1.0))
}

fn build(mesh: &TriMesh, options: PartOptions) -> Result<(Part, Vec<PartWarning>), PartError> {
    // The narrow sides are coping: all but the first four triangles.
    let flags = (0..mesh.triangles.len()).map(|k| k % 12 >= 4).collect();
    Part::new(mesh.clone(), flags, options)
}

fn good(mesh: &TriMesh) -> (Part, Vec<PartWarning>) {
    build(mesh, PartOptions::default()).unwrap()
}

fn bad(mesh: &TriMesh) -> PartError {
    build(mesh, PartOptions::default()).unwrap_err()
}

const OPEN: PartOptions = PartOptions {
    allow_open: true,
    weld: None,
    repair: false,
};

#[test]
fn a_clean_part_passes_unchanged() {
    let (part, warnings) = good(&plate());
    assert_eq!(warnings, []);
    assert_eq!(*part.mesh(), plate());
    assert!(part.is_closed());
    assert_eq!(part.volume(), 100.0);
    assert_eq!(part.area(), 240.0);
    assert_eq!(part.bounds().max, DVec3::new(10.0, 10.0, 1.0));
    assert_eq!(part.coping_count(), 8);
}

#[test]
fn a_part_inside_out_is_turned() {
    let (part, warnings) = good(&inverted(&plate()));
    assert_eq!(warnings, [PartWarning::Turned { volume: -100.0 }]);
    assert_eq!(part.volume(), 100.0);
}

#[test]
fn triangles_against_their_neighbours_are_turned() {
    let mut mesh = plate();
    for k in [1, 6, 7] {
        mesh.triangles[k].swap(0, 1);
    }
    let (part, warnings) = good(&mesh);
    assert!(
        matches!(warnings[..], [PartWarning::Reoriented { triangles: 3, .. }]),
        "{warnings:?}"
    );
    assert_eq!(part.volume(), 100.0);
    assert!(part.is_closed());
}

#[test]
fn a_surface_with_one_side_is_refused() {
    // Moebius strip of five triangles.
    let positions = (0..5)
        .map(|k| {
            let angle = f64::from(k) * 1.2566;
            DVec3::new(angle.cos(), angle.sin(), 0.3 * f64::from(k % 2))
        })
        .collect();
    let triangles = (0..5).map(|k| [k, (k + 1) % 5, (k + 2) % 5]).collect();
    let error = bad(&TriMesh {
        positions,
        triangles,
    });
    assert!(matches!(error, PartError::NotOrientable { .. }), "{error}");
}

#[test]
fn an_open_part_is_refused_unless_allowed() {
    let mut mesh = plate();
    mesh.triangles.remove(0);
    let error = bad(&mesh);
    let PartError::Open { count, first, .. } = &error else {
        panic!("{error}");
    };
    assert_eq!(*count, 3);
    assert_eq!(first.from, DVec3::ZERO);
    assert!(
        error.to_string().contains("(0, 0, 0) to (0, 10, 0)"),
        "{error}"
    );
    let (part, warnings) = build(&mesh, OPEN).unwrap();
    assert!(!part.is_closed());
    assert!(matches!(warnings[..], [PartWarning::Open { count: 3, .. }]));
}

/// Noise of single precision closes by itself, but only where it closes all.
#[test]
fn noise_is_welded_and_said() {
    let mesh = plate();
    let mut noisy = TriMesh {
        positions: mesh.faces().flat_map(|f| mesh.corners(f)).collect(),
        triangles: (0..12).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
    };
    for (k, p) in noisy.positions.iter_mut().enumerate() {
        *p += 1e-17 * (k % 3) as f64;
        p.x *= 1.0 + 1e-8 * (k % 5) as f64;
    }
    let (part, warnings) = good(&noisy);
    let [PartWarning::Welded { exact, near }] = warnings[..] else {
        panic!("{warnings:?}");
    };
    assert!(near > 0 && exact + near == 28, "{exact} {near}");
    assert!(part.is_closed());
    noisy.triangles.pop();
    assert!(matches!(bad(&noisy), PartError::Open { weld: None, .. }));
}

#[test]
fn split_vertices_are_welded() {
    let mesh = plate();
    let split = TriMesh {
        positions: mesh.faces().flat_map(|f| mesh.corners(f)).collect(),
        triangles: (0..12).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
    };
    let (part, warnings) = good(&split);
    assert_eq!(warnings, [PartWarning::Welded { exact: 28, near: 0 }]);
    assert!(part.is_closed());
    assert_eq!(part.mesh().positions.len(), 8);

    let mut rough = split.clone();
    for (k, p) in rough.positions.iter_mut().enumerate() {
        p.x += 1e-4 * (k % 5) as f64;
    }
    let error = bad(&rough);
    let PartError::Open {
        weld: Some(named), ..
    } = error
    else {
        panic!("{error}");
    };
    let weld = |tolerance| {
        let options = PartOptions {
            allow_open: false,
            weld: Some(tolerance),
            ..PartOptions::default()
        };
        build(&rough, options)
    };
    assert!(weld(named).is_ok(), "{named}");
    let (part, warnings) = weld(1e-2).unwrap();
    let [PartWarning::Welded { exact, near }] = warnings[..] else {
        panic!("{warnings:?}");
    };
    assert_eq!(exact + near, 28);
    assert!(part.is_closed());
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY, 10.0] {
        assert!(matches!(
            weld(tolerance),
            Err(PartError::WeldTolerance { .. })
        ));
    }
}

#[test]
fn several_shells_are_fine_and_strays_are_turned() {
    let (near, far) = (plate(), cuboid(DVec3::new(20.0, 0.0, 0.0), DVec3::ONE));
    let (part, warnings) = good(&join(&near, &far));
    assert_eq!(warnings, []);
    assert_eq!(part.volume(), 101.0);

    let (part, warnings) = good(&join(&near, &inverted(&far)));
    let turned = PartWarning::ShellsTurned {
        shells: 1,
        triangles: 12,
    };
    assert_eq!(warnings, [turned]);
    assert_eq!(part.volume(), 101.0);
}

#[test]
fn a_cavity_stays_a_cavity() {
    let outer = cuboid(DVec3::ZERO, DVec3::splat(10.0));
    let inner = inverted(&cuboid(DVec3::ONE, DVec3::splat(8.0)));
    let hollow = join(&outer, &inner);
    let (part, warnings) = good(&hollow);
    assert_eq!(warnings, []);
    assert_eq!(part.volume(), 1000.0 - 512.0);
    // All of it inside out: turned as a whole.
    let (part, warnings) = good(&inverted(&hollow));
    assert_eq!(warnings, [PartWarning::Turned { volume: -488.0 }]);
    assert_eq!(part.volume(), 488.0);
}

#[test]
fn shells_that_touch_along_an_edge_pass_with_a_warning() {
    let mesh = join(
        &plate(),
        &cuboid(DVec3::new(10.0, 10.0, 0.0), DVec3::new(5.0, 5.0, 1.0)),
    );
    // As two shells of vertices of their own there is nothing to say.
    assert_eq!(good(&mesh).1, []);
    let options = PartOptions {
        allow_open: false,
        weld: Some(1e-9),
        ..PartOptions::default()
    };
    let (part, warnings) = build(&mesh, options).unwrap();
    assert!(part.is_closed());
    assert!(
        matches!(
            warnings[..],
            [
                PartWarning::Welded { exact: 2, near: 0 },
                PartWarning::NonManifold {
                    count: 1,
                    balanced: true,
                    ..
                }
            ]
        ),
        "{warnings:?}"
    );
}

#[test]
fn an_edge_of_three_triangles_is_refused_unless_allowed() {
    let mut mesh = plate();
    // A membrane across the inside, its rims on four edges of the box.
    mesh.triangles.push([0, 2, 7]);
    mesh.triangles.push([0, 7, 5]);
    let error = bad(&mesh);
    assert!(
        matches!(
            error,
            PartError::Open { .. } | PartError::NonManifold { .. }
        ),
        "{error}"
    );
    // Two opposite edges of the box and two diagonals of its sides.
    let mut mesh = plate();
    mesh.triangles.push([0, 3, 7]);
    mesh.triangles.push([0, 7, 4]);
    let error = bad(&mesh);
    let PartError::NonManifold { uses: 3, .. } = error else {
        panic!("{error}");
    };
    let (part, warnings) = build(&mesh, OPEN).unwrap();
    assert!(!part.is_closed());
    assert!(matches!(
        warnings[..],
        [PartWarning::NonManifold {
            balanced: false,
            ..
        }]
    ));
}

#[test]
fn triangles_without_area_are_mended_or_kept_and_counted() {
    // A corner in the middle of an edge, filled by a sliver without area: the
    // triangle beyond is split there.
    let mut mesh = plate();
    mesh.positions.push(DVec3::new(5.0, 0.0, 0.0));
    let at = mesh.triangles.iter().position(|t| *t == [0, 3, 1]).unwrap();
    mesh.triangles[at] = [0, 3, 8];
    mesh.triangles.push([8, 3, 1]);
    mesh.triangles.push([0, 8, 1]);
    let (part, warnings) = good(&mesh);
    assert_eq!(warnings, [PartWarning::Flipped { triangles: 1 }]);
    assert!(part.is_closed());
    assert_eq!(part.triangle_count(), 14);
    // A repeated corner does not open anything.
    mesh.triangles.push([4, 4, 5]);
    let (part, warnings) = good(&mesh);
    let kept = PartWarning::ZeroArea {
        triangles: 1,
        first: FaceId(14),
    };
    assert_eq!(warnings, [PartWarning::Flipped { triangles: 1 }, kept]);
    assert!(part.is_closed());
}

#[test]
fn numbers_out_of_bounds_are_refused() {
    let mut mesh = plate();
    mesh.triangles[3][1] = 8;
    let error = bad(&mesh);
    let expected = PartError::IndexOutOfRange {
        triangle: FaceId(3),
        index: 8,
        vertices: 8,
    };
    assert_eq!(error, expected);
    for value in [f64::NAN, f64::INFINITY] {
        let mut mesh = plate();
        mesh.positions[5].y = value;
        assert!(matches!(bad(&mesh), PartError::NotFinite { vertex: 5, .. }));
    }
    for scale in [0.0, 1e-40, 1e40, 1e300] {
        let mut mesh = plate();
        mesh.positions.iter_mut().for_each(|p| *p *= scale);
        assert!(matches!(bad(&mesh), PartError::Size { .. }), "{scale}");
    }
    assert_eq!(bad(&TriMesh::default()), PartError::Empty);
}

#[test]
fn scale_and_place_do_not_matter() {
    for scale in [1e-3, 1e3, 1e-20, 1e20] {
        let mut mesh = plate();
        mesh.positions
            .iter_mut()
            .for_each(|p| *p = (*p + DVec3::splat(1e4)) * scale);
        let (part, warnings) = good(&mesh);
        assert_eq!(warnings, [], "{scale}");
        assert!((part.volume() / scale.powi(3) - 100.0).abs() < 1e-6);
    }
    let mut mesh = plate();
    mesh.positions
        .iter_mut()
        .for_each(|p| *p += DVec3::splat(1e9));
    assert!(matches!(
        good(&mesh).1[..],
        [PartWarning::FarFromOrigin { .. }]
    ));
}

#[test]
fn vertices_of_no_triangle_go() {
    let mut mesh = plate();
    mesh.positions.insert(0, DVec3::splat(1e6));
    mesh.triangles
        .iter_mut()
        .for_each(|t| *t = t.map(|v| v + 1));
    let (part, warnings) = good(&mesh);
    assert_eq!(warnings, []);
    assert_eq!(*part.mesh(), plate());
}

#[test]
fn flags_must_leave_a_wall() {
    let flagged = |flags: Vec<bool>| Part::new(plate(), flags, PartOptions::default());
    assert_eq!(
        flagged(vec![true; 12]).unwrap_err(),
        PartError::AllCoping { triangles: 12 }
    );
    assert_eq!(
        flagged(vec![true; 11]).unwrap_err(),
        PartError::CopingLength {
            flags: 11,
            triangles: 12
        }
    );
    assert_eq!(flagged(vec![false; 12]).unwrap().1, [PartWarning::NoCoping]);
    let mut mesh = plate();
    mesh.triangles.push([0, 0, 1]);
    let mut flags = vec![true; 12];
    flags.push(false);
    assert_eq!(
        Part::new(mesh, flags, PartOptions::default()).unwrap_err(),
        PartError::NoWall { walls: 1 }
    );
}

#[test]
fn a_doubled_surface_encloses_nothing() {
    let square = TriMesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::ONE, DVec3::Y],
        triangles: vec![[0, 1, 2], [0, 2, 3], [0, 2, 1], [0, 3, 2]],
    };
    assert!(matches!(bad(&square), PartError::NoVolume { .. }));
}
