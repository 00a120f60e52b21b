//! Acts of instructors, as the station's display shows them.

use shared_mem::message::ActMsg;
use shared_mem::words::ActKind;

/// Time for which a mark stays in the picture, s.
const MARK_S: f64 = 10.0;
/// Time for which the picture shows a note of an act, s.
const NOTICE_S: f64 = 8.0;

/// Reader of the acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ActsReader {
    /// The trainee at the station, who reads remarks only in the debrief.
    Trainee,
    /// The instructor who acts.
    Instructor,
    /// The viewer of a replay. A replay runs on during a pause of the session.
    Replay,
}

/// Acts of instructors at one moment.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ActsView {
    /// The newest act, while the picture shows a note of it. A remark has its text, unless the
    /// reader is the trainee.
    pub notice: Option<(ActKind, Option<String>)>,
    /// Place at which an instructor points, world frame, m.
    pub mark: Option<[f32; 3]>,
    /// Number of times that an instructor fogged the lens.
    pub fogs: usize,
    /// Number of times that an instructor paused.
    pub pauses: usize,
    /// In a replay, all acts of the session with their times, s.
    pub all: Vec<(f64, ActKind)>,
}

impl ActsView {
    /// The view of `reader` at `now_s` of acts with their times, s, the oldest first.
    #[must_use]
    pub fn at(acts: &[(f64, ActMsg)], now_s: f64, reader: ActsReader) -> Self {
        let tells_remarks = reader != ActsReader::Trainee;
        let lasts = |kind| kind == ActKind::Pause && reader != ActsReader::Replay;
        let known = acts.iter().filter(|(at_s, _)| *at_s <= now_s);
        let known = known.filter_map(|(at_s, act)| Some((*at_s, act.kind().ok()?, act)));
        let mut view = Self::default();
        if reader == ActsReader::Replay {
            let all = acts.iter();
            view.all = all
                .filter_map(|(at_s, act)| Some((*at_s, act.kind().ok()?)))
                .collect();
        }
        for (at_s, kind, act) in known {
            let is_new = now_s - at_s < NOTICE_S;
            // The note of a pause stays as long as the pause.
            if is_new || lasts(kind) {
                let remark = act
                    .text()
                    .filter(|_| kind == ActKind::Remark && tells_remarks);
                view.notice = Some((kind, remark.map(str::to_owned)));
            } else if kind == ActKind::Resume {
                view.notice = None;
            }
            match kind {
                ActKind::Point => view.mark = (now_s - at_s < MARK_S).then_some(act.at_m),
                ActKind::Fog => view.fogs += 1,
                ActKind::Pause => view.pauses += 1,
                _ => {}
            }
        }
        view
    }
}

/// Decides how long the note of an instructor's pause is shown. The trainee may end the pause.
#[derive(Debug, Default)]
pub(crate) struct PauseNote {
    /// Number of the newest pause that was seen, from 1.
    seen: usize,
    /// Number of the newest pause that has ended.
    over: usize,
}

impl PauseNote {
    /// True while the pause with this number lasts. Call it for each picture. The note of a pause
    /// that has ended does not come back with a later pause.
    pub(crate) fn tells(&mut self, number: usize, is_paused: bool) -> bool {
        match is_paused {
            true => self.seen = number,
            false if self.seen == number => self.over = number,
            false => {}
        }
        is_paused && number > self.over
    }
}

/// Id of the message that names an act.
pub(super) fn message(kind: ActKind) -> String {
    format!("act-{}", kind.name().replace('_', "-"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn acts() -> Vec<(f64, ActMsg)> {
        vec![
            (1.0, ActMsg::point([0.1, 0.0, 0.0])),
            (20.0, ActMsg::of(ActKind::Fog)),
            (40.0, ActMsg::of(ActKind::Pause)),
            (100.0, ActMsg::of(ActKind::Resume)),
            (120.0, ActMsg::remark("Nearer.").expect("a remark")),
        ]
    }

    #[test]
    fn a_mark_ends_by_itself_and_the_note_of_a_pause_ends_with_the_pause() {
        let view_at = |now_s| ActsView::at(&acts(), now_s, ActsReader::Trainee);
        assert_eq!(view_at(0.5), ActsView::default());
        assert_eq!(view_at(5.0).mark, Some([0.1, 0.0, 0.0]));
        assert_eq!(view_at(12.0).mark, None);
        assert_eq!((view_at(19.0).fogs, view_at(21.0).fogs), (0, 1));
        assert_eq!(view_at(95.0).notice, Some((ActKind::Pause, None)));
        assert_eq!(view_at(115.0).notice, None);
    }

    #[test]
    fn a_replay_shows_the_note_of_a_pause_for_a_limited_time() {
        let view_at = |now_s| ActsView::at(&acts(), now_s, ActsReader::Replay).notice;
        assert_eq!(view_at(41.0), Some((ActKind::Pause, None)));
        assert_eq!(view_at(49.0), None);
        assert_eq!(view_at(101.0), Some((ActKind::Resume, None)));
    }

    #[test]
    fn the_note_of_a_pause_that_the_trainee_ended_does_not_return() {
        let mut note = PauseNote::default();
        assert!(!note.tells(0, true), "the trainee's own pause");
        assert!(!note.tells(0, false));
        assert!(!note.tells(1, false), "the picture is older than the act");
        assert!(note.tells(1, true));
        assert!(!note.tells(1, false), "the trainee resumed");
        assert!(!note.tells(1, true), "the trainee's own pause");
        assert!(note.tells(2, true), "the instructor paused again");
    }

    #[test]
    fn a_trainee_sees_that_there_is_a_remark_and_reads_it_later() {
        let remark = |reader| ActsView::at(&acts(), 121.0, reader).notice;
        assert_eq!(remark(ActsReader::Trainee), Some((ActKind::Remark, None)));
        let text = Some("Nearer.".to_owned());
        for reader in [ActsReader::Instructor, ActsReader::Replay] {
            assert_eq!(remark(reader), Some((ActKind::Remark, text.clone())));
        }
    }
}
