//! `calot photon`: measures with a light sensor how long after a tick, and after a motion of the
//! handle, the screen changes.
//!
//! ```text
//! station (calot emulate, calot rt) ─► inputs of every tick ──┐
//!          └─► window with a square that changes ─► pictures ─┼─► measure ─► photon.json, .html
//!                       └─► light ─► sensor ─► edges ─────────┘
//! ```

pub(crate) mod args;
mod measure;
mod sensor;

use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use display_host::headless::Observed;
use display_host::patch::{By, Patch, Place, Surface};
use display_host::ui::Settings;
use display_host::window::{self, WindowConfig};
use figures::{Machine, PresentationSummary};
use jitter::photon::{self, FILE, Figures, Light, Pairs, Report, Screen, Spread};
use shared_mem::scene::SceneFile;
use shared_mem::service::Station;

use self::args::{PhotonArgs, PlaceName};
use self::measure::{Measure, Row};
use self::sensor::Eye;
use crate::args::LanguageName;
use crate::children::Process;
use crate::document;
use crate::folder::Folder;
use crate::output::{self, Format};
use crate::problem::Problem;
use crate::run::args::RunArgs;
use crate::run::player::Player;
use crate::run::processes;
use crate::say;
use crate::scene;
use crate::stop;

/// Size of the window until it covers the whole screen, pixels.
const SIZE: [u32; 2] = [1280, 720];
/// The time between two changes is the longest time to light plus this, ms. The default sum, 499
/// ms, is odd, so that changes fall into all phases of the screen's frames.
const APART_MS: u64 = 99;
/// If the times of the sensor's edges are uncertain by this or more (±), a note says so, ms.
const COARSE_MS: f64 = 1.0;

/// Result of the measuring thread: rows, and true if the measurement reached its end.
type Measured = Result<(Vec<Row>, bool), String>;

pub(crate) fn run(args: &PhotonArgs) -> Result<ExitCode, Problem> {
    window::answers()?;
    let stop = stop::flag()?;
    let out = output::folder(
        args.out.as_deref(),
        "photon",
        Format::of_result,
        args.overwrite,
    )?;
    let mut eye = Eye::open(&args.sensor)?;
    let folder = Folder::open(&args.station, false)?;
    let scene = scene::compile(&args.scene, &folder.scene())?;
    let station = RunArgs {
        scene: args.scene.clone(),
        station: args.station.clone(),
        controller: args.controller.clone(),
        ..RunArgs::default()
    };
    let mut running = processes::start(&station, Player::Script, &scene, folder.path(), &stop)?;
    let patch = Arc::new(Patch::new(args.size.is_none(), args.longest + APART_MS));
    let measured = show_and_measure(args, &running.scene, &patch, &mut eye, &stop);
    let dead = running.children.drain(..).rev().filter_map(Process::end);
    let dead: Vec<String> = dead.collect();
    let ((rows, complete), presentation) = match measured {
        Err(problem) if !dead.is_empty() => {
            return Err(format!("{problem}; {}", dead.join("; ")).into());
        }
        outcome => outcome?,
    };
    let surface = patch.surface().ok_or("no picture was drawn")?;
    let scene_name = SceneFile::open(&running.scene)?.name().to_owned();
    let mut report = report(args, scene_name, &rows, &eye, (surface, presentation));
    report.complete = complete && dead.is_empty();
    report.notes.extend(running.warnings);
    report.notes.extend(dead);
    save(&report, &rows, &out)?;
    match args.json {
        true => document::PHOTON.answer(&report)?,
        false => say::answer(photon::text(&report).trim_end()),
    }
    say::note(format_args!(
        "wrote {0}/{FILE} and {0}/photon.html",
        out.display()
    ));
    Ok(match report.complete {
        true => ExitCode::SUCCESS,
        false => ExitCode::FAILURE,
    })
}

/// Shows the window while a thread measures. When one of them ends, the other ends too.
fn show_and_measure(
    args: &PhotonArgs,
    scene: &Path,
    patch: &Arc<Patch>,
    eye: &mut Eye,
    stop: &Arc<AtomicBool>,
) -> Result<((Vec<Row>, bool), PresentationSummary), Problem> {
    let station = Station::new(&args.station)?;
    let places: Vec<Place> = args.place.iter().map(|&name| place(name)).collect();
    let config = WindowConfig {
        station: station.clone(),
        scene: scene.to_owned(),
        size: args.size.unwrap_or(SIZE),
        scope_angle: 0.0,
        muted: true,
        cold_lens: false,
        seconds: None,
        lose_device_after: None,
        tick_cpu: args.controller.realtime.core,
        settings: Settings {
            language: LanguageName::or_users(None),
            ..Settings::default()
        },
        task: None,
        instructor: false,
        watched: false,
        simulated: [false; 3],
        replayed_task: None,
        acts: None,
        replay: None,
        recording: None,
        pictures: None,
        patch: Some(Arc::clone(patch)),
    };
    // Set by Ctrl-C, by the end of the window, and by the end of the measurement.
    let over = Arc::clone(stop);
    std::thread::scope(|scope| {
        let measure = {
            let over = &*over;
            let measure = Measure {
                station: &station,
                patch,
                eye,
                places: &places,
                time: Duration::from_secs_f64(args.seconds),
                longest_ns: args.longest * 1_000_000,
                patience: Duration::from_secs_f64(args.patience),
                stop: over,
            };
            scope.spawn(move || -> Measured {
                let outcome = measure.run();
                over.store(true, Ordering::Relaxed);
                outcome.map_err(|problem| problem.to_string())
            })
        };
        let shown = window::run_apart(config, Arc::clone(&over), |observed| {
            if let Observed::Warning(text) = observed {
                say::note(format_args!("warning: {text}"));
            }
        });
        over.store(true, Ordering::Relaxed);
        let measured = measure.join();
        let presentation = shown?.presentation.summary();
        match measured {
            Ok(outcome) => Ok((outcome?, presentation)),
            Err(_) => Err("the thread that measures panicked".into()),
        }
    })
}

/// Report on the rows. `complete` is still false.
fn report(
    args: &PhotonArgs,
    scene: String,
    rows: &[Row],
    eye: &Eye,
    (surface, presentation): (Surface, PresentationSummary),
) -> Report {
    let presented = (rows.iter()).flat_map(|row| row.pairs.picture_to_presentation_ns.iter());
    let delay_ms = args.sensor.sensor_delay;
    let places: Vec<Figures> = rows
        .iter()
        .map(|row| {
            let from = match row.by {
                By::Tick => "tick",
                By::Motion => "motion",
            };
            Figures::of(row.place.name(), from, &row.pairs, delay_ms)
        })
        .collect();
    let within_ms = eye.within_ms();
    Report {
        program: concat!("calot ", env!("CARGO_PKG_VERSION")).to_owned(),
        command: crate::jitter::command(),
        scene,
        complete: false,
        longest_ms: args.longest as f64,
        notes: notes(
            &places,
            (eye.kind, within_ms, delay_ms),
            &surface,
            &presentation,
        ),
        places,
        sensor: Light {
            kind: eye.kind,
            name: eye.name.clone(),
            inverted: rows.first().is_some_and(|row| row.pairs.inverted),
            within_ms,
            delay_ms,
        },
        screen: Screen {
            size: surface.size,
            full_screen: surface.full_screen,
            refresh_hz: surface.refresh_hz,
            present_mode: surface.present_mode,
            adapter: surface.adapter,
            presentation_ms: Spread::of(presented.copied()),
            presentation,
        },
        machine: Machine::read(),
    }
}

/// Remarks that a reader of the figures needs: what they leave out or cannot tell.
fn notes(
    places: &[Figures],
    (kind, within_ms, delay_ms): (&str, Option<f64>, f64),
    surface: &Surface,
    presentation: &PresentationSummary,
) -> Vec<String> {
    let mut notes = Vec::new();
    let on_x11 = presentation.by_hardware.is_none();
    if on_x11 && presentation.copies > presentation.flips {
        notes.push(
            "most pictures were copied into the window: their presentation is the end of the copy, \
             and the screen may show them a frame later"
                .to_owned(),
        );
    }
    if presentation.by_hardware == Some(0) {
        notes.push(
            "the Wayland compositor read the times of presentation from its own clock and not from the \
             screen's hardware: the screen may show pictures earlier or later"
                .to_owned(),
        );
    }
    if !surface.full_screen {
        notes.push(
            "the picture was in a window: top, middle and bottom are those of the window, and a \
             compositor may add a frame"
                .to_owned(),
        );
    }
    if kind == "sound" && delay_ms <= 0.0 {
        notes.push(
            "times to light include the sound card's buffer; a known delay is left out with \
             --sensor-delay"
                .to_owned(),
        );
    }
    if let Some(ms) = within_ms.filter(|ms| *ms >= COARSE_MS) {
        notes.push(format!(
            "the sensor's times are exact to ±{ms:.1} ms only: behind USB, set the adapter's latency \
             timer to 1 ms; let a board report more often"
        ));
    }
    for it in places.iter().filter(|it| it.is_cut()) {
        notes.push(format!(
            "{}, from {}: {} of {} changes were not seen in time, so others may have been too late as \
             well: allow more with --longest, or move the sensor",
            it.place, it.from, it.unseen, it.changes
        ));
    }
    for it in places.iter().filter(|it| it.is_few()) {
        let less = match it.from {
            "motion" if it.changes + it.crowded == 0 => ": the handle did not move",
            "motion" if it.crowded > it.changes => ": move the handle more slowly",
            _ => "",
        };
        notes.push(format!(
            "{}, from {}: only {} changes{less}; medians need ten and more",
            it.place, it.from, it.changes
        ));
    }
    notes
}

fn save(report: &Report, rows: &[Row], out: &Path) -> Result<(), Problem> {
    std::fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()))?;
    let pairs: Vec<Pairs> = rows.iter().map(|row| row.pairs.clone()).collect();
    let json = serde_json::to_string_pretty(&document::PHOTON.of(report))?;
    for (name, text) in [(FILE, json), ("photon.html", photon::html(report, &pairs))] {
        let path = out.join(name);
        std::fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))?;
    }
    Ok(())
}

const fn place(name: PlaceName) -> Place {
    match name {
        PlaceName::Top => Place::Top,
        PlaceName::Middle => Place::Middle,
        PlaceName::Bottom => Place::Bottom,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes_say_what_the_figures_leave_out() {
        let surface = Surface {
            size: SIZE,
            full_screen: false,
            refresh_hz: None,
            present_mode: "Fifo".to_owned(),
            adapter: "none".to_owned(),
        };
        let row = |from, pairs: &Pairs| Figures::of("top", from, pairs, 0.0);
        let still = Pairs::default();
        let hasty = Pairs {
            crowded: 40,
            ..Pairs::default()
        };
        let late = Pairs {
            unseen: 3,
            ..Pairs::default()
        };
        let places = [
            row("motion", &still),
            row("motion", &hasty),
            row("tick", &late),
        ];
        let copied = PresentationSummary {
            source: Some("x11_present"),
            copies: 9,
            ..PresentationSummary::default()
        };
        let notes = notes(&places, ("sound", Some(8.0), 0.0), &surface, &copied).join("\n");
        for part in [
            "copied into the window",
            "in a window",
            "include the sound card's buffer",
            "±8.0 ms only",
            "only 0 changes: the handle did not move",
            "move the handle more slowly",
            "3 of 3 changes were not seen in time",
        ] {
            assert!(notes.contains(part), "{part} in {notes}");
        }
        let plain = Surface {
            full_screen: true,
            ..surface
        };
        let sensor = ("pin", Some(0.05), 0.0);
        let composed = PresentationSummary {
            source: Some("wp_presentation"),
            by_hardware: Some(0),
            ..copied.clone()
        };
        let notes = super::notes(&[], sensor, &plain, &composed);
        assert_eq!(notes.len(), 1);
        assert!(notes[0].contains("from its own clock"));
        let flipped = PresentationSummary {
            flips: 9,
            copies: 0,
            ..copied
        };
        assert!(super::notes(&[], sensor, &plain, &flipped).is_empty());
    }
}
