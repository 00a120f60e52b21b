//! Tools against tissue: where they touch, and the force that closes the separation.
//!
//! [`tool_contact`] runs both stages. [`skin`], [`tube`] and [`rigid`] find contacts;
//! [`constraint`] solves them with the models of [`law`], [`friction`] and [`influence`].
//! [`separation`] removes steps from the separation, [`patch`] is the weighted set of spheres under
//! a contact, and [`contact_force`] is the result. [`dent`] is the part that the display draws.
//!
//! # Two stages
//!
//! Stage `contact` finds candidates: first organs whose box is near a tool, then their spheres,
//! then places on the skin and beads of tubes. Stage `solve` closes each separation in every
//! substep, after the tissue has moved, and pushes the tissue. The hand feels exactly the force
//! that moves the tissue, whatever the number of spheres.
//!
//! # Skin
//!
//! Preparation (the offline build of a scene) remeshes the surface of each organ that has
//! tetrahedra to a contact skin, with triangles of a few millimetres. Twelve spheres carry each
//! vertex, so that the vertex follows every affine motion. Each tick takes points along the tool,
//! and moves the contact point of each over the skin as a god-object: by a walk from triangle to
//! triangle towards the tool point. A walk over the surface cannot pass through the surface, so the
//! motion of a fast tool need not be swept.
//!
//! # What spheres are too coarse for
//!
//! On an elastic half-space a rigid tool makes a dent δ with a force F over a contact of half-width
//! a. The spheres themselves yield by a part of this dent, as if F were spread over a Gaussian
//! patch `exp(−r²/A²)`. The module [`law`] adds the rest, `δ − c F`, with the compliance `c` of
//! such a patch. This rest is the difference of two half-spaces, which vanishes a few sphere
//! spacings away. So the spheres alone account for the organ's shape, its attachments and other
//! tools. The contact force solves
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
//! own; the skin around the contact is taken as a paraboloid. Hollow skin lowers the sum, but not
//! below half of the ball's curvature.
//!
//! Preparation computes the patch's width, and with it `c`, from the tissue's stiffness around each
//! vertex. The patch under a tool is at least 0.8 of the tool's radius wide; under a thin ball 1.3
//! of its radius, up to 4 mm. Under a narrower patch, closely spaced spheres strain in a way that
//! the law does not describe.
//!
//! # Several contacts on one skin
//!
//! Contacts close to each other share a load. The influence coefficient of one on another is the
//! displacement that a force at one makes at the other in a half-space, beyond the displacement
//! that the spheres already make. The coefficient is equal in both directions (Betti), and at most
//! the compliance of either contact under its own load. If it were larger, one contact could keep
//! another off the tissue.
//!
//! # Warm start
//!
//! Three quarters of the last force act before the tissue's constraints are solved, the rest after
//! them. One pass over the constraints is an implicit step in which each constraint accounts for
//! itself fully, and on average for half of the others. A force that acts wholly after the pass
//! meets tissue that is too soft; a force that acts wholly before the pass, tissue that is too
//! stiff. Friction has no warm start, because it would drag tissue that has slid since.
//!
//! # Separation without jumps
//!
//! A persistent contact adds an offset to its measured separation. So a contact that is first found
//! deep begins at zero depth. If the measured separation jumps, the filtered one changes by at most
//! 0.02 mm a tick plus twice the tool's travel. The offset decays by a hundredth a tick; after an
//! opening, by a twentieth, at most 0.025 mm. While the tool is still, the push turns so slowly
//! that the force changes by at most 1.5 mN a tick.
//!
//! # Friction
//!
//! A bristle (a spring along the skin) holds the tool back. Its compliance is that of a half-space
//! under a contact of half-width a (stiffness `8 G a / (2 − ν)`, Mindlin 1949) less the compliance
//! of the spheres. The bristle never pulls harder than `μ F` (return mapping), so there is no step
//! between sticking and sliding. The friction moves the spheres too.
//!
//! # Tubes
//!
//! Ducts and vessels collide as beads (balls) along the lines that join their spheres; layers one
//! sphere thick have one bead at each sphere. The motion of a tool past each bead is swept over the
//! whole tick, so even a fast tool stays on its side of the tube. Of a bead's neighbours, the
//! neighbour under the larger load decides on which side the tool lies. The wall of a bead is a
//! spring that stiffens as the tube is pressed flat, `F = k d (1 + d / D)`. The felt stiffness
//! includes the tissue behind the bead: twice the stiffness of a ball embedded in the tissue (Lur'e
//! 1964: `24 π G (1 − ν) r / (5 − 6 ν)`), and the mass of the bead's spheres. The push follows a
//! rotation of the tube with a time constant of 50 ms. A push that stayed perpendicular to the tube
//! would be a follower load, under which a thin tube flutters (Beck's column, Bolotin 1963).
//!
//! # Instrument and endoscope
//!
//! The endoscope presses on tissue as the instrument does, once its tracker has delivered a pose.
//! The hand feels the endoscope only where the instrument touches it (`rigid`), as steel on steel.

mod constraint;
pub(crate) mod contact_force;
pub(crate) mod dent;
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
