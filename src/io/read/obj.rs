//! Wavefront OBJ: a checking pass of our own, then tobj.
//!
//! tobj's errors carry neither file nor line, it takes NaN and infinities,
//! makes triangles of points and lines, and knows one name a face. So the
//! pass here reads every line, checks it, keeps its number and its names, and
//! hands tobj a plain stream of `v` and `f` lines that cannot fail: vertices
//! first, faces with positive indices, in file order.

use glam::DVec3;
use smallvec::SmallVec;
use tobj::LoadOptions;

use super::loaded::{FacetPlaces, RawMesh, ReadWarning};
use super::obj_tags::{ControlTags, TagSink};
use super::polygon::FacetSink;
use crate::io::error::{Located, Place, Problem};
use crate::io::names::{FacetNames, NamesBuilder};
use crate::io::text::{Lines, decode, excerpt, finite};
use crate::mesh::polygon::MOST_CORNERS;

pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, Located> {
    scan(bytes)?.finish()
}

/// The polygons of a file as they are, neither triangulated nor renumbered.
pub(super) fn parse_polygons(bytes: &[u8]) -> Result<Polygons, Located> {
    scan(bytes)?.polygons()
}

/// Vertices and faces of an OBJ with their lines.
pub(super) struct Polygons {
    pub(super) positions: Vec<DVec3>,
    /// Vertices of each face, in range.
    pub(super) faces: Vec<SmallVec<[u32; 4]>>,
    pub(super) vertex_lines: Vec<u64>,
    pub(super) face_lines: Vec<u64>,
    pub(super) tags: ControlTags,
    pub(super) names: FacetNames,
    pub(super) warnings: Vec<ReadWarning>,
}

/// The checking pass.
fn scan(bytes: &[u8]) -> Result<Scan, Located> {
    let mut scan = Scan::default();
    let mut lines = Lines::new(bytes);
    let mut joined = String::new();
    while let Some((number, raw)) = lines.next() {
        if raw.contains(&0) {
            return Err((
                Place::Line(number),
                Problem::Syntax("binary data in a text file".to_owned()),
            ));
        }
        let text = decode(raw);
        // A backslash at the end joins the next line; not so in comments,
        // where paths like C:\ occur.
        match text.trim_end().strip_suffix('\\') {
            Some(start) if !start.trim_start().starts_with('#') => {
                joined.clear();
                joined.push_str(start);
                for (_, more) in lines.by_ref() {
                    joined.push(' ');
                    let more = decode(more);
                    match more.trim_end().strip_suffix('\\') {
                        Some(start) => joined.push_str(start),
                        None => {
                            joined.push_str(&more);
                            break;
                        }
                    }
                }
                scan.line(number, &joined)?;
            }
            _ => scan.line(number, &text)?,
        }
    }
    Ok(scan)
}

/// What the checking pass gathers.
#[derive(Default)]
struct Scan {
    names: NamesBuilder,
    /// Checked `v` and `f` lines for tobj.
    vertex_lines: Vec<u8>,
    face_lines: Vec<u8>,
    vertices: usize,
    /// Line of each vertex.
    vertex_numbers: Vec<u64>,
    facet_lines: Vec<u64>,
    /// Corners of all facets, to check tobj against.
    corners: usize,
    /// Largest positive index and its line: later vertices may yet make it good.
    highest: Option<(i64, u64)>,
    /// `t` lines, read where a control mesh is asked for.
    tags: Vec<(u64, String)>,
    weights: Notice,
    curves: Notice,
    unknown: Notice,
    first_unknown: Option<(u64, String)>,
}

/// Count and first line of something odd.
#[derive(Default)]
struct Notice {
    count: usize,
    first: u64,
}

impl Notice {
    fn at(&mut self, line: u64) {
        if self.count == 0 {
            self.first = line;
        }
        self.count += 1;
    }

    fn warning(&self, code: &'static str, message: &str) -> Option<ReadWarning> {
        (self.count > 0).then(|| ReadWarning {
            code,
            place: Place::Line(self.first),
            message: format!("{} {message}", self.count),
        })
    }
}

impl Scan {
    fn line(&mut self, number: u64, text: &str) -> Result<(), Located> {
        let text = text.trim();
        let (keyword, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
        match keyword {
            "" => {}
            _ if keyword.starts_with('#') => {}
            "v" => self.vertex(number, rest)?,
            "f" | "fo" => self.facet(number, rest)?,
            "t" => self.tags.push((number, rest.to_owned())),
            "g" => {
                let mut groups: Vec<String> = rest.split_whitespace().map(str::to_owned).collect();
                if groups.is_empty() {
                    // The format's own name for no name.
                    groups.push("default".to_owned());
                }
                self.names.set_groups(groups);
            }
            "o" => self.names.set_object(some_name(rest)),
            "usemtl" => self.names.set_material(some_name(rest)),
            "vt" | "vn" | "vp" | "s" | "mg" | "mtllib" | "p" | "l" | "usemap" | "maplib"
            | "shadow_obj" | "trace_obj" | "lod" | "bevel" | "c_interp" | "d_interp" => {}
            "cstype" | "deg" | "bmat" | "step" | "curv" | "curv2" | "surf" | "parm" | "trim"
            | "hole" | "scrv" | "sp" | "end" | "con" | "ctech" | "stech" | "bzp" | "bsp"
            | "cdc" | "cdp" | "res" => self.curves.at(number),
            _ => {
                self.unknown.at(number);
                if self.first_unknown.is_none() {
                    self.first_unknown = Some((number, excerpt(keyword)));
                }
            }
        }
        Ok(())
    }

    fn vertex(&mut self, number: u64, rest: &str) -> Result<(), Located> {
        let place = Place::Line(number);
        let mut words = rest.split_whitespace();
        self.vertex_lines.push(b'v');
        for axis in ["x", "y", "z"] {
            let word = words.next().ok_or_else(|| {
                let message = format!("a vertex needs x, y and z; {axis} is missing");
                (place, Problem::Syntax(message))
            })?;
            finite(word).map_err(|problem| (place, problem))?;
            self.vertex_lines.push(b' ');
            self.vertex_lines.extend_from_slice(word.as_bytes());
        }
        self.vertex_lines.push(b'\n');
        self.vertices += 1;
        self.vertex_numbers.push(number);
        if self.vertices >= u32::MAX as usize {
            return Err((place, Problem::TooMany("vertices")));
        }
        // A fourth number alone is a weight, which only free-form curves use;
        // three more are a colour.
        if let (Some(weight), None) = (words.next(), words.next())
            && weight.parse() != Ok(1.0)
        {
            self.weights.at(number);
        }
        Ok(())
    }

    fn facet(&mut self, number: u64, rest: &str) -> Result<(), Located> {
        let place = Place::Line(number);
        self.face_lines.push(b'f');
        let mut corners = 0;
        for word in rest.split_whitespace() {
            if word.starts_with('#') {
                break;
            }
            if corners == MOST_CORNERS {
                // Counted no further, and kept neither.
                let corners = rest.split_whitespace().count();
                return Err((place, Problem::ManyCorners { corners }));
            }
            let index = vertex_index(word).map_err(|problem| (place, problem))?;
            let resolved = match index {
                1.. => Some(index),
                0 => None,
                _ => Some(self.vertices as i64 + 1 + index).filter(|&positive| positive > 0),
            };
            let Some(resolved) = resolved else {
                let problem = Problem::IndexOutOfRange {
                    index,
                    vertices: self.vertices,
                    relative: index < 0,
                };
                return Err((place, problem));
            };
            // An index past the vertices so far is looked at again at the end.
            if self.highest.is_none_or(|(highest, _)| resolved > highest) {
                self.highest = Some((resolved, number));
            }
            use std::io::Write;
            // Writing to a Vec cannot fail.
            let _ = write!(self.face_lines, " {resolved}");
            corners += 1;
        }
        self.face_lines.push(b'\n');
        if corners < 3 {
            return Err((place, Problem::FewCorners { corners }));
        }
        self.corners += corners;
        self.names.push_facet();
        self.facet_lines.push(number);
        Ok(())
    }

    /// Whether there are faces, and every vertex that they name.
    fn check(&self) -> Result<(), Located> {
        if let Some((index, line)) = self.highest
            && index > self.vertices as i64
        {
            let problem = Problem::IndexOutOfRange {
                index,
                vertices: self.vertices,
                relative: false,
            };
            return Err((Place::Line(line), problem));
        }
        if self.facet_lines.is_empty() {
            return Err(match &self.first_unknown {
                Some((line, word)) if self.vertices == 0 => (
                    Place::Line(*line),
                    Problem::Syntax(format!(
                        "{word:?} starts no OBJ statement, and the file has no faces"
                    )),
                ),
                _ => {
                    let vertices = self.vertices;
                    (Place::Whole, Problem::NoFaces { vertices })
                }
            });
        }
        Ok(())
    }

    fn polygons(mut self) -> Result<Polygons, Located> {
        self.check()?;
        let mut tags = TagSink::default();
        for (number, rest) in &self.tags {
            tags.line(*number, rest)?;
        }
        let (tags, skipped) = tags.finish();
        let mut warnings = self.warnings();
        warnings.extend(skipped);
        // Both streams hold what the pass wrote itself, a line each.
        let numbers = |line: &[u8]| -> Vec<f64> {
            let words = line.split(|&b| b == b' ').skip(1);
            words
                .filter_map(|word| std::str::from_utf8(word).ok()?.parse().ok())
                .collect()
        };
        let lines = |stream: &[u8]| -> Vec<Vec<f64>> {
            let lines = stream.split(|&b| b == b'\n');
            lines.filter(|line| !line.is_empty()).map(numbers).collect()
        };
        let positions = lines(&self.vertex_lines)
            .iter()
            .filter_map(|p| p.get(..3).map(DVec3::from_slice))
            .collect();
        // Indices are below 2^32, so exact as f64.
        let faces = lines(&self.face_lines)
            .iter()
            .map(|face| face.iter().map(|&index| index as u32 - 1).collect())
            .collect();
        Ok(Polygons {
            positions,
            faces,
            vertex_lines: std::mem::take(&mut self.vertex_numbers),
            face_lines: std::mem::take(&mut self.facet_lines),
            tags,
            names: self.names.finish(),
            warnings,
        })
    }

    fn finish(mut self) -> Result<RawMesh, Located> {
        self.check()?;
        let warnings = self.warnings();
        let mut stream = std::mem::take(&mut self.vertex_lines);
        stream.append(&mut self.face_lines);
        let (positions, sink) = self.through_tobj(&stream)?;
        Ok(sink.finish(
            positions,
            self.names.finish(),
            FacetPlaces::Lines(self.facet_lines),
            warnings,
        ))
    }

    fn warnings(&self) -> Vec<ReadWarning> {
        let unknown = match &self.first_unknown {
            Some((_, word)) => format!("unknown statements were skipped, the first {word:?}"),
            None => String::new(),
        };
        [
            self.weights
                .warning("vertex_weight", "vertices have a weight, which is ignored"),
            self.curves.warning(
                "free_form",
                "lines of free-form curves or surfaces were skipped; only polygons are read",
            ),
            self.unknown.warning("unknown_statement", &unknown),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    /// Loads the checked stream. tobj numbers vertices by first use, so those
    /// that no facet uses are gone.
    fn through_tobj(&self, stream: &[u8]) -> Result<(Vec<DVec3>, FacetSink), Located> {
        let options = LoadOptions {
            ignore_points: true,
            ignore_lines: true,
            ..LoadOptions::default()
        };
        let disagree = || {
            let message = "the OBJ parser does not agree with the checked faces".to_owned();
            (Place::Whole, Problem::Syntax(message))
        };
        let (mut models, _) =
            tobj::load_obj_buf(&mut &stream[..], &options, |_| Ok(Default::default()))
                .map_err(|error| (Place::Whole, Problem::Syntax(error.to_string())))?;
        let (Some(model), true) = (models.pop(), models.is_empty()) else {
            return Err(disagree());
        };
        let loaded = model.mesh;
        if loaded.indices.len() != self.corners {
            return Err(disagree());
        }
        let positions: Vec<DVec3> = loaded
            .positions
            .chunks_exact(3)
            .map(DVec3::from_slice)
            .collect();
        let mut sink = FacetSink::with_capacity(self.facet_lines.len());
        let mut rest = &loaded.indices[..];
        for (facet, &line) in self.facet_lines.iter().enumerate() {
            // No arities at all means triangles throughout.
            let arity = loaded.face_arities.get(facet).map_or(3, |&n| n as usize);
            let (corners, after) = rest.split_at_checked(arity).ok_or_else(disagree)?;
            rest = after;
            sink.push(corners, &positions, Place::Line(line))?;
        }
        Ok((positions, sink))
    }
}

fn some_name(rest: &str) -> Option<String> {
    let name = rest.trim();
    (!name.is_empty()).then(|| name.to_owned())
}

/// Vertex index of a corner `v`, `v/vt`, `v//vn` or `v/vt/vn`. The other two
/// must be numbers but are not used.
fn vertex_index(word: &str) -> Result<i64, Problem> {
    let bad = || Problem::NotAnIndex {
        word: excerpt(word),
    };
    let mut parts = word.split('/');
    let index = parts
        .next()
        .and_then(|part| part.parse().ok())
        .ok_or_else(bad)?;
    let mut others = 0;
    for part in parts {
        others += 1;
        if others > 2 || !(part.is_empty() || part.parse::<i64>().is_ok()) {
            return Err(bad());
        }
    }
    Ok(index)
}
