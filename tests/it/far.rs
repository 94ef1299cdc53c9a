//! Meshes far from the origin: every engine gives what it gives nearby.

use glam::DVec3;
use midsurf::extract::{Extraction, Settings, extract};
use midsurf::mesh::{Part, PartOptions, PartWarning, TriMesh, self_intersections};
use midsurf::offset::{self, OffsetError};
use midsurf::rethicken::{self, BallSurface, rethicken};
use midsurf::roundtrip;
use midsurf::settings::cell::CellSize;
use midsurf::settings::precision::Precision;
use midsurf::subdivide::{self, Boundary, Cage, Level, Scheme, hollow_out, interpolate};
use midsurf::surface::BorderKind;
use midsurf::thicken::{self, Side, thicken};

use crate::common::{cuboid, fixture, fixture_part};

/// Where ships and buildings have their parts, and much farther out.
const PLACES: [DVec3; 3] = [
    DVec3::new(43_120.0, 541_234.0, 312.0),
    DVec3::new(-7e5, 0.0, 3e5),
    DVec3::new(3e7, -5e7, 1e7),
];

fn moved(mesh: &TriMesh, to: DVec3) -> TriMesh {
    TriMesh {
        positions: mesh.positions.iter().map(|&p| p + to).collect(),
        triangles: mesh.triangles.clone(),
    }
}

fn part(mesh: &TriMesh, coping: Option<Vec<bool>>) -> Part {
    let coping = coping.unwrap_or_else(|| vec![false; mesh.triangles.len()]);
    let part = Part::new(mesh.clone(), coping, PartOptions::default());
    part.unwrap().0
}

fn silent(_: &'static str, _: u64, _: u64) {}

/// Closed, manifold, and cutting itself nowhere, as the numbers stand.
fn check_solid(mesh: &TriMesh) {
    assert!(mesh.edges().by_edge().all(|uses| uses.len() == 2));
    assert!(mesh.edges().census().is_closed());
    assert_eq!(self_intersections(mesh), []);
}

fn shape(extraction: &Extraction) -> [usize; 5] {
    let surface = &extraction.surface;
    let of = |kind| surface.borders().iter().filter(|b| b.kind == kind).count();
    [
        surface.sheet_count() as usize,
        surface.seams().len(),
        of(BorderKind::Coping),
        of(BorderKind::Fading),
        extraction.graph.cracks().len(),
    ]
}

#[test]
fn extraction_closes() {
    for name in ["plate", "tee", "bracket"] {
        let (mesh, coping) = fixture_part(name);
        let run = |to: DVec3| {
            let part = part(&moved(&mesh, to), Some(coping.clone()));
            extract(&part, &Settings::default(), &silent).unwrap()
        };
        let near = run(DVec3::ZERO);
        for to in PLACES {
            let far = run(to);
            assert_eq!(shape(&far), shape(&near), "{name} at {to}");
            let ratio = far.surface.mesh().area() / near.surface.mesh().area();
            assert!((ratio - 1.0).abs() < 1e-3, "{name} at {to}: {ratio}");
            // Vertices and footpoints are back at the part.
            let bounds = part(&moved(&mesh, to), None).bounds().grown(1e-3);
            for vertex in far.surface.vertices() {
                assert!(bounds.contains(vertex.position));
                assert!(vertex.ball.footpoints.iter().all(|&f| bounds.contains(f)));
            }
        }
    }
}

#[test]
fn offsets_keep_their_corners() {
    let mesh = cuboid(DVec3::ZERO, DVec3::new(400.0, 240.0, 100.0));
    let inner = cuboid(DVec3::splat(20.0), DVec3::new(360.0, 200.0, 60.0));
    for to in PLACES {
        for (precision, slack) in [(Precision::Double, 1e-6), (Precision::Single, 0.1)] {
            let part = part(&moved(&mesh, to), None);
            let settings = offset::Settings {
                cell: 9.3,
                precision,
                ..offset::Settings::new(&part, -20.0)
            };
            let result = offset::offset(&part, &settings, &silent);
            if precision == Precision::Single && to.abs().max_element() > 1e6 {
                // Planes a cell apart would not be that any more.
                assert!(matches!(result, Err(OffsetError::Grid(_))), "{to}");
                continue;
            }
            let mesh = result.unwrap().mesh;
            check_solid(&mesh);
            for corner in moved(&inner, to).positions {
                let distances = mesh.positions.iter().map(|p| p.distance(corner));
                let nearest = distances.fold(f64::INFINITY, f64::min);
                assert!(nearest < slack, "{to} {precision:?}: {nearest}");
            }
            for p in mesh.positions {
                assert_eq!(precision.round_point(p), p);
            }
        }
    }
}

#[test]
fn thickened_patches_keep_their_bits() {
    let square = TriMesh {
        positions: vec![
            DVec3::ZERO,
            10.1 * DVec3::X,
            DVec3::new(10.1, 7.3, 0.7),
            7.3 * DVec3::Y,
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    for to in PLACES {
        let patch = moved(&square, to);
        let result = thicken(&patch, &thicken::Settings::new(1.0, Side::Inner), &silent).unwrap();
        check_solid(&result.mesh);
        assert_eq!(result.mesh.positions[..4], patch.positions);
        let ratio = result.mesh.volume() / patch.area();
        assert!((ratio - 1.0).abs() < 0.02, "{to}: {ratio}");
    }
}

#[test]
fn round_trips_come_back() {
    let (mesh, coping) = fixture_part("tee");
    for to in PLACES {
        let part = part(&moved(&mesh, to), Some(coping.clone()));
        let settings = roundtrip::Settings {
            extract: Settings::default(),
            solid_cell: CellSize::Length(0.9),
            memory_limit: 1 << 30,
        };
        let result = roundtrip::roundtrip(&part, &settings, &silent).unwrap();
        check_solid(&result.solid.mesh);
        let c = result.comparison;
        assert!((c.volume_ratio - 1.0).abs() < 0.01, "{to}: {c:?}");
        assert!(c.all.worst_at.distance(to) < 100.0, "{to}: {c:?}");
    }
}

#[test]
fn balls_far_away_make_a_plate() {
    for to in PLACES {
        let corners = [[0.0, 0.0], [8.0, 0.0], [8.0, 6.0], [0.0, 6.0]];
        let positions = corners.map(|[x, y]| to + DVec3::new(x, y, 0.0)).to_vec();
        let triangles = vec![[0, 1, 2], [0, 2, 3]];
        let surface = BallSurface::new(positions, vec![0.5; 4], triangles, |_| true).unwrap();
        let settings = rethicken::Settings::new(&surface);
        let mesh = rethicken(&surface, &settings, &silent).unwrap().mesh;
        check_solid(&mesh);
        assert!(
            (mesh.volume() - 48.0).abs() < 1e-5,
            "{to}: {}",
            mesh.volume()
        );
    }
}

#[test]
fn subdivision_does_not_care() {
    let file = fixture("cages").join("cube.obj");
    let control = midsurf::io::read_control(&file).unwrap();
    let settings = subdivide::Settings {
        thickness: 0.2,
        samples: 4,
        level: Level::Fixed(1),
        scheme: Scheme::Crust,
        boundary: Boundary::EdgeAndCorner,
    };
    let cage = |to: DVec3| {
        let positions = control.positions.iter().map(|&p| p + to).collect();
        Cage::new(positions, &control.faces).unwrap()
    };
    let near = hollow_out(&cage(DVec3::ZERO), &settings, &|_| ()).unwrap();
    let (through, _) = interpolate(&cage(DVec3::ZERO), 1, 4, Boundary::EdgeAndCorner).unwrap();
    for to in PLACES {
        let far = hollow_out(&cage(to), &settings, &|_| ()).unwrap();
        let step = 1e-15 * to.abs().max_element() + 1e-12;
        let pairs = near
            .hollow
            .mesh
            .positions
            .iter()
            .zip(&far.hollow.mesh.positions);
        assert!(
            pairs.clone().all(|(p, q)| (*p + to).distance(*q) < step),
            "{to}"
        );
        assert!(
            (far.trial.epsilon - near.trial.epsilon).abs() < 1e-9,
            "{to}"
        );
        let (mesh, _) = interpolate(&cage(to), 1, 4, Boundary::EdgeAndCorner).unwrap();
        let pairs = through.positions.iter().zip(&mesh.positions);
        assert!(
            pairs.clone().all(|(p, q)| (*p + to).distance(*q) < step),
            "{to}"
        );
    }
}

#[test]
fn numbers_too_coarse_are_said() {
    let mesh = cuboid(DVec3::new(0.3, 0.7, 0.1), DVec3::new(40.0, 24.0, 2.0));
    let far = moved(&mesh, PLACES[0]);
    let single = TriMesh {
        positions: far
            .positions
            .iter()
            .map(|p| p.as_vec3().as_dvec3())
            .collect(),
        triangles: far.triangles.clone(),
    };
    let whole = moved(&cuboid(DVec3::ZERO, DVec3::new(40.0, 24.0, 2.0)), PLACES[0]);
    let warnings = |mesh: &TriMesh| {
        let flags = vec![false; mesh.triangles.len()];
        let (_, mut warnings) = Part::new(mesh.clone(), flags, PartOptions::default()).unwrap();
        warnings.retain(|w| matches!(w, PartWarning::FarFromOrigin { .. }));
        warnings
    };
    assert_eq!(warnings(&mesh), []);
    assert_eq!(warnings(&far), []);
    assert_eq!(warnings(&whole), []);
    let [PartWarning::FarFromOrigin { step, .. }] = warnings(&single)[..] else {
        panic!("no warning");
    };
    assert_eq!(step, 0.0625);
}
