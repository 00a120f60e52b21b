//! Lessons of a session: its errors, grouped by kind and organ, the gravest first.

use core::cmp::Reverse;

use crate::alarm::{Alarm, AlarmKind};

/// Errors of one kind at one organ, from which the trainee can learn.
#[derive(Debug, Clone, PartialEq)]
pub struct Lesson {
    /// Kind of the errors.
    pub kind: AlarmKind,
    /// The organ concerned, if any.
    pub organ: Option<String>,
    /// Indices of the alarms of these errors, the oldest first.
    pub alarms: Vec<usize>,
}

/// Rank of a kind of error. The gravest has 0.
const fn rank(kind: AlarmKind) -> u8 {
    match kind {
        AlarmKind::Unclamped => 0,
        AlarmKind::Perforated => 1,
        AlarmKind::Torn => 2,
        AlarmKind::Cut => 3,
        AlarmKind::ClipMisplaced => 4,
        AlarmKind::Burnt => 5,
        AlarmKind::TooEarly => 6,
        AlarmKind::Unseen => 7,
        AlarmKind::ClipOpen => 8,
        AlarmKind::Crushed => 9,
        AlarmKind::Touched => 10,
        AlarmKind::ClipLost => 11,
    }
}

impl Lesson {
    /// Lessons of these alarms, the gravest kind first. Within a kind, the more frequent lesson
    /// comes first.
    #[must_use]
    pub fn of(alarms: &[Alarm]) -> Vec<Self> {
        let mut lessons: Vec<Self> = Vec::new();
        for (number, alarm) in alarms.iter().enumerate() {
            let of_kind = |it: &&mut Self| (it.kind, &it.organ) == (alarm.kind, &alarm.organ);
            match lessons.iter_mut().find(of_kind) {
                Some(known) => known.alarms.push(number),
                None => lessons.push(Self {
                    kind: alarm.kind,
                    organ: alarm.organ.clone(),
                    alarms: vec![number],
                }),
            }
        }
        lessons.sort_by_key(|it| (rank(it.kind), Reverse(it.alarms.len())));
        lessons
    }

    /// Id of the message that says how to avoid the error.
    #[must_use]
    pub fn advice(&self) -> String {
        advice(self.kind.name(), self.organ.as_deref())
    }
}

/// Id of the message that says how to avoid an error, by the kind's name in `summary.json` and the
/// organ. The board of the drills has a message of its own, because nobody can draw it aside, and
/// so has an opened tube, which has no plane beside it as the gallbladder has.
#[must_use]
pub fn advice(kind: &str, organ: Option<&str>) -> String {
    match (kind, organ) {
        ("touched", Some("board")) => "advice-touched-board".to_owned(),
        ("perforated", Some(organ)) if organ != "gallbladder" => {
            "advice-perforated-other".to_owned()
        }
        _ => format!("advice-{}", kind.replace('_', "-")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_a_kind_at_an_organ_are_one_lesson_and_the_gravest_is_first() {
        let alarm = |kind, organ: &str| Alarm {
            at_s: 1.0,
            session_s: 2.0,
            kind,
            organ: Some(organ.to_owned()),
            at_m: [0.0; 3],
        };
        let lessons = Lesson::of(&[
            alarm(AlarmKind::Touched, "liver"),
            alarm(AlarmKind::Touched, "stomach"),
            alarm(AlarmKind::Burnt, "bile duct"),
            alarm(AlarmKind::Touched, "stomach"),
        ]);
        let of: Vec<_> = lessons.iter().map(|it| it.alarms.as_slice()).collect();
        assert_eq!(of, [&[2][..], &[1, 3], &[0]]);
        assert_eq!(lessons[0].advice(), "advice-burnt");
        assert_eq!(Lesson::of(&[]), []);
        let board = Lesson::of(&[alarm(AlarmKind::Touched, "board")]);
        assert_eq!(board[0].advice(), "advice-touched-board");
    }
}
