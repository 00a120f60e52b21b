//! Refused requests, explained in the user's language.

use shared_mem::message::{CommandMsg, ReplyMsg};
use shared_mem::service::ServiceError;

use crate::words::Words;

/// Reason why a request was not carried out.
#[derive(Debug)]
pub(super) enum Refusal {
    /// The controller refused a command with this answer.
    Answer { command: CommandMsg, answer: u32 },
    /// A command did not reach the controller, or was not answered.
    Command {
        command: CommandMsg,
        error: ServiceError,
    },
    /// The service of the emulated hand cannot be opened.
    Hand(ServiceError),
    /// No emulated hand takes the messages.
    NoHand,
}

impl Refusal {
    /// Text for the user.
    pub(super) fn said(&self, words: &Words) -> String {
        match self {
            Self::Answer { command, answer } => {
                let why = match *answer {
                    ReplyMsg::UNKNOWN => words.say("refused-unknown"),
                    ReplyMsg::OUT_OF_RANGE => words.say("refused-range"),
                    ReplyMsg::BUSY => words.say("refused-busy"),
                    other => {
                        let answer = other.to_string().into();
                        words.say_with("refused-otherwise", &[("answer", answer)])
                    }
                };
                not_done(words, *command, why)
            }
            Self::Command { command, error } => not_done(words, *command, service(words, error)),
            Self::Hand(error) => service(words, error),
            Self::NoHand => words.say("hand-nobody"),
        }
    }
}

fn not_done(words: &Words, command: CommandMsg, why: String) -> String {
    let what = match command.kind {
        CommandMsg::PAUSE => "command-pause",
        CommandMsg::START => "command-start",
        CommandMsg::RESET => "command-reset",
        CommandMsg::ENABLE_FORCE => "command-force",
        CommandMsg::INSTRUMENT => "command-instrument",
        CommandMsg::SEEK => "command-seek",
        CommandMsg::SPEED => "command-speed",
        _ => "command-other",
    };
    let values = [("what", words.say(what).into()), ("why", why.into())];
    words.say_with("command-not-done", &values)
}

/// Text of a service's error. Errors of the computer itself stay in English: they are rare, and
/// concern its administrator.
fn service(words: &Words, error: &ServiceError) -> String {
    match error {
        ServiceError::SecondHand(_) => words.say("hand-elsewhere"),
        ServiceError::OtherVersion { .. } => words.say("service-other-version"),
        ServiceError::NoAnswer { .. } => words.say("service-no-answer"),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::Language;

    #[test]
    fn every_refusal_is_said_in_every_language() {
        let station = || "here".to_owned();
        let commands = [
            CommandMsg::PAUSE,
            CommandMsg::START,
            CommandMsg::RESET,
            CommandMsg::ENABLE_FORCE,
            CommandMsg::INSTRUMENT,
            CommandMsg::SEEK,
            CommandMsg::SPEED,
            u32::MAX,
        ];
        let answers = [
            ReplyMsg::UNKNOWN,
            ReplyMsg::OUT_OF_RANGE,
            ReplyMsg::BUSY,
            77,
        ];
        let refused = commands.into_iter().flat_map(|kind| {
            let command = CommandMsg { kind, argument: 0 };
            answers.map(|answer| Refusal::Answer { command, answer })
        });
        let unheard = Refusal::Command {
            command: CommandMsg {
                kind: CommandMsg::PAUSE,
                argument: 1,
            },
            error: ServiceError::NoAnswer {
                station: station(),
                waited_ms: 500,
            },
        };
        let hand = Refusal::Hand(ServiceError::SecondHand(station()));
        let all = refused.chain([unheard, hand, Refusal::NoHand]);
        let (english, german) = (Words::default(), Words::new(Language::German));
        for refusal in all {
            let said = [&english, &german].map(|words| refusal.said(words));
            assert_ne!(said[0], said[1]);
            for id in ["refused-", "command-", "hand-", "service-"] {
                assert!(said.iter().all(|it| !it.contains(id)), "{said:?}");
            }
        }
    }
}
