//! Haptics: from contact forces to the force at the handle, and its limits.
//!
//! # Force at the handle
//!
//! The shaft is a lever about the port (trocar). It transmits the contacts' wrench about the port
//! to the handle. With handle position `h`, port `p` and shaft length `L`, `d = unit(p − h)` and
//! the tip is `h + L d`. The stiffness at the handle is that of the stiffest direction. It is
//! computed from the stiffness matrix M as `tr(M⁸)^⅛`, which is never too low and at most 15 % too
//! high.
//!
//! # Proxy
//!
//! A device's force is limited. A hand that pushed on beyond the limit would drive the instrument
//! through organs with forces that it does not feel. So beyond the limit the instrument follows a
//! virtual handle. The virtual handle is displaced from the real handle just so far that the
//! tissue's force stays at the limit (a god-object, Zilles and Salisbury 1995, on a spring that
//! yields at the limit). Contact and picture use this proxy pose. While the force is below the
//! limit, the proxy pose is the device pose.
//!
//! # Trocar
//!
//! If the scene or the station asks for it, the seal rubs on the shaft and the abdominal wall
//! resists tilting (`trocar`). The trocar's force does not move the proxy, and does not count as
//! force of tissue.
//!
//! # Opening
//!
//! Jaws follow a handle that opens and shuts, through a spring of the device's stiffness. The
//! fingers feel the tissue that the jaws squeeze or the scissors cut (`procedure::opening`).
//!
//! # Transition
//!
//! Some actions end a force in one tick: a pause, a change of the instrument, jaws that open, a
//! reset. At the handle, the lost part of the force then fades within 20 ms.
//!
//! # Safety chain
//!
//! Force leaves by one function, `OutputLimit::apply`, which passes it through gates in a fixed
//! order. The faults of the gates are counted; the timing, the panel and `summary.json` report
//! them.
//!
//! 1. Cut to zero at once: after a speed trip (above 1.2 m/s; it latches), if the force is not
//!    finite, if no person has enabled the force, or if the device is lost or reports a fault.
//! 2. Ramp: the force rises after every enable. It falls within 20 ms while the pose is stale or
//!    the simulation is paused.
//! 3. Stiffness: a loop with damping `b` begins to oscillate at the stiffness `K = b / (T/2 +
//!    delay)` (Colgate and Schenkel 1997, with delay). At most 0.7 K is rendered. Then passivity
//!    control adds damping, at most as much as the device renders.
//! 4. Clamp: to the peak force. As the motors warm, the limit falls to the continuous force.
//! 5. Slew: 1 N a tick. Then a last test for finite values.
//!
//! The ramp precedes passivity, because damping that removes energy must not fade with the ramp.
//! Clamp and slew come last, so they bound everything that leaves. `motion_scale` (simulated motion
//! of the handle divided by real motion) is applied between this chain and the device. So slew and
//! speed trip count simulated forces and speeds, and the scale is restricted to 0.5 to 2.
//!
//! # Passivity
//!
//! A contact may return to the hand at most the energy that the hand put in (Hannaford and Ryu
//! 2002, in the time domain). The observer sums the work that the hand does against the rendered
//! force. For each period it uses the force that acted then, which was sent `delay` earlier. The
//! energy that the device's own damping absorbs is added. If the sum is below zero, the loop has
//! generated energy, and the controller dissipates that energy by damping. Energy that tissue has
//! dissipated must not hide energy that the loop generates. So the sum is limited to the work that
//! the present force would do on the way back to the place where contact began. After 100 ms
//! without contact the sum is set to zero.

pub(crate) mod handle_force;
pub mod output_limit;
pub(crate) mod passivity;
pub(crate) mod proxy;
pub(crate) mod transition;
pub(crate) mod trocar;
