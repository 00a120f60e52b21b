//! Documents: the JSON that `calot` writes, against the schemas that `calot schema` prints.

use std::collections::BTreeMap;
use std::process::Command;
use std::sync::{Mutex, PoisonError};

use jsonschema::Validator;
use serde_json::{Deserializer, Value};

use crate::calot;

/// Checks every document of a program's output, in lines, arrays or alone.
///
/// # Panics
///
/// If one does not name its schema or does not follow it.
#[track_caller]
pub(crate) fn check_output(stdout: &[u8]) {
    let text = String::from_utf8_lossy(stdout);
    // A program that was killed may leave half a document.
    for document in Deserializer::from_str(&text).into_iter::<Value>().flatten() {
        match &document {
            Value::Array(all) => all.iter().for_each(check),
            one => check(one),
        }
    }
}

/// Checks a document.
///
/// # Panics
///
/// If it does not name its schema or does not follow it.
#[track_caller]
pub fn check(document: &Value) {
    static KNOWN: Mutex<BTreeMap<String, Validator>> = Mutex::new(BTreeMap::new());
    let Some(id) = document["schema"].as_str() else {
        panic!("no schema is named in {document:#}");
    };
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let validator = known.entry(id.to_owned()).or_insert_with(|| schema(id));
    let wrong: Vec<String> = validator
        .iter_errors(document)
        .map(|error| format!("{}: {error}", error.instance_path()))
        .collect();
    drop(known);
    assert!(wrong.is_empty(), "{id}: {wrong:#?}");
}

/// Schema of this id, as the program prints it.
fn schema(id: &str) -> Validator {
    let output = calot().args(["schema", id]).output();
    let output = output.expect("calot schema runs");
    let text = String::from_utf8_lossy(&output.stdout);
    let schema: Value = serde_json::from_str(&text)
        .unwrap_or_else(|error| panic!("calot schema {id}: {error}: {text}"));
    jsonschema::validator_for(&schema).unwrap_or_else(|error| panic!("{id}: {error}"))
}

/// True for a command whose standard output is documents.
pub(crate) fn is_asked_for(command: &Command) -> bool {
    let program = std::path::Path::new(command.get_program());
    program.file_name().is_some_and(|it| it == "calot")
        && command.get_args().any(|it| it == "--json")
}
