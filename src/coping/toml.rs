//! The TOML form: rules by index, name, plane, box and flood fill, and what
//! mesh they belong to.

use glam::DVec3;
use serde::Deserialize;
use toml::{Spanned, Value};

use super::error::{Located, Span, TagProblem};
use super::rule::{
    BoxMode, Condition, FacetRange, MeshCheck, NameKind, OnEmpty, Rest, Rule, TagFile, facet_range,
};

/// Value of `format` in every tag file.
const FORMAT: &str = "coping-tags";
/// The version read here.
const VERSION: i64 = 1;
/// Angle between a triangle and a plane, in degrees, when the rule gives
/// none: more than tessellation noise, less than a draft.
const PLANE_ANGLE: f64 = 5.0;
/// Bend that a flood fill passes, in degrees, when the rule gives none: the
/// facets of a round at twelve a quarter bend by 7.5, a chamfer by 45.
const GROW_ANGLE: f64 = 20.0;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: Spanned<String>,
    version: Spanned<i64>,
    rest: Option<Rest>,
    #[serde(default)]
    mesh: MeshTable,
    #[serde(default)]
    options: Options,
    #[serde(default)]
    coping: Vec<Spanned<RuleTable>>,
    #[serde(default)]
    wall: Vec<Spanned<RuleTable>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct MeshTable {
    /// For the reader of the file; not checked.
    #[serde(rename = "file")]
    _file: Option<String>,
    /// For the reader of the file; not checked.
    #[serde(rename = "unit")]
    _unit: Option<String>,
    triangles: Option<Spanned<u64>>,
    sha256: Option<Spanned<String>>,
    geometry: Option<Spanned<String>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Options {
    index_base: Option<Spanned<u64>>,
    #[serde(default)]
    on_empty: OnEmpty,
    rest: Option<Rest>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RuleTable {
    name: Option<String>,
    triangles: Option<Spanned<Value>>,
    group: Option<Spanned<Value>>,
    object: Option<Spanned<Value>>,
    material: Option<Spanned<Value>>,
    plane: Option<Spanned<PlaneTable>>,
    #[serde(rename = "box")]
    in_box: Option<Spanned<BoxTable>>,
    near: Option<Spanned<NearTable>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PlaneTable {
    point: [f64; 3],
    normal: [f64; 3],
    tol: Option<f64>,
    max_angle: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BoxTable {
    min: [f64; 3],
    max: [f64; 3],
    #[serde(default)]
    mode: BoxMode,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct NearTable {
    point: [f64; 3],
    grow_angle: Option<f64>,
    max_area: Option<f64>,
}

pub(super) fn parse(text: &str) -> Result<TagFile, Located> {
    let file: File = toml::from_str(text).map_err(|error| {
        let span = error.span().unwrap_or(0..0);
        (span, TagProblem::Syntax(error.message().to_owned()))
    })?;
    if file.format.get_ref() != FORMAT {
        let message = format!("format is {:?}, not {FORMAT:?}", file.format.get_ref());
        return Err((file.format.span(), TagProblem::BadValue(message)));
    }
    if *file.version.get_ref() != VERSION {
        let message = format!(
            "version {} of the format is not known here, only {VERSION}",
            file.version.get_ref()
        );
        return Err((file.version.span(), TagProblem::BadValue(message)));
    }
    let base = match &file.options.index_base {
        None => 0,
        Some(base) if *base.get_ref() <= 1 => *base.get_ref(),
        Some(base) => {
            let message = format!("index_base is {}, not 0 or 1", base.get_ref());
            return Err((base.span(), TagProblem::BadValue(message)));
        }
    };
    let mut tables: Vec<(bool, Spanned<RuleTable>)> = Vec::new();
    tables.extend(file.coping.into_iter().map(|table| (true, table)));
    tables.extend(file.wall.into_iter().map(|table| (false, table)));
    // Rules run in the order of the file, whichever kind they are.
    tables.sort_by_key(|(_, table)| table.span().start);
    let mut rules = Vec::new();
    for (index, (coping, table)) in tables.into_iter().enumerate() {
        rules.push(rule(index, coping, table, base)?);
    }
    Ok(TagFile {
        mesh: MeshCheck {
            facets: file.mesh.triangles.map(with_span),
            sha256: file.mesh.sha256.map(with_span),
            geometry: file.mesh.geometry.map(with_span),
        },
        on_empty: file.options.on_empty,
        rest: file.rest.or(file.options.rest).unwrap_or_default(),
        rules,
    })
}

fn with_span<T>(value: Spanned<T>) -> (T, Span) {
    let span = value.span();
    (value.into_inner(), span)
}

fn rule(index: usize, coping: bool, table: Spanned<RuleTable>, base: u64) -> Result<Rule, Located> {
    let (table, span) = with_span(table);
    let kind = if coping { "coping" } else { "wall" };
    let name = table
        .name
        .unwrap_or_else(|| format!("rule {} ({kind})", index + 1));
    let mut conditions = Vec::new();
    if let Some(list) = table.triangles {
        conditions.push(Condition::Facets(facets(list, base)?));
    }
    for (kind, list) in [
        (NameKind::Group, table.group),
        (NameKind::Object, table.object),
        (NameKind::Material, table.material),
    ] {
        if let Some(list) = list {
            let patterns = names(list)?;
            conditions.push(Condition::Names { kind, patterns });
        }
    }
    if let Some(plane) = table.plane {
        conditions.push(plane_condition(plane)?);
    }
    if let Some(in_box) = table.in_box {
        conditions.push(box_condition(in_box)?);
    }
    if let Some(near) = table.near {
        conditions.push(near_condition(near)?);
    }
    if conditions.is_empty() {
        return Err((span, TagProblem::NoCondition { rule: name }));
    }
    Ok(Rule {
        name,
        coping,
        conditions,
        span,
    })
}

/// One item or a list of items.
fn items(list: Spanned<Value>) -> (Vec<Value>, Span) {
    let (value, span) = with_span(list);
    match value {
        Value::Array(items) => (items, span),
        one => (vec![one], span),
    }
}

/// Indices and ranges; a string may hold many, as a line of the text form does.
fn facets(list: Spanned<Value>, base: u64) -> Result<Vec<FacetRange>, Located> {
    let (items, span) = items(list);
    let mut ranges = Vec::new();
    for item in items {
        match item {
            Value::Integer(index) => {
                ranges.push(facet_range(&index.to_string(), base, span.clone())?);
            }
            Value::String(text) => {
                for line in text.lines() {
                    let line = line.split('#').next().unwrap_or("");
                    let words = line.split([' ', '\t', ',']).filter(|word| !word.is_empty());
                    for word in words {
                        ranges.push(facet_range(word, base, span.clone())?);
                    }
                }
            }
            other => {
                let word = other.to_string();
                return Err((span, TagProblem::NotARange { word }));
            }
        }
    }
    Ok(ranges)
}

fn names(list: Spanned<Value>) -> Result<Vec<(String, Span)>, Located> {
    let (items, span) = items(list);
    items
        .into_iter()
        .map(|item| match item {
            Value::String(pattern) => Ok((pattern, span.clone())),
            other => {
                let message = format!("{other} is no name");
                Err((span.clone(), TagProblem::BadValue(message)))
            }
        })
        .collect()
}

fn plane_condition(plane: Spanned<PlaneTable>) -> Result<Condition, Located> {
    let (plane, span) = with_span(plane);
    let fail = |message: &str| Err((span.clone(), TagProblem::BadValue(message.to_owned())));
    let point = DVec3::from_array(plane.point);
    let normal = DVec3::from_array(plane.normal).try_normalize();
    let Some(normal) = normal.filter(|_| point.is_finite()) else {
        return fail("a plane needs a finite point and a normal that is not zero");
    };
    if plane.tol.is_some_and(|tol| tol.is_nan() || tol < 0.0) {
        return fail("tol must not be negative");
    }
    let max_angle = plane.max_angle.unwrap_or(PLANE_ANGLE);
    if !(0.0..=90.0).contains(&max_angle) {
        return fail("max_angle must lie between 0 and 90 degrees");
    }
    Ok(Condition::Plane {
        point,
        normal,
        tolerance: plane.tol,
        max_angle,
    })
}

fn box_condition(in_box: Spanned<BoxTable>) -> Result<Condition, Located> {
    let (in_box, span) = with_span(in_box);
    let (min, max) = (DVec3::from_array(in_box.min), DVec3::from_array(in_box.max));
    // Infinite sides are fine, NaN is not.
    if !min.cmple(max).all() {
        let message = "min of a box must not exceed max".to_owned();
        return Err((span, TagProblem::BadValue(message)));
    }
    Ok(Condition::Box {
        min,
        max,
        mode: in_box.mode,
    })
}

fn near_condition(near: Spanned<NearTable>) -> Result<Condition, Located> {
    let (near, span) = with_span(near);
    let fail = |message: &str| Err((span.clone(), TagProblem::BadValue(message.to_owned())));
    let point = DVec3::from_array(near.point);
    if !point.is_finite() {
        return fail("the point must be finite");
    }
    let grow_angle = near.grow_angle.unwrap_or(GROW_ANGLE);
    if !(0.0..=180.0).contains(&grow_angle) {
        return fail("grow_angle must lie between 0 and 180 degrees");
    }
    if near
        .max_area
        .is_some_and(|area| area.is_nan() || area <= 0.0)
    {
        return fail("max_area must be positive");
    }
    Ok(Condition::Near {
        point,
        grow_angle,
        max_area: near.max_area,
        span,
    })
}
