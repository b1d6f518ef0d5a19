//! The JSON schema against the reader, the scenes of the project and the examples of the manual.

use etendue_scene::{
    SourceMap,
    read::keys::{Key, SECTIONS, Section},
    read_toml,
    schema::{Kind, json_schema, kind},
};
use serde_json::{Value, json};
use std::{fs, path::Path};

const MANUAL: &str = include_str!("../../../docs/scene-format.md");

/// What is wrong with `value` by `schema`; every keyword that is not known here is an error of the test.
fn faults(root: &Value, schema: &Value, value: &Value, place: &str) -> Vec<String> {
    let schema = match schema {
        Value::Bool(true) => return vec![],
        Value::Bool(false) => return vec![format!("{place}: not allowed")],
        Value::Object(schema) => schema,
        other => panic!("{other} is no schema"),
    };
    let all = |value: &Value, rule: &Value, place: &str| faults(root, rule, value, place);
    let mut found = Vec::new();
    for (keyword, rule) in schema {
        let mut fail = |wrong: bool| {
            if wrong {
                found.push(format!("{place}: {keyword} {rule}: {value}"));
            }
        };
        let number = value.as_f64();
        let limit = || rule.as_f64().unwrap();
        match &keyword[..] {
            "$schema" | "title" | "description" | "definitions" | "then" => {}
            "$ref" => {
                let target = root.pointer(rule.as_str().unwrap().trim_start_matches('#')).unwrap();
                found.extend(all(value, target, place));
            }
            "type" => fail(match rule.as_str().unwrap() {
                "object" => !value.is_object(),
                "array" => !value.is_array(),
                "string" => !value.is_string(),
                "boolean" => !value.is_boolean(),
                "integer" => !value.is_i64(),
                "number" => !value.is_number(),
                other => panic!("type {other}"),
            }),
            "enum" => fail(!rule.as_array().unwrap().contains(value)),
            "const" => fail(rule != value),
            "minimum" => fail(number.is_some_and(|x| x < limit())),
            "maximum" => fail(number.is_some_and(|x| x > limit())),
            "exclusiveMinimum" => fail(number.is_some_and(|x| x <= limit())),
            "exclusiveMaximum" => fail(number.is_some_and(|x| x >= limit())),
            "minLength" => fail(value.as_str().is_some_and(|s| (s.len() as f64) < limit())),
            "minItems" => fail(value.as_array().is_some_and(|a| (a.len() as f64) < limit())),
            "maxItems" => fail(value.as_array().is_some_and(|a| a.len() as f64 > limit())),
            "minProperties" => fail(value.as_object().is_some_and(|o| (o.len() as f64) < limit())),
            "maxProperties" => fail(value.as_object().is_some_and(|o| o.len() as f64 > limit())),
            "pattern" => {
                assert_eq!(rule, "^#[0-9a-fA-F]{6}$");
                let hex = |s: &str| s.len() == 7 && s[1..].bytes().all(|b| b.is_ascii_hexdigit()) && s.starts_with('#');
                fail(value.as_str().is_some_and(|s| !hex(s)));
            }
            "required" => {
                let missing = |key: &Value| value.is_object() && value.get(key.as_str().unwrap()).is_none();
                fail(rule.as_array().unwrap().iter().any(missing));
            }
            "items" => {
                for (i, item) in value.as_array().into_iter().flatten().enumerate() {
                    found.extend(all(item, rule, &format!("{place}[{i}]")));
                }
            }
            "properties" => {
                for (key, rule) in rule.as_object().unwrap() {
                    if let Some(value) = value.get(key) {
                        found.extend(all(value, rule, &format!("{place}.{key}")));
                    }
                }
            }
            "additionalProperties" => {
                let known = schema.get("properties").and_then(Value::as_object);
                for (key, value) in value.as_object().into_iter().flatten() {
                    if !known.is_some_and(|known| known.contains_key(key)) {
                        found.extend(all(value, rule, &format!("{place}.{key}")));
                    }
                }
            }
            "anyOf" => fail(rule.as_array().unwrap().iter().all(|rule| !all(value, rule, place).is_empty())),
            "allOf" => rule.as_array().unwrap().iter().for_each(|rule| found.extend(all(value, rule, place))),
            "if" => {
                if all(value, rule, place).is_empty() {
                    found.extend(all(value, &schema["then"], place));
                }
            }
            other => panic!("unknown keyword {other}"),
        }
    }
    found
}

fn json_of(text: &str) -> Value {
    fn convert(value: &toml::Value) -> Value {
        match value {
            toml::Value::String(s) => json!(s),
            toml::Value::Integer(i) => json!(i),
            toml::Value::Float(x) => json!(x),
            toml::Value::Boolean(b) => json!(b),
            toml::Value::Array(items) => items.iter().map(convert).collect(),
            toml::Value::Table(table) => Value::Object(table.iter().map(|(k, v)| (k.clone(), convert(v))).collect()),
            // JSON has no dates: there they are strings, as they may be in TOML.
            toml::Value::Datetime(date) => json!(date.to_string()),
        }
    }
    convert(&toml::Value::Table(text.parse().unwrap()))
}

fn faults_of(text: &str) -> Vec<String> {
    let schema = json_schema();
    faults(&schema, &schema, &json_of(text), "")
}

#[test]
fn every_key_has_a_kind_and_words_of_the_manual() {
    let schema = json_schema();
    for section in SECTIONS {
        for key in section.keys {
            assert!(
                kind(section.name, key.name).is_some(),
                "say in schema/kinds.rs what `{}` of {} is",
                key.name,
                section.name
            );
        }
    }
    let count = |value: &Value| value["properties"].as_object().unwrap().len();
    assert_eq!(count(&schema), SECTIONS[0].keys.len());
    let described =
        |value: &Value| value["properties"].as_object().unwrap().values().all(|p| p["description"].is_string());
    assert!(described(&schema));
    for (name, section) in schema["definitions"].as_object().unwrap() {
        assert!(described(section), "{name}: a row of the manual is missing or has no meaning");
    }
    assert_eq!(schema["definitions"].as_object().unwrap().len(), SECTIONS.len() - 1, "names of definitions are unique");
}

#[test]
fn scenes_and_examples_are_valid() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let files = fs::read_dir(scenes).unwrap().map(|e| e.unwrap().path());
    let mut texts: Vec<String> =
        files.filter(|p| p.extension().is_some_and(|e| e == "toml")).map(|p| fs::read_to_string(p).unwrap()).collect();
    assert!(texts.len() >= 4);
    for example in MANUAL.split("```toml\n").skip(1).map(|part| part.split("```").next().unwrap()) {
        let camera = "camera = { position = [0, 0, 5], look_at = [0, 0, 0] }\n";
        texts.push(format!("{}{example}", if example.contains("[camera]") { "" } else { camera }));
    }
    assert!(texts.len() >= 16);
    for text in texts {
        assert_eq!(faults_of(&text), [""; 0], "{text}");
    }
}

#[test]
fn mistakes_are_found() {
    let camera = "camera = { position = [0, 0, 5], look_at = [0, 0, 0] }\n";
    for (text, part) in [
        ("", "required"),
        ("camera = 1", "type"),
        ("camera = { position = [0, 0] }", "minItems"),
        ("camera = { position = [0, 0, 5], fov = 0 }", "exclusiveMinimum"),
        ("camera = { position = [0, 0, 5], fow = 40 }", "not allowed"),
        ("camera = { position = [0, 0, 5], type = \"orthographic\", fov = 40 }", "not allowed"),
    ] {
        assert!(faults_of(text).iter().any(|fault| fault.contains(part)), "{text}");
    }
    for text in [
        "[materials.m]\ntype = \"glas\"",
        "[materials.m]\ntype = \"black\"\nreflectance = 0.5",
        "[materials.m]\ntype = \"diffuse\"\nreflectance = \"#12345\"",
        "[materials.m]\ntype = \"diffuse\"\nreflectance = 1.5",
        "[[objects]]\nshape = \"sphere\"\ntransform = { scale = 2, translate = [0, 0, 0] }",
        "[sampler]\nspp = 1.5",
        "[film]\naovs = [\"nothing\"]",
    ] {
        assert!(!faults_of(&format!("{camera}{text}")).is_empty(), "{text}");
    }
}

/// The key that says of which type a table is.
fn picker(section: &Section) -> &'static str {
    ["kind", "shape"].into_iter().find(|key| section.key(key).is_some()).unwrap_or("type")
}

/// A scene with one key of a section, of one of its types.
fn scene(section: &Section, key: &Key, of_type: Option<&str>, value: &str) -> String {
    let picker = picker(section);
    let line = |between: &str| match of_type.filter(|_| key.name != picker) {
        Some(name) => format!("{picker} = \"{name}\"{between}{} = {value}", key.name),
        None => format!("{} = {value}", key.name),
    };
    let (lines, inline) = (line("\n"), line(", "));
    match section.name {
        "phase" | "density" => format!("[media.m]\n{} = {{ {inline} }}", section.name),
        "a stop" => format!("[textures.t]\ntype = \"gradient\"\nstops = [{{ {inline} }}]"),
        "emission" => format!("[materials.m]\ntype = \"black\"\nemission = {{ {inline} }}"),
        "tangent" => format!("[materials.m]\ntype = \"black\"\ntangent = {{ {inline} }}"),
        "rotate" | "look_at" => {
            format!("[[objects]]\nshape = \"sphere\"\ntransform = [{{ {} = {{ {inline} }} }}]", section.name)
        }
        "a step of transform" => format!("[[objects]]\nshape = \"sphere\"\ntransform = [{{ {inline} }}]"),
        "a textured parameter" => format!("[materials.m]\ntype = \"glass\"\nior = {{ {inline} }}"),
        "normal_map" => format!("[materials.m]\ntype = \"glass\"\nnormal_map = {{ {inline} }}"),
        "simplify" => format!("[meshes.m]\nfile = \"a.obj\"\nsimplify = {{ {inline} }}"),
        "body" => format!("[[objects]]\nshape = \"sphere\"\nbody = {{ {inline} }}"),
        "motor" => format!("[[joints]]\ntype = \"hinge\"\nmotor = {{ {inline} }}"),
        "keyframes" => format!("[animation]\nkeyframes = {{ {inline} }}"),
        "motion" => format!("[[objects]]\nshape = \"sphere\"\nmotion = {{ {inline} }}"),
        "a value with keys" => format!("[camera]\nfov = {{ {inline} }}"),
        "film.filter" => format!("[film.filter]\n{lines}"),
        name => format!("{}\n{lines}", name.replace("NAME", "m")),
    }
}

fn messages(text: &str) -> Vec<(String, String)> {
    let mut sources = SourceMap::new();
    let file = sources.insert("s", text.as_bytes().to_vec()).unwrap();
    let (_, found) = read_toml(file, text.as_bytes(), Path::new(""));
    found.iter().map(|d| (d.message.clone(), d.label.clone().unwrap_or_default())).collect()
}

/// Each key with the types that use it; with none where its table has no types.
fn keys() -> impl Iterator<Item = (&'static Section, &'static Key, Vec<Option<&'static str>>)> {
    SECTIONS[1..].iter().flat_map(|section| {
        let picker = picker(section);
        let of_section = match kind(section.name, picker) {
            Some(Kind::Choice(names)) => names.into_iter().map(Some).collect(),
            _ => vec![None],
        };
        section.keys.iter().map(move |key| {
            let own = key.types.iter().copied().map(Some).collect();
            (*section, key, if key.types.is_empty() { of_section.clone() } else { own })
        })
    })
}

/// The simplest of the kinds that a key takes, and how a value of it is written.
fn innermost(kind: &Kind) -> (&Kind, [&'static str; 2]) {
    match kind {
        Kind::Any(kinds) => innermost(&kinds[0]),
        Kind::Array(item, _, _) if matches!(**item, Kind::Choice(_)) => (item, ["[", "]"]),
        kind => (kind, ["", ""]),
    }
}

#[test]
fn names_are_those_of_the_reader() {
    let mut checked = 0;
    for (section, key, types) in keys() {
        let kind = kind(section.name, key.name).unwrap();
        let (Kind::Choice(names), [before, after]) = innermost(&kind) else { continue };
        let text = scene(section, key, types[0], &format!("{before}\"?\"{after}"));
        let answers = messages(&text);
        let label = answers.iter().find_map(|(_, label)| label.strip_prefix("expected one of ")).unwrap_or_else(|| {
            panic!("{text}: {answers:?}");
        });
        let expected: Vec<&str> = label.split(", ").map(|name| name.trim_matches('`')).collect();
        assert_eq!(*names, expected, "`{}` of {}", key.name, section.name);
        checked += 1;
    }
    assert!(checked > 15);
}

#[test]
fn ranges_are_those_of_the_reader() {
    let mut checked = 0;
    for (section, key, types) in keys() {
        // A factor may be a number or a colour, by the parameter that it is of.
        if key.name == "factor" {
            continue;
        }
        let kind = kind(section.name, key.name).unwrap();
        let just_beyond = |x: f64, up: bool| if up { x.next_up() } else { x.next_down() };
        let write = |x: f64| format!("{x:?}").replace("inf", "1e999");
        let (inside, outside): (Vec<String>, Vec<String>) = match innermost(&kind).0 {
            Kind::Integer(low, high) => {
                let outside = [low.checked_sub(1), high.checked_add(1)];
                (
                    vec![low.to_string(), high.to_string()],
                    outside.into_iter().flatten().map(|x| x.to_string()).collect(),
                )
            }
            Kind::Number(b) | Kind::Colour(b) => {
                let (mut inside, mut outside) = (vec![], vec![]);
                for (end, open, up) in [(b.low, b.low_open, false), (b.high, b.high_open, true)] {
                    if open {
                        outside.push(write(end))
                    } else {
                        inside.push(write(end))
                    }
                    outside.push(write(just_beyond(end, up)));
                }
                (inside, outside)
            }
            _ => continue,
        };
        let refused = |value: &String, of_type: Option<&str>| {
            let start = format!("`{}` is out of range", key.name);
            messages(&scene(section, key, of_type, value)).iter().any(|(message, _)| message.starts_with(&start))
        };
        for value in inside {
            assert!(types.iter().any(|t| !refused(&value, *t)), "`{}` of {}: {value} is fine", key.name, section.name);
        }
        for value in outside {
            // Of several types some may want another kind of value.
            assert!(types.iter().any(|t| refused(&value, *t)), "`{}` of {}: {value} is not", key.name, section.name);
        }
        checked += 1;
    }
    assert!(checked > 40);
}

#[test]
fn what_is_required_is_what_the_reader_asks_for() {
    let schema = json_schema();
    let mut checked = 0;
    for section in &SECTIONS[1..] {
        let definition = schema["definitions"].as_object().unwrap().iter().find(|(name, _)| {
            section
                .name
                .replace("NAME", "")
                .split(|c: char| !c.is_ascii_alphabetic())
                .filter(|w| !w.is_empty())
                .collect::<Vec<_>>()
                .join("-")
                == **name
        });
        for required in definition.unwrap().1["required"].as_array().into_iter().flatten() {
            let other = section.keys.iter().find(|key| key.types.is_empty() && key.name != required);
            // A table may have no other key.
            let text = other.map_or(section.name.to_owned(), |other| scene(section, other, None, "0"));
            let needs = format!("needs `{}`", required.as_str().unwrap());
            assert!(messages(&text).iter().any(|(message, _)| message.contains(&needs)), "{text}: {needs}");
            checked += 1;
        }
    }
    assert!(checked >= 9);
}
