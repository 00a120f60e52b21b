//! `calot replay --video`: a film of the session for blinded raters, and a side file with the truth
//! about the critical view.
//!
//! The simulation runs again. Each picture shows its moment, however long drawing takes. The film
//! shows only the endoscope's picture: no name, time, score, mark or text, and no metadata.

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
use shared_mem::words::Switches;

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
/// Step of the effects before the film begins and between its pictures, ticks.
const EFFECTS_EVERY: u64 = 40;
/// Duration of a tick, s.
const TICK_S: f32 = 0.001;
/// Interval between progress messages.
const PROGRESS: Duration = Duration::from_secs(2);

/// Makes the film `out`, and its side file next to it.
pub(super) fn run(
    args: &ReplayArgs,
    session: &mut Session,
    scene: &SceneFile,
    out: &Path,
) -> Result<ExitCode, Problem> {
    // A film has no mark of Calot, so no existing file is ever replaced.
    if std::fs::metadata(out).is_ok_and(|it| it.is_dir() || it.len() > 0) {
        let shown = out.display();
        return Err(format!(
            "--video {shown}: this file exists, and a film is never replaced; name another file"
        )
        .into());
    }
    let side = truth::path_of(out);
    output::check("--video", &side, Format::Json, args.overwrite)?;
    let size = args.size.unwrap_or(SIZE);
    let replay = Replay::new(scene, &session.setup)?;
    let mut film = Film {
        scene_id: replay.scene_id(),
        album: Album::open(scene, size)?,
        truth: Truth::of(&recording(&args.session), out)?,
        // The encoder makes a file, so it begins after everything that may fail.
        encoder: Encoder::begin(out, size, RATE)?,
        state: bytemuck::zeroed_box(),
        tools: bytemuck::zeroed_box(),
        events: Vec::new(),
        first_ns: None,
        length_s: 0.0,
        played: None,
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
    let drawn = film.drawn;
    film.end(args.speed, &side)?;
    say::note(format_args!(
        "wrote {}: {drawn} pictures; the truth of the critical view is in {}: keep it from the raters",
        out.display(),
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
    /// Length of the session so far, s.
    length_s: f64,
    /// Tick up to which the effects were played.
    played: Option<u64>,
    /// Interval of the session between two pictures, s.
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
        self.length_s = at_s;
        if is_restart(record) {
            self.album.clear();
            self.events.clear();
        }
        self.events.extend(tick.events());
        let film_s = |drawn: u32| f64::from(drawn) / f64::from(RATE);
        let is_due = |it: &Self| at_s >= it.from_s + f64::from(it.drawn) * it.every_s;
        let played = *self.played.get_or_insert(record.tick);
        // Effects are played before the film begins, too: its first picture shows earlier blood.
        if is_due(self) || record.tick.saturating_sub(played) >= EFFECTS_EVERY {
            self.play(tick, played);
        }
        while is_due(self) {
            let sight = self.truth.until(record.tick, film_s(self.drawn));
            self.album.look(sight);
            let (state, tools) = (&*self.state, &*self.tools);
            let picture = self
                .album
                .picture(state, tools, film_s(self.drawn) as f32)?;
            self.encoder.push(picture.as_raw())?;
            self.drawn += 1;
        }
        Ok(())
    }

    /// Plays the effects from tick `played` to this one. In a pause, nothing bleeds.
    fn play(&mut self, tick: &Replayed<'_>, played: u64) {
        tick.fill(self.scene_id, &mut self.state, &mut self.tools);
        let seconds = seconds_between(played, tick.record.tick, self.tools.switches());
        self.album
            .pass(&self.state, &self.tools, &self.events, seconds);
        self.events.clear();
        self.played = Some(tick.record.tick);
    }

    /// Ends the film, and writes its truth. Only a whole film with its truth gets its name.
    fn end(mut self, speed: f64, side: &Path) -> Result<(), Problem> {
        if self.drawn == 0 {
            return Err(format!(
                "--from {} s: the session is {:.1} s long, so the film would have no picture; \
                 begin earlier",
                self.from_s, self.length_s
            )
            .into());
        }
        self.encoder.end()?;
        let truth = self.truth.end(self.drawn, self.from_s, speed);
        let text = serde_json::to_string_pretty(&document::VIDEO_TRUTH.of(truth))?;
        output::write(side, &text).map_err(|error| format!("{}: {error}", side.display()))?;
        let kept = self.encoder.keep();
        if kept.is_err() {
            let _ = std::fs::remove_file(side);
        }
        kept
    }
}

/// Time that effects play from one tick to another, s. `switches` belong to the later tick.
fn seconds_between(from: u64, to: u64, switches: Switches) -> f32 {
    match switches.contains(Switches::PAUSED) {
        true => 0.0,
        false => to.saturating_sub(from) as f32 * TICK_S,
    }
}

/// True if this tick returns the organs to rest or to the start of a task.
fn is_restart(record: &InputRecord) -> bool {
    let command = u32::from(record.command & 15);
    matches!(command, CommandMsg::RESET | CommandMsg::START)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effects_follow_the_ticks_and_rest_in_a_pause() {
        let running = Switches::default();
        assert!((seconds_between(100, 140, running) - 0.04).abs() < 1e-6);
        let paused = seconds_between(100, 140, Switches::PAUSED);
        assert_eq!(paused.to_bits(), 0.0f32.to_bits());
    }
}
