//! Meshes of meshers and solvers, and CAD models, as parts.

use std::io::Write;
use std::process::Command;

use midsurf::io::{LoadedMesh, MeshFormat, Problem, read_mesh, read_mesh_bytes};

use crate::common::fixture;

fn read(text: &str, format: MeshFormat) -> LoadedMesh {
    read_mesh_bytes(text.as_bytes(), format, "part".as_ref()).unwrap()
}

fn problem(text: &str, format: MeshFormat) -> String {
    let error = read_mesh_bytes(text.as_bytes(), format, "part".as_ref()).unwrap_err();
    error.to_string()
}

/// A closed unit cube of eight nodes and one hexahedron, outward.
fn check_cube(loaded: &LoadedMesh) {
    assert_eq!(loaded.facet_count(), 6);
    assert!(loaded.mesh.edges().census().is_closed());
    assert!((loaded.mesh.volume() - 1.0).abs() < 1e-12);
}

/// Groups of all facets, in order.
fn groups(loaded: &LoadedMesh) -> Vec<String> {
    let facets = 0..loaded.facet_count() as u32;
    facets
        .map(|f| loaded.names.of(f).groups.join("+"))
        .collect()
}

const CORNERS: [[u8; 3]; 8] = [
    [0, 0, 0],
    [1, 0, 0],
    [1, 1, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 0, 1],
    [1, 1, 1],
    [0, 1, 1],
];

/// One line a node, numbered from 11.
fn nodes(line: impl Fn(usize, [u8; 3]) -> String) -> String {
    CORNERS
        .iter()
        .enumerate()
        .map(|(n, &at)| line(n + 11, at) + "\n")
        .collect()
}

#[test]
fn msh_2_gives_skins_with_the_names_of_surfaces() {
    let nodes = nodes(|n, [x, y, z]| format!("{n} {x} {y} {z}"));
    let text = format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n\
         $PhysicalNames\n1\n2 7 \"top rim\"\n$EndPhysicalNames\n\
         $Nodes\n8\n{nodes}$EndNodes\n\
         $Elements\n3\n1 15 2 0 1 11\n2 3 2 7 5 15 16 17 18\n\
         3 5 2 0 1 11 12 13 14 15 16 17 18\n$EndElements\n"
    );
    let loaded = read(&text, MeshFormat::Msh);
    check_cube(&loaded);
    let groups = groups(&loaded);
    assert_eq!(
        groups.iter().filter(|g| *g == "face 5+top rim").count(),
        1,
        "{groups:?}"
    );
}

#[test]
fn msh_4_gives_faces_and_solids() {
    let tags: String = (11..19).map(|n| format!("{n}\n")).collect();
    let places = nodes(|_, [x, y, z]| format!("{x} {y} {z}"));
    let faces = [
        "14 13 12 11",
        "15 16 17 18",
        "11 12 16 15",
        "12 13 17 16",
        "13 14 18 17",
        "14 11 15 18",
    ];
    let elements: String = (faces.iter().enumerate())
        .map(|(n, nodes)| format!("2 {} 3 1\n{} {nodes}\n", n + 1, n + 1))
        .collect();
    let surfaces: String = (1..=6)
        .map(|n| {
            format!(
                "{n} 0 0 0 1 1 1 {}\n",
                if n == 2 { "1 -9 0" } else { "0 0" }
            )
        })
        .collect();
    let text = format!(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n\
         $PhysicalNames\n1\n2 9 \"rim\"\n$EndPhysicalNames\n\
         $Entities\n0 0 6 1\n{surfaces}1 0 0 0 1 1 1 0 6 1 2 3 4 5 6\n$EndEntities\n\
         $Nodes\n1 8 11 18\n3 1 0 8\n{tags}{places}$EndNodes\n\
         $Elements\n6 6 1 6\n{elements}$EndElements\n"
    );
    let loaded = read(&text, MeshFormat::Msh);
    check_cube(&loaded);
    assert_eq!(groups(&loaded)[..3], ["face 1", "face 2+rim", "face 3"]);
    assert_eq!(loaded.names.of(0).object.as_deref(), Some("solid 1"));
}

#[test]
fn decks_of_abaqus_and_calculix() {
    let nodes = nodes(|n, [x, y, z]| format!("{n}, {x}., {y}., {z}."));
    let text = format!(
        "** a cube\n*HEADING\ncube\n*Node, NSET=all\n{nodes}\
         *Element, type=C3D8R, ELSET=body\n1, 11, 12, 13, 14,\n15, 16, 17, 18\n\
         *ELEMENT, TYPE=S4\n2, 15, 16, 17, 18\n3, 11, 12, 16, 15\n\
         *ELSET, ELSET=top\n2\n*ELSET, ELSET=rim, GENERATE\n2, 3, 1\n*STEP\n"
    );
    let loaded = read(&text, MeshFormat::Inp);
    check_cube(&loaded);
    let mut groups = groups(&loaded);
    groups.sort();
    assert_eq!(groups, ["body", "body", "body", "body", "rim", "top+rim"]);
    let shells = text.replace("C3D8R", "B31").replace("S4", "S4R");
    assert_eq!(read(&shells, MeshFormat::Inp).facet_count(), 2);
}

#[test]
fn bulk_data_of_nastran_in_all_fields() {
    let short =
        nodes(|n, [x, y, z]| format!("GRID    {n:<8}{:<8}{x}.{:<6}{y}.0{:<5}{z}.+0", "", "", ""));
    let long = nodes(|n, [x, y, z]| {
        format!(
            "GRID*   {n:<16}{:<16}{:<16}{:<16}*\n*       {z}.0D+00",
            "",
            format!("{x}."),
            format!("{y}.")
        )
    });
    let free = nodes(|n, [x, y, z]| format!("GRID,{n},,{x}.,{y}.,{z}."));
    let solids = [
        "CHEXA   1       4       11      12      13      14      15      16      +\n+       17      18\n",
        "CHEXA,1,4,11,12,13,14,15,16,+\n+,17,18\n",
    ];
    for nodes in [short, long, free] {
        for solid in solids {
            let text = format!("$ a cube\nBEGIN BULK\n{nodes}{solid}ENDDATA\n");
            let loaded = read(&text, MeshFormat::Bdf);
            check_cube(&loaded);
            assert_eq!(groups(&loaded)[0], "property 4");
        }
    }
}

/// A 3MF file around a model.
fn archive(model: &str) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default();
    zip.start_file("3D/3dmodel.model", options).unwrap();
    zip.write_all(model.as_bytes()).unwrap();
    zip.finish().unwrap().into_inner()
}

/// A cube with a triangle set, an object of two copies of it, and what is built.
fn model_3mf(build: &str) -> String {
    let vertices: String = (CORNERS.iter())
        .map(|[x, y, z]| format!("<vertex x='{x}' y='{y}' z='{z}'/>"))
        .collect();
    let quads = [
        [0, 3, 2, 1],
        [4, 5, 6, 7],
        [0, 1, 5, 4],
        [1, 2, 6, 5],
        [2, 3, 7, 6],
        [3, 0, 4, 7],
    ];
    let triangles: String = (quads.iter())
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
        .map(|[a, b, c]| format!("<triangle v1='{a}' v2='{b}' v3='{c}'/>"))
        .collect();
    format!(
        "<?xml version='1.0'?><model unit='centimeter' xmlns:t='x'><resources>\
         <object id='1' name='cube &amp; co'><mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles>\
         <t:trianglesets><t:triangleset name='rim' identifier='r'><t:ref index='0'/><t:refrange startindex='4' endindex='5'/>\
         </t:triangleset></t:trianglesets></mesh></object>\
         <object id='2'><components><component objectid='1'/>\
         <component objectid='1' transform='-1 0 0 0 1 0 0 0 1 9 0 0'/></components></object>\
         </resources><build>{build}</build></model>"
    )
}

#[test]
fn builds_of_3mf_in_millimetres() {
    let read = |build: &str| {
        read_mesh_bytes(
            &archive(&model_3mf(build)),
            MeshFormat::ThreeMf,
            "part".as_ref(),
        )
    };
    let one = read("<item objectid='1'/>").unwrap();
    assert!((one.mesh.volume() - 1e3).abs() < 1e-9);
    assert!(one.mesh.edges().census().is_closed());
    assert_eq!(one.names.of(0).object.as_deref(), Some("cube & co"));
    let rim: Vec<u32> = (0..12)
        .filter(|&f| one.names.of(f).groups == ["rim"])
        .collect();
    assert_eq!(rim, [0, 4, 5]);
    assert_eq!(one.warnings[0].code, "unit");
    // Of the two copies one is mirrored, and still outward.
    let two = read("<item objectid='2' transform='0 1 0 -1 0 0 0 0 1 0 0 5'/>").unwrap();
    assert!((two.mesh.volume() - 2e3).abs() < 1e-9);
    assert!((two.mesh.bounds().max.y - 90.0).abs() < 1e-9);
    assert!((two.mesh.bounds().min.z - 50.0).abs() < 1e-9);
    for (build, word) in [
        ("<item objectid='7'/>", "does not exist"),
        ("<item objectid='1' transform='1 2'/>", "transform"),
        ("<item objectid='1' p:path='/3D/a.model'/>", "a.model"),
        ("<item/>", "objectid"),
        (
            "<item objectid='1' transform='1e300 0 0 0 1e300 0 0 0 1e300 1e308 1e308 1e308'/>",
            "beyond all numbers",
        ),
        ("", "no faces"),
    ] {
        let message = read(build).unwrap_err().to_string();
        assert!(message.contains(word), "{message}");
    }
    let endless = model_3mf("<item objectid='2'/>").replace("objectid='1'", "objectid='2'");
    let error = read_mesh_bytes(&archive(&endless), MeshFormat::ThreeMf, "part".as_ref());
    assert!(
        error
            .unwrap_err()
            .to_string()
            .contains("component of itself")
    );
    let error = read_mesh_bytes(b"PK not at all", MeshFormat::ThreeMf, "part".as_ref());
    assert!(error.unwrap_err().to_string().contains("archive"));
}

/// What is wrong is told with its line; nothing panics.
#[test]
fn bad_element_meshes_are_refused() {
    for (text, format, word) in [
        ("$Nodes\n1\n", MeshFormat::Msh, "$MeshFormat"),
        ("$MeshFormat\n2.2 1 8\n", MeshFormat::Msh, "cut short"),
        ("$MeshFormat\n3 0 8\n", MeshFormat::Msh, "neither"),
        (
            "$MeshFormat\n2.2 0 8\n$Nodes\n9\n1 0 0 0\n",
            MeshFormat::Msh,
            "cut short",
        ),
        (
            "$MeshFormat\n2.2 0 8\n$Nodes\n1\nx 0 0 0\n",
            MeshFormat::Msh,
            "whole number",
        ),
        (
            "$MeshFormat\n2.2 0 8\n$Elements\n1\n1 2 0 1 2 3\n",
            MeshFormat::Msh,
            "not defined",
        ),
        (
            "$MeshFormat\n4.1 0 8\n$Entities\n0 0 1 0\n1 0 0 0 1 1 1 99999999999 1\n",
            MeshFormat::Msh,
            "whole number",
        ),
        ("*INCLUDE, INPUT=a.inp\n", MeshFormat::Inp, "INCLUDE"),
        (
            "*ELEMENT, TYPE=S3\n1, 1, 2, 3\n",
            MeshFormat::Inp,
            "not defined",
        ),
        ("*NODE\n1, 0, zero, 0\n", MeshFormat::Inp, "zero"),
        ("*NODE\n1, 0, 0, 0\n", MeshFormat::Inp, "no faces"),
        ("GRID,1,7,0.,0.,0.\n", MeshFormat::Bdf, "coordinate system"),
        ("GRID,1,,nan,0.,0.\n", MeshFormat::Bdf, "not a number"),
        ("CTRIA3,1,1,1,2,3\n", MeshFormat::Bdf, "not defined"),
    ] {
        let message = problem(text, format);
        assert!(message.contains(word), "{text}: {message}");
    }
}

/// A name on the command line that only looks like a CAD file; with Gmsh or without,
/// an error says what to do.
#[test]
fn cad_files_need_gmsh() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("part.step");
    std::fs::write(&file, "not STEP").unwrap();
    let run = |gmsh: &str| {
        let done = Command::new(env!("CARGO_BIN_EXE_midsurf"))
            .arg("info")
            .arg(&file)
            .env("GMSH", gmsh)
            .output()
            .unwrap();
        assert_eq!(done.status.code(), Some(2));
        String::from_utf8(done.stderr).unwrap()
    };
    let missing = run("/nowhere/gmsh");
    assert!(missing.contains("pip install gmsh"), "{missing}");
    // A program that makes nothing.
    let mute = run(env!("CARGO_BIN_EXE_midsurf"));
    assert!(mute.contains("made no mesh"), "{mute}");
}

/// Where Gmsh is installed, a model comes with a group a face.
#[test]
fn cad_files_are_meshed() {
    let file = fixture("plate_bore.step");
    match read_mesh(&file) {
        Ok(loaded) => {
            assert!(loaded.mesh.edges().census().is_closed());
            let whole = 40.0 * 30.0 * 2.0 - 25.0 * std::f64::consts::PI * 2.0;
            assert!((loaded.mesh.volume() - whole).abs() < 2e-3 * whole);
            let mut groups = groups(&loaded);
            groups.sort();
            groups.dedup();
            groups.retain(|group| group.starts_with("face "));
            assert_eq!(groups.len(), 7);
        }
        Err(error) => assert!(matches!(error.problem(), Problem::NoMesher), "{error}"),
    }
}
