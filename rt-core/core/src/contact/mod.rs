//! Contact of tools with tissue: detection, and the force that removes the overlap.
//!
//! [`tool_contact`] runs both stages. [`skin`], [`tube`] and [`rigid`] find contacts;
//! [`constraint`] solves them with the models of [`law`], [`friction`] and [`influence`].
//! [`separation`] filters the measured separation, so that the force has no steps. [`patch`] is the
//! weighted set of spheres under a contact, and [`contact_force`] is the result. [`dent`] is the
//! part of the contact that the display draws.
//!
//! # Two stages
//!
//! Stage `contact` finds candidates: first organs whose box is near a tool, then their spheres,
//! then points of the skin and beads of tubes. Stage `solve` runs in every substep, after the
//! tissue has moved: it computes the force that removes each overlap, and applies it to the tissue.
//! The hand feels exactly the force that moves the tissue, whatever the number of spheres.
//!
//! # Skin
//!
//! Preparation (the offline build of a scene) remeshes the surface of each organ that has
//! tetrahedra to a contact skin, with triangles of a few millimetres. Twelve spheres carry each
//! vertex, so that the vertex follows every affine motion. Contact is tested at points along the
//! tool. Each tool point has a god-object: its contact point on the skin. In every tick the
//! god-object walks from triangle to triangle towards its tool point. It stays on the surface, so a
//! fast tool cannot pass through, and its motion need not be swept.
//!
//! # Compliance that the spheres lack
//!
//! On an elastic half-space a rigid tool makes a dent δ with a force F over a contact of half-width
//! a. The spheres supply a part of this dent: they yield as a half-space does if F is spread over a
//! Gaussian patch `exp(−r²/A²)`, with compliance `c`. The module [`law`] adds the rest, `δ − c F`.
//! The rest is a difference of two half-space solutions, which vanishes a few sphere spacings away.
//! So the rest does not depend on the organ's shape, its attachments or other tools; the spheres
//! account for those. The contact force solves
//!
//! ```text
//! s + y F + δ(F) − c F = 0,   F ≥ 0
//! s: separation, m; y: compliance of the spheres within the step, m/N
//! ```
//!
//! The left side is monotone in F, so there is one solution. With `x = a/R` and `E* = E / (1 −
//! ν²)`:
//!
//! | shape | force | dent | source |
//! |---|---|---|---|
//! | ball | `E* R² ((1 + x²) artanh x − x)` | `R x artanh x` | Sneddon 1965 |
//! | cylinder of length `l` | `π E* l a² / (4 R)` | `a²/(2 R) (ln(2 l / a) + ½)` | Hertz |
//!
//! A ball's force is divided by `1 + 0.06 δ/R`, because a neo-Hookean half-space is softer than a
//! linear one (Zhang, Cao, Li and Feng 2014). The curvature of the skin at rest adds to the
//! curvature of the ball; the skin around the contact is taken as a paraboloid. Concave skin lowers
//! the sum, to half of the ball's curvature at least.
//!
//! Preparation computes the patch's width, and with it `c`, from the tissue's stiffness around each
//! vertex. The patch under a tool is at least 0.8 of the tool's radius wide; under a thin ball 1.3
//! of its radius, up to 4 mm. Under a narrower patch, closely spaced spheres strain in a way that
//! the law does not describe.
//!
//! # Several contacts on one skin
//!
//! A contact also presses down the skin under its neighbours. The influence coefficient is the
//! displacement at one contact per force at another, as in a half-space, less the displacement that
//! the spheres already transmit. The coefficient is equal in both directions (Betti). It is at most
//! the compliance of either contact under its own load; otherwise one contact could keep another
//! off the tissue.
//!
//! # Warm start
//!
//! Three quarters of the last force act before the tissue's constraints are solved, the rest after
//! them. The tissue's solver makes one Gauss–Seidel pass in a substep. In the pass, each constraint
//! reacts fully to its own error, but on average only to half of the other constraints'
//! corrections. If all of the force acted after the pass, the tissue would be too soft; if all of
//! it acted before the pass, too stiff. Friction has no warm start, because it would drag tissue
//! that has slid since the last substep.
//!
//! # Separation without jumps
//!
//! A persistent contact adds an offset to its measured separation. So a contact that is first found
//! deep begins at zero depth. If the measured separation jumps, the filtered separation changes by
//! at most 0.02 mm a tick plus twice the tool's travel; the offset takes up the rest. The offset
//! then decays by 1 % a tick. An offset that hides an opening decays by 5 % a tick, at most 0.025
//! mm. While the tool is still, the force turns so slowly that it changes by at most 1.5 mN a tick.
//!
//! # Friction
//!
//! A bristle (a spring along the skin) holds the tool back. Its compliance is that of a half-space
//! under a contact of half-width a (stiffness `8 G a / (2 − ν)`, Mindlin 1949), less the compliance
//! that the spheres supply. The bristle never pulls harder than `μ F` (return mapping), so there is
//! no step between sticking and sliding. The friction moves the spheres too.
//!
//! # Tubes
//!
//! Ducts and vessels collide as beads (balls) along the lines that join their spheres; layers one
//! sphere thick have one bead at each sphere. The motion of a tool past each bead is swept over the
//! whole tick, so even a fast tool stays on its side of the tube. A bead takes the tool's side from
//! its neighbour on the tube, if the neighbour bears the larger load. The wall of a bead is a
//! spring that stiffens with its compression d, `F = k d (1 + d / D)`; at compression D the tube is
//! flat. The felt stiffness includes the tissue behind the bead: twice the stiffness of a ball
//! embedded in the tissue (Lur'e 1964: `24 π G (1 − ν) r / (5 − 6 ν)`), and the mass of the bead's
//! spheres. When the tube rotates, the direction of the force follows with a time constant of 50
//! ms. A force that stayed perpendicular to the tube would be a follower load, under which a thin
//! tube flutters (Beck's column, Bolotin 1963).
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
