//! A centre as the delivery sees it.

use std::time::Duration;

use store::{Outgoing, Withdrawal};

use crate::error::DeliverError;

/// Longest wait for one answer of a centre.
pub const PATIENCE: Duration = Duration::from_secs(30);
/// Longest wait until a connection stands.
pub(crate) const CONNECT: Duration = Duration::from_secs(10);

/// Fate of a result at a centre.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Receipt {
    /// It is there now.
    New,
    /// It was there already.
    Known,
    /// The centre holds another result of this id, which stays.
    Differs,
    /// The centre forgot the person after the session began.
    Forgotten,
    /// Such a centre does not take it.
    LeftOut,
}

/// A connected centre.
pub(crate) trait Centre {
    /// Delivers a session. A second delivery of the same session changes nothing.
    fn deliver(&mut self, it: &Outgoing) -> Result<Receipt, DeliverError>;

    /// Forgets a person as far as known until then. A second time changes nothing.
    fn forget(&mut self, it: &Withdrawal) -> Result<(), DeliverError>;
}
