//! The bodies of a result: pieces, cavities, and whether it is a solid at all.

use crate::mesh::{Part, TriMesh, closed_shells, self_intersections};
use crate::offset::Void;

use crate::settings::quote::figure;
use crate::settings::warning::Warning;

/// The result's shells, and whether it is a solid at all.
pub struct Bodies {
    /// Shells that hold matter.
    pub pieces: usize,
    /// Volumes of the shells around none.
    pub cavities: Vec<f64>,
    /// Pairs of triangles that cut or touch each other.
    pub self_intersections: usize,
    /// Edges of more than two triangles.
    pub non_manifold_edges: usize,
    joined: bool,
}

impl Bodies {
    /// Counts. A contour alone cuts itself nowhere; a solid that was `joined` from
    /// two surfaces is searched.
    pub fn of(mesh: &TriMesh, joined: bool) -> Bodies {
        let uses = mesh.edges();
        let shells = closed_shells(mesh, &uses);
        let volumes = shells.iter().map(|shell| shell.volume);
        let (pieces, cavities): (Vec<f64>, Vec<f64>) = volumes.partition(|&volume| volume >= 0.0);
        let census = uses.census();
        Bodies {
            pieces: pieces.len(),
            cavities: cavities.into_iter().map(|volume| -volume).collect(),
            self_intersections: if joined {
                self_intersections(mesh).len()
            } else {
                0
            },
            joined,
            non_manifold_edges: census.balanced + census.unbalanced,
        }
    }

    /// Whether no triangles meet but in common vertices and edges of two.
    pub fn is_solid(&self) -> bool {
        self.self_intersections == 0 && self.non_manifold_edges == 0
    }

    /// What is odd about the result of a part with such cavities.
    pub fn warnings(&self, voids: &[Void], part: &Part) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let mut warn = |code, message| warnings.push(Warning::new(code, message));
        if let [first, ..] = voids {
            let [x, y, z] = first.at.to_array().map(figure);
            warn(
                "voids",
                format!(
                    "the part has {} already, of volume {}, the first at ({x}, {y}, {z}); --voids fill leaves none",
                    count(voids.len(), "cavity", "cavities"),
                    figure(voids.iter().map(|void| void.volume).sum()),
                ),
            );
        }
        let before = Bodies::pieces_of(part.mesh());
        if self.joined && self.pieces > before {
            warn(
                "loose_pieces",
                format!(
                    "the result is in {} pieces, the part in {before}: some lie loose{}",
                    self.pieces,
                    if voids.is_empty() {
                        ""
                    } else {
                        ", such as walls around cavities that the part has; --voids fill makes none of these"
                    },
                ),
            );
        }
        if !self.is_solid() {
            warn(
                "not_solid",
                format!(
                    "the result is no clean solid: {} pairs of triangles cut or touch each other, {} edges have more than two triangles, as where walls have no thickness",
                    self.self_intersections, self.non_manifold_edges
                ),
            );
        }
        warnings
    }

    fn pieces_of(mesh: &TriMesh) -> usize {
        let shells = closed_shells(mesh, &mesh.edges());
        shells.iter().filter(|shell| shell.volume >= 0.0).count()
    }
}

fn count(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}
