//! A thread that draws stills into PNG files.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::thread::JoinHandle;

use shared_mem::message::{StateFrame, ToolFrame};
use shared_mem::scene::SceneFile;

use crate::DisplayError;
use crate::effects::Stretch;
use crate::effects::fluid::Balance;
use crate::latency::{FrameRecord, now_ns};
use crate::render::gpu::Gpu;
use crate::render::{Quality, Renderer};

/// A moment to draw.
pub(crate) struct Still {
    pub(crate) state: Box<StateFrame>,
    pub(crate) tools: ToolFrame,
    pub(crate) path: PathBuf,
    /// True if the state is the newest and is drawn at once.
    pub(crate) live: bool,
    /// Effects since the previous picture. `None` for a single moment, which is drawn without smoke
    /// and blood.
    pub(crate) effects: Option<Stretch>,
}

impl Still {
    /// Keeps a copy of a moment, to be drawn later.
    pub(crate) fn kept(state: &StateFrame, tools: &ToolFrame, path: PathBuf) -> Self {
        let mut copy: Box<StateFrame> = bytemuck::allocation::zeroed_box();
        *copy = *state;
        Self {
            state: copy,
            tools: *tools,
            path,
            live: false,
            effects: None,
        }
    }
}

enum Answer {
    Ready { adapter: String, software: bool },
    Painted(FrameRecord, Balance),
    Failed(DisplayError),
}

/// Results of the drawing thread.
#[derive(Debug, Default)]
pub(crate) struct Painted {
    /// Graphics adapter and driver, if the device was opened.
    pub(crate) adapter: Option<String>,
    /// True if the adapter is a CPU.
    pub(crate) software: bool,
    pub(crate) frames: Vec<FrameRecord>,
    /// Blood, bile and water at the last picture.
    pub(crate) fluids: Option<Balance>,
}

/// The owner's handle of the drawing thread.
pub(crate) struct Painter {
    orders: Option<Sender<Still>>,
    answers: Receiver<Answer>,
    thread: Option<JoinHandle<()>>,
    drop_waiting: Arc<AtomicBool>,
    painted: Painted,
    left: usize,
}

impl Painter {
    /// Starts the thread, which opens the graphics device and prepares the scene.
    pub(crate) fn start(
        scene: Arc<SceneFile>,
        size: Option<[u32; 2]>,
        tick_cpu: Option<usize>,
    ) -> Result<Self, DisplayError> {
        if let Some([width, height]) = size
            && ![width, height].iter().all(|s| (64..=8192).contains(s))
        {
            return Err(DisplayError::Size { width, height });
        }
        let (orders, order_inbox) = channel::<Still>();
        let (answer_outbox, answers) = channel();
        let drop_waiting = Arc::new(AtomicBool::new(false));
        let dropped = drop_waiting.clone();
        let thread = std::thread::Builder::new()
            .name("calot-painter".into())
            .spawn(move || {
                crate::priority::step_aside(tick_cpu);
                work(&scene, size, &order_inbox, &answer_outbox, &dropped);
            })
            .map_err(|error| DisplayError::Device {
                doing: "starting the drawing thread",
                detail: error.to_string(),
            })?;
        Ok(Self {
            orders: Some(orders),
            answers,
            thread: Some(thread),
            drop_waiting,
            painted: Painted::default(),
            left: 0,
        })
    }

    /// True if the thread is ready and has nothing to draw, so that it draws the next still at
    /// once.
    pub(crate) fn is_free(&self) -> bool {
        self.painted.adapter.is_some() && self.left == 0
    }

    /// True if ready to draw.
    pub(crate) fn is_ready(&self) -> bool {
        self.painted.adapter.is_some()
    }

    /// Number of stills not drawn yet.
    pub(crate) fn left(&self) -> usize {
        self.left
    }

    /// Orders a still.
    pub(crate) fn paint(&mut self, still: Still) {
        // A thread that has ended left its reason in `answers`.
        if let Some(orders) = &self.orders
            && orders.send(still).is_ok()
        {
            self.left += 1;
        }
    }

    /// Drops the waiting stills and takes no more.
    pub(crate) fn drop_waiting(&mut self) {
        self.drop_waiting.store(true, Ordering::Relaxed);
        self.orders = None;
    }

    /// Takes the thread's results. Returns the reason if it failed.
    pub(crate) fn collect(&mut self) -> Option<DisplayError> {
        loop {
            match self.answers.try_recv() {
                Ok(Answer::Ready { adapter, software }) => {
                    self.painted.adapter = Some(adapter);
                    self.painted.software = software;
                }
                Ok(Answer::Painted(frame, fluids)) => {
                    self.left = self.left.saturating_sub(1);
                    self.painted.frames.push(frame);
                    self.painted.fluids = Some(fluids);
                }
                Ok(Answer::Failed(error)) => return Some(error),
                Err(TryRecvError::Empty) => return None,
                Err(TryRecvError::Disconnected) => {
                    self.left = 0;
                    return None;
                }
            }
        }
    }

    /// Waits for the thread to draw the ordered pictures and to end. Returns its results.
    pub(crate) fn end(mut self) -> Painted {
        self.orders = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
        let _ = self.collect();
        std::mem::take(&mut self.painted)
    }
}

fn work(
    scene: &SceneFile,
    size: Option<[u32; 2]>,
    orders: &Receiver<Still>,
    answers: &Sender<Answer>,
    dropped: &AtomicBool,
) {
    if let Err(error) = paint_all(scene, size, orders, answers, dropped) {
        // The owner may be gone; nobody else needs the reason.
        let _ = answers.send(Answer::Failed(error));
    }
}

fn paint_all(
    scene: &SceneFile,
    size: Option<[u32; 2]>,
    orders: &Receiver<Still>,
    answers: &Sender<Answer>,
    dropped: &AtomicBool,
) -> Result<(), DisplayError> {
    let gpu = Gpu::open()?;
    let mut quality = Quality::for_adapter(&gpu);
    quality.size = size.unwrap_or(quality.size);
    let mut renderer = Renderer::new(&gpu, scene, quality)?;
    // The first frame compiles shaders, which takes seconds on a software driver.
    renderer.render(&gpu, &[], &resting(scene), 0.0);
    gpu.wait("drawing the first frame")?;
    let ready = Answer::Ready {
        adapter: gpu.describe(),
        software: gpu.is_software(),
    };
    if answers.send(ready).is_err() {
        return Ok(());
    }
    while let Ok(still) = orders.recv() {
        if dropped.load(Ordering::Relaxed) {
            return Ok(());
        }
        let spheres = still.state.spheres().unwrap_or(&[]);
        // A still without effects leaves the effects of the run as they are.
        let mut apart = None;
        match &still.effects {
            Some(stretch) => stretch.play(&mut renderer, spheres),
            None => {
                let none = renderer.effects().none();
                apart = Some(core::mem::replace(renderer.effects_mut(), none));
            }
        }
        renderer.set_cells(&gpu, still.state.cells().unwrap_or(&[]));
        let time_s = (still.state.at_ns % 3_600_000_000_000) as f32 * 1e-9;
        renderer.set_sutures(still.state.sutures());
        if let Some(parted) = still.state.parted() {
            renderer.set_parted(&gpu, parted);
        }
        renderer.set_clips(still.state.clips().unwrap_or(&[]), spheres);
        renderer.set_stones(still.state.stones().unwrap_or(&[]));
        renderer.render(&gpu, spheres, &still.tools, time_s);
        let submitted_ns = now_ns();
        let picture = renderer.read(&gpu)?;
        let shown_ns = now_ns();
        if let Some(mut effects) = apart {
            effects.skin_changed(); // it may have changed for this picture
            *renderer.effects_mut() = effects;
        }
        let fluids = renderer.effects().fluids().balance();
        crate::kept::write(&picture, &still.path)?;
        let frame = FrameRecord {
            tick: still.state.tick,
            sample_ns: still.state.sample_ns,
            state_ns: still.state.at_ns,
            submitted_ns,
            shown_ns,
            live: still.live,
            path: Some(still.path),
        };
        if answers.send(Answer::Painted(frame, fluids)).is_err() {
            return Ok(());
        }
    }
    Ok(())
}

/// Tools of the first frame, which nobody sees: camera and instrument at the camera's start.
fn resting(scene: &SceneFile) -> ToolFrame {
    let mut tools: ToolFrame = bytemuck::Zeroable::zeroed();
    tools.world_from_camera = scene.room().world_from_camera;
    tools.world_from_instrument = scene.room().world_from_camera;
    tools.world_from_handle = scene.room().world_from_camera;
    tools
}
