//! Coping tags: both forms, their selections and their errors.

use std::path::Path;

use glam::DVec3;
use midsurf::coping::{Coping, TagError, geometry_checksum, read_tags_bytes};
use midsurf::io::{LoadedMesh, MeshFormat, read_mesh};
use proptest::prelude::*;

use crate::common::{cuboid, fixture, join, obj_text, read, stl_bytes};

/// Plate of 10 x 10 x 1 with a small cube beside it: triangles 0-3 are the
/// broad faces of the plate, 4-11 its narrow sides, 12-23 the cube.
fn mesh() -> LoadedMesh {
    let plate = cuboid(DVec3::ZERO, DVec3::new(10.0, 10.0, 1.0));
    let cube = cuboid(DVec3::new(20.0, 0.0, 0.0), DVec3::ONE);
    let text = obj_text(&join(&plate, &cube));
    let mut names = [
        "g broad\n",
        "g rim_a side\n",
        "g rim_b side\n",
        "g\no cube\nusemtl red\n",
    ]
    .into_iter();
    let mut named = String::new();
    let mut facet = 0;
    for line in text.lines() {
        if line.starts_with('f') {
            if [0, 4, 8, 12].contains(&facet) {
                named += names.next().unwrap();
            }
            facet += 1;
        }
        named += line;
        named.push('\n');
    }
    read(MeshFormat::Obj, named.as_bytes()).unwrap()
}

fn tags(name: &str, text: &str) -> Result<Coping, TagError> {
    read_tags_bytes(
        text.as_bytes(),
        &mesh(),
        Path::new(name),
        Path::new("part.obj"),
    )
}

fn chosen(coping: &Coping) -> Vec<usize> {
    let flags = coping.flags.iter().enumerate();
    flags.filter(|(_, flag)| **flag).map(|(k, _)| k).collect()
}

/// Triangles that the text form selects.
fn text(text: &str) -> Vec<usize> {
    chosen(&tags("part.coping.txt", text).unwrap())
}

/// Triangles that rules of the TOML form select.
fn toml(rules: &str) -> Vec<usize> {
    let whole = format!("format = \"coping-tags\"\nversion = 1\n{rules}");
    chosen(&tags("part.toml", &whole).unwrap_or_else(|error| panic!("{error}")))
}

#[test]
fn text_form() {
    assert!(text("").is_empty());
    assert!(text("# nothing\n\n").is_empty());
    assert_eq!(text("3\n5-7 # side\n\n 9 \n"), [3, 5, 6, 7, 9]);
    assert_eq!(text("3, 5-7 9\r\n4-11:4"), [3, 4, 5, 6, 7, 8, 9]);
    assert_eq!(text("\u{feff}3\r4\r"), [3, 4]);
    assert_eq!(text("group: rim_a"), [4, 5, 6, 7]);
    assert_eq!(text("group: rim_?"), [4, 5, 6, 7, 8, 9, 10, 11]);
    assert_eq!(text("group: s*e\n0"), [0, 4, 5, 6, 7, 8, 9, 10, 11]);
    // `group` stands for objects and materials too.
    let cube: Vec<usize> = (12..24).collect();
    assert_eq!(text("group: red"), cube);
    assert_eq!(text("group: cube"), cube);
    assert_eq!(text("material: r*"), cube);
    assert_eq!(text("object: cube"), cube);
}

#[test]
fn text_rules_are_reported_by_block() {
    let coping = tags("t.txt", "0\n1-3\ngroup: red\n# x\n4\n").unwrap();
    let rules: Vec<_> = coping
        .rules
        .iter()
        .map(|r| (r.name.as_str(), r.count))
        .collect();
    assert_eq!(
        rules,
        [
            ("triangles from line 1", 4),
            ("group: red", 12),
            ("triangles from line 5", 1)
        ]
    );
    assert_eq!(coping.rules[0].area, 200.0);
    assert_eq!(coping.rules[1].bounds.min, DVec3::new(20.0, 0.0, 0.0));
    assert_eq!(coping.rules[1].bounds.max, DVec3::new(21.0, 1.0, 1.0));
}

#[test]
fn polygons_count_as_one() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf 1 2 3\nf 1 2 3 4\n";
    let loaded = read(MeshFormat::Obj, text.as_bytes()).unwrap();
    let select = |tags: &str| {
        let file = Path::new("t.txt");
        let coping = read_tags_bytes(tags.as_bytes(), &loaded, file, Path::new("x.obj"));
        chosen(&coping.unwrap())
    };
    assert_eq!(select("0"), [0, 1]);
    assert_eq!(select("1"), [2]);
    assert_eq!(select("2"), [3, 4]);
    assert_eq!(select("1-2"), [2, 3, 4]);
}

#[test]
fn toml_by_index_and_name() {
    assert_eq!(
        toml("[[coping]]\ntriangles = [3, \"5-7\", \"8-11:2\"]"),
        [3, 5, 6, 7, 8, 10]
    );
    assert_eq!(toml("[[coping]]\ntriangles = 3"), [3]);
    assert_eq!(
        toml("[options]\nindex_base = 1\n[[coping]]\ntriangles = [1, \"2-3\"]"),
        [0, 1, 2]
    );
    assert_eq!(toml("[[coping]]\ngroup = \"rim_a\""), [4, 5, 6, 7]);
    assert_eq!(toml("[[coping]]\ngroup = [\"rim_a\", \"br*\"]").len(), 8);
    assert_eq!(toml("[[coping]]\nmaterial = \"red\"").len(), 12);
    assert_eq!(toml("[[coping]]\nobject = \"cube\"").len(), 12);
    // Two conditions must both hold.
    assert_eq!(
        toml("[[coping]]\ngroup = \"side\"\ntriangles = \"0-5\""),
        [4, 5]
    );
}

#[test]
fn toml_by_place() {
    let plane = "[[coping]]\nplane = { point = [0, 0, 0], normal = [0, 0, -2]";
    assert_eq!(toml(&format!("{plane} }}")), [0, 1, 12, 13]);
    assert_eq!(
        toml(&format!("{plane}, tol = 0.01, max_angle = 5 }}")),
        [0, 1, 12, 13]
    );
    // Within 1 of the plane lies everything; the angle leaves the broad faces.
    assert_eq!(
        toml(&format!("{plane}, tol = 1, max_angle = 5 }}")),
        [0, 1, 2, 3, 12, 13, 14, 15]
    );
    assert_eq!(
        toml(&format!("{plane}, tol = 1, max_angle = 90 }}")).len(),
        24
    );

    let in_box = |mode: &str| {
        toml(&format!(
            "[[coping]]\nbox = {{ min = [-1, -1, -1], max = [0.5, 20, 20], mode = \"{mode}\" }}"
        ))
    };
    // The side at x = 0.
    assert_eq!(in_box("all"), [8, 9]);
    // All but the side at x = 10, which has no corner at x = 0.
    assert_eq!(in_box("any"), [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]);
    assert_eq!(in_box("centroid"), [8, 9]);
    let half = "[[coping]]\nbox = { min = [15, -inf, -inf], max = [inf, inf, inf] }";
    assert_eq!(toml(half), (12..24).collect::<Vec<_>>());
}

#[test]
fn toml_by_flood_fill() {
    let near = |rest: &str| {
        let rule = format!("[[coping]]\nnear = {{ point = [5, 4, 1.2]{rest} }}");
        toml(&rule)
    };
    assert_eq!(near(""), [2, 3]);
    assert_eq!(near(", grow_angle = 0"), [2, 3]);
    assert_eq!(near(", grow_angle = 20, max_area = 100"), [2, 3]);
    // Round the edges over the whole plate, but not over to the cube.
    assert_eq!(near(", grow_angle = 91"), (0..12).collect::<Vec<_>>());
}

#[test]
fn wall_takes_back_and_the_last_rule_wins() {
    let rules = "
[[coping]]
group = \"side\"
[[wall]]
triangles = \"5-9\"
[[coping]]
triangles = 7
";
    assert_eq!(toml(rules), [4, 7, 10, 11]);
    let whole = format!("format = \"coping-tags\"\nversion = 1\n{rules}");
    let coping = tags("t.toml", &whole).unwrap();
    let makes: Vec<_> = coping.rules.iter().map(|r| (r.coping, r.count)).collect();
    assert_eq!(makes, [(true, 8), (false, 5), (true, 1)]);
    assert_eq!(coping.rules[1].name, "rule 2 (wall)");
}

#[test]
fn empty_rules_are_errors_unless_told_otherwise() {
    let file = |on_empty: &str| {
        let text = format!(
            "format = \"coping-tags\"\nversion = 1\n[options]\non_empty = \"{on_empty}\"\n\
             [[coping]]\nname = \"none\"\ngroup = \"nowhere\"\n[[coping]]\ntriangles = 4\n"
        );
        tags("t.toml", &text)
    };
    let error = file("error").unwrap_err().to_string();
    assert!(
        error.contains("t.toml, line 7: no group name of the mesh fits \"nowhere\""),
        "{error}"
    );
    assert!(
        error.contains("there are broad, rim_a, side, rim_b, default"),
        "{error}"
    );
    let coping = file("warn").unwrap();
    assert_eq!(coping.warnings.len(), 1);
    assert_eq!(chosen(&coping), [4]);
    assert_eq!(file("ignore").unwrap().warnings.len(), 0);
}

#[test]
fn checksums_survive_conversion_and_tell_meshes_apart() {
    let obj = read_mesh(fixture("tee.obj")).unwrap();
    let stl = read_mesh(fixture("tee.stl")).unwrap();
    let geometry = geometry_checksum(&obj.mesh);
    assert_eq!(geometry, geometry_checksum(&stl.mesh));
    let mut shuffled = obj.mesh.clone();
    shuffled.triangles.reverse();
    shuffled.triangles.iter_mut().for_each(|t| t.rotate_left(1));
    assert_eq!(geometry, geometry_checksum(&shuffled));
    let mut moved = obj.mesh.clone();
    moved.positions[3].x += 0.001;
    assert_ne!(geometry, geometry_checksum(&moved));

    let accept = |loaded: &LoadedMesh, check: &str| {
        let text = format!(
            "format = \"coping-tags\"\nversion = 1\n[mesh]\nfile = \"tee\"\nunit = \"mm\"\n{check}\n\
             [[coping]]\ntriangles = 0\n"
        );
        let file = Path::new("t.toml");
        read_tags_bytes(text.as_bytes(), loaded, file, Path::new("tee.obj"))
    };
    let by_geometry = format!("geometry = \"{}\"", geometry.to_uppercase());
    assert!(accept(&obj, &by_geometry).is_ok());
    assert!(accept(&stl, &by_geometry).is_ok());
    let by_file = format!("sha256 = \"{}\"", obj.sha256);
    assert!(accept(&obj, &by_file).is_ok());
    assert!(accept(&obj, "triangles = 28").is_ok());
    for (check, what) in [
        (by_file.as_str(), "the sha256 of the file should be"),
        ("geometry = \"00\"", "the geometry checksum should be 00"),
        (
            "triangles = 29",
            "the number of triangles should be 29, but tee.obj has 28",
        ),
    ] {
        let error = accept(&stl, check).unwrap_err();
        assert_eq!(error.line(), Some(6));
        let error = error.to_string();
        assert!(error.contains("these tags are for another mesh"), "{error}");
        assert!(error.contains(what), "{error}");
    }
}

fn refused(name: &str, text: &str, line: u64, message: &str) {
    let error = match tags(name, text) {
        Ok(_) => panic!("accepted: {text}"),
        Err(error) => error,
    };
    assert!(error.to_string().contains(message), "{error}");
    assert_eq!(error.line(), Some(line), "{error}");
    assert!(error.to_string().starts_with(name), "{error}");
}

#[test]
fn broken_text_tags_are_refused_with_their_line() {
    for (text, line, message) in [
        (
            "0\n24\n",
            2,
            "triangle 24 does not exist: the mesh has 24 (0 to 23)",
        ),
        ("0-30", 1, "triangle 30 does not exist"),
        ("99999999999999999999", 1, "no triangle index"),
        ("# x\n\n7-5", 3, "runs backwards"),
        ("-3", 1, "\"-3\" is no tag"),
        ("1-2-3", 1, "no triangle index or range"),
        ("1:0", 1, "no triangle index or range"),
        ("1x", 1, "no triangle index or range"),
        ("rim", 1, "\"rim\" is no tag"),
        ("group: ", 1, "needs a name"),
        (
            "1\ngroup: nix",
            2,
            "no group, object or material name of the mesh fits \"nix\"",
        ),
        ("object: rim_a", 1, "no object name"),
        ("[mesh]\n", 1, "TOML form"),
        ("format = \"coping-tags\"", 1, "TOML form"),
        ("<html>", 1, "is no tag"),
    ] {
        refused("part.txt", text, line, message);
    }
}

#[test]
fn broken_toml_tags_are_refused_with_their_line() {
    for (text, line, message) in [
        ("", 1, "missing field `format`"),
        ("format = \"coping-tags\"\n", 1, "missing field `version`"),
        ("format = \"tags\"\nversion = 1", 1, "not \"coping-tags\""),
        ("format = \"coping-tags\"\nversion = 2", 2, "version 2"),
        ("format = \"coping-tags\nversion = 2", 1, ""),
    ] {
        refused("part.toml", text, line, message);
    }
    for (rules, line, message) in [
        ("[[coping]]", 3, "has no condition"),
        ("[[coping]]\nname = \"x\"", 3, "\"x\" has no condition"),
        ("[[coping]]\ncolour = 1", 4, "unknown field `colour`"),
        (
            "[[coping]]\ntriangles = 24",
            4,
            "triangle 24 does not exist",
        ),
        ("[[coping]]\ntriangles = -1", 4, "no triangle index"),
        ("[[coping]]\ntriangles = [1.5]", 4, "no triangle index"),
        ("[[coping]]\ngroup = 1", 4, "is no name"),
        ("[options]\nindex_base = 2", 4, "not 0 or 1"),
        (
            "[options]\nindex_base = 1\n[[coping]]\ntriangles = 0",
            6,
            "index 0 cannot occur",
        ),
        ("[options]\non_empty = \"maybe\"", 4, "unknown variant"),
        (
            "[[coping]]\nplane = { point = [0,0,0], normal = [0,0,0] }",
            4,
            "normal that is not zero",
        ),
        (
            "[[coping]]\nplane = { point = [0,0], normal = [0,0,1] }",
            4,
            "length",
        ),
        (
            "[[coping]]\nplane = { point = [0,0,0], normal = [0,0,1], tol = -1 }",
            4,
            "tol must",
        ),
        (
            "[[coping]]\nplane = { point = [0,0,0], normal = [0,0,1], max_angle = 91 }",
            4,
            "max_angle",
        ),
        (
            "[[coping]]\nplane = { point = [0,0,5], normal = [0,0,1] }",
            3,
            "selects no triangle",
        ),
        (
            "[[coping]]\nbox = { min = [0,0,1], max = [1,1,0] }",
            4,
            "must not exceed",
        ),
        (
            "[[coping]]\nbox = { min = [nan,0,0], max = [1,1,0] }",
            4,
            "must not exceed",
        ),
        (
            "[[coping]]\nbox = { min = [0,0,0], max = [1,1,1], mode = \"some\" }",
            4,
            "unknown variant",
        ),
        ("[[coping]]\nnear = { point = [0,0,inf] }", 4, "finite"),
        (
            "[[coping]]\nnear = { point = [5,5,1], grow_angle = 200 }",
            4,
            "grow_angle",
        ),
        (
            "[[coping]]\nnear = { point = [5,5,1], max_area = 99 }",
            4,
            "passed its largest area 99: it reached 100",
        ),
    ] {
        let whole = format!("format = \"coping-tags\"\nversion = 1\n{rules}");
        refused("part.toml", &whole, line, message);
    }
}

#[test]
fn an_stl_is_tagged_by_index() {
    let loaded = read(
        MeshFormat::Stl,
        &stl_bytes(&cuboid(DVec3::ZERO, DVec3::ONE), ""),
    )
    .unwrap();
    let file = Path::new("t.txt");
    let coping = read_tags_bytes(b"4-11", &loaded, file, Path::new("x.stl")).unwrap();
    assert_eq!(chosen(&coping), (4..12).collect::<Vec<_>>());
    let error = read_tags_bytes(b"group: x", &loaded, file, Path::new("x.stl")).unwrap_err();
    assert!(
        error.to_string().contains("it has no such names at all"),
        "{error}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_tags_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let mesh = mesh();
        for name in ["t.txt", "t.toml"] {
            let _ = read_tags_bytes(&bytes, &mesh, Path::new(name), Path::new("x.obj"));
        }
    }

    #[test]
    fn random_lines_never_panic(text in "([0-9]{1,3}(-[0-9]{1,3}(:[0-9])?)?|group: [a-z*?]{1,5}|#ü|[ ,\n\r=\\[\\]]){0,9}") {
        let _ = tags("t.txt", &text);
        let whole = format!("format = \"coping-tags\"\nversion = 1\n{text}");
        let _ = tags("t.toml", &whole);
    }
}
