//! `calot store push`: results to a centre.

use std::process::ExitCode;

use deliver::{Destination, Pushed, push};

use super::args::PushArgs;
use crate::args::StoreFile;
use crate::document;
use crate::problem::Problem;
use crate::say;

pub(super) fn run(file: &StoreFile, args: &PushArgs) -> Result<ExitCode, Problem> {
    let variable = |name: &str| std::env::var(name).ok();
    let ca = args.ca.as_deref();
    let to = match (&args.to, &args.to_file) {
        (_, Some(path)) => Destination::from_file(path, ca, &variable)?,
        (address, None) => {
            let address = address.as_deref().unwrap_or_default();
            Destination::shown(address, ca, &variable)?
        }
    };
    // Fail if there is no store, instead of making one.
    drop(file.read()?);
    let pushed = push(&mut file.open()?, &to)?;
    if args.json {
        document::PUSHED.line(&pushed)?;
    } else {
        tell(&pushed);
    }
    if let Some(problem) = &pushed.problem {
        say::note(problem);
    }
    Ok(match pushed.waiting {
        0 => ExitCode::SUCCESS,
        _ => ExitCode::FAILURE,
    })
}

fn tell(pushed: &Pushed) {
    let to = &pushed.to;
    say::note(format_args!(
        "{to}: {} sessions sent, {} were there already",
        pushed.sent, pushed.known
    ));
    if pushed.withdrawn > 0 {
        say::note(format_args!(
            "{} forgotten people are forgotten there, too",
            pushed.withdrawn
        ));
    }
    if pushed.left_out > 0 {
        say::note(format_args!(
            "{} sessions of scripted hands are left out",
            pushed.left_out
        ));
    }
    for name in &pushed.forgotten_there {
        say::note(format_args!(
            "'{name}' was forgotten at the centre and is still in this store; `calot store forget` forgets here, too"
        ));
    }
    for session in &pushed.differing {
        say::note(format_args!(
            "session {session} is there with other contents, which stay"
        ));
    }
    for it in &pushed.refused {
        say::note(format_args!(
            "session {} is refused: {}",
            it.session, it.problem
        ));
    }
    for centre in &pushed.owed_elsewhere {
        say::note(format_args!(
            "{centre} still has to forget somebody; `calot store push` to that address tells it"
        ));
    }
    if pushed.waiting > 0 {
        say::note(format_args!("{} wait in the store", pushed.waiting));
    }
}
