//! A session on disk: an MCAP file that other programs open, and that `calot replay` runs again.
//!
//! ```text
//! shared memory ─► Listening (thread, 10 ms) ─► bounded queue ─► Recording (thread) ─► FILE.mcap
//!                                                               a chunk a second
//! ```
//!
//! | topic | encoding | what | how often |
//! |---|---|---|---|
//! | `/setup` | `x-calot` | [`shared_mem::inputs::RunSetup`] as it lies in memory | once |
//! | `/inputs` | `x-calot` | what each tick took in, and its hashes, packed ([`pack`]) | every tick |
//! | `/course` | `x-calot` | where both hands are, and raw events ([`Entry`]): what assessment reads | 100 Hz |
//! | `/tf` | JSON | poses, `foxglove.FrameTransforms` | 20 Hz |
//! | `/tool` | JSON | force, jaw, contacts, switches | 20 Hz |
//! | `/events` | JSON | contact, grasp, tear, fault, … | as they come |
//! | `/timing` | JSON | ticks, misses, slowest tick | every second |
//! | `/gaps` | JSON | ticks or events that are missing | where they are |
//!
//! An orderly end is metadata `calot.end`: ticks that ran, as the controller said at its own end, and ticks
//! and events that are missing.
//!
//! Times are of the wall clock; host times are [`Info::wall_from_host_ns`] behind it. The compiled
//! scene is attached: prepared again, by another version, it would be another. The file holds
//! nothing of a person.

mod course;
mod describe;
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
pub use file::{Error, FILE_VERSION};
pub use health::{Health, Recorded, Standing};
pub use info::{Assignment, Finish, Info, hex, printable};
pub use operation::Operation;
pub use read::{End, ReadError, Session};
pub use record::{Config, Listening, Recording, Sight};
pub use storage::{Storage, create_private, is_being_recorded};

#[cfg(test)]
mod tests;
