//! From contact forces to the force at the handle, and its limits.
//!
//! # Force at the handle
//!
//! The contacts' wrench about the port goes through the lever to the handle. The port is a fulcrum:
//! with handle position `h`, port `p` and shaft length `L`, `d = unit(p − h)` and the tip is `h + L
//! d`. The stiffness at the handle is that in its stiffest direction, `tr(M⁸)^⅛`, which is never
//! too low and at most 15 % too high. A step in one contact's stiffness is a step there and no
//! larger.
//!
//! # Proxy
//!
//! A device's force ends at its limit. A hand that goes on would carry the instrument through
//! organs with forces that it does not feel. So the instrument follows a handle that yields from
//! the hand's by as much as keeps the tissue's force at what the hand feels (a god-object, Zilles
//! and Salisbury 1995, on a spring that bears the device's limit and no more). Contact and picture
//! use this proxy pose. Below the limit the proxy pose is the device pose.
//!
//! # Transition
//!
//! A command or jaws may end a force: a pause, another instrument, letting go, a reset. The missing
//! force then fades in 20 ms.
//!
//! # The safety chain
//!
//! Force leaves by one function, `OutputLimit::apply`, through gates in one order. Each has a
//! counter that the timing, the panel and `summary.json` carry.
//!
//! 1. Cut at once: speed trip (1.2 m/s, latches), a force that is no number, not enabled by a
//! person, a lost port.
//! 2. Ramp: up after every enable, down in 20 ms where the pose is stale or the simulation paused.
//! 3. Stiffness: `b = K (T/2 + delay)` says at which stiffness `K` a loop of that damping `b` and
//! delay begins to swing (Colgate and    Schenkel 1997, with delay); 0.7 of it is rendered. Then
//! passivity, whose damping is the device's at most.
//! 4. Clamp: the peak or, as the motors warm, down to the continuous force.
//! 5. Slew: 1 N a tick. Then once more: is all of it a number?
//!
//! The ramp stands before passivity, because damping that takes energy out must not fade with it.
//! It stands before clamp and slew, which therefore bound everything that leaves. `motion_scale`
//! lies behind the chain: slew and speed trip count in the simulation's lengths, so that scale is
//! 0.5 to 2.
//!
//! # Passivity
//!
//! A contact may give the hand back what the hand put in, no more (Hannaford and Ryu 2002, in the
//! time domain). The observer adds up the work that hand and device exchange with the rendered
//! force, exactly for the force that acted in each period, which was sent `delay` before. The
//! device's own damping counts as well. Where the sum falls below zero, the loop makes energy, and
//! the controller takes it out again by damping. Energy that tissue dissipated must not hide energy
//! that the loop makes, so the sum never stands above what the present force could give back on its
//! way to where it began. Without contact it is set to zero.

pub(crate) mod handle_force;
pub mod output_limit;
pub(crate) mod passivity;
pub(crate) mod proxy;
pub(crate) mod transition;
