//! A centre and its stations as real processes, seen by a page of an instructor.

mod browser;
mod crowd;
mod cut;
mod house;
mod page;
mod real;
mod results;
mod shown;
mod stations;
mod strangers;
mod support;
