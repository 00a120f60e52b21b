//! A centre of many stations.
//!
//! ```text
//! station ─ shared memory ─► calot tell ─ pipe ─► calot-centre join
//!                                                      ║ zenoh, TLS
//!                      page of instructors ◄═ HTTPS ═ calot-centre serve
//! ```
//!
//! `calot tell` reads the station as a display does and knows no network. `calot-centre join` knows
//! the network and nothing of the simulation. So zenoh and its many packages are no part of the
//! display or of the realtime process, and a centre that hangs hangs neither.
//!
//! # What travels
//!
//! [`topic`] names it. A state comes twice a second, and at once when an alarm does; it repeats the
//! last alarms, so one that is lost on its way comes with the next. Pictures travel only while
//! somebody looks, and make room for states. A result travels until it is answered.
//!
//! # Trust
//!
//! Both ends have certificates of one authority. A station may do everything below the name in its
//! certificate and nothing elsewhere, if the list ([`roster`]) has it; a name that is taken off the
//! list has no rights any more. What a station sends is checked on arrival. Instructors log in with
//! a password over TLS. [`log`] tells who watched which station and when.

pub mod board;
pub mod error;
pub mod frame;
pub mod hall;
pub mod keys;
pub mod log;
pub mod member;
pub mod network;
pub mod rehearse;
pub mod results;
pub mod roster;
pub mod state;
pub mod teller;
pub mod topic;
pub mod web;

pub use error::CentreError;
