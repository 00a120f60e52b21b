//! The surgeon's work on tissue: what jaws, clips, scissors and current do, and what bleeds.
//!
//! # Grip
//!
//! Closed jaws hold each sphere between them by a spring of its own (XPBD). `bite` has the
//! resistance of the tissue, a neo-Hookean slab between two plates, `A G (1/λ² − λ)`; the friction
//! that it bears; and the stiffness of the tissue behind it, a half-space under a disc as wide as
//! the bite. A grip that is pulled harder than its friction slides. The squeeze is not rendered,
//! because the handle closes by a button, but the jaws stay as far open as what they hold keeps
//! them.
//!
//! # Scissors
//!
//! Links of tubes, bands and sutures are damaged by as much as the blades close on them, from the
//! moment at which the gap is as narrow as they are thick. The hand feels nothing of the cutting
//! force: between the blades it is in balance. It feels what the tissue no longer bears.
//!
//! # Current
//!
//! The hook is bare at its bent end only. Everything that it touches first says how much of it is
//! touched, in m². Then each takes its dose of the tick's energy, in J/m². The generator gives 30
//! W, of which half becomes heat at the tip: of the resistance around a small ball in tissue, `(1/a
//! − 1/r) / 4πσ`, half lies within one radius. A cutting current parts with 0.9 of the heat, a
//! coagulating one with 0.15; the rest dries what is around. Both shares are assumed. To heat
//! tissue from 37 to 100 °C and boil its water takes `1060 kg/m³ (3600 J/kg K · 63 K + 0.75 · 2.26
//! MJ/kg)`. A link is damaged by the energy over what it takes to boil it through, across the
//! electrode's width. Walls are burnt through place by place. Current that touches nothing burns
//! nothing.
//!
//! # Clips
//!
//! A clip closes the tubes between the applier's jaws, which hold them from the moment they close,
//! as far as the jaws reach over them. A tube that is squeezed flat is half its girth wide, and
//! whatever lies beyond the clip stays open. A clip stays on its link, which is stiff and thin
//! there.
//!
//! # Vessels
//!
//! Pressure spreads from where a vessel is held or tied to another, and bile from a full
//! gallbladder and from the liver. It spreads along intact links, through clips and dried walls as
//! far as they leave it open. It does so only after a change, and one link a tick, so that its cost
//! is bounded. Then every divided end and every hole leaks what reaches it. All events of one leak
//! carry the place where it began. A divided artery shortens by a tenth, because vessels lie
//! stretched in the body (10.1007/s00414-011-0549-9); a duct by half of that, which is assumed.
//! Arteries up to 1.5 mm in radius close when they are dried.
//!
//! # Sutures
//!
//! A suture to the world that is shorter than its ends are apart at rest (`drawn_mm` in a recipe)
//! is drawn in within two seconds. So the triangle's gallbladder is hung.
//! `Command::Start(Task::Hang)` takes the sutures down, and the trainee places them: the pedal
//! leads the needle through what the grasper's tip touches, then to the wall, past where the tip is
//! carried.

pub(crate) mod cautery;
pub mod clip;
pub(crate) mod cut;
pub(crate) mod grasp;
pub(crate) mod journal;
pub(crate) mod vessel;
