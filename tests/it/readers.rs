//! Mesh readers on good, odd and broken files.

use std::path::Path;

use midsurf::io::read_mesh;
use midsurf::mesh::{Part, PartOptions};
use midsurf::tags::read_tags;

/// Name, triangles, coping triangles, volume, as the generator of the parts
/// states them.
const FIXTURES: [(&str, usize, usize); 24] = [
    ("boss_gussets", 418, 121),
    ("box_divider", 44, 14),
    ("box_tube", 32, 16),
    ("bracket", 908, 448),
    ("cross", 44, 28),
    ("cylinder_shell", 360, 180),
    ("ell", 20, 12),
    ("ell_bend", 108, 56),
    ("enclosure", 2588, 988),
    ("hemisphere_shell", 2094, 90),
    ("ibeam", 44, 28),
    ("open_box", 28, 8),
    ("plate", 12, 8),
    ("plate_holes", 416, 204),
    ("plate_round_edge", 172, 84),
    ("plate_tapered", 12, 8),
    ("rib_grid", 140, 72),
    ("slanted_45", 28, 18),
    ("tee", 28, 18),
    ("tee_filleted", 116, 62),
    ("tee_rotated", 28, 18),
    ("tee_thick_web", 28, 18),
    ("tee_thin_web", 28, 18),
    ("wavy_rib", 4658, 324),
];

#[test]
fn every_fixture_is_a_part_without_warnings() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures");
    for (name, triangles, coping) in FIXTURES {
        let file = folder.join(format!("{name}.obj"));
        let loaded = read_mesh(&file).unwrap();
        assert_eq!(loaded.mesh.triangles.len(), triangles, "{name}");
        assert!(loaded.warnings.is_empty(), "{name}");
        let tags = read_tags(folder.join(format!("{name}.coping.txt")), &loaded, &file).unwrap();
        let (part, warnings) = Part::new(loaded.mesh, tags.flags, PartOptions::default()).unwrap();
        assert_eq!(warnings, [], "{name}");
        assert!(part.is_closed(), "{name}");
        assert_eq!(part.coping_count(), coping, "{name}");
    }
}
