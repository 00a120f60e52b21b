//! Scoring sheets: their forms, and filling them in the terminal.

use std::io::{BufRead as _, Write as _};

use store::{Sheet, SheetItem, Store, StoreError, rater_in_words};

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

/// A sheet to store.
pub(super) struct Filled<'a> {
    pub(super) session: &'a str,
    pub(super) form: &'a Sheet,
    /// Name, and true if the rater did not know who operated.
    pub(super) rater: (&'a str, bool),
    /// If they are empty, the terminal asks for them.
    pub(super) points: &'a [u8],
}

impl Filled<'_> {
    /// Stores the sheet; asks for the points if none are given. With `replaces`, it replaces an
    /// earlier sheet by the same rater.
    pub(super) fn store(
        &self,
        file: &StoreFile,
        new: NewRater,
        replaces: bool,
    ) -> Result<(), Problem> {
        let Self {
            session,
            form,
            rater,
            ..
        } = *self;
        // Before any question, refuse a session that does not exist, a rater's name that looks like
        // another's, and a second sheet.
        let store = file.read()?;
        store.ratings(session)?;
        new.confirm(&store, rater.0)?;
        if let Some(old) = store.rated(session, form, rater.0)?
            && !replaces
        {
            return Err(StoreError::from(old).into());
        }
        drop(store);
        let points = match self.points.is_empty() {
            true => ask(form)?,
            false => self.points.to_vec(),
        };
        let mut store = file.open()?;
        let sum: u32 = points.iter().map(|it| u32::from(*it)).sum();
        let total = form.total();
        let old = match replaces {
            true => store.rate_again(session, form, rater, &points)?,
            false => {
                store.rate(session, form, rater, &points)?;
                None
            }
        };
        say::note(format_args!("{sum} of {total}"));
        if let Some(old) = old {
            let blinded = if old.blinded { "blinded " } else { "" };
            say::note(format_args!(
                "replaced the {blinded}sheet '{}' of {} for session '{session}': {} of {total}",
                old.sheet,
                rater_in_words(&old.rater),
                old.sum()
            ));
        }
        Ok(())
    }
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
