//! Service `task`: the state of a task as JSON. The host that assesses the task sends it to the
//! hosts that watch. The realtime process does not receive it.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

/// Largest number of bytes of text in a [`TaskMsg`].
pub const TASK_TEXT: usize = 8176;

/// State of a task.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
#[type_name("calot.TaskMsg.v1")]
pub struct TaskMsg {
    /// Time of sending (`CLOCK_MONOTONIC`).
    pub at_ns: u64,
    /// Version of the text's format: [`TaskMsg::VERSION`].
    pub version: u32,
    /// Length of the text, bytes.
    pub length: u32,
    /// The text in UTF-8. All bytes after `length` are zero.
    pub text: [u8; TASK_TEXT],
}

impl TaskMsg {
    /// The version that this program writes and reads.
    pub const VERSION: u32 = 2;

    /// A message with this text; `None` if it is longer than [`TASK_TEXT`].
    #[must_use]
    pub fn new(at_ns: u64, text: &str) -> Option<Box<Self>> {
        let mut message: Box<Self> = bytemuck::allocation::zeroed_box();
        message
            .text
            .get_mut(..text.len())?
            .copy_from_slice(text.as_bytes());
        (message.at_ns, message.version) = (at_ns, Self::VERSION);
        message.length = u32::try_from(text.len()).ok()?;
        Some(message)
    }

    /// The text; `None` if another version wrote the message or the message is malformed.
    #[must_use]
    pub fn text(&self) -> Option<&str> {
        let text = self.text.get(..self.length as usize)?;
        let text = core::str::from_utf8(text).ok()?;
        (self.version == Self::VERSION).then_some(text)
    }
}

// Sender and receivers rely on this size. A change of it needs a new version.
const _: () = assert!(size_of::<TaskMsg>() == 16 + TASK_TEXT);
