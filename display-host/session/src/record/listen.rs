//! The listening thread: it takes the station's messages into the queue.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::mpsc;
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use bytemuck::Zeroable as _;
use shared_mem::message::{StateFrame, ToolFrame};
use shared_mem::service::{ServiceError, Station, Tap};

use super::queue::{Item, Items, Queue, queue};
use crate::file::Error;

/// Period at which the services are read. The services keep the messages of 8 s.
pub(super) const LOOK_EVERY: Duration = Duration::from_millis(10);
/// Period at which poses are written for viewers. `/course` and `/tool` get every frame that is
/// read.
const TOOLS_EVERY: Duration = Duration::from_millis(50);
/// Period of the identity images that tell what the endoscope shows.
const SEEN_EVERY: Duration = Duration::from_millis(200);

/// A thread that listens to a station, so that nothing is missed before the file is opened.
#[derive(Debug)]
pub struct Listening {
    pub(super) thread: JoinHandle<()>,
    pub(super) stop: Arc<AtomicBool>,
    pub(super) overflowed: Arc<AtomicU64>,
    pub(super) items: Items,
    pub(super) prepare: fn(Option<usize>),
    pub(super) tick_cpu: Option<usize>,
}

impl Listening {
    /// Starts listening. Call it before the controller starts: a session without its first tick
    /// cannot be replayed. Each of the recorder's threads calls `prepare` with `tick_cpu`, to stay
    /// off the tick's core.
    ///
    /// # Errors
    /// See [`Error`].
    pub fn begin(
        station: &Station,
        prepare: fn(Option<usize>),
        tick_cpu: Option<usize>,
    ) -> Result<Self, Error> {
        let (answer, answered) = mpsc::sync_channel::<Result<(), ServiceError>>(1);
        let stop = Arc::new(AtomicBool::new(false));
        let overflowed = Arc::new(AtomicU64::new(0));
        let (sender, items) = queue(overflowed.clone());
        let (station, stopped) = (station.clone(), stop.clone());
        let thread = Builder::new()
            .name("calot-listen".to_owned())
            .spawn(move || {
                prepare(tick_cpu);
                match Tap::open(&station) {
                    Ok(tap) => {
                        let _ = answer.send(Ok(()));
                        listen(&tap, &sender, &stopped);
                    }
                    Err(error) => {
                        let _ = answer.send(Err(error));
                    }
                }
            })
            .map_err(Error::Thread)?;
        if let Ok(opened) = answered.recv() {
            opened?;
        }
        Ok(Self {
            thread,
            stop,
            overflowed,
            items,
            prepare,
            tick_cpu,
        })
    }
}

fn listen(tap: &Tap, queue: &Queue, stop: &AtomicBool) {
    let mut shown_at: Option<Instant> = None;
    let mut seen_at: Option<Instant> = None;
    let mut newest_ns = 0;
    let mut tools = ToolFrame::zeroed();
    let send = |item: Item| queue.send(item);
    loop {
        // Read the flag first, so that everything sent before the end is still fetched.
        let last = stop.load(Relaxed);
        tap.drain_inputs(|batch| send(Item::Inputs(Box::new(*batch))));
        tap.drain_events(|event| send(Item::Event(*event)));
        tap.drain_timing(|batch| send(Item::Timing(Box::new(*batch))));
        if tap.newest_tools(&mut tools) && tools.capsules().is_some() && tools.at_ns != newest_ns {
            let shown = shown_at.is_none_or(|at| at.elapsed() >= TOOLS_EVERY);
            if shown {
                shown_at = Some(Instant::now());
            }
            newest_ns = tools.at_ns;
            send(Item::Tools(Box::new(tools), shown));
        }
        if seen_at.is_none_or(|at| at.elapsed() >= SEEN_EVERY) {
            let mut state: Box<StateFrame> = bytemuck::zeroed_box();
            if tap.newest_state(&mut state) {
                seen_at = Some(Instant::now());
                send(Item::State(state));
            }
        }
        if last {
            return;
        }
        std::thread::sleep(LOOK_EVERY);
    }
}
