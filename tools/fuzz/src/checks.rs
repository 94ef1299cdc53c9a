//! What must hold of every file and every mesh: no panic, and what the README
//! promises.

use std::path::Path;

use midsurf::CellSize;
use midsurf::coping::read_tags_bytes;
use midsurf::extract::{self, Extraction, extract};
use midsurf::io::{MeshFormat, read_control_bytes, read_mesh_bytes};
use midsurf::mesh::{Part, PartOptions, TriMesh, mend, self_intersections};
use midsurf::offset::{self, offset};
use midsurf::roundtrip::{self, roundtrip};
use midsurf::subdivide::{Boundary, Cage, Level, Scheme, Settings, hollow_out};
use midsurf::thicken::{self, Side, Way, thicken};

use super::solids::Case;

/// Most memory of an engine; what needs more is refused.
const MEMORY: u64 = 1 << 30;

const OPEN: PartOptions = PartOptions {
    allow_open: true,
    weld: None,
    repair: false,
};

fn quiet(_: &'static str, _: u64, _: u64) {}

/// Reads a file as whatever its suffix says, and checks what it holds.
pub fn reads(bytes: &[u8], file: &Path) {
    match file.extension().and_then(|suffix| suffix.to_str()) {
        Some("txt" | "toml") => {
            let part = Path::new("part.stl");
            let mesh = super::solids::voxels(&[true; 27], glam::DVec3::ONE);
            let loaded = read_mesh_bytes(&stl(&mesh), MeshFormat::Stl, part).expect("a sound file");
            match read_tags_bytes(bytes, &loaded, file, part) {
                Ok(tags) => assert_eq!(tags.flags.len(), loaded.mesh.triangles.len()),
                Err(error) => assert!(error.to_string().len() <= 3000, "{error}"),
            }
        }
        Some("cage") => subdivides(bytes),
        _ => {
            let format = MeshFormat::of(file).expect("a suffix that is read");
            match read_mesh_bytes(bytes, format, file) {
                Ok(loaded) => {
                    let mesh = loaded.mesh;
                    let count = mesh.positions.len();
                    assert!(mesh.positions.iter().all(|p| p.is_finite()));
                    assert!(
                        mesh.triangles
                            .iter()
                            .flatten()
                            .all(|&v| (v as usize) < count)
                    );
                    assert_eq!(loaded.source.len(), mesh.triangles.len());
                    assert!(loaded.source.is_sorted());
                    mends(&mesh);
                }
                Err(error) => assert!(error.to_string().len() <= 3000, "{error}"),
            }
        }
    }
}

/// A control mesh: what is accepted is subdivided, and is finite.
fn subdivides(bytes: &[u8]) {
    let Ok(control) = read_control_bytes(bytes, Path::new("a.obj")) else {
        return;
    };
    let Ok(cage) = Cage::new(control.positions, &control.faces) else {
        return;
    };
    let points = cage.positions().iter().copied();
    let size = midsurf::mesh::Bounds::of(points).diagonal();
    if cage.face_count() > 200 || !(1e-6..1e6).contains(&size) {
        return;
    }
    let settings = Settings {
        thickness: 0.02 * size,
        samples: 3,
        level: Level::Fixed(0),
        scheme: Scheme::Crust,
        boundary: Boundary::EdgeAndCorner,
    };
    if let Ok(solid) = hollow_out(&cage, &settings, &|_| ()) {
        let mesh = &solid.hollow.mesh;
        assert!(mesh.positions.iter().all(|p| p.is_finite()));
        assert!(mesh.edges().census().is_closed());
    }
}

/// Mending keeps what it must: it says what it changes, and done twice it does
/// nothing more.
fn mends(mesh: &TriMesh) {
    for repair in [false, true] {
        let options = PartOptions { repair, ..OPEN };
        let Ok(mended) = mend(mesh.clone(), options) else {
            continue;
        };
        assert_eq!(mended.origin.len(), mended.mesh.triangles.len());
        assert!(mended.origin.is_sorted());
        assert!(mended.mesh.positions.iter().all(|p| p.is_finite()));
        if mended.repairs.is_empty() {
            assert_eq!(mended.mesh.triangles.len(), mesh.triangles.len());
        }
        let before = mesh.edges().census();
        let after = mended.mesh.edges().census();
        assert!(after.open <= before.open || !mended.repairs.is_empty());
        if before.is_closed() {
            assert!(after.is_closed(), "{:?}", mended.repairs);
        }
        let again = mend(mended.mesh.clone(), options).expect("what was mended once");
        // Where rounds did not suffice, the last one left something.
        if mended.repairs.len() < 4 {
            assert_eq!(again.repairs, [], "after {:?}", mended.repairs);
        }
        let flags = vec![false; mesh.triangles.len()];
        let _ = Part::new(mesh.clone(), flags, options);
    }
}

pub fn repairs(case: &Case) {
    mends(&case.mesh);
}

fn part(case: &Case) -> Option<Part> {
    let part = Part::new(case.mesh.clone(), case.coping.clone(), OPEN);
    part.ok().map(|(part, _)| part)
}

fn settings(part: &Part, case: &Case) -> extract::Settings {
    let size = part.bounds().diagonal();
    extract::Settings {
        cell: CellSize::Length((0.06 + 0.25 * case.choice) * size),
        keep_fins: case.choice > 0.8,
        memory_limit: MEMORY,
        ..extract::Settings::default()
    }
}

/// Every triangle edge has two triangles or more, lies on a border, or is counted as
/// a crack; all numbers are finite.
fn holds(result: &Extraction) {
    let surface = &result.surface;
    for vertex in surface.vertices() {
        assert!(vertex.position.is_finite());
        assert!(vertex.ball.radius.is_finite() && vertex.ball.radius >= 0.0);
    }
    let pair = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
    let borders: std::collections::BTreeSet<[u32; 2]> = (surface.borders().iter())
        .flat_map(|line| midsurf::surface::segments(&line.path, line.closed))
        .map(pair)
        .collect();
    let mesh = surface.mesh();
    let uses = mesh.edges();
    let bare = uses
        .by_edge()
        .filter(|uses| uses.len() == 1 && !borders.contains(&uses[0].edge));
    assert_eq!(bare.count(), result.graph.cracks().len());
}

pub fn extracts(case: &Case) {
    let Some(part) = part(case) else { return };
    if let Ok(result) = extract(&part, &settings(&part, case), &quiet) {
        holds(&result);
    }
}

pub fn goes_round(case: &Case) {
    let Some(part) = part(case) else { return };
    let settings = roundtrip::Settings {
        extract: settings(&part, case),
        solid_cell: CellSize::Percent(5.0),
        memory_limit: MEMORY,
    };
    if let Ok(result) = roundtrip(&part, &settings, &quiet) {
        holds(&result.extraction);
        assert!(result.comparison.closed);
        assert_eq!(result.comparison.self_intersections, 0);
        assert!(result.solid.mesh.positions.iter().all(|p| p.is_finite()));
    }
}

pub fn offsets(case: &Case) {
    let Some(part) = part(case) else { return };
    let size = part.bounds().diagonal();
    for distance in [0.03 * size, -0.02 * size, 0.3 * case.choice * size] {
        let mut settings = offset::Settings::new(&part, distance);
        settings.cell = (0.03 + 0.05 * case.choice) * size;
        settings.memory_limit = MEMORY;
        if let Ok(result) = offset(&part, &settings, &quiet) {
            let census = result.mesh.edges().census();
            assert!(census.is_closed() && census.balanced == 0, "{census:?}");
            assert_eq!(self_intersections(&result.mesh), []);
            assert!(result.mesh.positions.iter().all(|p| p.is_finite()));
        }
    }
}

pub fn thickens(case: &Case) {
    for side in [Side::Inner, Side::Outer] {
        let thickness = 0.05 + 0.5 * case.choice;
        let mut settings = thicken::Settings::new(thickness, side);
        settings.cell = 0.4 * thickness;
        settings.memory_limit = MEMORY;
        let Ok(result) = thicken(&case.mesh, &settings, &quiet) else {
            continue;
        };
        assert_eq!(
            result.self_intersections,
            self_intersections(&result.mesh).len()
        );
        assert!(result.mesh.positions.iter().all(|p| p.is_finite()));
        if result.bad_edges == 0 {
            assert!(result.mesh.edges().census().is_closed());
        }
        if result.way == Way::Joined && result.repairs.is_empty() {
            // But for vertices of no triangle.
            let corners = case.mesh.triangles.iter().flatten();
            let used: std::collections::BTreeSet<u32> = corners.copied().collect();
            let kept = result.mesh.positions.iter().zip(used);
            for (at, v) in kept {
                assert_eq!(*at, case.mesh.positions[v as usize]);
            }
        }
    }
}

/// Binary STL of a mesh.
fn stl(mesh: &TriMesh) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for face in mesh.faces() {
        bytes.extend([0; 12]);
        let corners = mesh.corners(face);
        bytes.extend(
            corners
                .iter()
                .flat_map(|p| p.to_array())
                .flat_map(|x| (x as f32).to_le_bytes()),
        );
        bytes.extend([0, 0]);
    }
    bytes
}
