//! Creases and remeshing: topology as traced, every vertex exact, good shapes.

use glam::DVec3;
use midsurf::CellSize;
use midsurf::extract::{Extraction, Settings, extract};
use midsurf::internals::field::Field;
use midsurf::mesh::{Part, PartOptions, self_intersections};
use midsurf::reshape::ElementSettings;
use midsurf::reshape::remesh::Junctions;
use midsurf::surface::graph::Counts;
use midsurf::surface::{MidSurface, MidVertex, segments};

use crate::common::{fixture_part, ringed};

fn part(name: &str) -> Part {
    let (mesh, coping) = fixture_part(name);
    Part::new(mesh, coping, PartOptions::default()).unwrap().0
}

fn run(part: &Part, size: Option<CellSize>) -> Extraction {
    made(part, size.map(ElementSettings::of_size))
}

fn made(part: &Part, elements: Option<ElementSettings>) -> Extraction {
    let settings = Settings {
        elements,
        ..Settings::default()
    };
    extract(part, &settings, &|_, _, _| ()).unwrap()
}

/// What must not change.
fn topology(result: &Extraction) -> Counts {
    Counts {
        vertices: 0,
        edges: 0,
        triangles: 0,
        creases: 0,
        ..*result.graph.counts()
    }
}

fn angles(surface: &MidSurface) -> Vec<f64> {
    let mut all: Vec<f64> = (surface.triangles().iter())
        .map(|t| {
            let p = t.corners.map(|v| surface.position(v));
            let at = |k: usize| (p[(k + 1) % 3] - p[k]).angle_between(p[(k + 2) % 3] - p[k]);
            at(0).min(at(1)).min(at(2)).to_degrees()
        })
        .collect();
    all.sort_by(f64::total_cmp);
    all
}

/// Remeshes a fixture to some thicknesses and holds the result against the
/// traced one and the part.
fn check(name: &str, thicknesses: f64, least: f64) -> Extraction {
    let part = part(name);
    let traced = run(&part, None);
    let result = run(&part, Some(CellSize::Thicknesses(thicknesses)));
    let what = format!("{name} at {thicknesses} t");
    assert_eq!(topology(&result), topology(&traced), "{what}");
    assert_eq!(result.graph.cracks().len(), 0, "{what}");
    let mesh = result.surface.mesh();
    assert_eq!(self_intersections(&mesh), [], "{what}");
    let worst = angles(&result.surface)[0];
    assert!(worst >= least, "{what}: an angle of {worst}");
    let field = Field::new(&part);
    for vertex in result.surface.vertices() {
        let nearest = field.footpoint(vertex.position).distance;
        let off = (vertex.ball.radius - nearest).abs();
        assert!(
            off <= 1e-6 * nearest,
            "{what}: {off} off at {}",
            vertex.position
        );
    }
    result
}

#[test]
fn plates_tees_and_crosses_get_good_elements_of_any_size() {
    for name in ["plate", "tee", "tee_rotated", "cross", "rib_grid"] {
        for thicknesses in [1.0, 2.0, 5.0] {
            check(name, thicknesses, 25.0);
        }
    }
}

#[test]
fn curved_walls_are_followed_within_the_sag() {
    // Radii of vertices are exact; edges run inside by the sag at most.
    let part = part("cylinder_shell");
    let elements = ElementSettings {
        sag: CellSize::Thicknesses(0.05),
        ..ElementSettings::of_size(CellSize::Thicknesses(5.0))
    };
    let result = made(&part, Some(elements));
    let t = result.surface.vertices()[0].ball.thickness;
    let axis = |p: DVec3| p.truncate().length();
    let radius = axis(result.surface.position(0));
    for triangle in result.surface.triangles() {
        let p = triangle.corners.map(|v| result.surface.position(v));
        for k in 0..3 {
            let middle = 0.5 * (p[k] + p[(k + 1) % 3]);
            let sag = radius - axis(middle);
            assert!(sag < 2.0 * 0.05 * t, "{sag} at {middle}");
        }
    }
}

#[test]
fn plane_sheets_get_few_elements() {
    let plate = run(&part("plate"), Some(CellSize::Thicknesses(5.0)));
    let area = plate.graph.area();
    let t = plate.surface.vertices()[0].ball.thickness;
    let ideal = area / (0.433 * 25.0 * t * t);
    let count = plate.surface.triangles().len() as f64;
    assert!(count < 2.5 * ideal, "{count} against {ideal}");
}

#[test]
fn the_bend_of_an_ell_is_a_chain_of_edges() {
    // The branch point of the pruned fin: (2 - sqrt 2) t from both outer faces.
    for size in [None, Some(CellSize::Thicknesses(2.0))] {
        let result = run(&part("ell"), size);
        let creases = result.surface.creases();
        assert_eq!(creases.len(), 1);
        assert!(!creases[0].closed);
        let at = |v: &u32| result.surface.position(*v);
        let points: Vec<DVec3> = creases[0].path.iter().map(at).collect();
        let length: f64 = points.windows(2).map(|w| w[0].distance(w[1])).sum();
        let straight = points[0].distance(points[points.len() - 1]);
        assert!(
            (length - straight).abs() < 1e-9 * length,
            "{length} {straight}"
        );
        for v in &creases[0].path {
            let feet = &result.surface.vertices()[*v as usize].ball.footpoints;
            assert!(feet.len() >= 3, "{} has {} feet", at(v), feet.len());
        }
        let steps = segments(&creases[0].path, false).count();
        assert!(steps >= 2);
    }
}

/// A tube whose round walls are triangulated freely, each row turned against the one below, its
/// ends coping.
fn tube(radii: [f64; 2], chords: u32, rows: u32, height: f64) -> Part {
    let ring = |radius: f64, row: u32| {
        let up = height * f64::from(row) / f64::from(rows);
        (radius, up, 0.5 * f64::from(row % 2))
    };
    let outside = (0..=rows).map(|row| ring(radii[1], row));
    let inside = (0..=rows).rev().map(|row| ring(radii[0], row));
    let rings: Vec<(f64, f64, f64)> = outside.chain(inside).collect();
    let mesh = ringed(&rings, chords);
    // Between the walls.
    let ends = [rows, 2 * rows + 1];
    let coping = (0..mesh.triangles.len() as u32).map(|t| ends.contains(&(t / (2 * chords))));
    let coping = coping.collect();
    Part::new(mesh, coping, PartOptions::default()).unwrap().0
}

/// Chords of a round wall bend it by eighteen degrees each, and are no bends of the part: elements
/// pass over them.
#[test]
fn chords_of_a_round_wall_are_no_creases() {
    for radii in [[1.8, 3.0], [9.0, 10.0]] {
        let result = run(
            &tube(radii, 20, 8, 4.0 * radii[1]),
            Some(CellSize::Thicknesses(2.0)),
        );
        assert_eq!(result.surface.creases().len(), 0, "{radii:?}");
        let t = radii[1] - radii[0];
        let area = std::f64::consts::PI * (radii[0] + radii[1]) * 4.0 * radii[1];
        let ideal = area / (0.433 * 4.0 * t * t);
        let count = result.surface.triangles().len() as f64;
        assert!(count < 4.0 * ideal, "{count} against {ideal}");
        let feet = |v: &MidVertex| v.ball.footpoints.len();
        assert!(result.surface.vertices().iter().all(|v| feet(v) >= 2));
    }
}

/// Where no walls meet, straight junctions move nothing, though chords of a round wall do not lie
/// opposite each other.
#[test]
fn straight_junctions_leave_walls_without_any_as_they_are() {
    let part = tube([1.8, 3.0], 12, 8, 12.0);
    let with = |junctions| {
        let elements = ElementSettings {
            junctions,
            ..ElementSettings::of_size(CellSize::Thicknesses(2.0))
        };
        made(&part, Some(elements))
    };
    let straight = with(Junctions::Straight);
    let field = Field::new(&part);
    for v in straight.surface.vertices() {
        let on = |&foot: &DVec3| field.footpoint(foot).distance < 1e-9;
        assert!(v.ball.footpoints.iter().all(on), "{}", v.position);
    }
}

#[test]
fn bends_of_a_box_meet_in_its_corners() {
    for thicknesses in [1.0, 5.0] {
        let result = check("open_box", thicknesses, 15.0);
        // Four upright edges and four at the floor.
        assert_eq!(result.surface.creases().len(), 8);
    }
}

#[test]
fn remeshing_gives_the_same_bytes_on_any_number_of_threads() {
    let part = part("tee_rotated");
    let with = |threads: usize| {
        let pool = rayon_pool(threads);
        pool.install(|| run(&part, Some(CellSize::Thicknesses(2.0))).surface)
    };
    assert_eq!(with(1), with(3));
}

fn rayon_pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap()
}

/// Shares of quadrilaterals, triangles that may be lower than a tenth of the wall
/// (features of the enclosure are closer together than that), and vertices that
/// may be left on a chord, without feet.
#[test]
fn quads_are_most_elements_and_neither_low_nor_folded() {
    for (name, share, low, lone) in [
        // A plate's border is one loop; where it was begun does not matter to corners.
        ("plate", 1.0, 0, 0),
        ("rib_grid", 0.95, 0, 0),
        ("hemisphere_shell", 0.95, 0, 0),
        // Bends of a box meet in a corner a fraction of an element from its border.
        ("box_tube", 0.95, 0, 4),
        // A bend much narrower than an element.
        ("ell_bend", 0.85, 0, 0),
        ("enclosure", 0.85, 12, 40),
    ] {
        let elements = ElementSettings {
            quads: true,
            ..ElementSettings::of_size(CellSize::Thicknesses(2.0))
        };
        let part = part(name);
        let result = made(&part, Some(elements));
        let found = result.graph.counts().lone_feet;
        assert!(found <= lone, "{name}: {found} without feet");
        let same = Counts {
            lone_feet: 0,
            ..topology(&result)
        };
        assert_eq!(same, topology(&run(&part, None)), "{name}");
        let surface = &result.surface;
        assert_eq!(self_intersections(&surface.mesh()), [], "{name}");
        let all = surface.triangles().len() - result.quads.len();
        let quads = result.quads.len();
        assert!(
            quads as f64 >= share * all as f64,
            "{name}: {quads} of {all}"
        );
        let t = surface.vertices()[0].ball.thickness;
        let is_low = |c: [u32; 3]| {
            let [a, b, c] = c.map(|v| surface.position(v));
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            (b - a).cross(c - a).length() / longest < 0.1 * t
        };
        let lows = surface.triangles().iter().filter(|s| is_low(s.corners));
        let lows = lows.count();
        assert!(lows <= low, "{name}: {lows} low");
    }
}

/// Webs are flat where both their footpoints sit on edges, above a flange: no
/// element there is smaller than asked.
#[test]
fn flat_walls_get_as_few_elements_as_the_size_asks() {
    for name in ["rib_grid", "tee"] {
        let elements = ElementSettings {
            quads: true,
            ..ElementSettings::of_size(CellSize::Thicknesses(2.0))
        };
        let result = made(&part(name), Some(elements));
        let surface = &result.surface;
        let size = 2.0 * surface.vertices()[0].ball.thickness;
        let asked = surface.mesh().area() / (size * size);
        let made = (surface.triangles().len() - result.quads.len()) as f64;
        assert!(made <= 2.0 * asked, "{name}: {made} for {asked}");
    }
}

/// Flaps that run into their plate at a knife edge: sheets lie so close that elements cut each
/// other, and smaller ones more. What was traced stays there.
#[test]
fn where_smaller_elements_fail_the_traced_mesh_stays() {
    let part = part("placed/louvers");
    for junctions in [Junctions::Medial, Junctions::Straight] {
        let elements = ElementSettings {
            quads: true,
            junctions,
            ..ElementSettings::of_size(CellSize::Thicknesses(2.0))
        };
        let result = made(&part, Some(elements));
        assert_eq!(self_intersections(&result.surface.mesh()), []);
        let count = result.surface.triangles().len();
        let raw = run(&part, None).surface.triangles().len();
        assert!(3 * count < raw, "{count} of {raw}");
    }
}

/// Where a border bends between two vertices the traced mesh has a triangle across
/// the bend, upright on the sheet; made large it would leave the part.
#[test]
fn elements_at_the_end_of_a_sheet_stay_in_the_part() {
    let part = part("placed/grating");
    let field = Field::new(&part);
    for quads in [false, true] {
        for size in [2.0, 5.0] {
            let elements = ElementSettings {
                quads,
                ..ElementSettings::of_size(CellSize::Thicknesses(size))
            };
            let settings = Settings {
                cell: CellSize::Thicknesses(1.0),
                elements: Some(elements),
                ..Settings::default()
            };
            let surface = extract(&part, &settings, &|_, _, _| ()).unwrap().surface;
            let mesh = surface.mesh();
            assert_eq!(self_intersections(&mesh), [], "{size}");
            for p in &mesh.positions {
                let outside = -field.signed_clearance(*p);
                assert!(outside < 0.05, "{size}: {outside} at {p}");
            }
        }
    }
}
