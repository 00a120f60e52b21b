//! Calot's simulation and control law: `no_std`, no `alloc`, no clock, no files, no randomness.
//!
//! Time, input and storage are arguments. The scene is immutable; the [`state`] changes. One tick
//! ([`sim::Sim::tick`]) runs these stages:
//!
//! ```text
//! sample → tool → contact → solve → force → procedure → publish
//! ```
//!
//! | stage | begin to read at | module |
//! |---|---|---|
//! | sample | `Ports::sample`, `Inputs::take` | `sim::exchange`, `sim::sample` |
//! | tool | `Sim::move_tool` | `sim` |
//! | contact | `ToolContacts::find` | `contact::tool_contact` |
//! | solve | `substeps::run` | `tissue::substeps` |
//! | force | `handle_force::felt`, `OutputLimit::apply` | `haptics` |
//! | procedure | `cut_all`, `tear_all` | `procedure::cut`, `tissue::damage` |
//! | publish | `Ports::publish`, `TickView` | `sim::exchange`, `sim::view` |
//!
//! Units are SI; the unit comes last in a name (`force_n`): `_n_m` is N/m, `_nm` is N m. The name
//! of a transform gives its frames: `world_from_handle` takes handle coordinates to world
//! coordinates. Contact normals point from tissue to tool.
//!
//! # Glossary
//!
//! | word | meaning |
//! |---|---|
//! | device pose | pose of the handle as the hand holds it |
//! | proxy pose | pose of the instrument; it differs while tissue exceeds the device's force |
//! | port (trocar) | the point of the abdominal wall about which a shaft pivots |
//! | tool | a rigid instrument in the simulation, made of capsules |
//! | part | one capsule of a tool: shaft, jaw, hook tip, endoscope |
//! | scene, state | immutable prepared data; all data that changes |
//! | organ | a range of spheres with one material |
//! | sphere | a mass point with a radius inside an organ |
//! | link, rest length | a distance constraint between two spheres of one organ |
//! | attachment | a distance constraint between two organs, or between an organ and the world |
//! | suture | a thread from an organ to the abdominal wall; it pulls and never pushes |
//! | tetrahedron, batch | a solid element of four spheres; eight elements without common spheres |
//! | held sphere | a sphere that the constraints do not move: it is fixed, or led along a path |
//! | compliance | inverse stiffness of a constraint, m/N |
//! | lambda | multiplier of a constraint: its force times the square of the substep |
//! | tick, substep | one control period; a part of it in which an organ is solved |
//! | multirate | organs with different numbers of substeps in one tick |
//! | retardation time | time constant of the material's viscous damping, s |
//! | contact skin | closed triangle surface of an organ against which tools collide |
//! | bead | a ball on the centre line of a tube; tools collide with beads where there is no skin |
//! | separation | signed distance from tissue to tool along the normal; negative: penetration |
//! | candidate | a place where tool and tissue may touch within the tick |
//! | contact constraint | a candidate that is solved |
//! | contact force | the result of a contact constraint |
//! | persistent contact | a contact tracked from tick to tick with its cached force |
//! | warm start | a share of the last force, applied before the constraints are solved |
//! | influence coefficient | displacement at one place per force at another (Boussinesq) |
//! | separation offset | a decaying addition to a separation that would otherwise jump |
//! | damage | the broken share of a link or attachment, 0 to 1 (cohesive zone) |
//! | cell | a hexahedron of fat or connective tissue that can be removed |
//! | passivity, Z-width | as in Colgate, Adams and Hannaford |
//! | transition | a gradual end of a force that a command would end at once |
//! | clip | a closed titanium clip |
//! | grip, bite | jaws closed on tissue; the tissue between them |
//! | event | an occurrence that a tick reports: contact, tear, cut, leak |
//! | fault | an error that a tick detected, with a fixed answer and a counter |
//! | stale | a sample older than its limit |
//! | overrun, late tick | a tick that ends after its deadline |
//! | missed period | a control period that was skipped |
//! | checkpoint, digest | a copy of all that changes; a hash of what a tick computed |
//!
//! # Modules
//!
//! Tests of the checkout call these modules *rooms*. [`scene::Room`] is the operating room.
//!
//! | module | contents |
//! |---|---|
//! | [`capacity`] | limits of arrays and loops |
//! | [`fault`] | faults of a tick, and their counters |
//! | [`math`] | vectors, rotations, poses |
//! | [`time`] | host time, the control period |
//! | `hash` | hash by which two runs are compared |
//! | [`words`] | flags of a sphere, health of a device, events |
//! | [`port`] | interfaces to haptic device, tracker and pedal |
//! | [`tool`] | instruments, their capsules, the lever about the trocar |
//! | [`scene`] | the immutable scene, and its checks |
//! | [`tissue`] | spheres, links, tetrahedra, cells, their solvers, damage |
//! | `contact` | contact of tools with tissue |
//! | `organs` | contact of organs with each other and with themselves |
//! | [`procedure`] | grasp, scissors, current, clips, leaks |
//! | [`haptics`] | force at the handle, and its limits |
//! | [`state`] | all per-sphere data that changes |
//! | [`study`] | tissue without devices, for studies, tests and preparation |
//! | [`sim`] | the tick |
//!
//! The module [`port`] holds the interfaces to devices. In geometry a port is a trocar, as in
//! `instrument_port_m`.
//!
//! `tests/tidy/tests/layers.rs` lists the modules from which each module may import, and checks it.
#![no_std]
#![deny(unsafe_code)]

pub mod capacity;
mod contact;
pub mod fault;
pub mod haptics;
mod hash;
pub mod math;
mod organs;
pub mod port;
pub mod procedure;
pub mod scene;
pub mod sim;
pub mod state;
pub mod study;
#[cfg(test)]
mod testing;
pub mod time;
pub mod tissue;
pub mod tool;
pub mod words;
