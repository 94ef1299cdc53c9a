//! Coping tags: which triangles close a wall instead of bounding it.
//!
//! A tag file is a list of rules. The text form gives indices, ranges and
//! names, one a line; the TOML form selects by place and shape too and can
//! carry a checksum of its mesh. Rules run top to bottom, the last match
//! wins; conditions in one rule must all hold, items of one list unite.

pub mod detect;
mod error;
mod excerpt;
mod glob;
mod identity;
mod rule;
mod select;
mod sliver;
mod text;
mod toml;
mod units;
mod write;

use std::path::Path;

pub use crate::io::geometry_checksum;
pub use detect::{Detection, detect};
pub use error::{TagError, TagProblem};
pub use sliver::Sliver;
pub use write::{detected_text, detected_toml, ranges};

use crate::io::{LoadedMesh, decode};
use crate::mesh::{Bounds, FaceId, TriMesh};
use error::Located;
use rule::{OnEmpty, Rest, TagFile};
use select::Selector;

/// What a tag file selects on a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Coping {
    /// One flag a triangle of the mesh: true for coping.
    pub flags: Vec<bool>,
    /// What each rule selects, in the order of the file.
    pub rules: Vec<RuleResult>,
    /// Rules that select nothing, where the file lets them pass with a warning.
    pub warnings: Vec<String>,
    /// What the detector found, where it was asked.
    pub detection: Option<Detection>,
    /// Narrow strips between coping faces that no rule tagged and that were
    /// tagged with them.
    pub slivers: Vec<Sliver>,
    /// The factor by which the mesh would have to be scaled for the places that the
    /// rules name to lie at it, where none does as it is: other units.
    pub scaled: Option<f64>,
}

/// What one rule selects, whatever later rules do to it.
#[derive(Clone, Debug, PartialEq)]
pub struct RuleResult {
    /// Name given in the file, or what the rule says.
    pub name: String,
    /// False for a rule that takes triangles back to the wall.
    pub coping: bool,
    /// Triangles selected.
    pub count: usize,
    /// Their area.
    pub area: f64,
    /// Box around them; empty when there are none.
    pub bounds: Bounds,
}

impl RuleResult {
    /// Count, area and box of the chosen triangles.
    pub fn of(
        mesh: &TriMesh,
        chosen: impl Fn(FaceId) -> bool,
        name: &str,
        coping: bool,
    ) -> RuleResult {
        let faces: Vec<FaceId> = mesh.faces().filter(|&face| chosen(face)).collect();
        RuleResult::of_faces(mesh, faces.iter().copied(), name, coping)
    }

    /// The same of triangles given one by one.
    fn of_faces(
        mesh: &TriMesh,
        faces: impl Iterator<Item = FaceId> + Clone,
        name: &str,
        coping: bool,
    ) -> RuleResult {
        RuleResult {
            name: name.to_owned(),
            coping,
            count: faces.clone().count(),
            area: faces.clone().map(|face| mesh.triangle_area(face)).sum(),
            bounds: Bounds::of(faces.flat_map(|face| mesh.corners(face))),
        }
    }
}

impl Coping {
    /// No tags: every triangle is wall.
    pub fn none(mesh: &LoadedMesh) -> Coping {
        Coping {
            flags: vec![false; mesh.mesh.triangles.len()],
            rules: Vec::new(),
            warnings: Vec::new(),
            detection: None,
            slivers: Vec::new(),
            scaled: None,
        }
    }

    /// Tags found by the program.
    pub fn detected(mesh: &LoadedMesh) -> Coping {
        let detection = detect(&mesh.mesh, &detect::Options::default());
        let is_coping = |face: FaceId| detection.flags[face.index()];
        let mut coping = Coping {
            flags: detection.flags.clone(),
            rules: vec![RuleResult::of(&mesh.mesh, is_coping, "detected", true)],
            warnings: Vec::new(),
            detection: Some(detection),
            slivers: Vec::new(),
            scaled: None,
        };
        coping.adopt_slivers(&mesh.mesh, &vec![false; mesh.mesh.triangles.len()]);
        coping
    }

    /// Tags the slivers between coping faces, but for triangles that are `kept`
    /// as wall.
    fn adopt_slivers(&mut self, mesh: &TriMesh, kept: &[bool]) {
        let slivers = sliver::slivers(mesh, &self.flags, kept);
        for &triangle in slivers.iter().flat_map(|sliver| &sliver.triangles) {
            self.flags[triangle as usize] = true;
        }
        self.slivers.extend(slivers);
    }
}

/// Reads a tag file and holds it against a mesh. A name that ends in `.toml`
/// means the TOML form, any other the text form. `mesh_file` serves messages
/// only.
///
/// # Errors
///
/// [`TagError`] names the file, the line, and what to do.
pub fn read_tags(
    file: impl AsRef<Path>,
    loaded: &LoadedMesh,
    mesh_file: &Path,
) -> Result<Coping, TagError> {
    let file = file.as_ref();
    let bytes = crate::io::read_bytes(file)
        .map_err(|problem| TagError::whole(file, TagProblem::Unread(problem)))?;
    read_tags_bytes(&bytes, loaded, file, mesh_file)
}

/// Reads tags from memory; as [`read_tags`].
///
/// # Errors
///
/// As [`read_tags`].
pub fn read_tags_bytes(
    bytes: &[u8],
    loaded: &LoadedMesh,
    file: &Path,
    mesh_file: &Path,
) -> Result<Coping, TagError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let text = decode(bytes);
    // Old Macintosh line ends.
    let text = if text.contains('\n') {
        text
    } else {
        text.replace('\r', "\n").into()
    };
    let fail = |located: Located| TagError::at(file, &text, located);
    let is_toml = file
        .extension()
        .is_some_and(|suffix| suffix.eq_ignore_ascii_case("toml"));
    let parsed = if is_toml {
        self::toml::parse(&text)
    } else {
        text::parse(&text)
    }
    .map_err(fail)?;
    apply(&parsed, loaded, mesh_file).map_err(fail)
}

/// What two lists in order have in common.
fn in_both(a: &[u32], b: &[u32]) -> Vec<u32> {
    let mut rest = b;
    let mut both = Vec::new();
    for &item in a {
        let from = rest.partition_point(|&other| other < item);
        rest = &rest[from..];
        if rest.first() == Some(&item) {
            both.push(item);
        }
    }
    both
}

fn apply(file: &TagFile, loaded: &LoadedMesh, mesh_file: &Path) -> Result<Coping, Located> {
    identity::check(&file.mesh, loaded, &mesh_file.to_string_lossy())?;
    let mut coping = match file.rest {
        Rest::Wall => Coping::none(loaded),
        Rest::Auto => Coping::detected(loaded),
    };
    coping.scaled = units::factor(file, &loaded.mesh.bounds());
    let mut kept = vec![false; coping.flags.len()];
    let mut selector = Selector::new(loaded);
    for rule in &file.rules {
        let strict = file.on_empty == OnEmpty::Error;
        let mut chosen: Option<Vec<u32>> = None;
        for condition in &rule.conditions {
            let holds = selector.select(condition, &rule.name, strict)?;
            chosen = Some(match chosen {
                None => holds,
                Some(before) => in_both(&before, &holds),
            });
        }
        // A rule has a condition.
        let chosen = chosen.unwrap_or_default();
        let faces = chosen.iter().map(|&triangle| FaceId(triangle));
        let result = RuleResult::of_faces(&loaded.mesh, faces, &rule.name, rule.coping);
        if result.count == 0 {
            let rule_name = rule.name.clone();
            let problem = TagProblem::SelectsNothing {
                rule: rule_name,
                scaled: coping.scaled,
            };
            match file.on_empty {
                OnEmpty::Error => return Err((rule.span.clone(), problem)),
                OnEmpty::Warn => coping.warnings.push(problem.to_string()),
                OnEmpty::Ignore => {}
            }
        }
        for triangle in chosen {
            coping.flags[triangle as usize] = rule.coping;
            kept[triangle as usize] = !rule.coping;
        }
        coping.rules.push(result);
    }
    coping.adopt_slivers(&loaded.mesh, &kept);
    Ok(coping)
}
