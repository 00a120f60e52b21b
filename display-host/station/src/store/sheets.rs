//! Scoring sheets: their forms, and filling them in the terminal.

use std::io::{BufRead as _, Write as _};

use store::{Sheet, SheetItem, Store};

use crate::args::{NewRater, StoreFile};
use crate::document;
use crate::problem::Problem;
use crate::say;

/// Prints the built-in forms with their anchors.
pub(super) fn forms(json: bool) -> Result<(), Problem> {
    let all = Sheet::built_in();
    if json {
        return document::FORM.array(all);
    }
    for sheet in &all {
        let Sheet {
            name,
            title,
            source,
            least,
            most,
            ..
        } = sheet;
        say::answer(format_args!(
            "{name}: {title} ({source}), each {least} to {most}"
        ));
        for item in &sheet.items {
            say::answer(format_args!("  {}", item.text));
            for line in anchors(item) {
                say::answer(format_args!("    {line}"));
            }
        }
    }
    Ok(())
}

fn anchors(item: &SheetItem) -> impl Iterator<Item = String> {
    let anchors = item.anchors.iter();
    anchors.map(|(points, meaning)| format!("{points}  {meaning}"))
}

/// Prints the sheets of a session as JSON.
pub(super) fn show(store: &Store, session: &str) -> Result<(), Problem> {
    document::SHEET.array(store.ratings(session)?)
}

/// Stores a sheet; asks for the points if none are given. `rater` is the name and whether the rater
/// did not know who operated.
pub(super) fn fill(
    file: &StoreFile,
    session: &str,
    form: &Sheet,
    rater: (&str, bool),
    points: &[u8],
    new: NewRater,
) -> Result<(), Problem> {
    // Before anybody is asked, a session that is not there is refused, and a rater's name that
    // looks like another's.
    let store = file.read()?;
    store.ratings(session)?;
    new.confirm(&store, rater.0)?;
    drop(store);
    let points = match points.is_empty() {
        true => ask(form)?,
        false => points.to_vec(),
    };
    file.open()?.rate(session, form, rater, &points)?;
    let sum: u32 = points.iter().map(|it| u32::from(*it)).sum();
    say::note(format_args!("{sum} of {}", form.total()));
    Ok(())
}

/// Asks in the terminal until each item has points of the scale.
fn ask(form: &Sheet) -> Result<Vec<u8>, Problem> {
    let (least, most) = (form.least, form.most);
    say::note(format_args!(
        "{} ({}): {least} to {most}",
        form.title, form.source
    ));
    let mut lines = std::io::stdin().lock().lines();
    let mut points = Vec::new();
    for item in &form.items {
        say::note(&item.text);
        anchors(item).for_each(|line| say::note(format_args!("  {line}")));
        loop {
            let mut stderr = std::io::stderr();
            let _ = write!(stderr, "points ").and_then(|()| stderr.flush());
            let line = lines
                .next()
                .ok_or("the input ended before the last item; nothing is stored")??;
            match line.trim().parse() {
                Ok(value) if form.has(value) => {
                    points.push(value);
                    break;
                }
                _ => say::note(format_args!("please type a number from {least} to {most}")),
            }
        }
    }
    Ok(points)
}
