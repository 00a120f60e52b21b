//! Carries out the user's requests: commands to the controller, and changes of the window's state.

use std::time::Duration;

use shared_mem::message::CommandMsg;
use shared_mem::scene::SceneFile;

use super::super::free_view::FreeCamera;
use super::super::refusal::Refusal;
use super::{Session, lead};
use crate::headless::Observed;
use crate::ui::Asked;
use crate::words::Words;

/// Longest wait for the answer to a command. The picture waits as well.
const COMMAND_PATIENCE: Duration = Duration::from_millis(60);
/// Longest wait for the answer to a command that begins a task.
const START_PATIENCE: Duration = Duration::from_secs(2);

impl Session {
    /// Carries out the requests, except those that the window itself handles.
    pub(in crate::window) fn carry_out(
        &mut self,
        asked: &[Asked],
        scene: &SceneFile,
        observer: &mut dyn FnMut(Observed<'_>),
    ) {
        for asked in asked {
            if self.ui.instructor && asked.reaches_in() {
                continue;
            }
            let (kind, argument) = match *asked {
                Asked::Pause(on) => (CommandMsg::PAUSE, u32::from(on)),
                // A task that has a start of its own begins there again.
                Asked::Reset => match self.ui.task_view.as_ref().and_then(|it| it.start) {
                    Some(task) => (CommandMsg::START, task),
                    None => (CommandMsg::RESET, 0),
                },
                Asked::EnableForce(on) => (CommandMsg::ENABLE_FORCE, u32::from(on)),
                Asked::Instrument(number) => (CommandMsg::INSTRUMENT, number),
                Asked::Acknowledge => {
                    (self.ui.alarm, self.ui.machine_alarm) = (None, None);
                    continue;
                }
                Asked::ToggleEngineering => {
                    self.ui.turn_engineering();
                    continue;
                }
                Asked::TogglePanel => {
                    self.ui.panel_hidden = !self.ui.panel_hidden;
                    continue;
                }
                Asked::ToggleHand if self.ui.watched => {
                    self.note(self.ui.words.say("watched-note"));
                    continue;
                }
                Asked::ToggleHand => {
                    if let Err(refusal) = self.operate.toggle() {
                        self.refuse(&refusal, observer);
                    }
                    continue;
                }
                Asked::ShowSettings(open) => {
                    // The settings need the mouse, so the instrument is released.
                    if open && self.operate.is_on() {
                        self.carry_out(&[Asked::ToggleHand], scene, observer);
                    }
                    self.ui.settings_open = open;
                    self.pause_for_settings(open, scene, observer);
                    continue;
                }
                Asked::Set(settings) => {
                    self.ui.set(settings);
                    self.operate.set(lead(settings.look));
                    observer(Observed::Settings(settings));
                    continue;
                }
                Asked::Point(at) => {
                    self.point(at, scene);
                    continue;
                }
                Asked::Act(act) => {
                    self.act(act);
                    continue;
                }
                Asked::Seek(at_ms) => (CommandMsg::SEEK, at_ms),
                Asked::Speed(speed) => (CommandMsg::SPEED, speed),
                Asked::FreeView(free) => {
                    let tools = self.feed.tools().filter(|_| free);
                    self.free = tools.map(FreeCamera::at);
                    continue;
                }
                Asked::LookAround(by) => {
                    let tools = self.feed.tools();
                    let here = self.free.or_else(|| tools.map(FreeCamera::at));
                    self.free = here.map(|mut camera| {
                        camera.turn(by);
                        camera
                    });
                    continue;
                }
                Asked::Again => {
                    self.carry_out(&[Asked::Reset, Asked::Pause(false)], scene, observer);
                    continue;
                }
                // The window itself handles these.
                Asked::NextScope
                | Asked::TurnScope(_)
                | Asked::TurnFocus(_)
                | Asked::WipeLens
                | Asked::ToggleSuction
                | Asked::ToggleFullScreen
                | Asked::Quit => continue,
            };
            let command = CommandMsg { kind, argument };
            let patience = match kind {
                CommandMsg::START => START_PATIENCE,
                _ => COMMAND_PATIENCE,
            };
            let refusal = match self.host.command(command, patience) {
                Ok(reply) if reply.outcome == 0 => {
                    if [CommandMsg::RESET, CommandMsg::START, CommandMsg::SEEK].contains(&kind) {
                        self.forget_effects();
                        self.force.clear();
                    }
                    continue;
                }
                Ok(reply) => Refusal::Answer {
                    command,
                    answer: reply.outcome,
                },
                Err(error) => Refusal::Command { command, error },
            };
            self.refuse(&refusal, observer);
        }
    }

    /// Pauses the controller while the settings are open.
    fn pause_for_settings(
        &mut self,
        open: bool,
        scene: &SceneFile,
        observer: &mut dyn FnMut(Observed<'_>),
    ) {
        let works = !self.ui.instructor && self.replay.is_none() && self.is_live();
        if open && works && !self.ui.is_paused() {
            self.paused_for_settings = true;
            self.carry_out(&[Asked::Pause(true)], scene, observer);
        } else if !open && core::mem::take(&mut self.paused_for_settings) {
            self.carry_out(&[Asked::Pause(false)], scene, observer);
        }
    }

    /// Reports a refusal: as an alarm in the user's language, and in English to the operator of the
    /// station.
    fn refuse(&mut self, refusal: &Refusal, observer: &mut dyn FnMut(Observed<'_>)) {
        observer(Observed::Warning(&refusal.said(&Words::default())));
        self.ui.alarm = Some(refusal.said(&self.ui.words));
    }
}
