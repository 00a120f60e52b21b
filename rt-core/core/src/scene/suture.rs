//! Attachments that are sutures.

use crate::scene::{Anchor, Attachment};

/// Attachments of a scene, each with its suture number if it is a suture.
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

/// True if an attachment is a suture: a thread to the world.
pub(crate) fn is_suture(tie: &Attachment) -> bool {
    tie.is_thread && matches!(tie.to, Anchor::World(_))
}
