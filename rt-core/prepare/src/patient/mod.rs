//! Patients: a case from a seed, or one of six with a name, and its recipe.
//!
//! A case is habitus, course of duct and artery, state of the gallbladder's wall, stones, and
//! adhesions. Its recipe differs from Calot's triangle ([`crate::Recipe::triangle`]) in that fat
//! and peritoneum cover duct and artery, and that the hepatic artery begins behind the stomach. The
//! same seed gives the same recipe, and so the same scene.
//!
//! # What is known, and what is assumed
//!
//! - Courses: [`crate::shape::Course`]; sources stand in `shape/vessel.rs`. Half of the seeds have
//!   the usual course. Each variant is more frequent than in life, so that trainees meet it.
//! - Habitus: a body mass index of 18 to 45. With it the cover grows from 3.4 to 4.5 mm, and the
//!   lumps of fat grow by a third. Both are assumed, because no source measures fat over the
//!   triangle. The liver of an obese patient is fatty and larger, here by up to 5 %.
//! - Serosa: a sheet over fat stiffens it. The cover has 12 kPa, which is assumed: 0.1 mm of serosa
//!   of 0.4 MPa lie over 4 mm of fat. The cover runs on to the liver and the hepatic artery. When
//!   it was bare fat of 1.6 kPa, tied to the ducts alone, the hook was caught and dragged duct and
//!   artery along. That still happens, but less often.
//! - Calot's triangle: what lies more than 2 mm behind the plane of its corners does not count,
//!   because duct and artery hide it from an instrument in front.
//! - Wall: up to 3 mm are normal; a wall with acute inflammation is thicker and oedematous, and
//!   the gallbladder is distended (a width of more than 4 cm counts; Tokyo Guidelines 2018,
//!   10.1002/jhbp.515). A scarred gallbladder is shrunken and stiff. In this model the wall is
//!   part of a solid body, so its state changes the body's width, stiffness and toughness. The
//!   factors are assumed.
//! - Stones: 1 to 30 of 3 to 25 mm, as far as they fit. As in a suspension, stones that fill the
//!   share φ of the volume multiply the body's stiffness by 1 + 2.5 φ (Einstein). They also make
//!   the body heavier: cholesterol stones sink in bile, and are taken to have 1100 kg/m³. They
//!   leave through a hole that is wide enough (`rt_core::procedure::stones`).
//! - Adhesions: the cover adheres to the neck and up to 20 mm of the infundibulum. The tissue of
//!   the bed is tougher and denser in scars, and looser in oedema (assumed).

mod case;
mod parts;
mod random;
mod text;

pub use case::{NAMES, PREFIX, Patient};
pub use parts::{Stones, Wall};
