//! The side file of a film: the model's truth about the critical view of safety.

use std::path::{Path, PathBuf};

use assess::{Act, Assessment, Cvs, Metric};
use serde::Serialize;
use session::{Entry, EntryContent, Operation};

use super::RATE;
use crate::problem::Problem;
use crate::report;

/// Time between two moments of the truth, s of the film.
const EVERY_S: f64 = 1.0;

/// The side file of a film.
#[derive(Debug, Serialize)]
pub(super) struct Side {
    /// Name of the film's file.
    video: String,
    /// Id of the session; empty for a session without a task.
    session: String,
    task: String,
    /// Pictures a second.
    rate_hz: u32,
    /// Number of pictures.
    pictures: u32,
    /// Time of the session at the film's beginning, s.
    from_s: f64,
    /// Speed of the film, as a multiple of real time.
    speed: f64,
    moments: Vec<Moment>,
    /// The assessment's record of the shown views.
    cvs: Option<Cvs>,
    outcome: String,
    score: f64,
    /// Acts of instructors, without the texts of remarks.
    acts: Vec<Act>,
}

/// The model's truth at a moment of the film.
#[derive(Debug, Serialize)]
struct Moment {
    /// Time of the film, s.
    video_s: f64,
    /// Share of the tissue in Calot's triangle that is removed.
    triangle: Option<f64>,
    /// Share of the tissue in the bed's lower third that is removed.
    lower_bed: Option<f64>,
    /// Share of cystic duct and artery that is whole.
    two: Option<f64>,
    /// True if the view was shown and held: from the front, from behind.
    held: [bool; 2],
}

/// The side file while the film is made.
pub(super) struct Truth {
    operation: Operation,
    assessment: Assessment,
    next: Option<Entry>,
    sight_rad: [f32; 2],
    video: String,
    moments: Vec<Moment>,
}

/// Path of a film's side file.
pub(super) fn path_of(video: &Path) -> PathBuf {
    video.with_extension("truth.json")
}

impl Truth {
    pub(super) fn of(session: &Path, video: &Path) -> Result<Self, Problem> {
        let mut operation = Operation::open(session)?;
        let (assessment, _) = report::assessment(&operation, session, None, None)?;
        Ok(Self {
            next: operation.next(),
            operation,
            assessment,
            sight_rad: [0.0; 2],
            video: video
                .file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned(),
            moments: Vec::new(),
        })
    }

    /// Assesses the session up to this tick, which the film shows at `video_s`. Returns the angles
    /// of the endoscope, rad: between view and shaft, and of the light cable.
    pub(super) fn until(&mut self, tick: u64, video_s: f64) -> [f32; 2] {
        while let Some(entry) = self.next.take_if(|it| it.tick <= tick) {
            if let EntryContent::Sight {
                off_rad,
                turned_rad,
            } = entry.what
            {
                self.sight_rad = [off_rad, turned_rad];
            }
            self.assessment.take(&entry);
            self.next = self.operation.next();
        }
        let due_s = self.moments.len() as f64 * EVERY_S;
        if video_s + 0.5 / f64::from(RATE) >= due_s {
            let values = self.assessment.metrics();
            let share = |metric| Some(values.get(metric)).filter(|it| it.is_finite());
            self.moments.push(Moment {
                video_s,
                triangle: share(Metric::CvsTriangle),
                lower_bed: share(Metric::CvsBed),
                two: share(Metric::CvsTwo),
                held: self.assessment.views_held(),
            });
        }
        self.sight_rad
    }

    /// Assesses the rest of the session and returns the side file.
    pub(super) fn end(mut self, pictures: u32, from_s: f64, speed: f64) -> Side {
        for entry in self.next.take().into_iter().chain(&mut self.operation) {
            self.assessment.take(&entry);
        }
        let assigned = self.operation.assignment.take().unwrap_or_default();
        let assessed = self.assessment.end();
        Side {
            video: self.video,
            session: assigned.id,
            task: assessed.task.name().to_owned(),
            rate_hz: RATE,
            pictures,
            from_s,
            speed,
            moments: self.moments,
            cvs: assessed.cvs,
            outcome: assessed.outcome.name().to_owned(),
            score: assessed.score,
            acts: assessed.acts.into_iter().map(without_text).collect(),
        }
    }
}

/// The act without its text, which may name persons.
fn without_text(act: Act) -> Act {
    Act {
        remark: None,
        ..act
    }
}
