//! Attachments that are sutures.

use crate::scene::{Anchor, Attachment};

/// The attachments of a scene, each with its number if it is a suture.
pub(crate) fn numbered<'a>(
    ties: impl Iterator<Item = &'a Attachment>,
) -> impl Iterator<Item = (&'a Attachment, Option<u8>)> {
    let mut next = 0;
    ties.map(move |tie| {
        let number = is_suture(tie).then_some(next);
        next += u8::from(number.is_some());
        (tie, number)
    })
}

/// Whether an attachment is one.
pub(crate) fn is_suture(tie: &Attachment) -> bool {
    tie.is_thread && matches!(tie.to, Anchor::World(_))
}
