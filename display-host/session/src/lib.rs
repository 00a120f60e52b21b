//! A session on disk: an MCAP file that other programs open, and that `calot replay` runs again.
//!
//! ```text
//! shared memory ─► Listening (thread, 10 ms) ─► bounded queue ─► Recording (thread) ─► FILE.mcap
//!                                                               a chunk a second
//! ```
//!
//! | topic | encoding | content | rate |
//! |---|---|---|---|
//! | `/setup` | `x-calot` | [`shared_mem::inputs::RunSetup`] as laid out in memory | once |
//! | `/inputs` | `x-calot` | inputs of each tick and its hashes, packed ([`pack`]) | every tick |
//! | `/course` | `x-calot` | both hands and raw events ([`Entry`]), for assessment | 100 Hz |
//! | `/tf` | JSON | poses, `foxglove.FrameTransforms` | 20 Hz |
//! | `/tool` | JSON | force, jaw, contacts, switches | 20 Hz |
//! | `/events` | JSON | contact, grasp, tear, fault, … | each one |
//! | `/timing` | JSON | ticks, misses, slowest tick | every second |
//! | `/gaps` | JSON | missing ticks or events | at each gap |
//!
//! A proper end is the metadata `calot.end`: the number of ticks that ran, as the controller
//! reported it, and the missing ticks and events.
//!
//! Times are wall-clock times; host times are [`Info::wall_from_host_ns`] behind. The compiled
//! scene is attached, because another version would prepare a different one. The file holds no
//! personal data.
//!
//! # Recording and replay
//!
//! `calot run` records with `--out` or `--record`. One thread listens from before the controller's
//! start; another writes MCAP, a chunk a second. The tick puts its record into a queue, and a full
//! queue is a counted gap. The disk can hold up neither: what it refuses waits, 16 MB at most. Then
//! the file ends, whole up to there.
//!
//! Beside the inputs stands the course of the operation (`course`): where both hands are, 100 times
//! a second, and the events. An assessment is made from it alone. Inputs are packed to 62 to 82
//! bytes a tick, so there is no compression, and no C code. The compiled scene is attached:
//! prepared again by another version it would be another one.
//!
//! A replay ends at the first missing tick and where the file is damaged, and fails. A file that is
//! only cut at its end does not fail it: a kill leaves such a file. The controller's last batch
//! says how many ticks ran (`InputBatch::ran`), so ticks that are missing at the end are known;
//! without that batch, replay says that more may have followed. `--what-if` and `--show` end at the
//! same places, with a warning. In `--what-if` the hand moves as it was recorded and does not feel
//! the other force.
//!
//! `--show` takes the controller's place at a station, so that any display shows a session. It
//! keeps up to 128 checkpoints, further apart the longer the session is; any earlier moment is run
//! again from one of them, bit for bit. Of what flies and lies on the skin only leaks are told
//! again after such a jump, each as it is then.

mod course;
mod describe;
mod error;
mod file;
mod health;
mod info;
mod opened;
mod operation;
pub mod pack;
mod read;
mod record;
mod records;
mod storage;

pub use course::{Entry, Movement, What};
pub use error::ReadError;
pub use file::{Error, FILE_VERSION};
pub use health::{Health, Recorded, Standing};
pub use info::{Assignment, Finish, Info, hex, printable};
pub use operation::Operation;
pub use read::Session;
pub use record::{Config, Listening, Recording, Sight, check_target};
pub use records::End;
pub use storage::{Storage, create_private, is_being_recorded};

#[cfg(test)]
mod tests;
