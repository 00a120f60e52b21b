//! Tools against tissue: where they touch, and the force that closes the separation.
//!
//! [`tool_contact`] runs both stages. [`skin`], [`tube`] and [`rigid`] find contacts;
//! [`constraint`] solves them with the models of [`law`], [`friction`] and [`influence`].
//! [`separation`] removes steps, [`patch`] weighs the spheres, and [`contact_force`] is the result.
//!
//! # Two stages
//!
//! Stage `contact` finds candidates: organs whose box comes near, their spheres, then the places of
//! the skin and the beads of tubes. Stage `solve` closes each separation after the tissue has
//! moved, within every substep, and pushes the tissue with the force that the hand feels. The
//! multiplier of a contact constraint is that force. What moves the tissue is what the hand feels,
//! whatever the number of spheres.
//!
//! # Skin
//!
//! Preparation remeshes each organ that has tetrahedra to a contact skin, a few millimetres fine.
//! Twelve spheres carry each vertex, so that it follows every affine motion. The tick looks at
//! points along the tool and follows each over the skin as a god-object: it walks from where the
//! point was on the skin to where it is now. A walk over the surface cannot leave it, so a skin
//! needs no sweep.
//!
//! # What spheres are too coarse for
//!
//! On an elastic half-space a rigid tool makes a dent δ with a force F over a contact of half-width
//! a. The spheres make a part of it themselves, as if F were spread over a Gaussian patch
//! `exp(−r²/A²)`. The rest, `δ − c F` with the patch's own compliance `c`, is added by [`law`]. It
//! is the difference of two half-spaces. So everything farther away than a few spacings (the
//! organ's shape, its attachments, other tools) is left to the spheres. The contact force solves
//!
//! ```text
//! s + y F + δ(F) − c F = 0,   F ≥ 0
//! s: separation, m; y: compliance of the spheres within the step, m/N
//! ```
//!
//! which is monotone and has one answer. With `x = a/R` and `E* = E / (1 − ν²)`:
//!
//! | shape | force | dent | source |
//! |---|---|---|---|
//! | ball | `E* R² ((1 + x²) artanh x − x)` | `R x artanh x` | Sneddon 1965 |
//! | cylinder of length `l` | `π E* l a² / (4 R)` | `a²/(2 R) (ln(2 l / a) + ½)` | Hertz |
//!
//! A ball's force is divided by `1 + 0.06 δ/R`, because a neo-Hookean half-space is softer than a
//! linear one (Zhang, Cao, Li and Feng 2014). The curvature of the skin at rest adds to the ball's
//! own: what the skin falls off from the contact is a paraboloid. A hollow blunts a tool by half at
//! most.
//!
//! Preparation bakes `c` from the tissue's stiffness around each vertex. A ball presses on a patch
//! of at least 0.8 of its radius, a thin one (up to 4 mm) of 1.3: under less, spheres that are
//! close together strain as the law does not know.
//!
//! # Several contacts on one skin
//!
//! Contacts side by side share a load. The influence coefficient of one on another is what the
//! half-space carries over beyond what the spheres do. It is the same both ways (Betti), and no
//! more than what more of the same force does to either contact itself. So no contact holds another
//! off.
//!
//! # Warm start
//!
//! Three quarters of the last tick's force act before the constraints are solved, the rest after
//! them. One pass over the constraints is an implicit step in which each knows all of itself and
//! half of the others. A force put on all after it finds tissue too soft; one put on all before it,
//! too stiff. Friction has no warm start: it would drag on what has slid on.
//!
//! # Separation without jumps
//!
//! A persistent contact keeps an offset to its measured separation. A contact that is found deep
//! begins with none of its depth. One that jumps changes its separation by 0.02 mm a tick and twice
//! the tool's travel at most. The offset decays by a hundredth a tick; where a contact opens, by a
//! twentieth and at most 0.025 mm. The direction of the push turns so slowly that the force changes
//! by 1.5 mN a tick.
//!
//! # Friction
//!
//! A bristle holds the tool back along the skin. It is as stiff as a half-space under a contact of
//! half-width a (Mindlin 1949: `8 G a / (2 − ν)`) less what the spheres yield. It never pulls
//! harder than `μ F` (return mapping). There is no step between sticking and sliding. The force
//! moves the spheres too.
//!
//! # Tubes
//!
//! Ducts and vessels, and layers one sphere thick, are beads along the lines of their spheres. A
//! tool is followed past every bead through the whole of a tick's motion and keeps its side,
//! however fast it is. A bead takes its side from the neighbour that bears more. Its wall is a
//! spring that stiffens as the tube is pressed flat, `F = k d (1 + d / D)`. The felt stiffness
//! counts the tissue behind the bead as well, as a ball that is embedded in it (Lur'e 1964: `24 π G
//! (1 − ν) r / (5 − 6 ν)`). The push turns with the tube within 50 ms only: one that stays square
//! to the tube is a follower load, under which a thin tube flutters (Beck's column, Bolotin 1963).
//!
//! # Instrument and endoscope
//!
//! The endoscope presses on tissue as the instrument does, once its tracker has said where it is.
//! The hand feels it only where the instrument meets it (`rigid`): steel on steel.

mod constraint;
pub(crate) mod contact_force;
mod friction;
mod influence;
mod law;
mod part_box;
mod patch;
mod rigid;
mod separation;
pub(crate) mod skin;
pub(crate) mod tool_contact;
pub(crate) mod tube;
