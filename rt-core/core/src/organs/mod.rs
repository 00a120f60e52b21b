//! Organ against organ, and an organ against itself.
//!
//! Spheres collide as balls that touch about where the skins touch: the radius of the ball around
//! an outer sphere (its reach) is about the distance at rest from the sphere to the skin over it. A
//! ball reaches equally far in all directions, so near a thin rim it reaches too far in some
//! directions and not far enough in others. Inner spheres of one organ overlap at rest. So within
//! an organ only pairs that were apart at rest are kept apart. Spheres of two organs that
//! overlapped at rest come no nearer than they were at rest.
//!
//! Two spheres press each other apart as a damped spring of 200 N/m (XPBD, Macklin 2016), in each
//! substep of the finer organ. So the pushes on a sphere that is squeezed between others come to a
//! balance. Exact distance constraints, solved one after another, would never let such a sphere
//! rest. Spheres that overlap part at 0.1 m/s at most. Friction is that of wet serous skins, 0.02
//! (pleura on pleura; D'Angelo 2004, DOI 10.1016/j.resp.2004.05.006).
//!
//! Near pairs are searched in a grid, a sixteenth of the spheres a tick.

pub(crate) mod between;
mod grid;
pub(crate) mod pairs;
