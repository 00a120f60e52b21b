//! Procedure: the surgeon's work on tissue with jaws, clips, scissors and current, and bleeding.
//!
//! # Grip
//!
//! Closed jaws hold each sphere between them by a spring of its own (XPBD). `bite` computes three
//! things: the resistance of the tissue, a neo-Hookean slab between two plates, `A G (1/λ² − λ)`;
//! the friction that it bears; and the stiffness of the tissue behind it, a half-space under a disc
//! as wide as the bite. A pull beyond the friction makes the grip slide, and the tissue keeps the
//! jaws open. A handle that opens and shuts renders the squeeze; one with a button does not.
//!
//! # Scissors
//!
//! Closing blades damage the links of tubes, bands and sutures by as much as they close on them,
//! from the moment at which the gap is as narrow as the link is thick. The arm does not feel the
//! cutting force, which is in balance between the blades. It feels that the severed tissue no
//! longer pulls. Fingers in a handle that opens and shuts feel the cut.
//!
//! # Current
//!
//! The hook is bare at its bent end only. First the contact areas of everything touched are summed,
//! in m². Then each takes its dose of the tick's energy, in J/m². The generator gives 30 W, of
//! which half becomes heat at the tip: of the resistance around a small ball in tissue, `(1/a −
//! 1/r) / 4πσ`, half lies within one radius. A cutting current divides tissue with 0.9 of the heat,
//! a coagulating one with 0.15; the rest desiccates the tissue around. Both shares are assumed.
//! Heating tissue from 37 to 100 °C and boiling its water takes `1060 kg/m³ (3600 J/kg K · 63 K +
//! 0.75 · 2.26 MJ/kg)`. The damage of a link grows by its energy over the energy that boils it
//! through, across the electrode's width. Walls are burnt through place by place. Current without
//! contact burns nothing.
//!
//! # Clips
//!
//! A clip closes the tubes between the applier's jaws, which hold the tubes from the moment they
//! begin to close. It closes them as far as the jaws reach over them. A tube that is squeezed flat
//! is half its circumference wide, and the part of it beyond the clip stays open. A clip stays on
//! its link, which is stiff and thin there.
//!
//! # Vessels
//!
//! The pressure of blood spreads from the held spheres of a vessel and from attached vessels, that
//! of bile from a full gallbladder and from the liver. It spreads along intact links, and through
//! clips and desiccated walls as far as they leave the lumen open. It does so only after a change,
//! and by one link a tick, so that its cost is bounded. Then every divided end and every hole leaks
//! what reaches it. All events of one leak carry the place where it began. A divided artery
//! shortens by a tenth, because vessels lie stretched in the body (10.1007/s00414-011-0549-9); a
//! duct by half of that, which is assumed. Desiccation closes arteries of up to 1.5 mm in radius.
//!
//! # Sutures
//!
//! A suture to the world that is shorter than the distance of its ends at rest (`drawn_mm` in a
//! recipe) is drawn in within two seconds. So the triangle's gallbladder is hung.
//! `Command::Start(Task::Hang)` takes the sutures down, and the trainee places them. The pedal
//! passes the needle through the tissue at the grasper's tip; pressed again, it hangs the suture on
//! the wall, in the direction in which the tip was carried.

pub(crate) mod cautery;
pub mod clip;
pub(crate) mod cut;
pub(crate) mod grasp;
pub(crate) mod journal;
pub(crate) mod opening;
pub(crate) mod unrest;
pub(crate) mod vessel;
