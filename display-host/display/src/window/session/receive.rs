//! Takes the messages of all services, and updates the panel and the sound by them.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use shared_mem::message::{Event, EventMsg, TimingBatch};
use shared_mem::words::{self, EventKind, Fault};

use super::Session;
use crate::feed::Offer;
use crate::headless::Observed;
use crate::sound::synth::{Current, Heard};
use crate::ui::{Bulletin, Link};

/// Time without a new state after which the controller counts as silent.
const SILENCE: Duration = Duration::from_millis(500);
/// Duration of a task alarm's sound.
const TASK_ALARM: Duration = Duration::from_millis(1500);
/// Time span of the force plot, s.
const FORCE_S: f64 = 6.0;

impl Session {
    /// Receives all messages from the services.
    pub(in crate::window) fn receive(&mut self, observer: &mut dyn FnMut(Observed<'_>)) {
        let restarts = self.feed.counters().restarts;
        if self.host.newest_state(&mut self.inbox_state)
            && self.feed.offer_state(&self.inbox_state) == Offer::Taken
        {
            self.last_state = Some(Instant::now());
            self.forgot_dead = false;
            observer(Observed::State(&self.inbox_state));
        }
        if self.host.newest_tools(&mut self.inbox_tools)
            && self.feed.offer_tools(&self.inbox_tools) == Offer::Taken
        {
            let [x, y, z] = self.inbox_tools.force_n.map(f64::from);
            let force_n = (x * x + y * y + z * z).sqrt();
            let now = self.start.elapsed().as_secs_f64();
            self.force.push_back([now, force_n]);
            while self.force.front().is_some_and(|old| old[0] < now - FORCE_S) {
                self.force.pop_front();
            }
            observer(Observed::Tools(&self.inbox_tools));
        }
        if self.feed.counters().restarts > restarts {
            self.forget_effects();
            // The new controller is another run, whose task comes in new bulletins.
            if self.bulletins.is_some() {
                self.ui.watch(None);
            }
        }
        self.take_bulletin();
        self.receive_acts();
        self.judge_link();
        let now = self.start.elapsed().as_secs_f64();
        let (feed, ui, pending) = (&mut self.feed, &mut self.ui, &mut self.pending);
        let (causes, newest_clip) = (&self.causes, &mut self.newest_clip);
        let (heard, was_reset) = (&mut self.heard, &mut self.was_reset);
        let organs = &self.organs;
        let simulated = ui.simulated;
        let notes = &mut self.notes;
        self.host.drain_events(|event| {
            feed.note_event(event);
            notes.event(event);
            // A reset clears all bleeding and stains, whoever requested it.
            if event.is(EventKind::Reset) {
                pending.clear();
                (*newest_clip, *was_reset) = (None, true);
            }
            // A clip that closes while muted never clicks.
            if let Ok(Event::Clip { number }) = event.decode()
                && newest_clip.replace(number) != Some(number)
                && ui.settings.sound
            {
                heard.clips = heard.clips.wrapping_add(1);
            }
            if let Some((id, concerns_hand)) = alarm(event, simulated) {
                let text = Some(ui.words.say(id));
                match concerns_hand {
                    true => ui.alarm = text,
                    false => ui.machine_alarm = text,
                }
            }
            if let Some((id, organ)) = unrest(event).zip(organs.get(event.organ as usize)) {
                let organ = ui.words.organ(organ).into();
                let text = Some(ui.words.say_with(id, &[("organ", organ)]));
                // Only the hand can draw a buried instrument out. Falls and shakes are the scene's
                // fault.
                match event.is(EventKind::Buried) {
                    true => ui.alarm = text,
                    false => ui.machine_alarm = text,
                }
            }
            if let Some(effect) = causes.event(event).filter(|_| ui.link == Link::Live) {
                pending.push(now, event.tick, effect);
            }
            observer(Observed::Event(event));
        });
        let limited_ticks = &mut self.limited_ticks;
        self.host.drain_timing(|batch| {
            if feed.note_timing(batch) {
                ui.health.take(batch);
                if begins_to_limit(limited_ticks, batch) {
                    ui.machine_alarm = Some(ui.words.say("fault-limited"));
                }
                observer(Observed::Timing(batch));
            }
        });
        self.ui.tools = self.feed.tools().copied();
        if let Some(task) = &self.task {
            let task = task.lock().unwrap_or_else(PoisonError::into_inner).clone();
            let before = self.ui.task_view.as_ref().map_or(0, |task| task.alarms);
            // An exam has no text of the alarm, so no alarm sounds.
            if task.alarms > before && task.alarm.is_some() {
                self.alarmed = Some(Instant::now());
            }
            self.ui.task_view = Some(task);
        }
        self.take_notes();
        let newest = |it: &Arc<Mutex<_>>| *it.lock().unwrap_or_else(PoisonError::into_inner);
        self.ui.replay = self.replay.as_ref().map(newest);
        let newest = |it: &Arc<Mutex<_>>| *it.lock().unwrap_or_else(PoisonError::into_inner);
        let recording = self.recording.as_ref().map(newest);
        let before = self.ui.recording.map(|it| it.standing);
        self.ui.recording = recording.map(|health| health.at(Instant::now()));
        let failing = self.ui.recording.filter(|it| it.begins_to_fail(before));
        if failing.is_some() {
            self.ui.alarm = Some(self.ui.words.say("recording-alarm"));
        }
        self.ui.is_view_free = self.free.is_some();
        self.sound(observer);
        self.ui.in_hand = self.operate.is_on();
        self.ui.pressed = self.operate.pressed();
        self.ui.force = self.force.iter().copied().collect();
    }

    /// Takes the assessor's latest bulletin.
    fn take_bulletin(&mut self) {
        let Some((receiver, inbox)) = &mut self.bulletins else {
            return;
        };
        if receiver.newest(inbox) {
            self.ui.watch(inbox.text().and_then(Bulletin::parse));
        }
    }

    /// Plays the sounds. If they fail, reports the problem once and goes on without sound.
    fn sound(&mut self, observer: &mut dyn FnMut(Observed<'_>)) {
        let Some(sound) = &self.sound else { return };
        if let Some(problem) = sound.take_problem() {
            observer(Observed::Warning(&problem));
            self.sound = None;
            return;
        }
        let tools = self.feed.tools().filter(|_| self.ui.link == Link::Live);
        // The irrigator's pedals open valves, and no current hums.
        let electric = tools.filter(|it| !it.has(words::Instrument::Irrigator));
        let current = electric.map(|it| it.switches().current());
        self.heard.current = match current.unwrap_or(words::Current::Off) {
            words::Current::Cut => Current::Cut,
            words::Current::Coagulate => Current::Coagulate,
            words::Current::Off => Current::Off,
        };
        let task_alarm = self.alarmed.is_some_and(|at| at.elapsed() < TASK_ALARM);
        self.heard.alarm = self.ui.alarm.is_some() || task_alarm;
        self.heard.heart = tools.is_some() && !self.ui.is_paused();
        let clips = self.heard.clips;
        sound.hear(match self.ui.settings.sound {
            true => self.heard,
            false => Heard {
                clips,
                ..Heard::default()
            },
        });
    }

    fn judge_link(&mut self) {
        let silence = self.last_state.map(|last| last.elapsed());
        self.ui.link = match silence {
            _ if self.feed.other_scene_id().is_some() => Link::OtherScene,
            None => Link::Waiting,
            Some(silence) if silence < SILENCE => Link::Live,
            Some(silence) => Link::Silent(silence.as_secs_f32()),
        };
        if matches!(self.ui.link, Link::Silent(_)) && !self.forgot_dead {
            self.host.forget_dead();
            self.forgot_dead = true;
        }
    }
}

/// Message for an organ that falls or shakes, or that holds the instrument when its device starts
/// or returns. The trainee is not at fault.
fn unrest(event: &EventMsg) -> Option<&'static str> {
    match event.decode() {
        Ok(Event::Fall { .. }) => Some("unrest-falls"),
        Ok(Event::Shake { .. }) => Some("unrest-shakes"),
        Ok(Event::Buried { .. }) => Some("unrest-buried"),
        _ => None,
    }
}

/// True for the first batch after which the haptic device has limited its force. The controller
/// sends no event for this, because some devices limit their force in ordinary use.
fn begins_to_limit(known_ticks: &mut u64, batch: &TimingBatch) -> bool {
    let code = Fault::DeviceLimited as usize;
    let ticks = batch.faults.get(code).copied().unwrap_or(0);
    let before = std::mem::replace(known_ticks, ticks);
    before == 0 && ticks > 0
}

/// Message for a fault that switches off the force or the current, and true if the person at the
/// station can mend the fault. An instructor and an engineer see the other faults. Nobody can mend
/// a simulated device. While mouse and keys lead, the picture itself says why no force or current
/// acts.
fn alarm(event: &EventMsg, [handle, _, pedal]: [bool; 3]) -> Option<(&'static str, bool)> {
    let Ok(Event::Fault(fault)) = event.decode() else {
        return None;
    };
    match fault {
        Fault::LostDevice | Fault::SpeedTrip if handle => None,
        Fault::LostPedal | Fault::HeldPedal | Fault::BothElectrodes if pedal => None,
        Fault::BadForce => Some(("fault-no-number", false)),
        Fault::StaleDevice => Some(("fault-late", false)),
        Fault::LostDevice => Some(("fault-gone", true)),
        Fault::SpeedTrip => Some(("fault-fast", true)),
        Fault::BothElectrodes => Some(("fault-both", true)),
        Fault::SilentDevice => Some(("fault-silent", false)),
        Fault::FrozenDevice => Some(("fault-frozen", false)),
        Fault::DeviceClock => Some(("fault-clock", false)),
        Fault::DeviceBundles => Some(("fault-bundles", false)),
        Fault::DeafDevice => Some(("fault-deaf", false)),
        Fault::LostPedal => Some(("fault-pedal", true)),
        Fault::HeldPedal => Some(("fault-held", true)),
        Fault::DeviceFault => Some(("fault-device", false)),
        Fault::DeviceWatchdog => Some(("fault-watchdog", false)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable as _;

    use super::*;

    #[test]
    fn a_simulated_device_raises_no_alarm_that_asks_for_a_plug() {
        let fault = |fault: Fault| EventMsg {
            kind: EventKind::Fault.number(),
            value: fault.number() as f32,
            ..EventMsg::zeroed()
        };
        let faults = [Fault::LostDevice, Fault::SpeedTrip];
        let of_pedal = [Fault::LostPedal, Fault::HeldPedal, Fault::BothElectrodes];
        for (fault, event) in faults.into_iter().chain(of_pedal).map(|it| (it, fault(it))) {
            assert!(matches!(event.decode(), Ok(Event::Fault(it)) if it == fault));
            assert_eq!(alarm(&event, [true; 3]), None, "{fault:?}");
            assert!(alarm(&event, [false; 3]).is_some(), "{fault:?}");
        }
        let handle_alone = [true, true, false];
        assert!(alarm(&fault(Fault::LostPedal), handle_alone).is_some());
    }

    #[test]
    fn a_device_that_limits_its_force_is_reported_once() {
        let mut batch = TimingBatch::zeroed();
        let mut known_ticks = 0;
        assert!(!begins_to_limit(&mut known_ticks, &batch));
        batch.faults[Fault::DeviceLimited as usize] = 3;
        assert!(begins_to_limit(&mut known_ticks, &batch));
        batch.faults[Fault::DeviceLimited as usize] = 9;
        assert!(!begins_to_limit(&mut known_ticks, &batch));
    }
}
