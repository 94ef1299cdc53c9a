//! `t` lines of an OBJ: creases, corners, holes and boundary rule of a control
//! mesh, as OpenSubdiv's shapes state them:
//!
//! ```text
//! t crease 2/1/0 0 1 2.5           edge of vertices 0 and 1, sharpness
//! t corner 1/1/0 4 10              vertex, sharpness
//! t hole 1/0/0 3                   face
//! t interpolateboundary 1/0/0 1    0 none, 1 edge and corner, 2 edge only
//! ```
//!
//! After the name stand the counts of whole numbers, numbers and words, then
//! these. Vertices and faces count from 0.

use super::loaded::ReadWarning;
use crate::io::error::{Located, Place, Problem};
use crate::io::text::{excerpt, finite};

/// What the `t` lines of a file say, unchecked.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ControlTags {
    /// Ends of edges, and sharpness.
    pub creases: Vec<([u32; 2], f64)>,
    /// Vertices, and sharpness.
    pub corners: Vec<(u32, f64)>,
    /// Faces.
    pub holes: Vec<u32>,
    /// The boundary rule, if the file names one.
    pub boundary: Option<BoundaryTag>,
    /// Lines of creases, corners and holes.
    lines: [Vec<u64>; 3],
}

/// Kinds of tags that name a place of the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TagKind {
    /// Sharp edges.
    Crease,
    /// Sharp vertices.
    Corner,
    /// Faces without surface.
    Hole,
}

/// `interpolateboundary`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoundaryTag {
    /// 0: faces at the boundary have no surface.
    None,
    /// 1: boundary curves, and single faces' vertices held.
    EdgeAndCorner,
    /// 2: boundary curves.
    EdgeOnly,
}

impl ControlTags {
    /// Where the file states a tag, counted among those of its kind.
    pub fn place_of(&self, kind: TagKind, tag: usize) -> Place {
        self.lines[kind as usize]
            .get(tag)
            .map_or(Place::Whole, |&line| Place::Line(line))
    }
}

/// Gathers `t` lines.
#[derive(Default)]
pub(super) struct TagSink {
    tags: ControlTags,
    skipped: Option<(u64, String)>,
}

impl TagSink {
    /// One more line, without its keyword.
    pub(super) fn line(&mut self, number: u64, rest: &str) -> Result<(), Located> {
        self.tag(number, rest)
            .map_err(|problem| (Place::Line(number), problem))
    }

    fn tag(&mut self, number: u64, rest: &str) -> Result<(), Problem> {
        let mut words = rest.split_whitespace();
        let (Some(name), Some(counts)) = (words.next(), words.next()) else {
            return Err(syntax(
                "a tag needs a name and counts, as in `t crease 2/1/0 0 1 2.5`",
            ));
        };
        let parsed: Option<Vec<usize>> = counts.split('/').map(|word| word.parse().ok()).collect();
        let Some(&[whole, real, text]) = parsed.as_deref() else {
            let message = format!("{:?} are no counts as in 2/1/0", excerpt(counts));
            return Err(Problem::Syntax(message));
        };
        let words: Vec<&str> = words.take_while(|word| !word.starts_with('#')).collect();
        let all = whole.saturating_add(real).saturating_add(text);
        if words.len() != all {
            let message = format!(
                "the counts promise {all} arguments, and {} follow",
                words.len()
            );
            return Err(Problem::Syntax(message));
        }
        let index = |word: &&str| {
            word.parse::<u32>().map_err(|_| Problem::NotAnIndex {
                word: excerpt(word),
            })
        };
        let whole: Vec<u32> = words[..whole].iter().map(index).collect::<Result<_, _>>()?;
        let real = &words[whole.len()..whole.len() + real];
        let real: Vec<f64> = real
            .iter()
            .map(|word| finite(word))
            .collect::<Result<_, _>>()?;
        // One sharpness for all, or one for each.
        let sharpness = |things: usize| match *real {
            [sharp] => Ok(vec![sharp; things]),
            _ if real.len() == things => Ok(real.clone()),
            _ => Err(syntax(
                "a tag needs one sharpness, or one for each edge or vertex",
            )),
        };
        let tags = &mut self.tags;
        match name {
            "crease" => {
                let (edges, rest) = whole.as_chunks::<2>();
                if edges.is_empty() || !rest.is_empty() {
                    return Err(syntax("a crease tag needs the two vertices of each edge"));
                }
                let sharp = sharpness(edges.len())?;
                tags.creases.extend(edges.iter().copied().zip(sharp));
                tags.lines[TagKind::Crease as usize].resize(tags.creases.len(), number);
            }
            "corner" => {
                let sharp = sharpness(whole.len())?;
                tags.corners.extend(whole.iter().copied().zip(sharp));
                tags.lines[TagKind::Corner as usize].resize(tags.corners.len(), number);
            }
            "hole" => {
                tags.holes.extend_from_slice(&whole);
                tags.lines[TagKind::Hole as usize].resize(tags.holes.len(), number);
            }
            "interpolateboundary" => {
                tags.boundary = Some(match *whole {
                    [0] => BoundaryTag::None,
                    [1] => BoundaryTag::EdgeAndCorner,
                    [2] => BoundaryTag::EdgeOnly,
                    _ => return Err(syntax("interpolateboundary is 0, 1 or 2")),
                });
            }
            // Of values that vary over faces; and what is done anyway.
            "facevaryinginterpolateboundary" | "facevaryingpropagatecorners" => {}
            "creasemethod" if words == ["normal"] => {}
            "smoothtriangles" if words == ["catmark"] => {}
            _ => {
                let tag = [name]
                    .into_iter()
                    .chain(words)
                    .collect::<Vec<_>>()
                    .join(" ");
                self.skipped.get_or_insert((number, excerpt(&tag)));
            }
        }
        Ok(())
    }

    /// The tags, and a warning where one was skipped.
    pub(super) fn finish(self) -> (ControlTags, Option<ReadWarning>) {
        let warning = self.skipped.map(|(line, tag)| ReadWarning {
            code: "unknown_tag",
            place: Place::Line(line),
            message: format!("tags of another kind were skipped, the first {tag:?}"),
        });
        (self.tags, warning)
    }
}

fn syntax(message: &str) -> Problem {
    Problem::Syntax(message.to_owned())
}
