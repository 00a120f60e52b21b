"""MuJoCo's soft bodies ("flex"): every sphere a node, or few nodes of a grid of cells."""

import itertools

import mujoco
import numpy as np

from trial import Failed

STVK, NEO_HOOKEAN = 0, 1


class Flex:
    """What both kinds share: the step, the pinned vertices and gravity."""

    def compile(self, spec, trial, integrator, solver="NEWTON", iterations=100):
        self.trial = trial
        spec.option.timestep = trial.tick_s
        spec.option.gravity = [0.0, 0.0, 0.0]
        spec.option.integrator = integrator
        spec.option.solver = getattr(mujoco.mjtSolver, "mjSOL_" + solver)
        spec.option.iterations = iterations
        off = mujoco.mjtDisableBit
        spec.option.disableflags |= off.mjDSBL_CONTACT | off.mjDSBL_SENSOR
        spec.memory = 1 << 28
        try:
            self.model = spec.compile()
        except ValueError as error:
            raise Failed(str(error)) from error
        bodies = self.model.dof_bodyid
        self.model.dof_damping[:] = trial.damping_per_s * self.model.body_mass[bodies]
        self.data = mujoco.MjData(self.model)

    def step(self, ticks):
        mujoco.mj_step(self.model, self.data, nstep=ticks)

    def blew_up(self):
        """True if MuJoCo met values that are not finite. It then starts again from rest."""
        bad = mujoco.mjtWarning
        kinds = (bad.mjWARN_BADQPOS, bad.mjWARN_BADQVEL, bad.mjWARN_BADQACC)
        return any(self.data.warning[int(kind)].number for kind in kinds)

    def fastest_m_s(self):
        return np.nan if self.blew_up() else np.abs(self.data.qvel).max()

    def displacement_m(self):
        places = self.places_m()
        return places * np.nan if self.blew_up() else places - self.trial.nodes_m

    def add_node(self, spec, name, place, mass):
        body = spec.worldbody.add_body(name=name, pos=place)
        body.mass = mass
        body.inertia = [mass * 1e-6] * 3
        body.explicitinertial = True
        for axis in np.eye(3):
            body.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)


class Full(Flex):
    """Every sphere is a node, with the tetrahedra and masses of Calot."""

    def __init__(self, trial, material, young_share, solver=None, iterations=100):
        tets = trial.free_part()
        corners = trial.tetrahedra[tets]
        self.used = np.unique(corners)
        number = np.full(len(trial.nodes_m), -1)
        number[self.used] = np.arange(len(self.used))
        spec = mujoco.MjSpec()
        flex = spec.add_flex(name="organ")
        verts, bodies = [], []
        for i in self.used:
            if trial.free[i]:
                self.add_node(spec, f"n{i}", trial.nodes_m[i], trial.mass_kg[i])
                verts += [0.0, 0.0, 0.0]
                bodies.append(f"n{i}")
            else:
                verts += trial.nodes_m[i].tolist()
                bodies.append("world")
        corners = number[corners]
        flip = trial.volumes_at_rest()[tets] < 0
        corners[flip] = corners[flip][:, [0, 2, 1, 3]]
        flex.dim, flex.elem, flex.vert, flex.vertbody = 3, corners.ravel().tolist(), verts, bodies
        flex.young, flex.poisson = trial.young_pa * young_share, trial.poisson
        flex.elastic3d, flex.radius, flex.contype, flex.conaffinity = material, 1e-3, 0, 0
        flex.selfcollide = mujoco.mjtFlexSelf.mjFLEXSELF_NONE
        kinds = mujoco.mjtIntegrator
        if solver:
            self.compile(spec, trial, kinds.mjINT_DISCRETE, solver, iterations)
            how = f"discrete integrator, {solver}, at most {iterations} iterations"
        else:
            self.compile(spec, trial, kinds.mjINT_EULER)
            how = "explicit Euler, 1 ms"
        # A tetrahedron stands for a volume of tissue that differs from its own.
        ratio = trial.volumes_at_rest()[tets]
        ratio = trial.volumes_m3[tets] / np.abs(ratio)
        stiffness = self.model.flex_stiffness.reshape(len(tets), -1)
        # The last number is the inverse of the volume at rest; all others scale with the modulus.
        stiffness[:, :23] *= ratio[:, None]
        self.nodes = len(trial.nodes_m)
        self.pinned = ~trial.free[self.used]
        name = "neo-Hookean" if material == NEO_HOOKEAN else "StVK"
        self.method = f"MuJoCo {mujoco.__version__} flex, {name}"
        self.setting = f"{how}, E x {young_share:g}, elements without a free node left out"

    def load(self, share):
        self.model.opt.gravity[:] = self.trial.gravity_m_s2 * share
        places = self.trial.held_m(share)[self.used]
        self.model.flex_vert[self.pinned] = places[self.pinned]

    def places_m(self):
        places = self.trial.held_m(1.0)
        places[self.used] = self.data.flexvert_xpos
        return places


class Reduced(Flex):
    """Nodes of a coarse grid move the tissue by trilinear or quadratic interpolation."""

    # Some grids swing or blow up at 1 ms, and might not with other masses of the nodes.
    must_rest = True

    def __init__(self, trial, order, cells, young_share):
        self.order = order
        # The organ is filled with a coarse mesh, and the spheres are points without elements in it.
        corners = self.free_elements(trial)
        fill = np.unique(corners)
        # The grid fits the part between the planes.
        points = trial.filled_nodes_m[fill]
        points = np.concatenate([points, trial.nodes_m[trial.free]])
        low, high = points.min(axis=0), points.max(axis=0)
        low[trial.axis] = trial.fixed_below_m
        if trial.moved.any():
            high[trial.axis] = trial.free_below_m
        # The first number of cells is along the organ, the second along its longer other axis.
        length = high - low
        length[trial.axis] = np.inf
        axes = np.argsort(-length)
        count = np.ones(3, int)
        count[axes] = cells
        number = np.full(len(trial.filled_nodes_m), -1)
        number[fill] = np.arange(len(fill))
        inside = (trial.nodes_m > low - 1e-9).all(axis=1) & (trial.nodes_m < high + 1e-9).all(axis=1)
        self.used = np.flatnonzero(trial.free & inside)
        self.first = len(fill)
        steps = count * order
        places = np.array(
            [
                low + (high - low) * np.array(at) / steps
                for at in itertools.product(*(range(n + 1) for n in steps))
            ]
        )
        mass = self.node_masses(trial, low, high, steps)
        empty = self.empty_nodes(trial.filled_nodes_m[corners], low, high, count, order)
        spec = mujoco.MjSpec()
        spec.worldbody.add_body(name="frame")
        flex = spec.add_flex(name="organ")
        self.kind = np.zeros(len(places), int)
        local, bodies = [], []
        for i, place in enumerate(places):
            if place[trial.axis] < trial.fixed_below_m + 1e-9:
                self.kind[i] = 1
            elif trial.moved.any() and place[trial.axis] > trial.free_below_m - 1e-9:
                self.kind[i] = 2
            if self.kind[i] == 0 and not empty[i]:
                self.add_node(spec, f"n{i}", place, mass[i])
                local += [0.0, 0.0, 0.0]
                bodies.append(f"n{i}")
            else:
                local += place.tolist()
                bodies.append("frame")
        corners = number[corners]
        flex.dim, flex.order, flex.cellcount = 3, order, count.tolist()
        flex.elem = corners.ravel().tolist()
        verts = np.concatenate([trial.filled_nodes_m[fill], trial.nodes_m[self.used]])
        flex.vert = verts.ravel().tolist()
        flex.vertbody = ["frame"] * len(verts)
        flex.node, flex.nodebody = local, bodies
        flex.young, flex.poisson = trial.young_pa * young_share, trial.poisson
        flex.radius, flex.contype, flex.conaffinity = 1e-3, 0, 0
        flex.selfcollide = mujoco.mjtFlexSelf.mjFLEXSELF_NONE
        self.compile(spec, trial, mujoco.mjtIntegrator.mjINT_EULER)
        self.places = places
        self.nodes = int((~empty).sum())
        name = {1: "trilinear", 2: "quadratic"}[order]
        self.method = f"MuJoCo {mujoco.__version__} flex, {name} cells"
        self.setting = "{} x {} x {} cells, explicit Euler, 1 ms, E x {:g}".format(
            *cells, young_share
        )

    @staticmethod
    def free_elements(trial):
        """Corners of the filling elements between the planes, in MuJoCo's order."""
        corners = trial.filled_tetrahedra
        middle = trial.filled_nodes_m[corners].mean(axis=1)[:, trial.axis]
        is_free = middle > trial.fixed_below_m
        if trial.moved.any():
            is_free &= middle < trial.free_below_m
        corners = corners[is_free].copy()
        a, b, c, d = (trial.filled_nodes_m[corners[:, i]] for i in range(4))
        flip = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) < 0
        corners[flip] = corners[flip][:, [0, 2, 1, 3]]
        return corners

    @staticmethod
    def empty_nodes(corners, low, high, count, order):
        """Marks the nodes of cells without tissue. MuJoCo wants them pinned."""
        shares = np.random.default_rng(1).dirichlet(np.ones(4), 50)
        points = np.concatenate([corners.transpose(0, 2, 1) @ s for s in shares])
        at = np.floor((points - low) / (high - low) * count).astype(int)
        inside = ((at >= 0) & (at < count)).all(axis=1)
        empty = np.ones(count * order + 1, bool)
        for cell in np.unique(at[inside], axis=0):
            empty[tuple(slice(c * order, c * order + order + 1) for c in cell)] = False
        return empty.ravel()

    @staticmethod
    def node_masses(trial, low, high, steps):
        """Mass of each node, kg: each sphere's mass goes to the nodes of its cell."""
        mass = np.zeros(steps + 1)
        for place, kg in zip(trial.nodes_m, trial.mass_kg):
            at = (place - low) / (high - low) * steps
            if (at < -1e-6).any() or (at > steps + 1e-6).any():
                continue
            first = np.clip(np.floor(at).astype(int), 0, steps - 1)
            share = at - first
            for corner in itertools.product((0, 1), repeat=3):
                weight = np.prod(np.where(corner, share, 1 - share))
                mass[tuple(first + corner)] += kg * weight
        # A node outside of the organ would have no mass.
        return np.maximum(mass, 0.02 * mass.mean()).ravel()

    def load(self, share):
        self.model.opt.gravity[:] = self.trial.gravity_m_s2 * share
        moved = self.kind == 2
        if moved.any():
            self.model.flex_node[moved] = moved_places(self.trial, self.places[moved], share)

    def places_m(self):
        places = self.trial.held_m(1.0)
        places[self.used] = self.data.flexvert_xpos[self.first :]
        return places


def moved_places(trial, places, share):
    """Places of points that follow the moved end at this share of the load, m."""
    nodes, moved = trial.nodes_m, trial.moved
    try:
        trial.nodes_m, trial.moved = places, np.ones(len(places), bool)
        return trial.held_m(share)
    finally:
        trial.nodes_m, trial.moved = nodes, moved
