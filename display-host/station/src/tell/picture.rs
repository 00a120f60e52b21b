//! Pictures of a station in two sizes, drawn in a thread of their own from what a display gets.

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use bytemuck::Zeroable as _;
use display_host::album::Album;
use image::codecs::jpeg::JpegEncoder;
use shared_mem::message::{EventMsg, StateFrame, ToolFrame};
use shared_mem::scene::SceneFile;

use crate::problem::Problem;

/// Size of a tile, pixels.
const TILE: [u32; 2] = [208, 156];
/// Size of an enlarged picture, pixels.
const VIEW: [u32; 2] = [640, 480];
/// Quality of a picture, 1 to 100.
const QUALITY: u8 = 70;
/// Longest step of the effects, s.
const STEP_MAX_S: f32 = 0.5;

/// Pictures a second that somebody wants to see.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Deserialize)]
pub(super) struct Rates {
    #[serde(default)]
    pub(super) tile_hz: f64,
    #[serde(default)]
    pub(super) view_hz: f64,
}

/// The newest data of the station, for the thread that draws.
#[derive(Default)]
pub(super) struct Moment {
    pub(super) newest: Option<(Box<StateFrame>, ToolFrame)>,
    pub(super) events: Vec<EventMsg>,
    pub(super) rates: Rates,
}

/// Time of the next picture of one size.
struct Pace {
    next: Instant,
}

impl Pace {
    /// True if a picture is due at this rate. The next one is due a period later.
    fn is_due(&mut self, rate_hz: f64, now: Instant) -> bool {
        if rate_hz <= 0.0 || now < self.next {
            return false;
        }
        let period = Duration::from_secs_f64(1.0 / rate_hz.clamp(0.1, 30.0));
        self.next = (self.next + period).max(now);
        true
    }
}

/// Draws until `is_over`. `send` gets true for the large size, and the picture.
pub(super) fn draw(
    scene: &Path,
    moment: &Arc<Mutex<Moment>>,
    is_over: &dyn Fn() -> bool,
    send: &mut dyn FnMut(bool, &[u8]),
) -> Result<(), Problem> {
    let scene = SceneFile::open(scene)?;
    let mut sizes = [(false, TILE, None), (true, VIEW, None)];
    let now = Instant::now();
    let mut paces = [Pace { next: now }, Pace { next: now }];
    let mut state = Box::new(StateFrame::zeroed());
    while !is_over() {
        std::thread::sleep(Duration::from_millis(8));
        let now = Instant::now();
        let rates = moment.lock().unwrap_or_else(PoisonError::into_inner).rates;
        let due = [
            paces[0].is_due(rates.tile_hz, now),
            paces[1].is_due(rates.view_hz, now),
        ];
        if due == [false; 2] {
            continue;
        }
        let mut events = Vec::new();
        let tools = {
            let mut moment = moment.lock().unwrap_or_else(PoisonError::into_inner);
            let Some(newest) = &moment.newest else {
                continue;
            };
            *state = *newest.0;
            let tools = newest.1;
            events.append(&mut moment.events);
            tools
        };
        for ((is_large, size, open), due) in sizes.iter_mut().zip(due) {
            // An open album gets every event, so that its effects are complete.
            if open.is_none() && due {
                *open = Some((Album::open(&scene, *size)?, Instant::now()));
            }
            let Some((album, drawn)) = open else { continue };
            let seconds = drawn.elapsed().as_secs_f32().min(STEP_MAX_S);
            *drawn = Instant::now();
            album.pass(&state, &tools, &events, seconds);
            if due {
                let picture = album.picture(&state, &tools, 0.0)?;
                send(*is_large, &jpeg(picture)?);
            }
        }
    }
    Ok(())
}

fn jpeg(picture: image::RgbaImage) -> Result<Vec<u8>, Problem> {
    let mut bytes = Vec::new();
    let picture = image::DynamicImage::from(picture).to_rgb8();
    JpegEncoder::new_with_quality(&mut bytes, QUALITY).encode_image(&picture)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_come_at_their_rate_and_none_are_made_up_for_a_delay() {
        let start = Instant::now();
        let mut pace = Pace { next: start };
        let at = |ms| start + Duration::from_millis(ms);
        assert!(!pace.is_due(0.0, at(0)));
        let due: Vec<bool> = [0, 100, 499, 500, 900, 3000, 3001, 3499]
            .map(|ms| pace.is_due(2.0, at(ms)))
            .to_vec();
        assert_eq!(due, [true, false, false, true, false, true, true, false]);
    }
}
