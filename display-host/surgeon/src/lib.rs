//! Scripted surgeons: each works a task of the operation, for tests and demonstrations. They see what a
//! display sees, lead the emulated hand as mouse and keyboard do, and look where it went.
//!
//! ```text
//! Theatre ─ state, tools, events ─► Sight ─► Work (acts of a plan: reach, close, burn) ─ HandMsg ─► Theatre
//! ```
//!
//! A [`Theatre`] is the station's processes in real time, or the simulation alone, faster.

mod dissect;
mod field;
mod gentle;
mod hang;
mod hold;
mod jaws;
mod nearing;
mod plan;
mod sight;
mod work;

use shared_mem::message::{CommandMsg, EventMsg, HandMsg, StateFrame, ToolFrame};

pub use plan::Surgeon;
pub use work::operate;

/// What a surgeon has before the eyes.
#[derive(Debug)]
pub struct Seen {
    /// The theatre's time, s.
    pub at_s: f64,
    /// The newest frame of the organs.
    pub state: Box<StateFrame>,
    /// The newest frame of the instrument.
    pub tools: Box<ToolFrame>,
    /// What happened since the last look.
    pub events: Vec<EventMsg>,
}

impl Seen {
    /// Nothing yet.
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

/// Where a surgeon operates.
pub trait Theatre {
    /// Gives the hand what it is asked, lets a few milliseconds pass and looks. `false`: it is over.
    fn look(&mut self, asked: &HandMsg, seen: &mut Seen) -> bool;

    /// Asks the controller for something.
    ///
    /// # Errors
    /// Why it could not be asked.
    fn command(&mut self, command: CommandMsg) -> Result<(), String>;

    /// The surgeon says why something was not done.
    fn tell(&mut self, what: &str);
}
