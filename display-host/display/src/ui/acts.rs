//! Acts of instructors, as the station's display shows them.

use shared_mem::message::ActMsg;
use shared_mem::words::ActKind;

/// Time for which a mark stays in the picture, s.
const MARK_S: f64 = 10.0;
/// Time for which the picture tells an act, s.
const NOTICE_S: f64 = 8.0;

/// Acts of instructors at one moment.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ActsView {
    /// The newest act, as long as the picture tells it. A remark has its text, if the text is told.
    pub notice: Option<(ActKind, Option<String>)>,
    /// Place at which an instructor points, world frame, m.
    pub mark: Option<[f32; 3]>,
    /// Number of times that an instructor fogged the lens.
    pub fogs: usize,
}

impl ActsView {
    /// The view of these acts at the time `now_s`. Each act comes with its time, s, the oldest act
    /// first. With `tells_remarks` the view has the text of a remark; a trainee reads this text
    /// only in the debrief.
    #[must_use]
    pub fn at(acts: &[(f64, ActMsg)], now_s: f64, tells_remarks: bool) -> Self {
        let known = acts.iter().filter(|(at_s, _)| *at_s <= now_s);
        let known = known.filter_map(|(at_s, act)| Some((*at_s, act.kind().ok()?, act)));
        let mut view = Self::default();
        for (at_s, kind, act) in known {
            let is_new = now_s - at_s < NOTICE_S;
            // The picture tells a pause until it ends.
            if is_new || kind == ActKind::Pause {
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
                _ => {}
            }
        }
        view
    }
}

/// Id of the message that tells an act.
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
    fn a_mark_goes_by_itself_and_a_pause_is_told_until_it_ends() {
        let told = |now_s| ActsView::at(&acts(), now_s, false);
        assert_eq!(told(0.5), ActsView::default());
        assert_eq!(told(5.0).mark, Some([0.1, 0.0, 0.0]));
        assert_eq!(told(12.0).mark, None);
        assert_eq!((told(19.0).fogs, told(21.0).fogs), (0, 1));
        assert_eq!(told(95.0).notice, Some((ActKind::Pause, None)));
        assert_eq!(told(115.0).notice, None);
    }

    #[test]
    fn a_trainee_is_told_of_a_remark_and_reads_it_later() {
        let remark = |tells| ActsView::at(&acts(), 121.0, tells).notice;
        assert_eq!(remark(false), Some((ActKind::Remark, None)));
        let text = Some("Nearer.".to_owned());
        assert_eq!(remark(true), Some((ActKind::Remark, text)));
    }
}
