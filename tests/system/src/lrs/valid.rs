//! The rules of xAPI 2.0 (IEEE 9274.1.1) for a statement: properties, types, IRIs, durations,
//! times.

use std::collections::BTreeMap;

use serde_json::{Map, Value};

type Checked = Result<(), String>;

/// Checks a request that writes, and returns the statement and its id.
pub(super) fn put(
    content_type: Option<&String>,
    query: &BTreeMap<String, String>,
    body: &str,
) -> Result<(String, Value), String> {
    if content_type.is_none_or(|it| it != "application/json") {
        return Err(format!("content type {content_type:?}"));
    }
    let id = query.get("statementId").ok_or("no parameter statementId")?;
    let statement: Value = serde_json::from_str(body).map_err(|error| error.to_string())?;
    check(&statement)?;
    if statement["id"] != id.as_str() {
        return Err("the ids of parameter and statement differ".to_owned());
    }
    Ok((id.clone(), statement))
}

/// Checks a statement.
///
/// # Errors
///
/// The rule that it breaks.
pub fn check(statement: &Value) -> Checked {
    let of = "statement";
    let allowed = [
        "id",
        "actor",
        "verb",
        "object",
        "result",
        "context",
        "timestamp",
        "stored",
        "authority",
        "version",
        "attachments",
    ];
    let all = object(statement, of, &allowed, &["actor", "verb", "object"])?;
    nothing_is_null(statement, of)?;
    if let Some(id) = all.get("id") {
        uuid(id, "id")?;
    }
    agent(&all["actor"])?;
    verb(&all["verb"])?;
    let is_activity = target(&all["object"])?;
    let voids = all["verb"]["id"] == "http://adlnet.gov/expapi/verbs/voided";
    if voids && all["object"]["objectType"] != "StatementRef" {
        return Err("a voiding statement refers to no statement".to_owned());
    }
    if let Some(it) = all.get("result") {
        result(it)?;
    }
    if let Some(it) = all.get("context") {
        context(it, is_activity)?;
    }
    match all.get("timestamp") {
        Some(it) => time(text(it, "timestamp")?),
        None => Ok(()),
    }
}

fn object<'a>(
    value: &'a Value,
    of: &str,
    allowed: &[&str],
    needed: &[&str],
) -> Result<&'a Map<String, Value>, String> {
    let all = value
        .as_object()
        .ok_or_else(|| format!("{of} is no object"))?;
    if let Some(other) = all.keys().find(|it| !allowed.contains(&it.as_str())) {
        return Err(format!("{of} has the property '{other}'"));
    }
    match needed.iter().find(|it| !all.contains_key(**it)) {
        Some(absent) => Err(format!("{of} lacks '{absent}'")),
        None => Ok(all),
    }
}

/// Null is allowed within extensions only.
fn nothing_is_null(value: &Value, of: &str) -> Checked {
    match value {
        Value::Null => Err(format!("{of} is null")),
        Value::Object(all) => {
            let mut all = all.iter().filter(|(name, _)| *name != "extensions");
            all.try_for_each(|(name, it)| nothing_is_null(it, name))
        }
        Value::Array(all) => all.iter().try_for_each(|it| nothing_is_null(it, of)),
        _ => Ok(()),
    }
}

fn text<'a>(value: &'a Value, of: &str) -> Result<&'a str, String> {
    value.as_str().ok_or_else(|| format!("{of} is no text"))
}

fn uuid(value: &Value, of: &str) -> Checked {
    let id = text(value, of)?;
    let dashes = [8, 13, 18, 23];
    let fits = |(at, it): (usize, char)| match dashes.contains(&at) {
        true => it == '-',
        false => it.is_ascii_hexdigit(),
    };
    match id.len() == 36 && id.chars().enumerate().all(fits) {
        true => Ok(()),
        false => Err(format!("{of} '{id}' is no UUID")),
    }
}

/// An absolute IRI: a scheme, then something without spaces.
fn iri(id: &str, of: &str) -> Checked {
    let scheme = |it: &str| {
        it.starts_with(|it: char| it.is_ascii_alphabetic())
            && it
                .chars()
                .all(|it| it.is_ascii_alphanumeric() || "+-.".contains(it))
    };
    let forbidden = |it: char| it.is_whitespace() || it.is_control() || "<>\"{}|\\^`".contains(it);
    match id.split_once(':') {
        Some((head, rest)) if scheme(head) && !rest.is_empty() && !id.contains(forbidden) => Ok(()),
        _ => Err(format!("{of} '{id}' is no IRI")),
    }
}

fn agent(value: &Value) -> Checked {
    let allowed = [
        "objectType",
        "name",
        "mbox",
        "mbox_sha1sum",
        "openid",
        "account",
    ];
    let all = object(value, "actor", &allowed, &[])?;
    if all.get("objectType").is_some_and(|it| it != "Agent") {
        return Err("the actor is no agent".to_owned());
    }
    let identifiers = ["mbox", "mbox_sha1sum", "openid", "account"];
    if identifiers
        .iter()
        .filter(|it| all.contains_key(**it))
        .count()
        != 1
    {
        return Err("the actor has not exactly one identifier".to_owned());
    }
    let Some(account) = all.get("account") else {
        return Ok(());
    };
    let names = ["homePage", "name"];
    let account = object(account, "account", &names, &names)?;
    let home = text(&account["homePage"], "homePage")?;
    iri(home, "homePage")?;
    if !home.starts_with("http") {
        return Err("the homePage of an account is no address of a page".to_owned());
    }
    text(&account["name"], "name of an account").map(drop)
}

fn language_map(value: &Value, of: &str) -> Checked {
    let all = value
        .as_object()
        .ok_or_else(|| format!("{of} is no language map"))?;
    let is_tag = |it: &str| {
        let mut parts = it.split('-');
        let first = parts.next().is_some_and(|it| (2..=8).contains(&it.len()));
        first && it.chars().all(|it| it.is_ascii_alphanumeric() || it == '-')
    };
    for (tag, it) in all {
        if !is_tag(tag) {
            return Err(format!("{of}: '{tag}' is no language"));
        }
        text(it, of)?;
    }
    Ok(())
}

fn verb(value: &Value) -> Checked {
    let all = object(value, "verb", &["id", "display"], &["id"])?;
    iri(text(&all["id"], "verb")?, "verb")?;
    all.get("display")
        .map_or(Ok(()), |it| language_map(it, "display"))
}

/// Checks the object; true if it is an activity.
fn target(value: &Value) -> Result<bool, String> {
    if value["objectType"] == "StatementRef" {
        let names = ["objectType", "id"];
        let all = object(value, "reference", &names, &names)?;
        uuid(&all["id"], "id of a reference")?;
        return Ok(false);
    }
    let all = object(
        value,
        "activity",
        &["objectType", "id", "definition"],
        &["id"],
    )?;
    if all.get("objectType").is_some_and(|it| it != "Activity") {
        return Err("the object is neither an activity nor a reference".to_owned());
    }
    iri(text(&all["id"], "id of an activity")?, "id of an activity")?;
    if let Some(it) = all.get("definition") {
        let allowed = ["name", "description", "type", "moreInfo", "extensions"];
        let all = object(it, "definition", &allowed, &[])?;
        for name in ["name", "description"] {
            all.get(name).map_or(Ok(()), |it| language_map(it, name))?;
        }
        if let Some(it) = all.get("type") {
            iri(text(it, "type")?, "type")?;
        }
    }
    Ok(true)
}

fn extensions(value: Option<&Value>) -> Checked {
    let Some(value) = value else {
        return Ok(());
    };
    let all = value.as_object().ok_or("extensions are no object")?;
    all.keys().try_for_each(|it| iri(it, "key of an extension"))
}

fn result(value: &Value) -> Checked {
    let allowed = [
        "score",
        "success",
        "completion",
        "response",
        "duration",
        "extensions",
    ];
    let all = object(value, "result", &allowed, &[])?;
    for name in ["success", "completion"] {
        if all.get(name).is_some_and(|it| !it.is_boolean()) {
            return Err(format!("{name} is neither true nor false"));
        }
    }
    if let Some(it) = all.get("duration") {
        duration(text(it, "duration")?)?;
    }
    extensions(all.get("extensions"))?;
    all.get("score").map_or(Ok(()), score)
}

fn score(value: &Value) -> Checked {
    let all = object(value, "score", &["scaled", "raw", "min", "max"], &[])?;
    let number = |name: &str| match all.get(name).map(Value::as_f64) {
        Some(None) => Err(format!("{name} of a score is no number")),
        found => Ok(found.flatten()),
    };
    let (least, most) = (number("min")?, number("max")?);
    if number("scaled")?.is_some_and(|it| !(-1.0..=1.0).contains(&it)) {
        return Err("a scaled score is outside -1 to 1".to_owned());
    }
    let raw = number("raw")?;
    let is_below = raw.zip(least).is_some_and(|(raw, least)| raw < least);
    let is_above = raw.zip(most).is_some_and(|(raw, most)| raw > most);
    let is_empty = least.zip(most).is_some_and(|(least, most)| least >= most);
    match is_below || is_above || is_empty {
        true => Err("a score is outside of its range".to_owned()),
        false => Ok(()),
    }
}

/// ISO 8601: `P`, numbers with units, the last of which may have a fraction.
fn duration(given: &str) -> Checked {
    let wrong = || Err(format!("'{given}' is no duration"));
    let Some(rest) = given.strip_prefix('P') else {
        return wrong();
    };
    let (date, clock) = match rest.split_once('T') {
        Some((_, "")) => return wrong(),
        Some((date, clock)) => (date, clock),
        None => (rest, ""),
    };
    if date.is_empty() && clock.is_empty() {
        return wrong();
    }
    for (part, units) in [(date, "YMWD"), (clock, "HMS")] {
        let mut from = 0;
        let mut number = String::new();
        for it in part.chars() {
            match units.chars().skip(from).position(|unit| unit == it) {
                Some(at) if number.parse::<f64>().is_ok() => {
                    from += at + 1;
                    number.clear();
                }
                None if it.is_ascii_digit() || it == '.' => number.push(it),
                _ => return wrong(),
            }
        }
        if !number.is_empty() {
            return wrong();
        }
    }
    Ok(())
}

fn context(value: &Value, is_activity: bool) -> Checked {
    let allowed = [
        "registration",
        "instructor",
        "team",
        "contextActivities",
        "contextAgents",
        "contextGroups",
        "revision",
        "platform",
        "language",
        "statement",
        "extensions",
    ];
    let all = object(value, "context", &allowed, &[])?;
    if let Some(it) = all.get("registration") {
        uuid(it, "registration")?;
    }
    for name in ["revision", "platform"] {
        match all.get(name) {
            Some(_) if !is_activity => return Err(format!("{name} without an activity")),
            Some(it) => text(it, name).map(drop)?,
            None => {}
        }
    }
    extensions(all.get("extensions"))
}

/// RFC 3339, with a zone that is not an unknown one.
fn time(given: &str) -> Checked {
    let wrong = || Err(format!("'{given}' is no time of RFC 3339"));
    let form = "0000-00-00T00:00:00";
    let Some((head, zone)) = given.split_at_checked(form.len()) else {
        return wrong();
    };
    let fits = |(it, form): (char, char)| match form {
        '0' => it.is_ascii_digit(),
        form => it == form,
    };
    let number = |from: usize, to: usize| head.get(from..to).and_then(|it| it.parse::<u32>().ok());
    let in_range = |from, to, range: std::ops::RangeInclusive<u32>| {
        number(from, to).is_some_and(|it| range.contains(&it))
    };
    let is_time = head.chars().zip(form.chars()).all(fits)
        && in_range(5, 7, 1..=12)
        && in_range(8, 10, 1..=31)
        && in_range(11, 13, 0..=23)
        && in_range(14, 16, 0..=59)
        && in_range(17, 19, 0..=60);
    let zone = zone.strip_prefix('.').map_or(zone, |it| {
        it.trim_start_matches(|it: char| it.is_ascii_digit())
    });
    let is_zone =
        zone == "Z" || (zone.len() == 6 && zone.starts_with(['+', '-']) && zone != "-00:00");
    match is_time && is_zone {
        true => Ok(()),
        false => wrong(),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn good() -> Value {
        json!({
            "id": "c7a5f0d6-9d1e-5b6a-8f7a-2f0f4c58aa11",
            "actor": {"account": {"homePage": "https://x.example", "name": "a"}},
            "verb": {"id": "http://x.example/did", "display": {"en": "did"}},
            "object": {"id": "urn:x:y", "definition": {"type": "urn:x:z", "name": {"en-US": "y"}}},
            "result": {"score": {"raw": 5, "min": 0, "max": 10, "scaled": 0.5}, "duration": "PT1M2.50S",
                "extensions": {"urn:x:e": null}},
            "context": {"registration": "c7a5f0d6-9d1e-5b6a-8f7a-2f0f4c58aa11", "platform": "x"},
            "timestamp": "2026-11-29T08:10:00.5Z",
        })
    }

    #[test]
    fn a_statement_that_keeps_every_rule_is_taken() {
        check(&good()).expect("a good statement");
    }

    #[test]
    fn each_broken_rule_is_found() {
        for (path, value) in [
            ("/id", json!("c7a5f0d69d1e5b6a8f7a2f0f4c58aa11")),
            (
                "/actor",
                json!({"account": {"homePage": "https://x.example"}}),
            ),
            (
                "/actor",
                json!({"mbox": "mailto:a@b", "account": {"homePage": "https://x", "name": "a"}}),
            ),
            ("/actor/account/homePage", json!("urn:x:y")),
            ("/verb/id", json!("did")),
            ("/verb/display", json!({"x y": "did"})),
            ("/object/id", json!("a b")),
            ("/object", json!({"objectType": "StatementRef", "id": "x"})),
            ("/result/score/scaled", json!(1.5)),
            ("/result/score/raw", json!(11)),
            ("/result/duration", json!("62.5")),
            ("/result/duration", json!("PT")),
            ("/result/duration", json!("PT2S1M")),
            ("/result/extensions", json!({"e": 1})),
            ("/result", json!({"success": "yes"})),
            ("/context/platform", json!(null)),
            ("/context/registration", json!("x")),
            ("/timestamp", json!("2026-11-29 08:10:00Z")),
            ("/timestamp", json!("2026-13-29T08:10:00Z")),
            ("/timestamp", json!("2026-11-29T08:10:00")),
            ("/context", json!({"session": "x"})),
        ] {
            let mut bad = good();
            *bad.pointer_mut(path).expect("it is there") = value.clone();
            assert!(check(&bad).is_err(), "{path}: {value}");
        }
    }
}
