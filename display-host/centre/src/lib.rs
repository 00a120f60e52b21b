//! A centre of many stations.
//!
//! ```text
//! station ─ shared memory ─► calot tell ─ pipe ─► calot-centre join
//!                                                      ║ zenoh, TLS
//!                      page of instructors ◄═ HTTPS ═ calot-centre serve
//! ```
//!
//! `calot tell` reads the station as a display does, and does not use the network. `calot-centre
//! join` uses the network, and knows nothing of the simulation. So zenoh and its many packages are
//! no part of the display or of the realtime process, and a centre that hangs holds up neither.
//!
//! # Messages
//!
//! [`topic`] lists the messages. A station sends its state twice a second, and at once with an
//! alarm. Each state repeats the last alarms, so a lost state loses no alarm. Pictures are sent
//! only while somebody watches, and give way to states. A result is sent until it is answered.
//!
//! # Trust
//!
//! Both ends have certificates of one authority. A station on the list ([`roster`]) may use all
//! topics below the name in its certificate, and no others. A name that is taken off the list loses
//! its rights. Everything that a station sends is checked on arrival. Instructors log in with a
//! password over TLS. [`log`] records who watched which station and when.

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
