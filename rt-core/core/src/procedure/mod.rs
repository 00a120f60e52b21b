//! Procedure: the surgeon's work on tissue with jaws, clips, scissors and current, and bleeding.
//!
//! # Grip
//!
//! Closed jaws hold each sphere between them by a separate spring (XPBD). `bite` computes three
//! things: the resistance of the tissue, as a neo-Hookean slab between two plates,
//! `A G (1/λ² − λ)`; the friction of the slab on the jaws; and the stiffness of the tissue behind
//! the slab, as a half-space under a disc as wide as the bite. If the pull exceeds the friction,
//! the tissue slides through the jaws. The tissue between the jaws keeps them open. A handle that
//! opens and shuts renders the squeeze; a handle with a button does not.
//!
//! # Scissors
//!
//! Closing blades damage the links of tubes, bands and sutures between them. The damage begins when
//! the gap is as narrow as the link is thick, and is complete when the gap is shut. The hand does
//! not feel the cutting force at the shaft, because the forces of the two blades balance. It feels
//! that the severed tissue no longer pulls. Fingers in a handle that opens and shuts feel the cut.
//!
//! # Current
//!
//! Only the bent end of the hook is bare. The contact areas of the tip with all tissue are summed,
//! m². The energy of the tick divided by this sum is the dose on every area, J/m². The generator
//! gives 30 W, of which half becomes heat at the tip: of the resistance around a small ball in
//! tissue, `(1/a − 1/r) / 4πσ`, half lies within one radius of the ball's surface. A cutting
//! current divides tissue with 0.9 of the heat, a coagulating one with 0.15; the rest desiccates
//! the tissue around the tip. Both shares are assumed. Heating tissue from 37 to 100 °C and boiling
//! its water takes `1060 kg/m³ (3600 J/kg K · 63 K + 0.75 · 2.26 MJ/kg)`. The damage of a link
//! grows by the energy that it absorbs, divided by the energy that boils it away over the width of
//! the electrode. Walls are burnt through place by place. Current without contact burns nothing.
//!
//! # Heat
//!
//! Each sphere has a temperature. The other half of the current's power warms the tissue beside the
//! tip, in inverse proportion to the fourth power of the distance. If the tip touches a tube, this
//! half warms the tube, along the path of the current. Heat flows along links and attachments,
//! blood carries it off, and water boils at 100 °C. Damage is the Arrhenius sum of Henriques and
//! Moritz. This damage raises events, and changes no mechanics.
//!
//! # Clips
//!
//! A clip closes the tubes between the applier's jaws. The jaws hold the tubes as soon as they
//! begin to close. A flattened tube is half its circumference wide; the part of this width that the
//! clip does not cover stays open. A clip stays on its link of the tube, and makes the link stiff
//! and thin.
//!
//! # Vessels
//!
//! The pressure of blood spreads from the held spheres of a vessel and from attached vessels; the
//! pressure of bile spreads from a full gallbladder and from the liver. Pressure spreads along
//! intact links; clips and desiccated walls reduce the pressure to the share of the lumen that they
//! leave open. The pressure is computed only after a change. In each tick it spreads by one pass
//! over all links, so that the cost of a tick is bounded. Then every divided end and every hole
//! leaks at the pressure that reaches it. All events of one leak carry the place where it began. A
//! divided artery shortens by a tenth, because vessels lie stretched in the body
//! (10.1007/s00414-011-0549-9). A duct shortens by half as much, which is assumed. Desiccation
//! closes arteries of up to 1.5 mm in radius.
//!
//! # Sutures
//!
//! A suture that is shorter than the distance between its ends at rest (`drawn_mm` in a recipe) is
//! drawn in within two seconds. This is how the scene of Calot's triangle hangs the gallbladder.
//! `Command::Start(Task::Hang)` takes the sutures down, and the trainee places them. A first press
//! of the pedal passes the needle through the tissue at the grasper's tip. A second press hangs the
//! suture on the abdominal wall, in the direction in which the tip was carried in between.

pub(crate) mod cautery;
pub mod clip;
pub(crate) mod cut;
pub(crate) mod grasp;
pub mod heat;
pub(crate) mod journal;
pub(crate) mod lens;
pub(crate) mod opening;
pub(crate) mod shaking;
pub mod stones;
pub(crate) mod unrest;
pub(crate) mod vessel;
