"""pypbd (PositionBasedDynamics): XPBD or PBD finite elements with Calot's tetrahedra and masses."""

from importlib.metadata import version

import numpy as np
import pypbd

# Its number of each constraint, as its own demonstrations use them.
KINDS = {"PBD FEM": 2, "XPBD FEM": 3}
# Gravity of the library, which Python cannot set, m/s2.
THEIRS = np.array([0.0, -9.81, 0.0])


class Solid:
    """One soft body. Its axes are turned so that gravity points along the library's."""

    def __init__(self, trial, kind, iterations, substeps, young_share):
        self.trial = trial
        pypbd.Logger.addConsoleSink(pypbd.LogLevel.ERR)
        # z up becomes y up.
        self.turn = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
        tets = trial.free_part()
        self.used = np.unique(trial.tetrahedra[tets])
        number = np.full(len(trial.nodes_m), -1)
        number[self.used] = np.arange(len(self.used))
        self.is_free = trial.free[self.used]
        corners = number[trial.tetrahedra[tets]]
        flip = trial.volumes_at_rest()[tets] < 0
        corners[flip] = corners[flip][:, [0, 2, 1, 3]]
        simulation = pypbd.Simulation.getCurrent()
        simulation.initDefault()
        self.model = simulation.getModel()
        places = trial.nodes_m[self.used] @ self.turn.T
        self.body = self.model.addTetModel(
            [p.reshape(3, 1) for p in places], corners.ravel().tolist(), testMesh=False
        )
        self.particles = self.model.getParticles()
        for i, node in enumerate(self.used):
            self.particles.setMass(i, float(trial.mass_kg[node]) if trial.free[node] else 0.0)
        self.model.addSolidConstraints(
            self.body,
            KINDS[kind],
            trial.young_pa * young_share,
            trial.poisson,
            trial.young_pa * young_share,
            False,
            False,
        )
        self.clock = pypbd.TimeManager.getCurrent()
        self.clock.setTimeStepSize(trial.tick_s)
        self.steps = simulation.getTimeStep()
        control = pypbd.TimeStepController
        self.steps.setValueUInt(control.NUM_SUB_STEPS, substeps)
        self.steps.setValueUInt(control.MAX_ITERATIONS, iterations)
        self.share = 0.0
        self.nodes = len(trial.nodes_m)
        self.method = f"pypbd {version('pypbd')} {kind}, {substeps} substep(s)"
        self.setting = (
            f"{iterations} iteration(s), E x {young_share:g}, "
            "elements without a free node left out"
        )

    def load(self, share):
        self.share = share
        held = self.trial.held_m(share)[self.used] @ self.turn.T
        for i in np.flatnonzero(~self.is_free):
            self.particles.setPosition(int(i), held[i])

    def step(self, ticks):
        trial = self.trial
        wanted = self.turn @ trial.gravity_m_s2 * self.share
        add = (wanted - THEIRS) * trial.tick_s
        keep = 1.0 - trial.damping_per_s * trial.tick_s
        free = np.flatnonzero(self.is_free).tolist()
        for _ in range(ticks):
            for i in free:
                speed = np.asarray(self.particles.getVelocity(i)).ravel()
                self.particles.setVelocity(i, speed * keep + add)
            self.bare(1)

    def bare(self, ticks):
        for _ in range(ticks):
            self.steps.step(self.model)

    def fastest_m_s(self):
        free = np.flatnonzero(self.is_free).tolist()
        return max(np.linalg.norm(self.particles.getVelocity(i)) for i in free)

    def displacement_m(self):
        places = self.trial.held_m(1.0)
        for i in np.flatnonzero(self.is_free):
            place = np.asarray(self.particles.getPosition(int(i))).ravel()
            places[self.used[i]] = place @ self.turn
        return places - self.trial.nodes_m
