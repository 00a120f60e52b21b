//! The station's desk for instructors: it accepts or refuses their acts, carries them out, and
//! passes them to the recorder.

use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{self, Receiver};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use assess::Difficulty;
use display_host::latency::now_ns;
use display_host::ui::{ActsReader, ActsView};
use session::{Acts, Health, Heard, Standing};
use shared_mem::message::{ActMsg, ActReply, CommandMsg, ReplyMsg};
use shared_mem::service::{ACT_PATIENCE, ActDesk, Commander, ServiceError, Station};
use shared_mem::words::{ActKind, EventKind};

use crate::problem::Problem;

/// Interval at which the desk looks for acts.
const LOOK_EVERY: Duration = Duration::from_millis(15);
/// Longest wait for the controller's answer.
const COMMAND_PATIENCE: Duration = Duration::from_millis(300);
/// Longest wait for the event of a complication.
const EVENT_PATIENCE: Duration = Duration::from_millis(800);
/// Ticks after a complication within which its event reaches the recording.
const EVENT_TICKS: u64 = 150;
/// Largest number of acts in a session.
const ACTS_MAX: usize = 5000;

// An instructor's display waits longer than the desk needs for an answer.
const _: () = {
    let longest =
        LOOK_EVERY.as_millis() + COMMAND_PATIENCE.as_millis() + EVENT_PATIENCE.as_millis();
    assert!(longest < ACT_PATIENCE.as_millis());
};

/// Rules by which the station takes or refuses an act.
#[derive(Debug, Clone, Default)]
pub(super) struct Terms {
    /// True if the session is an exam: the desk then takes remarks only.
    pub(super) is_exam: bool,
    /// State of the recording; `None` if nothing is recorded.
    pub(super) recording: Option<Arc<Mutex<Health>>>,
}

impl Terms {
    pub(super) fn new(
        difficulty: Option<Difficulty>,
        recording: Option<Arc<Mutex<Health>>>,
    ) -> Self {
        Self {
            is_exam: difficulty == Some(Difficulty::Exam),
            recording,
        }
    }

    /// Reason why this act is refused, as [`ActReply`] numbers it.
    fn refuse(&self, act: &ActMsg) -> Result<ActKind, u32> {
        let kind = act.kind().map_err(|_| ActReply::UNKNOWN)?;
        if !act.is_sane() {
            return Err(ActReply::UNKNOWN);
        }
        if self.is_exam && kind.helps_or_hinders() {
            return Err(ActReply::EXAM);
        }
        let standing =
            |it: &Arc<Mutex<Health>>| it.lock().unwrap_or_else(PoisonError::into_inner).standing;
        let is_recorded = self.recording.as_ref().map(standing);
        match is_recorded.is_some_and(|it| it != Standing::Ended) {
            true => Ok(kind),
            false => Err(ActReply::UNRECORDED),
        }
    }
}

/// A desk that serves until it is dropped.
#[derive(Debug)]
pub(super) struct Desk {
    /// View of the acts for the display.
    pub(super) view: Arc<Mutex<ActsView>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Desk {
    /// Starts the thread of the desk. The desk passes acts to the recorder by `acts`. The recorder
    /// reports recorded ticks and events by `news`.
    pub(super) fn begin(
        station: &Station,
        terms: Terms,
        acts: Acts,
        news: Receiver<Heard>,
    ) -> Result<Self, Problem> {
        let (view, stop) = (
            Arc::<Mutex<ActsView>>::default(),
            Arc::new(AtomicBool::new(false)),
        );
        let (shown, stopped) = (view.clone(), stop.clone());
        let station = station.clone();
        let (sender, opening) = mpsc::sync_channel(1);
        let thread = Builder::new()
            .name("calot-desk".to_owned())
            .spawn(move || {
                display_host::priority::step_aside(None);
                // The ends of the services stay in the thread that uses them.
                let opened =
                    ActDesk::open(&station).and_then(|desk| Ok((desk, Commander::open(&station)?)));
                let (desk, controller) = match opened {
                    Ok(ends) => ends,
                    Err(error) => {
                        let _ = sender.send(Err(error));
                        return;
                    }
                };
                let _ = sender.send(Ok(()));
                let mut work = Work {
                    controller,
                    terms,
                    acts,
                    news,
                    began: Instant::now(),
                    done: Vec::new(),
                };
                while !stopped.load(Relaxed) {
                    while !stopped.load(Relaxed)
                        && let Some(request) = desk.next_request()
                    {
                        let outcome = work.take(&request.act());
                        request.reply(outcome);
                    }
                    work.forget_news();
                    let now_s = work.began.elapsed().as_secs_f64();
                    let view = ActsView::at(&work.done, now_s, ActsReader::Trainee);
                    *shown.lock().unwrap_or_else(PoisonError::into_inner) = view;
                    std::thread::sleep(LOOK_EVERY);
                }
            })
            .map_err(|error| format!("cannot start the desk's thread: {error}"))?;
        if let Ok(outcome) = opening.recv() {
            outcome?;
        }
        Ok(Self {
            view,
            stop,
            thread: Some(thread),
        })
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        self.stop.store(true, Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

struct Work {
    controller: Commander,
    terms: Terms,
    acts: Acts,
    news: Receiver<Heard>,
    began: Instant,
    /// Acts so far, with their times, s.
    done: Vec<(f64, ActMsg)>,
}

impl Work {
    /// Carries the act out, or refuses it. Returns the outcome as [`ActReply`] numbers it.
    fn take(&mut self, act: &ActMsg) -> u32 {
        let outcome = match self.terms.refuse(act) {
            Ok(_) if self.done.len() >= ACTS_MAX => ActReply::FULL,
            Ok(kind) => self.carry_out(kind),
            Err(refusal) => refusal,
        };
        if ActReply::is_recorded(outcome) {
            self.acts.note(now_ns(), *act);
            self.done.push((self.began.elapsed().as_secs_f64(), *act));
        }
        outcome
    }

    fn carry_out(&self, kind: ActKind) -> u32 {
        let (command, event) = match kind {
            ActKind::Point | ActKind::Remark | ActKind::Fog => return ActReply::DONE,
            ActKind::Pause => ((CommandMsg::PAUSE, 1), None),
            ActKind::Resume => ((CommandMsg::PAUSE, 0), None),
            ActKind::Bleeding => (complication(kind), Some(EventKind::Opened)),
            ActKind::SlippedClip => (complication(kind), Some(EventKind::Unclipped)),
        };
        self.forget_news();
        let (kind, argument) = command;
        let command = CommandMsg { kind, argument };
        let reply = self.controller.command(command, COMMAND_PATIENCE);
        match (reply.map(|it| (it.outcome, it.tick)), event) {
            (Ok((ReplyMsg::DONE, _)), None) => ActReply::DONE,
            (Ok((ReplyMsg::DONE, tick)), Some(event)) => happened(&self.news, event, tick),
            // The controller may still carry the command out. A second command would do harm.
            (Err(ServiceError::NoAnswer { .. }), Some(_)) => ActReply::UNCERTAIN,
            _ => ActReply::SILENT,
        }
    }

    /// Drops what the recorder reported before the next act.
    fn forget_news(&self) {
        while self.news.try_recv().is_ok() {}
    }
}

/// Command for a complication, and its argument.
fn complication(kind: ActKind) -> (u32, u32) {
    let number = kind.complication().map_or(u32::MAX, |it| it.number());
    (CommandMsg::COMPLICATION, number)
}

/// Outcome of a complication that the controller accepted in this tick. It happened if its event
/// reaches the recording.
fn happened(news: &Receiver<Heard>, kind: EventKind, tick: u64) -> u32 {
    let began = Instant::now();
    loop {
        let left = EVENT_PATIENCE.saturating_sub(began.elapsed());
        match news.recv_timeout(left) {
            Ok(Heard::Event(event)) if event.is(kind) && event.tick >= tick => {
                return ActReply::DONE;
            }
            // The event would have been recorded by now.
            Ok(Heard::Tick(newest)) if newest > tick + EVENT_TICKS => return ActReply::NOTHING,
            Ok(_) if !left.is_zero() => {}
            _ => return ActReply::UNCERTAIN,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable as _;
    use shared_mem::message::EventMsg;

    fn recording(standing: Standing) -> Option<Arc<Mutex<Health>>> {
        Some(Arc::new(Mutex::new(Health {
            standing,
            ..Health::default()
        })))
    }

    #[test]
    fn a_complication_happened_only_if_its_event_is_recorded() {
        let event = |kind: EventKind, tick| {
            Heard::Event(EventMsg {
                tick,
                kind: kind.number(),
                ..EventMsg::zeroed()
            })
        };
        let earlier = event(EventKind::Opened, 99);
        let other = event(EventKind::Unclipped, 100);
        let it = event(EventKind::Opened, 100);
        let (soon, late) = (
            Heard::Tick(100 + EVENT_TICKS),
            Heard::Tick(101 + EVENT_TICKS),
        );
        for (news, outcome) in [
            (vec![earlier, other, soon, it], ActReply::DONE),
            (vec![earlier, other, soon, late], ActReply::NOTHING),
            (vec![earlier, other, soon], ActReply::UNCERTAIN),
        ] {
            let (hear, heard) = mpsc::channel();
            news.iter().for_each(|it| hear.send(*it).unwrap());
            assert_eq!(happened(&heard, EventKind::Opened, 100), outcome);
        }
    }

    #[test]
    fn an_exam_takes_remarks_only_and_unrecorded_acts_are_refused() {
        let remark = ActMsg::remark("Well done").unwrap();
        let point = ActMsg::point([0.0; 3]);
        let exam = Terms::new(Some(Difficulty::Exam), recording(Standing::Recording));
        assert_eq!(exam.refuse(&remark), Ok(ActKind::Remark));
        for kind in ActKind::ALL.into_iter().filter(|it| *it != ActKind::Remark) {
            assert_eq!(exam.refuse(&ActMsg::of(kind)), Err(ActReply::EXAM));
        }
        let practice = Terms::new(None, recording(Standing::Recording));
        assert_eq!(practice.refuse(&point), Ok(ActKind::Point));
        for recording in [None, recording(Standing::Ended)] {
            let unrecorded = Terms::new(None, recording);
            assert_eq!(unrecorded.refuse(&point), Err(ActReply::UNRECORDED));
        }
        let false_kind = ActMsg { kind: 99, ..point };
        assert_eq!(practice.refuse(&false_kind), Err(ActReply::UNKNOWN));
        let nowhere = ActMsg::point([f32::NAN; 3]);
        assert_eq!(practice.refuse(&nowhere), Err(ActReply::UNKNOWN));
    }
}
