//! Pictures of chosen moments of a replayed session, as a display would have shown them. No window
//! and no running controller is needed.

use std::io::Cursor;

use shared_mem::message::{EventMsg, StateFrame, ToolFrame};
use shared_mem::scene::SceneFile;
use shared_mem::words::Switches;

use crate::DisplayError;
use crate::effects::{Causes, Effect};
use crate::render::gpu::Gpu;
use crate::render::{Quality, Renderer};

/// Time constant of a film's exposure, s.
const EXPOSURE_S: f32 = 0.4;

/// Draws pictures of a session's moments.
pub struct Album {
    gpu: Gpu,
    renderer: Renderer,
    causes: Causes,
}

impl core::fmt::Debug for Album {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Album").finish_non_exhaustive()
    }
}

impl Album {
    /// Opens an album for pictures of this scene, of `size` pixels.
    ///
    /// # Errors
    /// [`DisplayError::NoAdapter`], [`DisplayError::Device`], [`DisplayError::Size`],
    /// [`DisplayError::TooLarge`].
    pub fn open(scene: &SceneFile, size: [u32; 2]) -> Result<Self, DisplayError> {
        let gpu = Gpu::open()?;
        let quality = Quality {
            size,
            ..Quality::for_adapter(&gpu)
        };
        let mut renderer = Renderer::new(&gpu, scene, quality)?;
        // Each picture has its final exposure at once, because it has no predecessor to adapt from.
        renderer.exposure_mut().adapt = 1.0;
        Ok(Self {
            gpu,
            renderer,
            causes: Causes::of(scene),
        })
    }

    /// Advances the effects by `seconds` up to this moment: smoke drifts, blood runs. `events` are
    /// the events in these seconds.
    pub fn pass(
        &mut self,
        state: &StateFrame,
        tools: &ToolFrame,
        events: &[EventMsg],
        seconds: f32,
    ) {
        let spheres = state.spheres().unwrap_or(&[]);
        let of_events = events.iter().filter_map(|event| self.causes.event(event));
        let mut begin: Vec<Effect> = of_events.collect();
        // In a pause, the electrode burns nothing, whatever the pedals say.
        if !tools.switches().contains(Switches::PAUSED) {
            begin.extend(self.causes.work(state, tools, seconds));
        }
        if !begin.is_empty() {
            self.renderer.follow(spheres);
        }
        self.renderer.play(spheres, &begin, seconds);
    }

    /// Clears all effects. Call it when the organs were reset.
    pub fn clear(&mut self) {
        self.renderer.effects_mut().clear();
    }

    /// Prepares for a film whose pictures follow each other by `seconds`: the exposure adapts as a
    /// camera's does.
    pub fn film(&mut self, seconds: f32) {
        self.renderer.exposure_mut().adapt = 1.0 - (-seconds / EXPOSURE_S).exp();
    }

    /// Takes another endoscope. `angle` is the angle between its view and its shaft, `turned` the
    /// turn of the view about the shaft, rad.
    pub fn look(&mut self, [angle, turned]: [f32; 2]) {
        let scope = self.renderer.scope_mut();
        (scope.angle, scope.turned) = (angle, turned);
    }

    /// Draws this moment as a PNG, as the endoscope showed it.
    ///
    /// # Errors
    /// [`DisplayError::Device`].
    pub fn draw(&mut self, state: &StateFrame, tools: &ToolFrame) -> Result<Vec<u8>, DisplayError> {
        let picture = self.picture(state, tools, 0.0)?;
        let mut png = Cursor::new(Vec::new());
        let written = picture.write_to(&mut png, image::ImageFormat::Png);
        written.map_err(|error| DisplayError::Device {
            doing: "packing a picture",
            detail: error.to_string(),
        })?;
        Ok(png.into_inner())
    }

    /// Draws this moment, `time_s` after the beginning, as the endoscope showed it.
    ///
    /// # Errors
    /// [`DisplayError::Device`].
    pub fn picture(
        &mut self,
        state: &StateFrame,
        tools: &ToolFrame,
        time_s: f32,
    ) -> Result<image::RgbaImage, DisplayError> {
        let spheres = state.spheres().unwrap_or(&[]);
        self.renderer
            .set_cells(&self.gpu, state.cells().unwrap_or(&[]));
        self.renderer.set_sutures(state.sutures());
        if let Some(parted) = state.parted() {
            self.renderer.set_parted(&self.gpu, parted);
        }
        self.renderer
            .set_clips(state.clips().unwrap_or(&[]), spheres);
        self.renderer.set_stones(state.stones().unwrap_or(&[]));
        self.renderer.render(&self.gpu, spheres, tools, time_s);
        self.renderer.read(&self.gpu)
    }
}
