//! Finds the line on which a key of the recipe stands.

use toml::de::{DeTable, DeValue};

/// One step of a key's path.
#[derive(Debug, Clone, Copy)]
pub(super) enum Step<'a> {
    Key(&'a str),
    Index(usize),
}

/// Line, from 1, of the value at the path. If the text does not have this value, the line of its
/// nearest parent in the text.
pub(super) fn line_of_path(text: &str, path: &[Step<'_>]) -> usize {
    let Ok(document) = DeTable::parse(text) else {
        return 1;
    };
    let mut at = document.span().start;
    let mut value: Option<&DeValue<'_>> = None;
    for step in path {
        let next = match (step, value) {
            (Step::Key(key), None) => document.get_ref().get(*key),
            (Step::Key(key), Some(DeValue::Table(table))) => table.get(*key),
            (Step::Index(index), Some(DeValue::Array(array))) => array.get(*index),
            _ => None,
        };
        let Some(next) = next else { break };
        at = next.span().start;
        value = Some(next.get_ref());
    }
    line_of_offset(text, at)
}

/// Line, from 1, of a byte offset.
pub(super) fn line_of_offset(text: &str, offset: usize) -> usize {
    let end = offset.min(text.len());
    1 + text.as_bytes()[..end]
        .iter()
        .filter(|&&b| b == b'\n')
        .count()
}
