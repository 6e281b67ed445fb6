//! The case format as a JSON schema, so that editors complete keys, show what they mean and mark mistakes.

use serde_json::{Map, Value as Json, json};

use super::schema::{Key, MAX_COUNT, MAX_MAGNITUDE, Need, ROOT, Table, Value};

/// The schema of case files (JSON Schema, draft 2020-12), from the same tables that the reader asks. What it accepts may
/// still be refused: that a shape has no area, say, no schema tells; `etendue check` does.
pub fn json_schema() -> Json {
    let mut schema = table(&ROOT);
    let head = [
        ("$schema", json!("https://json-schema.org/draft/2020-12/schema")),
        ("title", json!("A case of etendue")),
        ("description", json!("Metres, W/m², right-handed. `etendue check` says whether a case holds.")),
    ];
    for (key, value) in head {
        schema[key] = value;
    }
    schema
}

fn table(table: &Table) -> Json {
    let known = || table.keys.iter().filter(|key| key.need != Need::Later);
    let properties: Map<String, Json> = known().map(|key| (key.name.to_owned(), property(key))).collect();
    // What the whole file requires depends on what else there is: a lamp needs no source.
    let is_whole = table.path.is_empty();
    let required: Vec<&str> =
        known().filter(|key| key.need == Need::Required && !is_whole).map(|key| key.name).collect();
    let mut schema = json!({ "type": "object", "properties": properties, "additionalProperties": false });
    if !required.is_empty() {
        schema["required"] = json!(required);
    }
    schema
}

fn property(key: &Key) -> Json {
    let mut schema = value(&key.value);
    let unit = if key.unit.is_empty() { String::new() } else { format!(" Unit: {}.", key.unit) };
    let default = match key.need {
        Need::Default(default) => format!(" Default: {default}."),
        _ => String::new(),
    };
    schema["description"] = json!(format!("{}{unit}{default}", key.meaning));
    schema
}

fn value(value: &Value) -> Json {
    let number = || json!({ "type": "number", "minimum": -MAX_MAGNITUDE, "maximum": MAX_MAGNITUDE });
    let count = || json!({ "type": "integer", "minimum": 0, "maximum": MAX_COUNT });
    let some = |items: Json, n: u64| json!({ "type": "array", "items": items, "minItems": n, "maxItems": n });
    match value {
        Value::Number => number(),
        Value::Field(below) => json!({ "anyOf": [number(), table(below)] }),
        Value::Count => count(),
        Value::Counts => json!({ "type": "array", "items": count() }),
        Value::Text => json!({ "type": "string" }),
        Value::Texts => json!({ "type": "array", "items": { "type": "string" } }),
        Value::Vector => some(number(), 3),
        Value::Vectors => json!({ "type": "array", "items": some(number(), 3) }),
        Value::AutoOrCount => json!({ "anyOf": [{ "const": "auto" }, count()] }),
        Value::CountPair => some(count(), 2),
        Value::Flag => json!({ "type": "boolean" }),
        Value::Coefficients => some(number(), 6),
        Value::MapTriangle => {
            json!({ "anyOf": [{ "enum": ["similar", "half-square"] }, some(some(number(), 2), 3)] })
        }
        Value::Table(below) => table(below),
        Value::Tables(below) => json!({ "anyOf": [table(below), { "type": "array", "items": table(below) }] }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::shipped;
    use toml::de::{DeTable, DeValue};

    /// What a text would be as JSON.
    fn parsed(text: &str) -> Json {
        fn table(table: &DeTable) -> Json {
            Json::Object(
                table.iter().map(|(key, value)| (key.get_ref().to_string(), json(value.get_ref()))).collect(),
            )
        }
        fn json(value: &DeValue) -> Json {
            match value {
                DeValue::String(text) => Json::from(text.as_ref()),
                DeValue::Integer(n) => {
                    Json::from(i64::from_str_radix(&n.as_str().replace('_', ""), n.radix()).unwrap())
                }
                DeValue::Float(x) => Json::from(x.as_str().parse::<f64>().unwrap()),
                DeValue::Boolean(flag) => Json::from(*flag),
                DeValue::Datetime(at) => Json::from(at.to_string()),
                DeValue::Array(items) => items.iter().map(|item| json(item.get_ref())).collect(),
                DeValue::Table(below) => table(below),
            }
        }
        table(DeTable::parse(text).unwrap().get_ref())
    }

    /// Whether a schema made of these keywords holds, by their definitions; a keyword that is not known here panics.
    fn holds(schema: &Json, value: &Json) -> bool {
        schema.as_object().unwrap().iter().all(|(keyword, what)| match keyword.as_str() {
            "$schema" | "title" | "description" => true,
            "type" => match what.as_str().unwrap() {
                "object" => value.is_object(),
                "array" => value.is_array(),
                "string" => value.is_string(),
                "number" => value.is_number(),
                "boolean" => value.is_boolean(),
                "integer" => value.is_u64() || value.is_i64(),
                other => panic!("{other}"),
            },
            "const" => value == what,
            "enum" => what.as_array().unwrap().contains(value),
            "minimum" => value.as_f64().is_none_or(|x| x >= what.as_f64().unwrap()),
            "maximum" => value.as_f64().is_none_or(|x| x <= what.as_f64().unwrap()),
            "minItems" => value.as_array().is_none_or(|items| items.len() as u64 >= what.as_u64().unwrap()),
            "maxItems" => value.as_array().is_none_or(|items| items.len() as u64 <= what.as_u64().unwrap()),
            "items" => value.as_array().is_none_or(|items| items.iter().all(|item| holds(what, item))),
            "anyOf" => what.as_array().unwrap().iter().any(|schema| holds(schema, value)),
            "required" => value.as_object().is_none_or(|table| {
                what.as_array().unwrap().iter().all(|key| table.contains_key(key.as_str().unwrap()))
            }),
            "properties" => value.as_object().is_none_or(|table| {
                table.iter().all(|(key, value)| what.get(key).is_none_or(|schema| holds(schema, value)))
            }),
            "additionalProperties" => {
                assert_eq!(what, &Json::Bool(false));
                let known = schema["properties"].as_object().unwrap();
                value.as_object().is_none_or(|table| table.keys().all(|key| known.contains_key(key)))
            }
            other => panic!("{other} is not known"),
        })
    }

    #[test]
    fn every_shipped_case_holds() {
        let schema = json_schema();
        let mut n = 0;
        for case in shipped() {
            assert!(holds(&schema, &parsed(case.text())), "{}", case.name());
            n += 1;
        }
        assert!(n > 20, "{n}");
    }

    #[test]
    fn what_the_reader_refuses_by_its_keys_does_not_hold() {
        let schema = json_schema();
        let text = crate::case::TEMPLATE;
        assert!(holds(&schema, &parsed(text)));
        for (from, to) in [
            ("radius =", "radios ="),
            ("radius = 0.3", "radius = \"wide\""),
            ("center = [0.0, 0.0, 2.0]", "center = [0.0, 2.0]"),
            ("points = 33", "points = -33"),
            ("points = 33", "points = 33.5"),
            ("exitance = 1.0 ", "exitance = true "),
            ("exitance = 1.0 ", "exitance = 1e31 "),
            ("normal = [0.0, 0.0, -1.0]", ""),
            ("[receiver.rectangle]", "[receiver.blob]"),
        ] {
            let wrong = text.replacen(from, to, 1);
            assert_ne!(wrong, text, "{from}");
            assert!(!holds(&schema, &parsed(&wrong)), "{from} → {to}");
            assert!(crate::case::Case::from_toml("wrong", &wrong).is_err(), "{from} → {to}");
        }
    }
}
