//! Scripted surgeons: each performs a task of the operation, for tests and demonstrations. They see
//! what a display sees, move the emulated hand as mouse and keyboard do, and watch the result.
//!
//! ```text
//! Theatre ─ state, tools, events ─► Sight ─► Work (a plan's acts) ─ HandMsg ─► Theatre
//! ```
//!
//! A [`Theatre`] is either the station's processes in real time or the simulation alone, faster.

mod critical;
mod dissect;
mod field;
mod flaw;
mod gentle;
mod hang;
mod hold;
mod jaws;
mod look;
mod nearing;
mod plan;
mod scope;
mod sight;
mod stones;
mod vector;
mod work;

use shared_mem::message::{CommandMsg, EventMsg, HandMsg, StateFrame, ToolFrame};

pub use plan::Surgeon;
pub use work::operate;

/// Everything a surgeon sees at one moment.
#[derive(Debug)]
pub struct Seen {
    /// Time of the theatre, s.
    pub at_s: f64,
    /// Latest frame of the organs.
    pub state: Box<StateFrame>,
    /// Latest frame of the instrument.
    pub tools: Box<ToolFrame>,
    /// Events since the previous look.
    pub events: Vec<EventMsg>,
}

impl Seen {
    /// The view before the first frame.
    #[must_use]
    pub fn nothing() -> Self {
        Self {
            at_s: 0.0,
            state: bytemuck::zeroed_box(),
            tools: bytemuck::zeroed_box(),
            events: Vec::new(),
        }
    }
}

/// The place of an operation: a station, or the simulation alone.
pub trait Theatre {
    /// Passes the request to the hand, lets a few milliseconds pass and looks. Returns `false` once
    /// the operation is over.
    fn look(&mut self, asked: &HandMsg, seen: &mut Seen) -> bool;

    /// Sends a command to the controller.
    ///
    /// # Errors
    /// The reason why it could not be sent.
    fn command(&mut self, command: CommandMsg) -> Result<(), String>;

    /// Looks through an endoscope whose view lies so to its shaft: the angle between the two, and
    /// the view's turn about the shaft (0: down), rad. Returns `false`, and changes nothing, if the
    /// surgeon cannot choose the endoscope here, as at a station.
    fn look_off(&mut self, sight_rad: [f32; 2]) -> bool {
        let _ = sight_rad;
        false
    }

    /// Receives the surgeon's words, such as the reason for leaving a step undone.
    fn tell(&mut self, what: &str);
}
