//! Named lines: seams, borders, creases, and the coping faces that borders end
//! on.

use rustc_hash::FxHashMap;

use super::ShellModel;
use crate::field::Field;
use crate::mesh::sets::Sets;
use crate::mesh::{FaceId, Part};
use crate::surface::{BorderKind, MidSurface, segments};

/// Triangles whose normals differ by less than this, degrees, are of one
/// coping face: below the facets of a drilled hole.
const FLAT: f64 = 20.0;

/// What a line is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SetKind {
    /// Where sheets meet.
    Seam,
    /// Free boundary at a coping face.
    CopingBorder,
    /// Free boundary where the wall fades out.
    FadingBorder,
    /// Bend inside a sheet.
    Crease,
    /// All that ends on one coping face of the part.
    Coping,
}

/// Sides of elements under a name.
#[derive(Clone, Debug, PartialEq)]
pub struct LineSet {
    /// Upper-case letters, digits and underscores; no other set has it.
    pub name: String,
    /// What it is.
    pub kind: SetKind,
    /// Its sides.
    pub sides: Vec<Side>,
}

/// Ends of a side of an element, and the node in its middle if there is one.
pub type Side = ([u32; 2], Option<u32>);

impl LineSet {
    /// Its nodes, ascending.
    pub fn nodes(&self) -> Vec<u32> {
        let mut nodes: Vec<u32> = (self.sides.iter())
            .flat_map(|(ends, middle)| ends.iter().copied().chain(*middle))
            .collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }
}

/// Seams, borders and creases of a surface, numbered from 1 each.
pub(super) fn lines(surface: &MidSurface, middles: &FxHashMap<[u32; 2], u32>) -> Vec<LineSet> {
    let set = |name: String, kind, path: &[u32], closed| LineSet {
        name,
        kind,
        sides: segments(path, closed)
            .map(|[a, b]| ([a, b], middles.get(&[a.min(b), a.max(b)]).copied()))
            .collect(),
    };
    let seams = (1..).zip(surface.seams());
    let seams = seams.map(|(n, l)| set(format!("SEAM_{n}"), SetKind::Seam, &l.path, l.closed));
    let borders = (1..).zip(surface.borders()).map(|(n, l)| {
        let kind = match l.kind {
            BorderKind::Coping => SetKind::CopingBorder,
            BorderKind::Fading => SetKind::FadingBorder,
        };
        set(format!("BORDER_{n}"), kind, &l.path, l.closed)
    });
    let creases = (1..).zip(surface.creases());
    let creases =
        creases.map(|(n, l)| set(format!("CREASE_{n}"), SetKind::Crease, &l.path, l.closed));
    seams.chain(borders).chain(creases).collect()
}

/// Number of the flat coping face that each triangle of a part belongs to,
/// from 0 in order of the lowest triangle; none for walls.
pub fn coping_patches(part: &Part) -> Vec<Option<u32>> {
    let mesh = part.mesh();
    let coping = part.coping();
    let normal = |f: usize| mesh.area_vector(FaceId(f as u32)).normalize_or_zero();
    let mut by_edge: FxHashMap<[u32; 2], u32> = FxHashMap::default();
    let mut joined = Sets::new(coping.len());
    let flat = FLAT.to_radians().cos();
    for (f, corners) in mesh.triangles.iter().enumerate().filter(|f| coping[f.0]) {
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            match by_edge.remove(&[a.min(b), a.max(b)]) {
                Some(other) if normal(f).dot(normal(other as usize)) > flat => {
                    joined.join(f as u32, other);
                }
                Some(_) => {}
                None => {
                    by_edge.insert([a.min(b), a.max(b)], f as u32);
                }
            }
        }
    }
    let mut count = 0;
    let mut number = vec![None; coping.len()];
    for f in (0..coping.len()).filter(|&f| coping[f]) {
        let first = joined.find(f as u32) as usize;
        if first == f {
            number[f] = Some(count);
            count += 1;
        } else {
            number[f] = number[first];
        }
    }
    number
}

impl ShellModel {
    /// Adds a set for every coping face of the part on which a border ends, by
    /// the name of the coping triangle nearest to each side's middle.
    ///
    /// Sets come in order of their names; names that differ only in signs that
    /// no set may hold fall together.
    pub(super) fn name_copings(&mut self, field: &Field, name: &dyn Fn(FaceId) -> String) {
        let borders = self
            .lines
            .iter()
            .filter(|l| l.kind == SetKind::CopingBorder);
        let mut sides: Vec<(String, Side)> = Vec::new();
        for side in borders.flat_map(|l| &l.sides) {
            let [a, b] = side.0.map(|n| self.nodes[n as usize].position);
            if let Some(foot) = field.nearest_coping(a.midpoint(b), f64::INFINITY) {
                sides.push((set_name("COPING_", &name(foot.face)), *side));
            }
        }
        sides.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.0.cmp(&b.1.0)));
        self.lines
            .extend(sides.chunk_by(|a, b| a.0 == b.0).map(|same| LineSet {
                name: same[0].0.clone(),
                kind: SetKind::Coping,
                sides: same.iter().map(|s| s.1).collect(),
            }));
    }
}

/// A name that every solver takes: upper case, at most 80 signs, the prefix
/// not twice.
fn set_name(prefix: &str, name: &str) -> String {
    let plain = |c: char| match c {
        'a'..='z' | 'A'..='Z' | '0'..='9' | '_' => c.to_ascii_uppercase(),
        _ => '_',
    };
    let name: String = name.chars().map(plain).collect();
    let bare = name.strip_prefix(prefix).unwrap_or(&name);
    format!("{prefix}{bare}").chars().take(80).collect()
}
