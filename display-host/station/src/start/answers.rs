//! Questions and the rating sheet after an operation.

use display_host::ui::launcher::{Asking, Points, Screen, Wish};
use display_host::words::Words;
use store::{GOALS, Store};

use super::{Desk, problem};
use crate::clock::now_unix_s;

/// Questions a new rater's name that looks like a known one, once.
fn unlike(words: &Words, store: &Store, points: &Points) -> Result<(), String> {
    let known = store.alike_rater(&points.rater);
    let Some(known) = known.map_err(|it| problem::of_store(words, &it))? else {
        return Ok(());
    };
    let question = words.say_with("points-rater-alike", &[("known", known.into())]);
    match points.problem.as_ref() == Some(&question) {
        true => Ok(()),
        false => Err(question),
    }
}

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
            rater: String::new(),
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
            Wish::Rater(name) => points.rater.clone_from(name),
            _ => points.at = points.at.saturating_sub(1),
        }
    }

    /// Stores the points. On failure the screen keeps them and shows the reason.
    pub(super) fn keep(&mut self) {
        let Screen::Points(points) = &self.view.screen else {
            return;
        };
        let given: Vec<u8> = points.given.iter().flatten().copied().collect();
        let asking = points.asking;
        let kept = self.put(points, &given);
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

    fn put(&self, points: &Points, given: &[u8]) -> Result<(), String> {
        let mut store = self.open_store()?;
        let words = &self.view.words;
        let kept = match points.asking {
            Asking::Questions => {
                store.answer(&points.trainee, &self.questions, given, now_unix_s())
            }
            Asking::Sheet => {
                let session = self.debrief.as_ref().map_or("", |(_, session)| session);
                let given = given.try_into().map_err(|_| words.say("sheet-not-whole"))?;
                unlike(words, &store, points)?;
                store.set_sheet(session, &points.rater, given)
            }
        };
        kept.map_err(|it| problem::of_store(words, &it))
    }
}

#[cfg(test)]
mod tests {
    use assess::{Difficulty, Outcome};

    use super::*;

    #[test]
    fn a_new_rater_like_a_known_one_is_questioned_once() {
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::open(&folder.path().join("store.sqlite")).unwrap();
        let words = Words::default();
        let mut points = Points {
            asking: Asking::Sheet,
            trainee: "Ada".to_owned(),
            items: Vec::new(),
            given: Vec::new(),
            at: 0,
            rater: "Bo Berg".to_owned(),
            problem: None,
        };
        assert_eq!(unlike(&words, &store, &points), Ok(()));
        let session = crate::store::tests::session(1, Difficulty::Exam, Outcome::Passed);
        store.add_session("Ada", &session).unwrap();
        store.set_sheet(&session.id, "Bo Berg", [3; 5]).unwrap();
        assert_eq!(unlike(&words, &store, &points), Ok(()), "the same name");
        "bo berg".clone_into(&mut points.rater);
        let question = unlike(&words, &store, &points).unwrap_err();
        assert!(question.contains("Bo Berg"), "{question}");
        points.problem = Some(question);
        assert_eq!(unlike(&words, &store, &points), Ok(()), "saved once more");
    }
}
