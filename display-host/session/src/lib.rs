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
//! | `/tf` | protobuf | poses, `foxglove.FrameTransforms` | 20 Hz |
//! | `/tip` | protobuf | the instrument's tip, `foxglove.PoseInFrame` | 20 Hz |
//! | `/tool` | protobuf | force, tip, jaw, contacts, switches, `calot.Tool` | 100 Hz |
//! | `/events` | protobuf | contact, grasp, tear, fault, …, `calot.Event` | each event |
//! | `/log` | protobuf | events in words, `foxglove.Log` | each event |
//! | `/stages` | protobuf | times of each tick and stage, `calot.Stages` | every tick |
//! | `/timing` | protobuf | ticks, misses, slowest tick, `calot.Timing` | every second |
//! | `/gaps` | protobuf | missing ticks or events, `calot.Gap` | at each gap |
//!
//! Each protobuf channel embeds its description; `proto/calot.proto` has Calot's with comments.
//! Messages of a channel are in the order of their times: an event that arrives after a younger
//! pose has the pose's stamp in `/course`, and its own time inside.
//!
//! A properly ended session has the metadata `calot.end`: the number of ticks that ran, as the
//! controller reported it, and the number of missing ticks and events.
//!
//! Times are wall-clock times: host time plus [`Info::wall_from_host_ns`]. The compiled scene is
//! attached, because another version of Calot would compile the scene differently. The file holds
//! no personal data.
//!
//! # Recording
//!
//! `calot run` records with `--out` or `--record`. One thread listens to the station from before
//! the controller's start. Another thread writes MCAP, a chunk a second. The controller puts the
//! record of each tick into a queue; a full queue leaves a gap, which is counted. A slow or full
//! disk delays neither the controller nor the listening thread: the bytes wait in memory, 16 MB at
//! most. If more would wait, the file ends, and is readable up to that point.
//!
//! The file also holds the course of the operation (`course`), from which alone an assessment is
//! made. Inputs are packed to 51 to 83 bytes a tick, so the file needs no compression, and the
//! program no C library for it. The times of a tick add about 30 bytes.
//!
//! # Replay
//!
//! A replay ends at the first missing tick, or at the first damage of the file, and reports a
//! failure. A file that is only cut off at its end is no failure, because a killed recorder leaves
//! such a file. The controller's last batch says how many ticks ran (`InputBatch::ran`), which
//! reveals missing ticks at the end. Without that batch, the replay says that more ticks may have
//! followed. `--what-if` and `--show` end at the same places, with a warning. With `--what-if` the
//! hand moves as it was recorded and does not react to the changed force.
//!
//! `--show` acts as the controller of a station, so that any display shows the session. It keeps up
//! to 128 checkpoints, further apart in a longer session, and simulates any earlier moment again
//! from one of them, bit for bit. Displays draw fluids in the air and on the organs from events.
//! After such a jump, only the events of leaks are sent again, each leak in its present state.

mod copy;
mod course;
mod describe;
mod error;
mod file;
mod health;
pub mod identity;
mod index;
mod info;
pub mod inputs_file;
mod lost;
mod opened;
mod operation;
pub mod pack;
mod proto;
mod read;
mod record;
mod records;
mod repair;
mod salvage;
mod storage;
mod surfaces;
mod timeline;
mod times;
mod viewer;

pub use course::{Entry, EntryContent, Movement};
pub use error::ReadError;
pub use file::{Error, FILE_VERSION};
pub use health::{Health, Recorded, Standing};
pub use info::{Assignment, ENDOSCOPE_DRILL, Finish, Info, hex, printable};
pub use lost::Lost;
pub use operation::Operation;
pub use read::Session;
pub use record::{Acts, Config, Heard, Listening, Recording, Sight, check_target};
pub use records::End;
pub use repair::{Repaired, repair};
pub use storage::{Storage, create_private, is_being_recorded};
pub use surfaces::{SURFACES_BY, Surface, SurfaceFile};
pub use timeline::Times;
pub use times::TickTimes;

#[cfg(test)]
mod tests;
