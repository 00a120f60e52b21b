//! A learning record store that speaks xAPI 2.0 (IEEE 9274.1.1).
//!
//! A record store never deletes a statement. It voids it: the statement stays, and no query returns
//! it except by its own id. So no statement holds a name: its actor is the UUID that the store
//! derives from a name ([`store::person_id`]).

mod records;
mod statement;

pub(crate) use records::Records;
