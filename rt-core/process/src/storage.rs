//! Storage of a simulation, on the heap.

use rt_core::port::DeviceCapabilities;
use rt_core::scene::Scene;
use rt_core::sim::{Parameters, Sim};
use rt_core::state::State;
use rt_core::tissue::Method;
use rt_core::tissue::paper::Paper;

/// State of a simulation, and the memory of the inner-sphere paper's method if that method is used.
pub(crate) struct Storage {
    state: Box<State>,
    paper: Option<Box<Paper>>,
}

impl Storage {
    /// Storage of a simulation. `paper_iterations` > 0 selects the inner-sphere paper's method with
    /// this number of iterations; 0 selects neo-Hookean.
    pub(crate) fn new(paper_iterations: u32) -> Self {
        Self {
            state: Box::new(State::new()),
            paper: (paper_iterations > 0).then(|| Box::new(Paper::new(paper_iterations))),
        }
    }

    /// A simulation of `scene` at rest in this storage.
    pub(crate) fn sim<'a>(
        &'a mut self,
        scene: Scene<'a>,
        device: DeviceCapabilities,
        parameters: Parameters,
    ) -> Sim<'a> {
        let mut sim = Sim::new(scene, &mut self.state, device, parameters);
        if let Some(paper) = &mut self.paper {
            sim.solve_by(Method::Paper(paper));
        }
        sim
    }
}
