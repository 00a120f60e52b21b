//! `calot replay --video`: a film of the session for blinded raters, and its truth in a side file.
//!
//! The simulation runs again. Each picture shows its moment, however long drawing takes. The film
//! holds the endoscope's picture alone: no name, time, score, mark or text, and no metadata.

mod encoder;
mod truth;

use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use display_host::album::Album;
use rt_process::replay::{Replay, Replayed};
use session::Session;
use shared_mem::inputs::InputRecord;
use shared_mem::message::{CommandMsg, EventMsg, StateFrame, ToolFrame};
use shared_mem::scene::SceneFile;

use self::encoder::Encoder;
use self::truth::Truth;
use super::args::ReplayArgs;
use super::recorded::{LeftOut, next_in_order};
use crate::document;
use crate::output::{self, Format};
use crate::problem::Problem;
use crate::report::recording;
use crate::say;

/// Pictures a second.
pub(super) const RATE: u32 = 25;
/// Size of the pictures, pixels.
const SIZE: [u32; 2] = [640, 480];
/// Interval between progress messages.
const PROGRESS: Duration = Duration::from_secs(2);

/// Makes the film in `out`, and its truth beside it.
pub(super) fn run(
    args: &ReplayArgs,
    session: &mut Session,
    scene: &SceneFile,
    out: &Path,
) -> Result<ExitCode, Problem> {
    // Nobody can tell a film of Calot from another.
    if std::fs::metadata(out).is_ok_and(|it| it.is_dir() || it.len() > 0) {
        let shown = out.display();
        return Err(format!(
            "--video {shown}: is there, and no film is replaced; name another file"
        )
        .into());
    }
    let side = truth::path_of(out);
    output::check("--video", &side, Format::Json, args.overwrite)?;
    let size = args.size.unwrap_or(SIZE);
    let replay = Replay::new(scene, &session.setup)?;
    let mut film = Film {
        scene_id: replay.scene_id(),
        encoder: Encoder::begin(out, size, RATE)?,
        album: Album::open(scene, size)?,
        truth: Truth::of(&recording(&args.session), out)?,
        state: bytemuck::zeroed_box(),
        tools: bytemuck::zeroed_box(),
        events: Vec::new(),
        first_ns: None,
        every_s: args.speed / f64::from(RATE),
        from_s: args.start_s(),
        drawn: 0,
    };
    film.album.film(1.0 / RATE as f32);
    let mut expected = 0;
    let mut gap = None;
    let (mut problem, mut said) = (None, Instant::now());
    let ticks = core::iter::from_fn(|| {
        next_in_order(session, &mut expected).unwrap_or_else(|missing| {
            gap = Some(missing);
            None
        })
    });
    replay.run(ticks, |tick| {
        if said.elapsed() >= PROGRESS {
            said = Instant::now();
            say::note(format_args!("{} pictures", film.drawn));
        }
        problem = film.take(tick).err();
        problem.is_none()
    })?;
    if let Some(problem) = problem {
        return Err(problem);
    }
    for warning in LeftOut::of(session, gap).in_words() {
        say::note(format_args!("warning: {warning}"));
    }
    film.encoder.end()?;
    let truth = film.truth.end(film.drawn, film.from_s, args.speed);
    let text = serde_json::to_string_pretty(&document::VIDEO_TRUTH.of(truth))?;
    output::write(&side, &text).map_err(|error| format!("{}: {error}", side.display()))?;
    say::note(format_args!(
        "wrote {}: {} pictures; the truth of the critical view is in {}: keep it from the raters",
        out.display(),
        film.drawn,
        side.display()
    ));
    Ok(ExitCode::SUCCESS)
}

struct Film {
    scene_id: [u8; 16],
    encoder: Encoder,
    album: Album,
    truth: Truth,
    state: Box<StateFrame>,
    tools: Box<ToolFrame>,
    /// Events since the last picture.
    events: Vec<EventMsg>,
    first_ns: Option<u64>,
    /// Time of the session between two pictures, s.
    every_s: f64,
    /// Time of the session at the film's beginning, s.
    from_s: f64,
    /// Pictures so far.
    drawn: u32,
}

impl Film {
    /// Takes a tick, and draws the pictures that are due.
    fn take(&mut self, tick: &Replayed<'_>) -> Result<(), Problem> {
        let record = tick.record;
        let first_ns = *self.first_ns.get_or_insert(record.now_ns);
        let at_s = record.now_ns.saturating_sub(first_ns) as f64 * 1e-9;
        if is_restart(record) {
            self.album.clear();
            self.events.clear();
        }
        self.events.extend(tick.events());
        let film_s = |drawn: u32| f64::from(drawn) / f64::from(RATE);
        while at_s >= self.from_s + f64::from(self.drawn) * self.every_s {
            let sight = self.truth.until(record.tick, film_s(self.drawn));
            self.album.look(sight);
            tick.fill(self.scene_id, &mut self.state, &mut self.tools);
            let (state, tools) = (&*self.state, &*self.tools);
            self.album
                .pass(state, tools, &self.events, self.every_s as f32);
            self.events.clear();
            let picture = self
                .album
                .picture(state, tools, film_s(self.drawn) as f32)?;
            self.encoder.push(picture.as_raw())?;
            self.drawn += 1;
        }
        Ok(())
    }
}

/// True if this tick returns the organs to rest or to the start of a task.
fn is_restart(record: &InputRecord) -> bool {
    let command = u32::from(record.command & 15);
    matches!(command, CommandMsg::RESET | CommandMsg::START)
}
