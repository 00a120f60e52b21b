//! Fixtures shared by the system tests.
