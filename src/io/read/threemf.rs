//! 3MF: the objects that the build names, placed as it says, in millimetres.
//!
//! A facet's object is the name of its object, its groups are the triangle sets that
//! it is in, its material is the name of its base material or its colour. Objects may
//! stand in further model files of the archive.

use std::borrow::Cow;
use std::io::{Cursor, Read};

use glam::{DMat3, DVec3};
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use rustc_hash::FxHashMap;

use super::loaded::{FacetPlaces, RawMesh, ReadWarning};
use super::polygon::FacetSink;
use crate::io::error::{Located, Place, Problem};
use crate::io::names::NamesBuilder;
use crate::io::text::{corner, excerpt, finite};
use crate::io::unit::Unit;

/// Components within components; more is a circle.
const DEEPEST: usize = 32;

/// Most triangles and copies that repeated components may add up to, and most bytes
/// that the model may unpack to: a small file can claim any number of them.
const MOST_TRIANGLES: usize = 200_000_000;
const MOST_COPIES: usize = 1_000_000;
const MOST_BYTES: u64 = 8 << 30;

/// Units by the format's names for them.
const UNITS: [(&str, Unit); 6] = [
    ("micron", Unit::Micron),
    ("millimeter", Unit::Millimetre),
    ("centimeter", Unit::Centimetre),
    ("inch", Unit::Inch),
    ("foot", Unit::Foot),
    ("meter", Unit::Metre),
];

/// Model files that an archive may have.
const MOST_FILES: usize = 10_000;

/// Rows of a transform as the file has them: three of a matrix, one of a shift.
#[derive(Clone, Copy)]
struct Transform {
    turn: DMat3,
    shift: DVec3,
}

#[derive(Default)]
struct Object {
    name: Option<String>,
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    sets: Vec<(String, Vec<u32>)>,
    components: Vec<(Id, Transform)>,
    /// Property group and place in it, for all triangles and for each; where the
    /// triangles have none the list is short.
    paint: Option<(u64, u64)>,
    paints: Vec<Option<(u64, u64)>>,
}

/// A model file of the archive, and a number in it.
type Id = (usize, u64);

#[derive(Default)]
struct Model {
    unit: Option<String>,
    objects: FxHashMap<Id, Object>,
    /// Names of base materials, and colours.
    properties: FxHashMap<Id, Vec<String>>,
    items: Vec<(Id, Transform)>,
}

/// The archive's model files: the root first, then those that it refers to.
struct Archive<'a> {
    zip: zip::ZipArchive<Cursor<&'a [u8]>>,
    files: Vec<String>,
    /// Bytes that may still be unpacked.
    left: u64,
}

pub(super) fn parse(bytes: &[u8]) -> Result<RawMesh, Located> {
    let mut archive = Archive::open(bytes).map_err(syntax)?;
    let mut model = Model::default();
    let mut next = 0;
    while next < archive.files.len() {
        let text = archive.unpack(next).map_err(syntax)?;
        read_model(&text, next, &mut archive.files, &mut model)?;
        next += 1;
    }
    let unit = model.unit.as_deref().unwrap_or("millimeter");
    let scale = UNITS.iter().find(|(name, _)| *name == unit);
    let Some(&(_, found)) = scale else {
        return Err(syntax(format!("the unit {:?} is not known", excerpt(unit))));
    };
    let scale = found.millimetres();
    let mut out = Out::default();
    for &(object, transform) in &model.items {
        let scaled = Transform {
            turn: transform.turn * scale,
            shift: transform.shift * scale,
        };
        out.place(&model, object, scaled, 0)?;
    }
    let mut warnings = Vec::new();
    if scale != 1.0 {
        warnings.push(ReadWarning {
            code: "unit",
            place: Place::Whole,
            message: format!("lengths in {unit} were taken to millimetres"),
        });
    }
    let names = out.names.finish();
    let mut raw = out
        .sink
        .finish(out.points, names, FacetPlaces::None, warnings);
    raw.unit = Some(Unit::Millimetre);
    Ok(raw)
}

fn syntax(message: String) -> Located {
    (Place::Whole, Problem::Syntax(message))
}

impl Archive<'_> {
    fn open(bytes: &[u8]) -> Result<Archive<'_>, String> {
        let zip = zip::ZipArchive::new(Cursor::new(bytes))
            .map_err(|error| format!("this is no 3MF archive: {error}"))?;
        let names = zip.file_names().flatten().map(Cow::into_owned);
        let mut models: Vec<String> = names.filter(|name| name.ends_with(".model")).collect();
        // The root model stands highest.
        models.sort_by_key(|name| (name.matches('/').count(), name.clone()));
        models.truncate(1);
        if models.is_empty() {
            return Err("the archive holds no model".to_owned());
        }
        Ok(Archive {
            zip,
            files: models,
            left: MOST_BYTES,
        })
    }

    /// The text of a model file.
    fn unpack(&mut self, file: usize) -> Result<String, String> {
        let name = &self.files[file];
        let found = self.zip.by_name(name);
        let found = found.map_err(|error| format!("{:?}: {error}", excerpt(name)))?;
        let mut text = String::new();
        let read = found.take(self.left).read_to_string(&mut text);
        read.map_err(|error| format!("the model cannot be unpacked: {error}"))?;
        self.left -= text.len() as u64;
        Ok(text)
    }
}

/// Reads a model file; others that it refers to join the list of files.
fn read_model(
    text: &str,
    file: usize,
    files: &mut Vec<String>,
    model: &mut Model,
) -> Result<(), Located> {
    let mut reader = Reader::from_str(text);
    let mut current: Option<Id> = None;
    let mut group: Option<Id> = None;
    loop {
        let event = reader.read_event().map_err(|e| syntax(e.to_string()))?;
        let tag = match &event {
            Event::Start(tag) | Event::Empty(tag) => tag,
            Event::Eof => return Ok(()),
            _ => continue,
        };
        let tag = Tag(tag);
        let name = tag.0.local_name();
        let object = current.and_then(|id| model.objects.get_mut(&id));
        match (name.as_ref(), object) {
            ("model", _) if file == 0 => model.unit = tag.text("unit"),
            ("basematerials" | "colorgroup", _) => {
                let id = (file, tag.number("id")?);
                group = Some(id);
                model.properties.entry(id).or_default();
            }
            (kind @ ("base" | "color"), _) => {
                let of = if kind == "base" { "name" } else { "color" };
                if let Some(list) = group.and_then(|id| model.properties.get_mut(&id)) {
                    list.push(tag.needed(of)?);
                }
            }
            ("object", _) => {
                let id = (file, tag.number("id")?);
                current = Some(id);
                let name = tag.text("name").filter(|name| !name.is_empty());
                let object = model.objects.entry(id).or_default();
                object.name = name;
                object.paint = tag.paint("pindex")?;
            }
            ("vertex", Some(object)) => {
                let at = [tag.real("x")?, tag.real("y")?, tag.real("z")?];
                object.points.push(DVec3::from(at));
            }
            ("triangle", Some(object)) => {
                let count = object.points.len();
                let mut corners = [0; 3];
                for (at, name) in corners.iter_mut().zip(["v1", "v2", "v3"]) {
                    let index = i64::try_from(tag.number(name)?).unwrap_or(i64::MAX);
                    *at = corner(index, count).map_err(|problem| (Place::Whole, problem))?;
                }
                if let Some(paint) = tag.paint_of_triangle(object.paint)? {
                    object.paints.resize(object.triangles.len(), None);
                    object.paints.push(Some(paint));
                }
                object.triangles.push(corners);
            }
            ("triangleset", Some(object)) => {
                let name = tag.text("name").unwrap_or_default();
                object.sets.push((name, Vec::new()));
            }
            ("ref", Some(object)) => {
                let index = tag.number("index")?;
                object.add_to_set(index, index)?;
            }
            ("refrange", Some(object)) => {
                object.add_to_set(tag.number("startindex")?, tag.number("endindex")?)?;
            }
            ("component", Some(object)) => {
                let id = (tag.file(file, files)?, tag.number("objectid")?);
                object.components.push((id, tag.transform()?));
            }
            // Only the root builds.
            ("item", _) if file == 0 => {
                let id = (tag.file(file, files)?, tag.number("objectid")?);
                model.items.push((id, tag.transform()?));
            }
            _ => {}
        }
    }
}

impl Object {
    /// Triangles in a range join the set that was begun last.
    fn add_to_set(&mut self, first: u64, last: u64) -> Result<(), Located> {
        let count = self.triangles.len();
        let Some((_, set)) = self.sets.last_mut() else {
            return Ok(());
        };
        if last >= count as u64 {
            return Err(syntax(format!("triangle {last} of a set does not exist")));
        }
        // Ranges that repeat could fill the memory.
        if first <= last && set.len() as u64 + (last - first) >= 2 * count as u64 {
            return Err(syntax(
                "a triangle set names its triangles twice".to_owned(),
            ));
        }
        set.extend((first..=last).map(|index| index as u32));
        Ok(())
    }
}

/// An element with its attributes.
struct Tag<'a>(&'a BytesStart<'a>);

impl Tag<'_> {
    fn text(&self, name: &str) -> Option<String> {
        let found = self.0.attributes().flatten();
        let mut found = found.filter(|a| a.key.local_name().as_ref() == name);
        let text = found.next()?.value;
        let plain = quick_xml::escape::unescape(&text).map(Cow::into_owned);
        Some(plain.unwrap_or_else(|_| text.to_string()))
    }

    fn needed(&self, name: &str) -> Result<String, Located> {
        let tag = self.0.local_name();
        let tag = tag.as_ref();
        self.text(name)
            .ok_or_else(|| syntax(format!("a {tag} without {name}")))
    }

    fn number(&self, name: &str) -> Result<u64, Located> {
        let word = self.needed(name)?;
        let bad = || syntax(format!("{:?} is not a whole number", excerpt(&word)));
        word.trim().parse().map_err(|_| bad())
    }

    fn real(&self, name: &str) -> Result<f64, Located> {
        finite(self.needed(name)?.trim()).map_err(|problem| (Place::Whole, problem))
    }

    fn transform(&self) -> Result<Transform, Located> {
        let mut entries = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
        if let Some(text) = self.text("transform") {
            let words: Vec<&str> = text.split_whitespace().collect();
            if words.len() != entries.len() {
                return Err(syntax(format!("a transform of {} numbers", words.len())));
            }
            for (entry, word) in entries.iter_mut().zip(words) {
                *entry = finite(word).map_err(|problem| (Place::Whole, problem))?;
            }
        }
        let row = |k: usize| DVec3::new(entries[k], entries[k + 1], entries[k + 2]);
        // The file multiplies rows from the left: its rows are columns here.
        Ok(Transform {
            turn: DMat3::from_cols(row(0), row(3), row(6)),
            shift: row(9),
        })
    }

    /// Property group and place in it, if both are given.
    fn paint(&self, index: &str) -> Result<Option<(u64, u64)>, Located> {
        match (self.text("pid"), self.text(index)) {
            (Some(_), Some(_)) => Ok(Some((self.number("pid")?, self.number(index)?))),
            _ => Ok(None),
        }
    }

    /// The same of a triangle, which may leave the group to its object.
    fn paint_of_triangle(
        &self,
        of_object: Option<(u64, u64)>,
    ) -> Result<Option<(u64, u64)>, Located> {
        match (self.text("p1"), of_object) {
            (Some(_), Some((group, _))) if self.text("pid").is_none() => {
                Ok(Some((group, self.number("p1")?)))
            }
            _ => self.paint("p1"),
        }
    }

    /// The model file that an object stands in.
    fn file(&self, own: usize, files: &mut Vec<String>) -> Result<usize, Located> {
        let Some(path) = self.text("path") else {
            return Ok(own);
        };
        let path = path.trim_start_matches('/');
        if let Some(known) = files.iter().position(|name| name == path) {
            return Ok(known);
        }
        if files.len() >= MOST_FILES {
            return Err((Place::Whole, Problem::TooMany("model files")));
        }
        files.push(path.to_owned());
        Ok(files.len() - 1)
    }
}

/// What comes of the objects.
#[derive(Default)]
struct Out {
    points: Vec<DVec3>,
    sink: FacetSink,
    names: NamesBuilder,
    copies: usize,
}

impl Out {
    fn place(&mut self, model: &Model, id: Id, by: Transform, depth: usize) -> Result<(), Located> {
        let object = (model.objects.get(&id))
            .ok_or_else(|| syntax(format!("object {} does not exist", id.1)))?;
        if depth > DEEPEST {
            return Err(syntax(format!("object {} is a component of itself", id.1)));
        }
        self.copies += 1;
        let triangles = self.sink.facet_count() as usize + object.triangles.len();
        if triangles > MOST_TRIANGLES || self.copies > MOST_COPIES {
            return Err((Place::Whole, Problem::TooMany("triangles")));
        }
        if self.points.len() + object.points.len() > u32::MAX as usize {
            return Err((Place::Whole, Problem::TooMany("vertices")));
        }
        let first = self.points.len() as u32;
        let placed = object.points.iter().map(|&p| by.turn * p + by.shift);
        self.points.extend(placed);
        if !self.points[first as usize..].iter().all(|p| p.is_finite()) {
            return Err(syntax(format!(
                "object {} is placed beyond all numbers",
                id.1
            )));
        }
        let mut groups: Vec<Vec<String>> = vec![Vec::new(); object.triangles.len()];
        for (name, set) in &object.sets {
            for &triangle in set {
                groups[triangle as usize].push(name.clone());
            }
        }
        // A mirrored copy would be inside out.
        let mirrored = by.turn.determinant() < 0.0;
        self.names.set_object(object.name.clone());
        for ((k, corners), groups) in object.triangles.iter().enumerate().zip(groups) {
            let paint = object.paints.get(k).copied().flatten().or(object.paint);
            let paint = paint.and_then(|(group, at)| {
                model
                    .properties
                    .get(&(id.0, group))?
                    .get(usize::try_from(at).ok()?)
            });
            self.names.set_material(paint.cloned());
            let mut corners = corners.map(|v| v + first);
            if mirrored {
                corners.swap(1, 2);
            }
            self.sink.push(&corners, &self.points, Place::Whole)?;
            self.names.set_groups(groups);
            self.names.push_facet();
        }
        for &(part, transform) in &object.components {
            let inner = Transform {
                turn: by.turn * transform.turn,
                shift: by.turn * transform.shift + by.shift,
            };
            self.place(model, part, inner, depth + 1)?;
        }
        Ok(())
    }
}
