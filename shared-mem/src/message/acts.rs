//! Service `acts`: what an instructor does at a running station.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use crate::words::{ActKind, Unknown};

/// Largest number of bytes of a remark.
pub const REMARK_BYTES: usize = 176;
/// Largest coordinate of a place, m.
const PLACE_MAX_M: f32 = 10.0;

/// Service `acts`, request of an instructor's display.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("calot.ActMsg.v1")]
pub struct ActMsg {
    /// Number of an [`ActKind`].
    pub kind: u32,
    /// Length of the remark, bytes.
    pub length: u32,
    /// Place at which the instructor points, world frame, m.
    pub at_m: [f32; 3],
    /// The remark in UTF-8. All bytes after `length` are zero.
    pub remark: [u8; REMARK_BYTES],
}

impl ActMsg {
    /// An act without place and remark.
    #[must_use]
    pub fn of(kind: ActKind) -> Self {
        Self {
            kind: kind.number(),
            ..Self::zeroed()
        }
    }

    /// The instructor points at this place, world frame, m.
    #[must_use]
    pub fn point(at_m: [f32; 3]) -> Self {
        Self {
            at_m,
            ..Self::of(ActKind::Point)
        }
    }

    /// A remark, cut at the last letter that has room. `None` for an empty one.
    #[must_use]
    pub fn remark(text: &str) -> Option<Self> {
        let plain: String = text.chars().filter(|it| !it.is_control()).collect();
        let plain = plain.trim();
        let length = plain.floor_char_boundary(REMARK_BYTES);
        let kept = plain.as_bytes().get(..length)?;
        let mut act = Self::of(ActKind::Remark);
        act.remark.get_mut(..length)?.copy_from_slice(kept);
        act.length = u32::try_from(length).ok()?;
        (length > 0).then_some(act)
    }

    /// Kind of the act.
    ///
    /// # Errors
    /// [`Unknown`] if its number has no name.
    pub fn kind(&self) -> Result<ActKind, Unknown> {
        self.kind.try_into()
    }

    /// The remark; `None` if it is no text.
    #[must_use]
    pub fn text(&self) -> Option<&str> {
        core::str::from_utf8(self.remark.get(..self.length as usize)?).ok()
    }

    /// True if the kind has a name, the place is in the room, and the remark is text without
    /// control characters.
    #[must_use]
    pub fn is_sane(&self) -> bool {
        let has_place = self.at_m.iter().all(|x| x.abs() < PLACE_MAX_M);
        let has_text = self
            .text()
            .is_some_and(|it| !it.chars().any(char::is_control));
        self.kind().is_ok() && has_place && has_text
    }
}

/// Service `acts`, reply of the station.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
#[type_name("calot.ActReply.v1")]
pub struct ActReply {
    /// One of the `ActReply` constants.
    pub outcome: u32,
}

impl ActReply {
    /// The act was carried out, and is recorded.
    pub const DONE: u32 = 0;
    /// During an exam, the station accepts only remarks.
    pub const EXAM: u32 = 1;
    /// The complication is impossible now: there is no clip on a tube, or no blood in the artery.
    pub const NOTHING: u32 = 2;
    /// The station records no session, or its recording has ended.
    pub const UNRECORDED: u32 = 3;
    /// The station does not understand the act.
    pub const UNKNOWN: u32 = 4;
    /// The controller did not answer in time.
    pub const SILENT: u32 = 5;
    /// The act is recorded. No answer came in time, so it is unknown whether the act was carried
    /// out.
    pub const UNCERTAIN: u32 = 6;
    /// The session already holds the largest number of acts.
    pub const FULL: u32 = 7;

    /// True if an act with this outcome is in the recording.
    #[must_use]
    pub const fn is_recorded(outcome: u32) -> bool {
        matches!(outcome, Self::DONE | Self::UNCERTAIN)
    }
}

// Sender and receivers rely on this size. A change of it needs a new version.
const _: () = assert!(size_of::<ActMsg>() == 20 + REMARK_BYTES);

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn remark_is_kept_and_long_remark_is_cut_between_letters() {
        let text = |it: &str| ActMsg::remark(it).and_then(|act| act.text().map(str::to_owned));
        assert_eq!(text(" Go nearer.\n").as_deref(), Some("Go nearer."));
        assert_eq!(text(" \t"), None);
        let long = "ध".repeat(100);
        let kept = text(&long).expect("a remark");
        assert_eq!(kept.len(), 174, "58 letters of three bytes");
        assert!(long.starts_with(&kept));
    }

    #[test]
    fn places_outside_of_the_room_and_false_texts_are_refused() {
        let point = ActMsg::point([0.1, 0.2, 0.3]);
        assert!(point.is_sane());
        assert!(!ActMsg::point([0.0, f32::NAN, 0.0]).is_sane());
        assert!(!ActMsg::point([0.0, 11.0, 0.0]).is_sane());
        assert!(!ActMsg { kind: 77, ..point }.is_sane());
        let length = REMARK_BYTES as u32 + 1;
        assert!(!ActMsg { length, ..point }.is_sane());
        let mut bell = ActMsg::remark("ring").expect("a remark");
        bell.remark[0] = 7;
        assert!(!bell.is_sane());
        bell.remark[0] = 0xff;
        assert_eq!(bell.text(), None);
    }

    proptest! {
        #[test]
        fn any_text_is_a_sane_remark_or_none(text in any::<String>()) {
            prop_assert!(ActMsg::remark(&text).is_none_or(|act| act.is_sane()));
        }
    }
}
