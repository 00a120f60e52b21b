//! Contact of organs with each other, and of an organ with itself.
//!
//! Spheres collide as balls that touch about where the skins touch. The radius of a ball is called
//! the reach of its sphere. The reach is about the distance at rest from the sphere's centre to the
//! skin. A ball is round, so near a thin rim it extends too far in some directions and not far
//! enough in others. Neighbouring spheres of one organ overlap at rest. So within an organ, only
//! pairs that were apart at rest are kept apart. Spheres of two organs that overlapped at rest come
//! no nearer than they were at rest.
//!
//! A damped spring of 200 N/m (XPBD, Macklin 2016) presses two spheres apart, in each substep of
//! the finer organ. So the forces on a sphere that is squeezed between others come to a balance.
//! Exact distance constraints, solved one after another, would never let such a sphere rest.
//! Overlapping spheres separate at 0.1 m/s at most. Friction is that of wet serous skins, 0.02
//! (pleura on pleura; D'Angelo 2004, DOI 10.1016/j.resp.2004.05.006).
//!
//! Near pairs are searched in a grid, a sixteenth of the spheres a tick.

pub(crate) mod between;
mod grid;
pub(crate) mod pairs;
