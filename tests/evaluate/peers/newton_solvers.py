"""Newton's VBD on the processor, with Calot's tetrahedra and masses."""

import newton
import numpy as np
import warp as wp

wp.config.quiet = True
wp.config.log_level = getattr(wp, "LOG_ERROR", 40)


class Solid:
    """One soft body of particles and tetrahedra. Particles without mass stay where they are put."""

    def __init__(self, trial, iterations, young_share):
        wp.init()
        wp.set_device("cpu")
        self.trial = trial
        builder = newton.ModelBuilder(gravity=[0.0, 0.0, 0.0])
        self.tets = trial.free_part()
        self.used = np.unique(trial.tetrahedra[self.tets])
        number = np.full(len(trial.nodes_m), -1)
        number[self.used] = np.arange(len(self.used))
        self.is_free = trial.free[self.used]
        for i in self.used:
            mass = float(trial.mass_kg[i]) if trial.free[i] else 0.0
            place = [float(c) for c in trial.nodes_m[i]]
            builder.add_particle(pos=place, vel=[0.0, 0.0, 0.0], mass=mass, radius=1e-3)
        volumes = trial.volumes_at_rest()
        mu, lame = trial.lame(young_share)
        for t in self.tets:
            corners = [int(i) for i in number[trial.tetrahedra[t]]]
            if volumes[t] < 0:
                corners[1], corners[2] = corners[2], corners[1]
            # A tetrahedron stands for a volume of tissue that differs from its own.
            ratio = float(trial.volumes_m3[t] / abs(volumes[t]))
            builder.add_tetrahedron(*corners, k_mu=mu * ratio, k_lambda=lame * ratio, k_damp=0.0)
        builder.color()
        self.model = builder.finalize(device="cpu")
        self.states = [self.model.state(), self.model.state()]
        self.control = self.model.control()
        self.solver = newton.solvers.SolverVBD(self.model, iterations=iterations)
        # Velocities are damped from outside; the factor is that of the other methods.
        self.keep = 1.0 - trial.damping_per_s * trial.tick_s
        self.nodes = len(trial.nodes_m)
        self.method = f"Newton {newton.__version__} VBD"
        self.setting = (
            f"Warp {wp.__version__} on one core, {iterations} iteration(s), E x {young_share:g}, "
            "elements without a free node left out"
        )

    def load(self, share):
        self.model.set_gravity([float(g) for g in self.trial.gravity_m_s2 * share])
        places = self.states[0].particle_q.numpy()
        held = self.trial.held_m(share)[self.used]
        places[~self.is_free] = held[~self.is_free]
        self.states[0].particle_q.assign(places)

    def step(self, ticks):
        for _ in range(ticks):
            # The array shares the processor's memory with the simulation.
            self.states[0].particle_qd.numpy()[:] *= self.keep
            self.bare(1)

    def bare(self, ticks):
        for _ in range(ticks):
            before, after = self.states
            self.solver.step(before, after, self.control, None, self.trial.tick_s)
            self.states = [after, before]

    def fastest_m_s(self):
        speeds = self.states[0].particle_qd.numpy()[self.is_free]
        return np.linalg.norm(speeds, axis=1).max()

    def displacement_m(self):
        places = self.trial.held_m(1.0)
        places[self.used[self.is_free]] = self.states[0].particle_q.numpy()[self.is_free]
        return places - self.trial.nodes_m
