//! Complications of an instructor: what follows from them is no error of the trainee.

use super::*;

fn opened(assessment: &mut Assessment, at_s: f64) {
    assessment.take(&event(at_s, EventKind::Opened.number(), ARTERY, 0.0, 2e-6));
}

fn slip(assessment: &mut Assessment, at_s: f64, organ: u32, number: f32) {
    let kind = EventKind::Unclipped.number();
    assessment.take(&event(at_s, kind, organ, 0.0, number));
}

/// True for each side whose step is done, among the steps of the task.
fn views(assessment: &Assessment) -> Vec<bool> {
    let steps = assessment.status().steps;
    let views = steps
        .iter()
        .filter(|it| matches!(it.0, Step::ShowView { .. }));
    views.map(|it| it.1).collect()
}

#[test]
fn coagulating_an_artery_is_an_error_unless_an_instructor_opened_it() {
    for is_opened in [false, true] {
        let mut assessment = begin(Task::Free);
        rest(&mut assessment, 0.0, 0.1);
        if is_opened {
            opened(&mut assessment, 0.2);
        }
        assessment.take(&event(0.3, EventKind::Burn.number(), ARTERY, 0.0, 20.0));
        let assessed = assessment.end();
        let errors = usize::from(!is_opened);
        assert_eq!(kinds(&assessed), vec![AlarmKind::Burnt; errors]);
        is(assessed.metrics.get(Metric::BurnsWrong), errors as f64);
        is(
            assessed.metrics.get(Metric::BurnWrong),
            20.0 * errors as f64,
        );
    }
}

#[test]
fn a_clip_on_an_opened_artery_leaves_the_views_possible() {
    for is_opened in [false, true] {
        let mut assessment = begin(Task::Identify);
        rest(&mut assessment, 0.0, 0.1);
        remove(&mut assessment, 0..20);
        if is_opened {
            opened(&mut assessment, 1.1);
        }
        clip(&mut assessment, 1.2, ARTERY, 0.0, 0.0);
        hold_views(&mut assessment, 1.5);
        assert_eq!(assessment.views_held(), [is_opened; 2]);
    }
}

#[test]
fn a_clip_on_an_opened_artery_comes_never_too_early() {
    for is_opened in [false, true] {
        let mut assessment = begin(Task::Full);
        rest(&mut assessment, 0.0, 0.1);
        if is_opened {
            opened(&mut assessment, 0.2);
        }
        clip(&mut assessment, 0.3, ARTERY, 0.0, 0.0);
        let too_early = usize::from(!is_opened);
        let assessed = assessment.end();
        assert_eq!(kinds(&assessed), vec![AlarmKind::TooEarly; too_early]);
    }
}

#[test]
fn a_clip_that_slips_off_opens_no_step_again() {
    let mut assessment = begin(Task::Full);
    rest(&mut assessment, 0.0, 0.1);
    remove(&mut assessment, 0..20);
    assert_eq!(views(&assessment), [false; 2]);
    clip(&mut assessment, 1.2, ARTERY, 0.0, 0.0);
    assert_eq!(views(&assessment), [true; 2], "the view is past");
    slip(&mut assessment, 1.4, ARTERY, 0.0);
    opened(&mut assessment, 1.6);
    assert_eq!(views(&assessment), [true; 2]);
}
