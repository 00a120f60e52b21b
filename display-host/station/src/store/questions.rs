//! Asks the questionnaire in the terminal, and summarises all answers.

use std::io::{BufRead as _, Write as _};
use std::path::Path;

use store::{NOT_APPLICABLE, Questionnaire, Store};

use crate::args::{NewTrainee, StoreFile};
use crate::clock::now_unix_s;
use crate::document;
use crate::problem::Problem;
use crate::say;

/// Stores answers. Asks for them in the terminal if none are given.
pub(super) fn take(
    file: &StoreFile,
    new: NewTrainee,
    name: &str,
    questionnaire: Option<&Path>,
    answers: &[u8],
) -> Result<(), Problem> {
    let questions = questions(questionnaire)?;
    let mut store = file.open()?;
    new.confirm(&store, name)?;
    let answers = match answers.is_empty() {
        true => ask(&questions)?,
        false => answers.to_vec(),
    };
    store.answer(name, &questions, &answers, now_unix_s())?;
    say::note("thank you; `calot store answers` shows a summary of all answers");
    Ok(())
}

/// Prints a summary of all answers.
pub(super) fn summarise(
    store: &Store,
    questionnaire: Option<&Path>,
    json: bool,
) -> Result<(), Problem> {
    let questions = questions(questionnaire)?;
    let summary = store.summarise(&questions)?;
    if json {
        return document::ANSWERS.array(summary);
    }
    say::answer(format_args!(
        "{:>3}  {:<11}  {:<11}  {}",
        "n", "here", "paper", questions.title
    ));
    let pair = |mean: Option<f64>, sd: Option<f64>| match (mean, sd) {
        (Some(mean), Some(sd)) => format!("{mean:.1} ± {sd:.2}"),
        (Some(mean), None) => format!("{mean:.1}"),
        _ => "–".to_owned(),
    };
    for item in summary {
        let here = pair(item.mean, item.sd);
        let paper = item
            .paper
            .map_or("–".to_owned(), |[mean, sd]| pair(Some(mean), Some(sd)));
        say::answer(format_args!(
            "{:>3}  {here:<11}  {paper:<11}  {}",
            item.count, item.text
        ));
    }
    Ok(())
}

fn questions(path: Option<&Path>) -> Result<Questionnaire, Problem> {
    let Some(path) = path else {
        return Ok(Questionnaire::default());
    };
    Ok(Questionnaire::read(path)?)
}

/// Asks in the terminal until each answer is 0 to 5.
fn ask(questions: &Questionnaire) -> Result<Vec<u8>, Problem> {
    say::note(format_args!(
        "{}: 1 (not at all) to 5 (very), 0 if it does not apply to you",
        questions.title
    ));
    let mut lines = std::io::stdin().lock().lines();
    let mut answers = Vec::new();
    for (number, item) in questions.items.iter().enumerate() {
        let of = questions.items.len();
        loop {
            let mut stderr = std::io::stderr();
            let _ = write!(stderr, "{} of {of}  {} ", number + 1, item.text)
                .and_then(|()| stderr.flush());
            let line = lines
                .next()
                .ok_or("the input ended before the last answer; nothing is stored")??;
            match line.trim().parse() {
                Ok(answer @ NOT_APPLICABLE..=5) => {
                    answers.push(answer);
                    break;
                }
                _ => say::note("please type a number from 0 to 5"),
            }
        }
    }
    Ok(answers)
}
