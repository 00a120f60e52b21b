//! Questions and the rating sheet after an operation.

use display_host::ui::launcher::{Asking, Points, Screen, Wish};
use store::GOALS;

use super::{Desk, problem};
use crate::clock::now_unix_s;

impl Desk {
    pub(super) fn ask(&mut self, asking: Asking) {
        let Some((debrief, _)) = &self.debrief else {
            return;
        };
        let items: Vec<_> = match asking {
            Asking::Questions => {
                let items = self.questions.items.iter();
                items.map(|it| (it.id.clone(), it.text.clone())).collect()
            }
            Asking::Sheet => GOALS
                .map(|(name, text)| (name.to_owned(), text.to_owned()))
                .to_vec(),
        };
        self.view.screen = Screen::Points(Points {
            asking,
            trainee: debrief.trainee.clone(),
            given: vec![None; items.len()],
            items,
            at: 0,
            problem: None,
        });
    }

    pub(super) fn answer(&mut self, wish: &Wish) {
        let Screen::Points(points) = &mut self.view.screen else {
            return;
        };
        match wish {
            Wish::Answer(given) => {
                if let Some(slot) = points.given.get_mut(points.at) {
                    *slot = Some(*given);
                    points.at += 1;
                }
            }
            _ => points.at = points.at.saturating_sub(1),
        }
    }

    /// Stores the points. On failure the screen keeps them and shows the reason.
    pub(super) fn keep(&mut self) {
        let Screen::Points(points) = &self.view.screen else {
            return;
        };
        let given: Vec<u8> = points.given.iter().flatten().copied().collect();
        let (asking, trainee) = (points.asking, points.trainee.clone());
        let kept = self.put(asking, &trainee, &given);
        match (kept, &mut self.debrief) {
            (Ok(()), Some((debrief, _))) => {
                match asking {
                    Asking::Questions => debrief.answered = true,
                    Asking::Sheet => {
                        debrief.sheet = Some(given.iter().map(|it| u32::from(*it)).sum());
                    }
                }
                self.note(self.view.words.say("points-kept"));
                self.show_debrief();
            }
            (Ok(()), None) => self.show_start(),
            (Err(problem), _) => {
                if let Screen::Points(points) = &mut self.view.screen {
                    points.problem = Some(problem);
                }
            }
        }
    }

    fn put(&self, asking: Asking, trainee: &str, given: &[u8]) -> Result<(), String> {
        let mut store = self.open_store()?;
        let words = &self.view.words;
        let kept = match asking {
            Asking::Questions => store.answer(trainee, &self.questions, given, now_unix_s()),
            Asking::Sheet => {
                let session = self.debrief.as_ref().map_or("", |(_, session)| session);
                let points = given.try_into();
                store.set_sheet(session, points.map_err(|_| words.say("sheet-not-whole"))?)
            }
        };
        kept.map_err(|it| problem::of_store(words, &it))
    }
}
