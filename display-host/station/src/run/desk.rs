//! The station's desk for instructors: it decides on their acts, carries them out, and has them
//! recorded.

use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use assess::Difficulty;
use display_host::latency::now_ns;
use display_host::ui::ActsView;
use session::{Acts, Health, Standing};
use shared_mem::message::{ActMsg, ActReply, CommandMsg, EventMsg, ReplyMsg};
use shared_mem::service::{ActDesk, Commander, Station};
use shared_mem::words::{ActKind, EventKind};

use crate::problem::Problem;

/// Interval at which the desk looks for acts.
const LOOK_EVERY: Duration = Duration::from_millis(15);
/// Longest wait for the controller's answer.
const COMMAND_PATIENCE: Duration = Duration::from_millis(300);
/// Longest wait for the event of a complication.
const EVENT_PATIENCE: Duration = Duration::from_millis(400);

/// Rules by which the station takes or refuses an act.
#[derive(Debug, Clone, Default)]
pub(super) struct Terms {
    /// The session is an exam, which is worked alone.
    pub(super) is_exam: bool,
    /// State of the recording; `None`: nothing is recorded.
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
    /// Begins to serve. The desk notes acts in `acts`, and hears of complications by `events`.
    pub(super) fn begin(
        station: &Station,
        terms: Terms,
        acts: Acts,
        events: Receiver<EventMsg>,
    ) -> Result<Self, Problem> {
        let (view, stop) = (
            Arc::<Mutex<ActsView>>::default(),
            Arc::new(AtomicBool::new(false)),
        );
        let (shown, stopped) = (view.clone(), stop.clone());
        let station = station.clone();
        let (tell, told) = mpsc::sync_channel(1);
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
                        let _ = tell.send(Err(error));
                        return;
                    }
                };
                let _ = tell.send(Ok(()));
                let mut work = Work {
                    controller,
                    terms,
                    acts,
                    events,
                    began: Instant::now(),
                    done: Vec::new(),
                };
                while !stopped.load(Relaxed) {
                    while let Some(request) = desk.next_request() {
                        let outcome = work.take(&request.act());
                        request.reply(outcome);
                    }
                    let now_s = work.began.elapsed().as_secs_f64();
                    let view = ActsView::at(&work.done, now_s, false);
                    *shown.lock().unwrap_or_else(PoisonError::into_inner) = view;
                    std::thread::sleep(LOOK_EVERY);
                }
            })
            .map_err(|error| format!("cannot start the desk's thread: {error}"))?;
        if let Ok(told) = told.recv() {
            told?;
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

/// True if the desk has to hear of this event.
pub(super) fn concerns(event: &EventMsg) -> bool {
    event.is(EventKind::Opened) || event.is(EventKind::Unclipped)
}

struct Work {
    controller: Commander,
    terms: Terms,
    acts: Acts,
    events: Receiver<EventMsg>,
    began: Instant,
    /// Acts so far, with their times, s.
    done: Vec<(f64, ActMsg)>,
}

impl Work {
    /// Carries the act out, or refuses it. Returns the outcome as [`ActReply`] numbers it.
    fn take(&mut self, act: &ActMsg) -> u32 {
        let outcome = self.terms.refuse(act).and_then(|kind| self.carry_out(kind));
        match outcome {
            Ok(()) => {
                self.acts.note(now_ns(), *act);
                self.done.push((self.began.elapsed().as_secs_f64(), *act));
                ActReply::DONE
            }
            Err(refusal) => refusal,
        }
    }

    fn carry_out(&self, kind: ActKind) -> Result<(), u32> {
        match kind {
            ActKind::Point | ActKind::Remark | ActKind::Fog => Ok(()),
            ActKind::Pause => self.command(CommandMsg::PAUSE, 1),
            ActKind::Resume => self.command(CommandMsg::PAUSE, 0),
            ActKind::Bleeding | ActKind::SlippedClip => {
                let number = kind.complication().ok_or(ActReply::UNKNOWN)?.number();
                while self.events.try_recv().is_ok() {}
                self.command(CommandMsg::COMPLICATION, number)?;
                // Without an event, nothing went wrong.
                match self.events.recv_timeout(EVENT_PATIENCE) {
                    Ok(_) => Ok(()),
                    Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {
                        Err(ActReply::NOTHING)
                    }
                }
            }
        }
    }

    fn command(&self, kind: u32, argument: u32) -> Result<(), u32> {
        let command = CommandMsg { kind, argument };
        let reply = self.controller.command(command, COMMAND_PATIENCE);
        match reply.map(|it| it.outcome) {
            Ok(ReplyMsg::DONE) => Ok(()),
            _ => Err(ActReply::SILENT),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recording(standing: Standing) -> Option<Arc<Mutex<Health>>> {
        Some(Arc::new(Mutex::new(Health {
            standing,
            ..Health::default()
        })))
    }

    #[test]
    fn an_exam_takes_remarks_only_and_nothing_happens_unrecorded() {
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
