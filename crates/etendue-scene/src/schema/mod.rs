//! The JSON schema (draft 7) of scene files, for editors that complete and check TOML: from the one list of keys, with the
//! manual's words for each.

mod kinds;
mod manual;

use crate::read::{
    Bounds,
    keys::{SECTIONS, Section},
};
pub use kinds::{Kind, kind};
use serde_json::{Map, Value, json};

/// Keys that a table cannot be without, whatever its type.
const REQUIRED: &[(&str, &str)] = &[
    ("the scene file", "camera"),
    ("[camera]", "position"),
    ("film.filter", "type"),
    ("[world]", "medium"),
    ("density", "file"),
    ("density", "min"),
    ("density", "max"),
    ("a stop", "at"),
    ("a stop", "color"),
    ("[materials.NAME]", "type"),
    ("emission", "radiance"),
    ("keyframes", "file"),
    ("a value with keys", "keys"),
    ("rotate", "axis"),
    ("rotate", "angle"),
    ("look_at", "position"),
    ("look_at", "target"),
    ("[[joints]]", "type"),
    ("[[joints]]", "bodies"),
    ("[[joints]]", "anchor"),
];

/// The schema.
pub fn json_schema() -> Value {
    let definitions: Map<String, Value> =
        SECTIONS[1..].iter().map(|section| (definition_name(section), table(section))).collect();
    let Value::Object(mut schema) = table(SECTIONS[0]) else { return Value::Null };
    schema.insert("$schema".to_owned(), json!("http://json-schema.org/draft-07/schema#"));
    schema.insert("title".to_owned(), json!("Etendue scene file"));
    schema.insert("definitions".to_owned(), Value::Object(definitions));
    Value::Object(schema)
}

/// Letters and dashes.
fn definition_name(section: &Section) -> String {
    let words = section.name.split(|c: char| !c.is_ascii_alphabetic()).filter(|w| !w.is_empty() && *w != "NAME");
    words.collect::<Vec<_>>().join("-")
}

fn reference(section: &Section) -> Value {
    json!({ "$ref": format!("#/definitions/{}", definition_name(section)) })
}

fn table(section: &Section) -> Value {
    let mut properties = Map::new();
    for key in section.keys {
        let Some(kind) = kind(section.name, key.name) else { continue };
        let mut value = schema_of(&kind);
        if let (Some(words), Value::Object(object)) = (manual::meaning(section.name, key.name), &mut value) {
            // Draft 7 ignores what stands beside a reference.
            if object.contains_key("$ref") {
                value = json!({ "allOf": [value], "description": words });
            } else {
                object.insert("description".to_owned(), json!(words));
            }
        }
        properties.insert(key.name.to_owned(), value);
    }
    let mut schema = json!({ "type": "object", "properties": properties, "additionalProperties": false });
    let required: Vec<&str> = REQUIRED.iter().filter(|(name, _)| *name == section.name).map(|(_, key)| *key).collect();
    if !required.is_empty() {
        schema["required"] = json!(required);
    }
    if section.name == "a step of transform" {
        schema["minProperties"] = json!(1);
        schema["maxProperties"] = json!(1);
    }
    let rules = rules(section);
    if !rules.is_empty() {
        schema["allOf"] = json!(rules);
    }
    schema
}

/// Of each type the keys that belong to others.
fn rules(section: &Section) -> Vec<Value> {
    let picker = ["kind", "shape", "type"].into_iter().find(|key| section.key(key).is_some()).unwrap_or("type");
    if section.keys.iter().all(|key| key.types.is_empty()) {
        return Vec::new();
    }
    let Some(Kind::Choice(types)) = kind(section.name, picker) else { return Vec::new() };
    let rule = |name: &&str| {
        let foreign = section.keys.iter().filter(|key| !key.types.is_empty() && !key.types.contains(name));
        let never: Map<String, Value> = foreign.map(|key| (key.name.to_owned(), Value::Bool(false))).collect();
        json!({
            "if": { "properties": { picker: { "const": name } }, "required": [picker] },
            "then": { "properties": never },
        })
    };
    types.iter().map(rule).collect()
}

fn schema_of(kind: &Kind) -> Value {
    match kind {
        Kind::Boolean => json!({ "type": "boolean" }),
        Kind::Name => json!({ "type": "string", "minLength": 1 }),
        Kind::Integer(low, high) => json!({ "type": "integer", "minimum": low, "maximum": high }),
        Kind::Number(bounds) => number(bounds),
        Kind::Colour(bounds) => json!({ "anyOf": [
            number(bounds),
            { "type": "array", "items": number(bounds), "minItems": 3, "maxItems": 3 },
            { "type": "string", "pattern": "^#[0-9a-fA-F]{6}$" },
        ] }),
        Kind::Choice(names) => json!({ "type": "string", "enum": names }),
        Kind::Array(item, fewest, most) => {
            let mut array = json!({ "type": "array", "items": schema_of(item) });
            if *fewest > 0 {
                array["minItems"] = json!(fewest);
            }
            if *most < usize::MAX {
                array["maxItems"] = json!(most);
            }
            array
        }
        Kind::Table(section) => reference(section),
        Kind::Named(section) => json!({ "type": "object", "additionalProperties": reference(section) }),
        Kind::Names => json!({ "type": "object", "additionalProperties": schema_of(&Kind::Name) }),
        Kind::Any(kinds) => json!({ "anyOf": kinds.iter().map(schema_of).collect::<Vec<_>>() }),
    }
}

fn number(bounds: &Bounds) -> Value {
    let mut number = json!({ "type": "number" });
    let Bounds { low, low_open, high, high_open } = *bounds;
    number[if low_open { "exclusiveMinimum" } else { "minimum" }] = json!(low);
    number[if high_open { "exclusiveMaximum" } else { "maximum" }] = json!(high);
    number
}
