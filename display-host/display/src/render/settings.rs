//! Settings of the next frames: which tissue they show, in which state, size and quality.

use shared_mem::message::{ClipMsg, SphereState, StoneMsg, SutureMsg};

use super::gpu::Gpu;
use super::inside::{self, Inside};
use super::materials::shadow_map;
use super::pipeline::Pipelines;
use super::quality::Quality;
use super::targets::Targets;
use super::{Renderer, Shown, clips};
use crate::DisplayError;

impl Renderer {
    /// Shows the model inside the organs from the next frame on. `None` hides it.
    pub fn set_inside(&mut self, gpu: &Gpu, inside: Option<Inside>) {
        self.inside = inside;
        if inside.is_some() && self.inside_model.is_none() {
            let (layouts, quality) = (&self.layouts, &self.quality);
            let model = inside::Model::new(gpu, layouts, quality, &self.rest, &self.springs);
            self.inside_model = Some(model);
        }
    }

    /// Selects the tissue drawn from the next frame on.
    pub fn show(&mut self, shown: Shown) {
        self.shown = shown;
    }

    /// Sets the states of the cells of layered tissue (`StateFrame::cells`) from the next frame on.
    pub fn set_cells(&mut self, gpu: &Gpu, states: &[u8]) {
        self.cells.set(gpu, states, &self.skinning.corners);
    }

    /// Sets the sutures between organs and abdominal wall from the next frame on; `None`: the
    /// scene's own.
    pub fn set_sutures(&mut self, sutures: Option<&[SutureMsg]>) {
        self.sutures.set(sutures);
    }

    /// Sets the severed links of tubes (`StateFrame::parted`) from the next frame on.
    pub fn set_parted(&mut self, gpu: &Gpu, parted: impl Iterator<Item = bool>) {
        if self.pieces.set(parted, &mut self.mesh) {
            let severed: Vec<[u32; 2]> = self.pieces.severed().collect();
            self.motions.sever(&severed);
            self.skinning.replace(gpu, &self.mesh, &self.pieces);
            self.effects.skin_changed();
            self.heated.skin_changed();
        }
    }

    /// Sets the clips on the tubes for the next frame.
    pub fn set_clips(&mut self, clips: &[ClipMsg], spheres: &[SphereState]) {
        self.clips = clips::places(clips, spheres, &self.rest);
    }

    /// Sets the gallstones outside of the gallbladder for the next frame.
    pub fn set_stones(&mut self, stones: &[StoneMsg]) {
        self.stones.set(stones);
    }

    /// Changes everything about the quality except the picture's size.
    ///
    /// # Errors
    /// [`DisplayError::Device`].
    pub fn set_quality(&mut self, gpu: &Gpu, quality: Quality) -> Result<(), DisplayError> {
        let size = self.quality.size;
        self.quality = Quality { size, ..quality };
        let device = &gpu.device;
        self.pipelines = Pipelines::new(device, &self.layouts, &self.quality);
        self.shadow = shadow_map(device, &self.quality);
        self.scene_group = self.materials.group(device, &self.layouts, &self.shadow);
        let (frame, exposure) = (&self.frame, &self.exposure_value);
        let (layouts, filter) = (&self.layouts, &self.filter);
        self.targets = Targets::new(gpu, layouts, frame, exposure, filter, &self.quality);
        self.inside_model = None;
        self.set_inside(gpu, self.inside);
        gpu.check("changing the quality")
    }

    /// Changes the picture's size; the last picture is lost.
    ///
    /// # Errors
    /// [`DisplayError::Size`], [`DisplayError::Device`].
    pub fn resize(&mut self, gpu: &Gpu, size: [u32; 2]) -> Result<(), DisplayError> {
        let [width, height] = size;
        if !size.iter().all(|s| (64..=8192).contains(s)) {
            return Err(DisplayError::Size { width, height });
        }
        let (frame, exposure) = (&self.frame, &self.exposure_value);
        self.quality.size = size;
        let (layouts, filter) = (&self.layouts, &self.filter);
        self.targets = Targets::new(gpu, layouts, frame, exposure, filter, &self.quality);
        gpu.check("resizing the picture")
    }
}
