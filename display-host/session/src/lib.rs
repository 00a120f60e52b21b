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
//! | `/course` | `x-calot` | positions of both hands, raw events ([`Entry`]), for assessment | 100 Hz |
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
