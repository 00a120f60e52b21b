//! A display that draws while a turn is measured.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Sender;
use std::time::Duration;

use display_host::headless::{self, HeadlessConfig};
use display_host::latency::FrameRecord;
use shared_mem::service::Station;

use super::bench::Bench;
use crate::say;

/// The display draws in stretches of this length, s. After each stretch, its files are deleted and
/// the times of its pictures go to the report.
const STRETCH_S: f64 = 20.0;
/// First and least picture rates, Hz. If drawing falls behind, the rate is halved: otherwise the
/// time of a picture would include the wait for an earlier picture.
const PICTURES_PER_S: [f64; 2] = [2.0, 0.25];

/// Runs a display that draws until the turn is done.
pub(super) fn draw(
    bench: &Bench<'_>,
    scene: &Path,
    done: &AtomicBool,
    frames: &Sender<FrameRecord>,
) {
    let out_dir = bench.folder.join("pictures");
    let Ok(station) = Station::new(&bench.station.station) else {
        return;
    };
    let [mut per_s, least_per_s] = PICTURES_PER_S;
    let mut config = HeadlessConfig {
        station,
        scene: scene.to_owned(),
        seconds: STRETCH_S,
        out_dir: out_dir.clone(),
        size: None,
        frames: 0,
        patience: Duration::from_secs(30),
        tick_cpu: Some(bench.core),
        task_over: None,
        task: None,
        need_pictures: true,
    };
    while !done.load(Ordering::Relaxed) && !bench.stop.load(Ordering::Relaxed) {
        config.frames = (STRETCH_S * per_s) as u32;
        let outcome = headless::run(&config, done, &mut |_| ());
        let _ = std::fs::remove_dir_all(&out_dir);
        match outcome {
            Ok(outcome) => {
                let in_time = outcome.frames.iter().filter(|frame| frame.live).count();
                if 2 * in_time < outcome.frames.len() {
                    per_s = (per_s / 2.0).max(least_per_s);
                }
                for frame in outcome.frames {
                    let _ = frames.send(frame);
                }
            }
            Err(problem) => {
                say::note(format_args!(
                    "jitter: the display failed to draw: {problem}"
                ));
                return;
            }
        }
    }
}
