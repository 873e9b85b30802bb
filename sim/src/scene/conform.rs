//! Checks a parsed TOML document against the schema: known keys, right types, values in range.

use std::ops::Range;

use serde_json::Value;
use toml::{
    Spanned,
    de::{DeTable, DeValue},
};

use super::{
    moved::place_now,
    problem::Problem,
    schema::{alternatives, choices, numbers, resolve, schema, type_name},
    sources::Sources,
};

/// All departures of `document` from the schema. The document was merged from `sources`.
pub(crate) fn departures(document: &Spanned<DeTable<'_>>, sources: &Sources) -> Vec<Problem> {
    let mut walk = Walk { sources, problems: Vec::new() };
    walk.table(document.get_ref(), document.span(), resolve(schema()), "");
    walk.problems.sort_by_key(|problem| problem.span.start);
    walk.problems
}

/// The one of `candidates` that is most similar to `name`, if one is similar enough to have been meant.
pub(crate) fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    candidates
        .into_iter()
        .map(|candidate| (strsim::jaro_winkler(name, candidate), candidate))
        .filter(|(similarity, _)| *similarity > 0.75)
        .max_by(|(one, _), (other, _)| one.total_cmp(other))
        .map(|(_, candidate)| candidate)
}

/// First line of a piece of a scene file's text, cut to a length that suits an error message.
pub(crate) fn excerpt(text: &str) -> String {
    const LONGEST: usize = 60;
    let line = text.lines().next().unwrap_or_default().trim();
    if line.chars().count() > LONGEST { line.chars().take(LONGEST).chain(['…']).collect() } else { line.to_owned() }
}

struct Walk<'a> {
    sources: &'a Sources,
    problems: Vec<Problem>,
}

impl Walk<'_> {
    fn value(&mut self, value: &Spanned<DeValue<'_>>, property: &'static Value, key: &str) {
        let stated = resolve(property);
        let options = match alternatives(stated) {
            options if options.is_empty() => vec![stated],
            options => options.into_iter().map(resolve).collect(),
        };
        let Some(node) = options.iter().copied().find(|option| fits(value.get_ref(), option)) else {
            let wanted: Vec<String> = options.iter().map(|option| expectation(option)).collect();
            self.report(
                value.span(),
                key,
                format!("{}, expected {}", found(value.get_ref()), wanted.join(", or ")),
                property,
            );
            return;
        };
        match value.get_ref() {
            DeValue::Table(table) => self.table(table, value.span(), node, key),
            DeValue::Array(array) => {
                for (index, item) in array.iter().enumerate() {
                    self.value(item, &node["items"], &format!("{key}[{index}]"));
                }
                self.length(array.len(), value.span(), node, key);
            }
            DeValue::String(chosen) => self.choice(chosen, value.span(), node, key),
            number @ (DeValue::Integer(_) | DeValue::Float(_)) => self.number(number, value.span(), node, key),
            DeValue::Boolean(_) | DeValue::Datetime(_) => {}
        }
    }

    fn table(&mut self, table: &DeTable<'_>, span: Range<usize>, node: &'static Value, key: &str) {
        let Some(node) = self.variant(table, span.clone(), node, key) else { return };
        let known = node.get("properties").and_then(Value::as_object);
        for (name, value) in table.iter() {
            let path = join(key, name.get_ref());
            if let Some(property) = known.and_then(|known| known.get(name.get_ref().as_ref())) {
                self.value(value, property, &path);
            } else if node["additionalProperties"] == Value::Bool(false) {
                let names = known.into_iter().flat_map(|known| known.keys()).map(String::as_str);
                let expected = match (place_now(&path), nearest(name.get_ref(), names.clone())) {
                    (Some(now), _) => {
                        // The command rewrites the files that it is given, but not those that they extend.
                        let file = self.sources.base_at(&name.span()).unwrap_or("SCENE");
                        format!("moved, expected `{now}`; `wherein upgrade {file}` rewrites a scene")
                    }
                    (None, Some(meant)) => format!("unknown key, expected `{meant}`?"),
                    (None, None) => format!("unknown key, expected one of {}", names.collect::<Vec<_>>().join(", ")),
                };
                self.problems.push(Problem {
                    key: path,
                    value: None,
                    expected,
                    span: name.span(),
                    help: None,
                    file: None,
                });
            }
        }
        for required in node.get("required").and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str) {
            if !table.contains_key(required) {
                let property = known.and_then(|known| known.get(required)).unwrap_or(&Value::Null);
                let expected = format!("missing, expected {}", expectation(resolve(property)));
                let path = join(key, required);
                let help = explanation(&path, property);
                self.problems.push(Problem {
                    key: path,
                    value: None,
                    expected,
                    span: header(&span, key),
                    help,
                    file: None,
                });
            }
        }
    }

    /// The schema that holds for `table` where tables of several kinds are allowed: that of the kind which the table's key `kind` states. It is
    /// `node` itself if only one kind is allowed, and `None` if the kind is missing or unknown, which is reported.
    fn variant(
        &mut self,
        table: &DeTable<'_>,
        span: Range<usize>,
        node: &'static Value,
        key: &str,
    ) -> Option<&'static Value> {
        let Some(variants) = node.get("oneOf").and_then(Value::as_array) else { return Some(node) };
        let kind_of = |variant: &'static Value| variant["properties"]["kind"]["const"].as_str();
        let kinds: Vec<&str> = variants.iter().filter_map(kind_of).collect();
        let listed = kinds.join(", ");
        let Some(kind) = table.get("kind") else {
            let expected = format!("missing, expected one of {listed}");
            self.problems.push(Problem {
                key: join(key, "kind"),
                value: None,
                expected,
                span: header(&span, key),
                help: None,
                file: None,
            });
            return None;
        };
        let chosen = variants.iter().find(|variant| kind_of(variant) == kind.get_ref().as_str());
        if chosen.is_none() {
            self.report(kind.span(), &join(key, "kind"), format!("expected one of {listed}"), &Value::Null);
        }
        chosen
    }

    fn choice(&mut self, chosen: &str, span: Range<usize>, node: &'static Value, key: &str) {
        let choices = choices(node);
        if choices.is_empty() || choices.contains(&chosen) {
            return;
        }
        self.report(span, key, format!("expected one of {}", choices.join(", ")), node);
    }

    fn length(&mut self, length: usize, span: Range<usize>, node: &'static Value, key: &str) {
        let bound = |name: &str| node.get(name).and_then(Value::as_u64).map(|bound| bound as usize);
        let (least, most) = (bound("minItems").unwrap_or(0), bound("maxItems").unwrap_or(usize::MAX));
        if length < least || length > most {
            let wanted = if least == most { values(least) } else { format!("at least {}", values(least)) };
            self.report(span, key, format!("a list of {}, expected {wanted}", values(length)), node);
        }
    }

    fn number(&mut self, number: &DeValue<'_>, span: Range<usize>, node: &'static Value, key: &str) {
        let value = numeric(number);
        let bound = |name: &str| node.get(name).and_then(Value::as_f64);
        let within = value.is_finite()
            && bound("minimum").is_none_or(|least| value >= least)
            && bound("exclusiveMinimum").is_none_or(|limit| value > limit)
            && bound("maximum").is_none_or(|most| value <= most)
            && numbers(node).is_none_or(|numbers| numbers.contains(&value));
        if !within {
            self.report(span, key, format!("expected {}", expectation(node)), node);
        }
    }

    fn report(&mut self, span: Range<usize>, key: &str, expected: String, node: &'static Value) {
        let value = Some(excerpt(&self.sources.text()[span.clone()]));
        self.problems.push(Problem {
            key: key.to_owned(),
            value,
            expected,
            span,
            help: explanation(key, node),
            file: None,
        });
    }
}

/// Dotted path of a key, given the path of the table in which the key stands.
fn join(table: &str, key: &str) -> String {
    if table.is_empty() { key.to_owned() } else { format!("{table}.{key}") }
}

/// Range of bytes to underline in the message about a missing key: the header of the table that lacks it, or nothing at the top level of the file.
fn header(span: &Range<usize>, key: &str) -> Range<usize> {
    if key.is_empty() { 0..0 } else { span.clone() }
}

/// The value of a TOML number as floating point; NaN if there is none.
fn numeric(value: &DeValue<'_>) -> f64 {
    match value {
        DeValue::Float(float) => float.as_str().parse().unwrap_or(f64::NAN),
        DeValue::Integer(integer) => {
            i64::from_str_radix(integer.as_str(), integer.radix()).map_or(f64::NAN, |integer| integer as f64)
        }
        _ => f64::NAN,
    }
}

/// Whether `value` has a type that the schema `node` allows.
fn fits(value: &DeValue<'_>, node: &'static Value) -> bool {
    let is_variant = node.get("oneOf").is_some();
    match type_name(node) {
        "object" => value.is_table(),
        "array" => value.is_array(),
        "string" => value.is_str(),
        "boolean" => value.is_bool(),
        "integer" => value.is_integer(),
        "number" => value.is_integer() || value.is_float(),
        _ if is_variant && choices(node).is_empty() => value.is_table(),
        _ if is_variant => value.is_str(),
        _ => true,
    }
}

/// Type of a TOML value, in words.
pub(crate) fn found(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a text",
        DeValue::Integer(_) => "a whole number",
        DeValue::Float(_) => "a floating-point number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    }
}

/// A number of values, in words.
fn values(count: usize) -> String {
    format!("{count} value{}", if count == 1 { "" } else { "s" })
}

/// What the schema `node` allows, in words.
fn expectation(node: &'static Value) -> String {
    let bound = |name: &str| node.get(name).and_then(Value::as_f64);
    let kind = if type_name(node) == "integer" { "a whole number" } else { "a number" };
    match type_name(node) {
        "object" => "a table".to_owned(),
        "array" => match (node["minItems"].as_u64(), node["maxItems"].as_u64()) {
            (Some(least), Some(most)) if least == most => {
                format!("a list of {}", values(usize::try_from(least).unwrap_or(usize::MAX)))
            }
            _ => "a list".to_owned(),
        },
        "string" if choices(node).is_empty() => "a text in quotes".to_owned(),
        "boolean" => "true or false".to_owned(),
        "integer" | "number" if numbers(node).is_some() => {
            let listed: Vec<String> = numbers(node).into_iter().flatten().map(|number| number.to_string()).collect();
            format!("one of {}", listed.join(", "))
        }
        "integer" | "number" => match (bound("minimum"), bound("exclusiveMinimum"), bound("maximum")) {
            (Some(least), _, Some(most)) => format!("{kind} from {least} to {most}"),
            (_, Some(limit), Some(most)) => format!("{kind} above {limit}, at most {most}"),
            _ => format!("{kind} that is finite"),
        },
        _ if !choices(node).is_empty() => format!("one of {}", choices(node).join(", ")),
        _ => "a table".to_owned(),
    }
}

/// Explanation of a key for a message: its meaning and its default, from the schema.
fn explanation(key: &str, node: &'static Value) -> Option<String> {
    let meaning = node.get("description").and_then(Value::as_str)?;
    let plain = |value: &&Value| !value.is_object() && !value.is_array() && !value.is_null();
    let default = node.get("default").filter(plain).map(|value| format!(" Default: {value}.")).unwrap_or_default();
    Some(format!("`{key}`: {meaning}{default}"))
}
