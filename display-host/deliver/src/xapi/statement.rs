//! Statements about sessions.

use serde_json::{Map, Value, json};
use store::{Hand, Outgoing, SessionRecord};
use uuid::Uuid;

/// Namespace of statements, for UUIDs of version 5.
const STATEMENTS: Uuid = Uuid::from_u128(0x1f6f_4b1e_6a0c_4d0e_8f0b_52d3_9d7f_a6b4);
/// Beginning of the ids of everything that Calot names itself.
pub(crate) const OWN: &str = "urn:calot:";
/// Verbs of the specification's authors.
const VERBS: &str = "http://adlnet.gov/expapi/verbs/";

/// Id of the statement about a person's session: the same at each try.
pub(crate) fn statement_id(session: &str, person: &str) -> Uuid {
    Uuid::new_v5(&STATEMENTS, format!("{session}/{person}").as_bytes())
}

/// Id of the statement that voids another.
pub(crate) fn voiding_id(statement: Uuid) -> Uuid {
    Uuid::new_v5(&statement, b"voided")
}

/// Actor of a person. `home` is the page of the system that knows the account.
pub(crate) fn actor(home: &str, person: &str) -> Value {
    json!({"objectType": "Agent", "account": {"homePage": home, "name": person}})
}

/// Statement about a session. It depends on nothing but the session, so each try makes the same.
pub(crate) fn statement(home: &str, it: &Outgoing) -> Value {
    let session = &it.session;
    let (verb, en, de) = match session.outcome.as_str() {
        "passed" => ("passed", "passed", "bestanden"),
        "failed" => ("failed", "failed", "nicht bestanden"),
        "aborted" => ("terminated", "broke off", "abgebrochen"),
        "cut-short" => ("suspended", "was cut short", "unterbrochen"),
        _ => ("experienced", "practised", "geübt"),
    };
    json!({
        "id": statement_id(&session.id, &it.person).to_string(),
        "actor": actor(home, &it.person),
        "verb": {"id": format!("{VERBS}{verb}"), "display": {"en": en, "de": de}},
        "object": {
            "objectType": "Activity",
            "id": format!("{OWN}task:{}", segment(&session.task)),
            "definition": {
                "type": "http://adlnet.gov/expapi/activities/simulation",
                "name": {"en": session.task},
            },
        },
        "result": result(session),
        "context": {
            "registration": session.id,
            "platform": "Calot",
            "extensions": extensions(session),
        },
        "timestamp": timestamp(session.began_unix_s),
    })
}

fn result(session: &SessionRecord) -> Value {
    let mut result = Map::new();
    let score = session.score.clamp(0.0, 100.0);
    let scaled = score / 100.0;
    result.insert(
        "score".to_owned(),
        json!({"raw": score, "scaled": scaled, "min": 0, "max": 100}),
    );
    let is_decided = ["passed", "failed"].contains(&session.outcome.as_str());
    if is_decided {
        result.insert("success".to_owned(), (session.outcome == "passed").into());
    }
    result.insert("completion".to_owned(), is_decided.into());
    let time_s = session.metrics.get("time_s");
    if let Some(time_s) = time_s.filter(|it| it.is_finite() && **it >= 0.0) {
        // The specification compares durations to 0.01 s.
        result.insert("duration".to_owned(), format!("PT{time_s:.2}S").into());
    }
    result.insert(
        "extensions".to_owned(),
        json!({format!("{OWN}metrics"): session.metrics}),
    );
    result.into()
}

fn extensions(session: &SessionRecord) -> Value {
    let made = &session.circumstances;
    json!({
        format!("{OWN}difficulty"): session.difficulty,
        format!("{OWN}outcome"): session.outcome,
        format!("{OWN}alarms"): session.alarms,
        format!("{OWN}metrics-version"): session.metrics_version,
        format!("{OWN}scene"): session.scene,
        format!("{OWN}program"): session.program,
        format!("{OWN}realtime"): made.realtime,
        format!("{OWN}missed-ticks"): made.missed_ticks,
        format!("{OWN}device"): made.device,
        format!("{OWN}driver"): made.driver,
        format!("{OWN}site"): made.site,
    })
}

/// Statement that voids another.
pub(crate) fn voiding(home: &str, statement: Uuid, at_unix_s: i64) -> Value {
    json!({
        "id": voiding_id(statement).to_string(),
        "actor": actor(home, "calot"),
        "verb": {"id": format!("{VERBS}voided"), "display": {"en": "voided", "de": "widerrufen"}},
        "object": {"objectType": "StatementRef", "id": statement.to_string()},
        "timestamp": timestamp(at_unix_s),
    })
}

/// True if a record store takes this session. A scripted hand's session says nothing about the
/// person.
pub(crate) fn is_persons(it: &Outgoing) -> bool {
    it.session.hand == Hand::Person
}

/// True if `theirs`, as a record store returns it, says what `ours` does. A record store may add to
/// a statement and write times and numbers in another form. The site does not count: it may have
/// been named after the session was sent.
pub(crate) fn says_the_same(theirs: &Value, ours: &Value) -> bool {
    let at = |value: &Value, path: &str| value.pointer(path).cloned().unwrap_or_default();
    let parts = [
        "/actor/account",
        "/verb/id",
        "/object/id",
        "/result",
        "/context/registration",
        "/context/extensions",
    ];
    let mut ours = ours.clone();
    if let Some(Value::Object(made)) = ours.pointer_mut("/context/extensions") {
        made.remove(&format!("{OWN}site"));
    }
    parts
        .iter()
        .all(|path| includes(&at(theirs, path), &at(&ours, path)))
}

fn includes(theirs: &Value, ours: &Value) -> bool {
    match (theirs, ours) {
        (Value::Object(theirs), Value::Object(ours)) => ours.iter().all(|(key, value)| {
            // An absent value and null are one.
            includes(theirs.get(key).unwrap_or(&Value::Null), value)
        }),
        (Value::Number(theirs), Value::Number(ours)) => theirs.as_f64() == ours.as_f64(),
        _ => theirs == ours,
    }
}

/// Text as a part of an IRI.
fn segment(text: &str) -> String {
    percent_encoding::utf8_percent_encode(text, percent_encoding::NON_ALPHANUMERIC).to_string()
}

/// Time as RFC 3339 wants it, in UTC.
pub(crate) fn timestamp(unix_s: i64) -> String {
    let (days, second) = (unix_s.div_euclid(86_400), unix_s.rem_euclid(86_400));
    // Days since 1 March of year 0; a year that begins in March has its leap day at its end.
    let since = days + 719_468;
    let (era, day) = (since.div_euclid(146_097), since.rem_euclid(146_097));
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day_of_year = day - (365 * year + year / 4 - year / 100);
    let moved = (5 * day_of_year + 2) / 153;
    let month = if moved < 10 { moved + 3 } else { moved - 9 };
    let year = year + era * 400 + i64::from(month <= 2);
    let day = day_of_year - (153 * moved + 2) / 5 + 1;
    format!(
        "{year:04}-{month:02}-{day:02}T{:02}:{:02}:{:02}Z",
        second / 3600,
        second / 60 % 60,
        second % 60
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_those_of_the_calendar() {
        for (unix_s, text) in [
            (0, "1970-01-01T00:00:00Z"),
            (951_782_399, "2000-02-28T23:59:59Z"),
            (951_782_400, "2000-02-29T00:00:00Z"),
            (1_709_251_199, "2024-02-29T23:59:59Z"),
            (1_795_944_600, "2026-11-29T09:30:00Z"),
            (-1, "1969-12-31T23:59:59Z"),
        ] {
            assert_eq!(timestamp(unix_s), text);
        }
    }

    #[test]
    fn a_record_store_may_add_but_not_change() {
        let ours = json!({"result": {"score": {"raw": 80.0}}, "actor": {"account": {"name": "x"}}});
        let theirs = json!({"result": {"score": {"raw": 80}, "more": 1}, "actor": {"account": {"name": "x"}},
            "stored": "now"});
        assert!(says_the_same(&theirs, &ours));
        let other = json!({"result": {"score": {"raw": 81}}, "actor": {"account": {"name": "x"}}});
        assert!(!says_the_same(&other, &ours));
    }
}
