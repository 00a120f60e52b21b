//! Names of the messages. All messages of a station lie below its own name, so one rule gives the
//! rights of its certificate.
//!
//! | name | from → to | content |
//! |---|---|---|
//! | `calot/NAME/presence` | station → centre | a liveliness token |
//! | `calot/NAME/state` | station → centre | [`crate::state::State`], JSON |
//! | `calot/NAME/tile`, `view` | station → centre | a picture, JPEG |
//! | `calot/NAME/want` | centre → station | pictures a second that somebody watches, JSON |
//! | `calot/NAME/act` | centre → station | an act, JSON; answered |
//! | `calot/NAME/result` | station → centre | a session, or a forgetting, JSON; answered |

/// Kind of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Topic {
    /// The station is connected.
    Presence,
    /// Its state.
    State,
    /// A small picture.
    Tile,
    /// A large picture.
    View,
    /// Pictures that are wanted.
    Want,
    /// An act of an instructor.
    Act,
    /// A result for the centre's store.
    Result,
}

impl Topic {
    /// Name of this for a station.
    #[must_use]
    pub fn of(self, station: &str) -> String {
        let last = match self {
            Self::Presence => "presence",
            Self::State => "state",
            Self::Tile => "tile",
            Self::View => "view",
            Self::Want => "want",
            Self::Act => "act",
            Self::Result => "result",
        };
        format!("calot/{station}/{last}")
    }
}
