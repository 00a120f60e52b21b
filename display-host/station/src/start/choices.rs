//! Choices of the launcher, and the rules by which they fit together.

use std::ffi::OsString;

use assess::{Difficulty, Task};
use display_host::ui::Look;
use display_host::ui::launcher::StartForm;
use scene_prepare::patient::{NAMES, PREFIX};

use crate::args::IN_TRIANGLE;

/// Scene in which every task can be done.
pub(super) const TRIANGLE: &str = "triangle";
/// Scene of the drills.
const PHANTOM: &str = "phantom";
/// Scenes that need no file.
pub(super) fn scenes() -> Vec<String> {
    let patients = NAMES.map(|name| format!("{PREFIX}{name}"));
    let built_in = [TRIANGLE, "triangle-variant", "built-in", PHANTOM].map(str::to_owned);
    built_in.into_iter().chain(patients).collect()
}

/// Angles of the endoscopes, degrees.
pub(super) const SCOPES: [u16; 3] = [0, 30, 45];

/// Initial choices.
pub(super) fn usual() -> StartForm {
    StartForm {
        task: Task::Basics.name().to_owned(),
        difficulty: Difficulty::Beginner.name().to_owned(),
        scene: TRIANGLE.to_owned(),
        emulated: true,
        ..StartForm::default()
    }
}

/// Tasks in which the trainee may place the sutures.
pub(super) fn hanging() -> Vec<&'static str> {
    let tasks = Task::ALL.into_iter().filter(|it| it.may_hang());
    tasks.map(Task::name).collect()
}

/// The scripted surgeon whom a trainee may watch.
pub(super) const EXPERT: &str = "careful";

/// Arguments of `calot run` for a look: an option for each setting that is not the default.
pub(super) fn look(look: &Look) -> Vec<OsString> {
    let usual = Look::default();
    let mut words: Vec<OsString> = Vec::new();
    for (name, value, usual) in [
        ("--text-size", look.text_percent, usual.text_percent),
        (
            "--sensitivity",
            look.sensitivity_percent,
            usual.sensitivity_percent,
        ),
    ] {
        if value != usual {
            words.extend([name.into(), value.to_string().into()]);
        }
    }
    for (name, is_on) in [
        ("--high-contrast", look.high_contrast),
        ("--left-handed", look.left_handed),
    ] {
        words.extend(is_on.then(|| name.into()));
    }
    words
}

/// Tasks that the expert shows: all but free practice, which has no aim.
pub(super) fn shown() -> Vec<&'static str> {
    let tasks = Task::ALL.into_iter().filter(|it| *it != Task::Free);
    tasks.map(Task::name).collect()
}

/// The choices for the expert's operation: emulated devices, no trainee, and the straight
/// endoscope, which the expert needs.
pub(super) fn of_expert(form: &StartForm) -> StartForm {
    StartForm {
        trainee: String::new(),
        emulated: true,
        own_sutures: false,
        scope_degrees: 0,
        ..form.clone()
    }
}

/// Adapts the other choices to the one that changed.
pub(super) fn fitting(before: &StartForm, mut form: StartForm) -> StartForm {
    if form.scene == "built-in" && IN_TRIANGLE.contains(&form.task.as_str()) {
        match form.task == before.task {
            true => form.task = Task::Free.name().to_owned(),
            false => form.scene = TRIANGLE.to_owned(),
        }
    }
    let is_drill = form.task == Task::Phantom.name();
    if is_drill != (form.scene == PHANTOM) {
        let wish = match form.task == before.task {
            // Another scene was chosen.
            true if is_drill => (Task::Free.name(), None),
            true => (Task::Phantom.name(), None),
            // Another task was chosen.
            false if is_drill => (Task::Phantom.name(), Some(PHANTOM)),
            false => (form.task.as_str(), Some(TRIANGLE)),
        };
        let (task, scene) = (wish.0.to_owned(), wish.1.map(str::to_owned));
        form.task = task;
        form.scene = scene.unwrap_or(form.scene);
    }
    let may_hang = form.scene != "built-in" && hanging().contains(&form.task.as_str());
    form.own_sutures &= may_hang;
    form
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_gets_options_only_for_settings_that_differ() {
        assert!(look(&Look::default()).is_empty());
        let own = Look {
            text_percent: 150,
            high_contrast: true,
            left_handed: true,
            sensitivity_percent: 50,
        };
        let words = look(&own).join(" ".as_ref());
        let expected = "--text-size 150 --sensitivity 50 --high-contrast --left-handed";
        assert_eq!(words, expected);
    }

    #[test]
    fn the_expert_operates_emulated_devices_and_no_result_is_kept() {
        let form = StartForm {
            trainee: "Ada".to_owned(),
            emulated: false,
            ..usual()
        };
        let expert = of_expert(&form);
        assert_eq!((&*expert.trainee, expert.emulated), ("", true));
        assert_eq!(expert.task, form.task);
        assert!(!shown().contains(&Task::Free.name()));
    }

    #[test]
    fn task_and_scene_fit_whichever_was_chosen_last() {
        let before = usual();
        let organs = fitting(
            &before,
            StartForm {
                scene: "built-in".to_owned(),
                ..before.clone()
            },
        );
        assert_eq!((&*organs.task, &*organs.scene), ("free", "built-in"));
        let clamp = fitting(
            &organs,
            StartForm {
                task: "clamp".to_owned(),
                ..organs.clone()
            },
        );
        assert_eq!((&*clamp.task, &*clamp.scene), ("clamp", TRIANGLE));
        let drill = fitting(
            &clamp,
            StartForm {
                task: "phantom".to_owned(),
                ..clamp.clone()
            },
        );
        assert_eq!((&*drill.task, &*drill.scene), ("phantom", PHANTOM));
        for (scene, task) in [(TRIANGLE, "free"), (PHANTOM, "phantom")] {
            let form = StartForm {
                scene: scene.to_owned(),
                ..drill.clone()
            };
            let chosen = fitting(&drill, form);
            assert_eq!((&*chosen.task, &*chosen.scene), (task, scene));
        }
        let cut = fitting(
            &drill,
            StartForm {
                task: "cut".to_owned(),
                ..drill.clone()
            },
        );
        assert_eq!((&*cut.task, &*cut.scene), ("cut", TRIANGLE));
        let own = |task: &str, scene: &str| {
            let form = StartForm {
                task: task.to_owned(),
                scene: scene.to_owned(),
                own_sutures: true,
                ..usual()
            };
            fitting(&form.clone(), form).own_sutures
        };
        assert!(own("full", TRIANGLE) && own("free", "triangle-variant"));
        assert!(!own("cut", TRIANGLE) && !own("free", "built-in"));
    }
}
