//! `calot store list`: all trainees, or the sessions of one.

use store::{Hand, SessionRecord, Store, StoreError, Trainee};

use crate::args::StoreFile;
use crate::document;
use crate::problem::Problem;
use crate::report::utc;
use crate::say;

/// Prints the trainees, or the sessions of the trainee `name`.
pub(super) fn run(file: &StoreFile, name: Option<&str>, json: bool) -> Result<(), Problem> {
    let store = match name {
        None => file.read_if_any()?,
        Some(_) => Some(file.read()?),
    };
    let (Some(name), Some(store)) = (name, &store) else {
        let people = store.map_or_else(|| Ok(Vec::new()), |it| it.trainees())?;
        return trainees(people, json);
    };
    let sessions = store.sessions(name, None)?;
    if json {
        document::SESSION.array(sessions)?;
        return Ok(());
    }
    for it in &sessions {
        say::answer(line(store, it)?);
    }
    if let Some(last) = sessions.iter().rfind(|it| it.file.is_some()) {
        say::note(next_steps(&last.id));
    }
    Ok(())
}

fn trainees(people: Vec<Trainee>, json: bool) -> Result<(), Problem> {
    if json {
        document::TRAINEE.array(people)?;
        return Ok(());
    }
    if people.is_empty() {
        say::note("no trainee yet: `calot run --task clamp --trainee NAME` adds a session");
    }
    people.iter().for_each(|it| say::answer(row(it)));
    Ok(())
}

/// Line of a trainee, with the number of sessions.
fn row(person: &Trainee) -> String {
    let cohort = match person.cohort.as_str() {
        "" => String::new(),
        cohort => format!("  ({cohort})"),
    };
    let unit = match person.sessions {
        1 => "session ",
        _ => "sessions",
    };
    format!("{:>5} {unit}  {}{cohort}", person.sessions, person.name)
}

fn line(store: &Store, it: &SessionRecord) -> Result<String, StoreError> {
    let when = utc(u64::try_from(it.began_unix_s).unwrap_or(0));
    let points = store.sheet(&it.id)?;
    let goals: u32 = points.iter().map(|(_, it)| u32::from(*it)).sum();
    let goals = match goals {
        0 => String::new(),
        goals => format!("  GOALS {goals}"),
    };
    let hand = match it.hand {
        Hand::Scripted => "  by a scripted hand",
        Hand::Person => "",
    };
    let hand = match it.circumstances.realtime {
        Some(false) => format!("{hand}, not realtime"),
        _ => hand.to_owned(),
    };
    Ok(format!(
        "{}  {when}  {:<10} {:<9} {:<9} {:>3.0} of 100, {} alarms{goals}{hand}",
        it.id, it.task, it.difficulty, it.outcome, it.score, it.alarms
    ))
}

/// Commands that take the id of a session.
fn next_steps(id: &str) -> String {
    format!(
        "`calot replay {id} --show` shows a session, `calot report {id}` writes its debrief, `calot store sheet {id}` \
         takes an instructor's points"
    )
}

#[cfg(test)]
mod tests {
    use store::Consent;

    use super::*;

    #[test]
    fn a_trainee_s_line_says_of_what_its_number_is() {
        let person = |sessions| Trainee {
            name: "Dr. Lea Mueller".to_owned(),
            sessions,
            cohort: String::new(),
            consent: Consent::Unknown,
            person: String::new(),
        };
        assert_eq!(row(&person(3)), "    3 sessions  Dr. Lea Mueller");
        assert_eq!(row(&person(1)), "    1 session   Dr. Lea Mueller");
    }

    #[test]
    fn a_list_names_the_commands_that_take_its_ids() {
        let words = next_steps("01a2");
        for command in ["replay 01a2 --show", "report 01a2", "store sheet 01a2"] {
            assert!(words.contains(command), "{words}");
        }
    }
}
