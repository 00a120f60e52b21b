//! Service `task`: state of a task, from the host that assesses it to the hosts that watch. The
//! text is JSON. The realtime process never sees it.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

/// Bytes of text that a [`TaskMsg`] holds.
pub const TASK_TEXT: usize = 8176;

/// State of a task.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
#[type_name("calot.TaskMsg.v1")]
pub struct TaskMsg {
    /// When it was sent (`CLOCK_MONOTONIC`).
    pub at_ns: u64,
    /// Version of the text's format: [`TaskMsg::VERSION`].
    pub version: u32,
    /// Bytes of the text that count.
    pub length: u32,
    /// UTF-8; zero after `length`.
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

    /// Its text; `None` if another version wrote it or it is malformed.
    #[must_use]
    pub fn text(&self) -> Option<&str> {
        let text = self.text.get(..self.length as usize)?;
        let text = core::str::from_utf8(text).ok()?;
        (self.version == Self::VERSION).then_some(text)
    }
}

// The layout is the contract: a change of size is a change of version.
const _: () = assert!(size_of::<TaskMsg>() == 16 + TASK_TEXT);
