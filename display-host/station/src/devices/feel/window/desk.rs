//! The person's side of the window: shows the test's screens and sends answers.

use std::sync::atomic::AtomicBool;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use display_host::ui::feel::{Live, Progress, Screen, View, Wish, feel};
use display_host::window::Page;
use display_host::words::Words;
use hardware::feel::{Answer, Squeezed};
use rt_core::port::DeviceCapabilities;

use super::guide::{Said, Turn, Windowed, direction};
use super::signs::Signs;
use crate::devices::feel::weight::weight_n;

/// Period at which the page shows the newest position and force.
const PERIOD: Duration = Duration::from_millis(50);

/// The page of the test.
pub(super) struct Desk {
    pub(super) view: View,
    /// Number of the screen that is shown.
    number: u32,
    turns: Receiver<Turn>,
    answers: Sender<(u32, Said)>,
    live: Arc<Mutex<Live>>,
    signs: Arc<Signs>,
    is_over: bool,
}

impl Desk {
    /// Makes a page, and the guide that leads the person at this page through the test. Ctrl-C sets
    /// `stop`.
    pub(super) fn new(
        words: Words,
        can: &DeviceCapabilities,
        signs: &Arc<Signs>,
        stop: &Arc<AtomicBool>,
    ) -> (Self, Windowed) {
        let (sends_turns, turns) = channel();
        let (answers, takes_answers) = channel();
        let live = Arc::new(Mutex::new(Live::default()));
        let guide = Windowed::new(
            sends_turns,
            takes_answers,
            Arc::clone(&live),
            Arc::clone(signs),
            Arc::clone(stop),
        );
        let desk = Self {
            view: View {
                words,
                progress: Progress::default(),
                screen: Screen::Waiting,
                live: Live::default(),
                radius_m: can.workspace_radius_m,
                opens: can.opening.is_measured(),
            },
            number: 0,
            turns,
            answers,
            live,
            signs: Arc::clone(signs),
            is_over: false,
        };
        (desk, guide)
    }

    pub(super) fn take(&mut self, wish: Wish) {
        match wish {
            Wish::Done => self.say(Said::Done),
            Wish::Felt(way) => {
                let answer = way.map_or(Answer::Nothing, |it| Answer::Felt(direction(it)));
                self.say(Said::Pushed(answer));
            }
            Wish::FeltFingers(open) => self.say(Said::Squeezed(match open {
                Some(true) => Squeezed::Open,
                Some(false) => Squeezed::Shut,
                None => Squeezed::Nothing,
            })),
            Wish::Left(pushes) => self.say(Said::Left(pushes)),
            Wish::HasScale(has) => self.say(Said::HasScale(has)),
            Wish::Grams(text) => {
                self.view.screen = Screen::AskPressed {
                    grams: text,
                    wrong: false,
                };
            }
            Wish::TakeGrams => self.take_grams(),
            Wish::Stop => self.signs.halt(),
            Wish::Close => self.is_over = true,
        }
    }

    fn take_grams(&mut self) {
        let Screen::AskPressed { grams, wrong } = &mut self.view.screen else {
            return;
        };
        let pressed_n = weight_n(grams);
        *wrong = pressed_n.is_none() && !grams.trim().is_empty();
        if !*wrong {
            self.say(Said::Pressed(pressed_n));
        }
    }

    fn say(&self, said: Said) {
        // If the test has ended, nobody needs the answer.
        let _ = self.answers.send((self.number, said));
    }
}

impl Page for Desk {
    fn title(&self) -> String {
        self.view.title()
    }

    fn show(&mut self, ui: &mut egui::Ui) {
        self.signs.see();
        for wish in feel(ui, &self.view) {
            self.take(wish);
            ui.ctx().request_repaint();
        }
    }

    fn look_about(&mut self) -> bool {
        let mut is_new = false;
        loop {
            match self.turns.try_recv() {
                Ok(turn) => {
                    self.number = turn.number;
                    self.view.progress = turn.progress;
                    self.view.screen = turn.screen;
                    is_new = true;
                }
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => {
                    // Results stay until the person closes them.
                    self.is_over |= !matches!(self.view.screen, Screen::Ended(_));
                    break;
                }
            }
        }
        if let Ok(live) = self.live.lock()
            && *live != self.view.live
        {
            self.view.live = *live;
            is_new = true;
        }
        is_new
    }

    fn period(&self) -> Duration {
        PERIOD
    }

    fn escape(&mut self) {
        self.signs.halt();
    }

    fn is_over(&self) -> bool {
        self.is_over
    }
}
