//! Organ against organ, and an organ against itself.
//!
//! Spheres meet as balls, about where the skins lie: an outer sphere reaches as far as the skin
//! that it is nearest to lies from it at rest. A ball knows no direction, so beside a thin rim it
//! reaches too far one way and not far enough another. Inner spheres of one organ overlap at rest.
//! So within an organ only pairs that were apart at rest are kept apart, and spheres of two organs
//! come no nearer than they were at rest.
//!
//! Two spheres press each other apart as a damped spring of 200 N/m (XPBD, Macklin 2016), in each
//! substep of the finer organ. So where a sphere is squeezed between others, the pushes come to a
//! balance. Exact distances solved in turn never let it rest. What has come to lie in another organ
//! parts at 0.1 m/s at most. Friction is that of wet serous skins, 0.02 (pleura on pleura; D'Angelo
//! 2004, DOI 10.1016/j.resp.2004.05.006).
//!
//! Near pairs are searched in a grid, a sixteenth of the spheres a tick.

pub(crate) mod between;
mod grid;
pub(crate) mod pairs;
