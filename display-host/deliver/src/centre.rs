//! A centre as the delivery sees it.

use std::time::Duration;

use store::{Outgoing, Withdrawal};

use crate::error::DeliverError;

/// Longest wait for one answer of a centre.
pub const PATIENCE: Duration = Duration::from_secs(30);
/// Longest wait until a connection is made.
pub(crate) const CONNECT: Duration = Duration::from_secs(10);

/// A centre's answer to a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Receipt {
    /// The centre holds it now.
    New,
    /// The centre held it already.
    Known,
    /// The centre holds another result with this id, and keeps it.
    Differs,
    /// The centre forgot the person after the session began.
    Forgotten,
    /// A centre of this kind takes no such result.
    LeftOut,
}

/// A connected centre.
pub(crate) trait Centre {
    /// Delivers a session. A repetition changes nothing.
    fn deliver(&mut self, it: &Outgoing) -> Result<Receipt, DeliverError>;

    /// Forgets all data of a person up to that time. A repetition changes nothing.
    fn forget(&mut self, it: &Withdrawal) -> Result<(), DeliverError>;
}
