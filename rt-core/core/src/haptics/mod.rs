//! Haptics: from contact forces to the force at the handle, and its limits.
//!
//! # Force at the handle
//!
//! The lever takes the contacts' wrench about the port to the handle. With handle position `h`,
//! port `p` and shaft length `L`, `d = unit(p − h)` and the tip is `h + L d`. The stiffness at the
//! handle is that of its stiffest direction, `tr(M⁸)^⅛`, which is never too low and at most 15 %
//! too high. It changes by no more than the stiffness of a contact changes.
//!
//! # Proxy
//!
//! A device's force is limited. A hand that pushes on would drive the instrument through organs
//! with forces that it does not feel. So the instrument follows a handle that is displaced from the
//! hand, far enough to keep the tissue's force at the felt force (a god-object, Zilles and
//! Salisbury 1995, on a spring that bears the device's limit and no more). Contact and picture use
//! this proxy pose. Below the limit it is the device pose.
//!
//! # Opening
//!
//! Jaws follow a handle that opens and shuts, through a spring of the device's stiffness. The
//! fingers feel the squeezed tissue, and scissors feel the cut (`procedure::opening`).
//!
//! # Transition
//!
//! A decision may end a force: a pause, another instrument, opening jaws, a reset. The missing part
//! of the force then fades in 20 ms.
//!
//! # Safety chain
//!
//! Force leaves by one function, `OutputLimit::apply`, through gates in a fixed order. Each has a
//! counter that the timing, the panel and `summary.json` report.
//!
//! 1. Cut at once: speed trip (1.2 m/s, latches), a force that is not finite, not enabled by a
//!    person, a lost port.
//! 2. Ramp: up after every enable, down in 20 ms while the pose is stale or the simulation paused.
//! 3. Stiffness: a loop of damping `b` begins to oscillate at the stiffness `K` of `b = K (T/2 +
//!    delay)` (Colgate and Schenkel 1997, with delay); 0.7 of it is rendered. Then passivity, with
//!    at most the damping that the device renders.
//! 4. Clamp: the peak or, as the motors warm, down to the continuous force.
//! 5. Slew: 1 N a tick. Then a last test for finite values.
//!
//! The ramp precedes passivity, because damping that takes energy out must not fade with it. It
//! precedes clamp and slew, which therefore bound everything that leaves. `motion_scale` lies
//! behind the chain: slew and speed trip count in the simulation's lengths, so that scale is 0.5 to
//! 2.
//!
//! # Passivity
//!
//! A contact may return to the hand the energy that the hand put in, no more (Hannaford and Ryu
//! 2002, in the time domain). The observer sums the work that hand and device exchange with the
//! rendered force. The sum is exact for the force that acted in each period, which was sent `delay`
//! before. The device's own damping counts as well. Where the sum falls below zero, the loop makes
//! energy, and the controller dissipates it by damping. Energy that tissue dissipated must not hide
//! energy that the loop makes, so the sum never exceeds the work that the present force could do on
//! the way back to where contact began. Without contact it is set to zero.

pub(crate) mod handle_force;
pub mod output_limit;
pub(crate) mod passivity;
pub(crate) mod proxy;
pub(crate) mod transition;
