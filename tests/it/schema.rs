//! The schemas of reports and tag files hold for what is written and read.

use serde_json::{Value, json};

use crate::common::{Desk, fixture, text};

/// Checks a value against a schema; the keywords that our schemas have, all others
/// are refused.
fn fits(value: &Value, schema: &Value, root: &Value, at: &str) -> Result<(), String> {
    let fail = |what: &str| Err(format!("{at}: {what}: {value}"));
    for (keyword, wanted) in schema.as_object().unwrap() {
        match keyword.as_str() {
            "$schema" | "title" | "$defs" => {}
            "$ref" => {
                let pointer = wanted.as_str().unwrap().trim_start_matches('#');
                fits(value, root.pointer(pointer).unwrap(), root, at)?;
            }
            "const" if value != wanted => return fail("not the constant"),
            "const" => {}
            "enum" if !wanted.as_array().unwrap().contains(value) => return fail("no such word"),
            "enum" => {}
            "anyOf" => {
                let any = wanted.as_array().unwrap();
                if any.iter().all(|one| fits(value, one, root, at).is_err()) {
                    return fail("none of the forms");
                }
            }
            "type" => {
                let is = |name: &Value| match name.as_str().unwrap() {
                    "object" => value.is_object(),
                    "array" => value.is_array(),
                    "string" => value.is_string(),
                    "boolean" => value.is_boolean(),
                    "null" => value.is_null(),
                    "integer" => value.is_i64() || value.is_u64(),
                    "number" => value.is_number(),
                    other => panic!("type {other}"),
                };
                let fits = match wanted {
                    Value::Array(names) => names.iter().any(is),
                    name => is(name),
                };
                if !fits {
                    return fail("of another type");
                }
            }
            "minimum" if value.as_f64() < wanted.as_f64() => return fail("too small"),
            "minimum" => {}
            // Of what is no list or object nothing more is asked.
            "minItems" | "maxItems" | "items" if !value.is_array() => {}
            "additionalProperties" | "required" if !value.is_object() => {}
            "minItems" | "maxItems" => {
                let (count, bound) = (value.as_array().unwrap().len(), wanted.as_u64().unwrap());
                let fits = match keyword.as_str() {
                    "minItems" => count as u64 >= bound,
                    _ => count as u64 <= bound,
                };
                if !fits {
                    return fail("of another length");
                }
            }
            "required" => {
                for key in wanted.as_array().unwrap() {
                    if value.get(key.as_str().unwrap()).is_none() {
                        return fail(&format!("without {key}"));
                    }
                }
            }
            "items" => {
                for (k, item) in value.as_array().unwrap().iter().enumerate() {
                    fits(item, wanted, root, &format!("{at}/{k}"))?;
                }
            }
            "properties" => {
                for (key, inner) in wanted.as_object().unwrap() {
                    if let Some(item) = value.get(key) {
                        fits(item, inner, root, &format!("{at}/{key}"))?;
                    }
                }
            }
            "additionalProperties" => {
                let known = schema["properties"].as_object();
                let more = value.as_object().unwrap().iter();
                for (key, item) in
                    more.filter(|(key, _)| !known.is_some_and(|k| k.contains_key(*key)))
                {
                    match wanted {
                        Value::Bool(false) => return fail(&format!("has {key}")),
                        inner => fits(item, inner, root, &format!("{at}/{key}"))?,
                    }
                }
            }
            other => panic!("keyword {other}"),
        }
    }
    Ok(())
}

fn schema(desk: &Desk, of: &str) -> Value {
    let output = desk.run(&["schema", of]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn check(value: &Value, schema: &Value) -> Result<(), String> {
    fits(value, schema, schema, "")
}

#[test]
fn reports_fit_their_schema() {
    let desk = Desk::new();
    let schema = schema(&desk, "report");
    let plate = fixture("plate.obj");
    let tee = fixture("tee.obj");
    let [plate, tee] = [&plate, &tee].map(|file| file.to_str().unwrap());
    let mid = desk.path("mid.ply");
    let mid = mid.to_str().unwrap();
    let runs: [&[&str]; 6] = [
        &["extract", plate, "-o", mid, "--unit", "mm"],
        &["extract", tee, "--repair"],
        &["check", plate, mid],
        &["rethicken", mid],
        &["roundtrip", plate, "--solid-cell", "0.5t"],
        &["offset", plate, "--distance", "1", "--cell", "5%"],
    ];
    let mut last = Value::Null;
    for args in runs {
        let output = desk.run(&[args, &["--json", "-", "-q"]].concat());
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        check(&report, &schema).unwrap_or_else(|error| panic!("{args:?}: {error}"));
        last = report;
    }
    for (pointer, other) in [
        ("/schema", json!(2)),
        ("/warnings", json!([{ "code": 1, "message": "" }])),
        ("/outputs", json!("mid.ply")),
        ("/settings/threads", json!(0)),
    ] {
        let mut wrong = last.clone();
        *wrong.pointer_mut(pointer).unwrap() = other;
        assert!(check(&wrong, &schema).is_err(), "{pointer}");
    }
    last.as_object_mut().unwrap().remove("seconds");
    assert!(check(&last, &schema).is_err());
}

#[test]
fn tag_files_fit_their_schema() {
    let desk = Desk::new();
    let schema = schema(&desk, "tags");
    let parse = |text: &str| serde_json::to_value(text.parse::<toml::Table>().unwrap()).unwrap();
    let plate = fixture("plate.obj");
    let args = ["tags", "detect", plate.to_str().unwrap(), "-o", "tags.toml"];
    assert_eq!(desk.run(&args).status.code(), Some(0));
    let written = std::fs::read_to_string(desk.path("tags.toml")).unwrap();
    check(&parse(&written), &schema).unwrap();
    let head = "format = \"coping-tags\"\nversion = 1\n";
    let all = "rest = \"auto\"\n[mesh]\ntriangles = 12\n[options]\non_empty = \"warn\"\n\
        [[coping]]\nname = \"a\"\ngroup = [\"rim_*\"]\ntriangles = [0, \"4-9:2\"]\n[[coping]]\n\
        plane = { point = [0, 0, 0], normal = [1, 0, 0], tol = 0.1 }\n[[wall]]\n\
        box = { min = [0, 0, 0], max = [1, 1, 1], mode = \"any\" }\n[[coping]]\n\
        near = { point = [0, 0, 0], grow_angle = 20 }\n";
    check(&parse(&format!("{head}{all}")), &schema).unwrap();
    for wrong in [
        "rest = \"coping\"\n",
        "[[coping]]\nplane = { point = [0, 0], normal = [1, 0, 0] }\n",
        "[[coping]]\nplan = 1\n",
        "[[coping]]\nbox = { min = [0, 0, 0] }\n",
    ] {
        // What the schema refuses the program refuses too.
        let text = format!("{head}{wrong}");
        assert!(check(&parse(&text), &schema).is_err(), "{wrong}");
        desk.put("wrong.toml", &text);
        let args = ["tags", plate.to_str().unwrap(), "wrong.toml"];
        assert_eq!(desk.run(&args).status.code(), Some(2), "{wrong}");
    }
}
