//! Tests of the real programs: stations, their processes, devices on real lines, screens and
//! networks.

mod bad_input;
mod by_hand;
mod centre;
mod devices;
mod disks;
mod documents;
mod drill;
mod elsewhere;
mod failures;
mod foreign;
mod foxglove;
mod hand;
mod handle;
mod igtlink;
mod jitter;
mod launcher;
mod lost;
mod main_job;
mod operation;
mod photon;
mod replay;
mod returned;
mod silenced;
mod study;
mod swept;
