//! Measures friction, inertia, damping, delay and the stiffness limit of a haptic device, and
//! compares them with what the device declares.
//!
//! ```text
//! measure()  nobody holds the handle
//!   hold      a soft spring finds the force that carries the handle's weight
//!   friction  a force grows until the handle breaks away: friction, bias, rough mass, direction
//!   excite    a chirp, and pushes after which the handle runs out (coasts freely)
//! Records::analyse()
//!   fit       mass, damping, friction, bias and delay from positions, by least squares
//! wall()     a person presses a virtual wall that stiffens until it buzzes
//! ```
//!
//! Along the opening of a handle the same experiments are made, after a slow movement to both ends.
//!
//! The caller passes the clock ([`Clock`]): the command waits for real milliseconds, tests simulate
//! them. Every force passes through `bench`, which limits the force and ends the experiment when
//! the handle leaves its place.
//!
//! A delay is the time from a command to the sample that shows the command's effect, as a loop of 1
//! kHz sees both. The delay does not include the time for which a device holds the force of a
//! command.
//!
//! The stiffness `K` up to which a device of damping `b` is stable follows from `b = K (T/2 +
//! delay)` (Colgate and Schenkel 1997, with delay). Dry friction allows more stiffness (Diolaiti et
//! al. 2006), but only for small movements. So it is counted as the damping that has the same
//! effect on a tremor.

mod along;
mod analyse;
mod axis;
mod bench;
mod buzz;
mod curve;
mod echo;
mod excite;
mod fit;
mod friction;
mod given;
mod guard;
mod halt;
mod hold;
mod limits;
mod measure;
mod model;
mod opened;
mod opening;
mod place;
mod result;
mod wall;

pub use along::{Axis, Estimate, TREMOR_M_S, Trace, rendered_n_m};
pub use bench::Clock;
pub use buzz::SWING_M;
pub use echo::echo_s;
pub use halt::Halt;
pub use limits::FORCE_N;
pub use measure::{Options, Records, measure};
pub use opened::Opened;
pub use place::Place;
pub use result::Characterised;
pub use wall::{STIFFEST_N_M, Trial, Wall, wall};

#[cfg(test)]
mod tests;
