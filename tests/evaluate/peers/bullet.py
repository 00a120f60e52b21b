"""PyBullet's deformable bodies: neo-Hookean tetrahedra. It takes the sag alone."""

import os
import tempfile

import numpy as np
import pybullet

from trial import Failed


class Solid:
    """One soft body, anchored to the world. PyBullet gives every node the same mass."""

    def __init__(self, trial, young_share):
        if trial.moved.any():
            raise Failed("PyBullet has no nodes that follow a path")
        self.trial = trial
        tets = trial.free_part()
        self.used = np.unique(trial.tetrahedra[tets])
        number = np.full(len(trial.nodes_m), -1)
        number[self.used] = np.arange(len(self.used))
        corners = number[trial.tetrahedra[tets]]
        flip = trial.volumes_at_rest()[tets] < 0
        corners[flip] = corners[flip][:, [0, 2, 1, 3]]
        pybullet.connect(pybullet.DIRECT)
        pybullet.resetSimulation(pybullet.RESET_USE_DEFORMABLE_WORLD)
        pybullet.setTimeStep(trial.tick_s)
        pybullet.setPhysicsEngineParameter(sparseSdfVoxelSize=0.25)
        mu, lame = trial.lame(young_share)
        with tempfile.NamedTemporaryFile("w", suffix=".vtk", delete=False) as file:
            file.write(vtk(trial.nodes_m[self.used], corners))
        # The mean mass of a free node, for all.
        mean = trial.mass_kg[trial.free].mean()
        self.body = pybullet.loadSoftBody(
            file.name,
            mass=float(mean * len(self.used)),
            useNeoHookean=1,
            NeoHookeanMu=float(mu),
            NeoHookeanLambda=float(lame),
            NeoHookeanDamping=0.01,
            useSelfCollision=0,
            collisionMargin=1e-4,
        )
        os.unlink(file.name)
        self.is_free = trial.free[self.used]
        if len(self.places()) != len(self.used):
            raise Failed("PyBullet changed the number of nodes")
        for i in np.flatnonzero(~self.is_free):
            pybullet.createSoftBodyAnchor(self.body, int(i), -1, -1)
        self.last = self.places()
        self.nodes = len(trial.nodes_m)
        self.method = "PyBullet {} neo-Hookean".format(package_version())
        self.setting = (
            f"1 ms, damping 0.01 of its own, E x {young_share:g}, one mass for all nodes, "
            "elements without a free node left out"
        )

    def places(self):
        flags = pybullet.MESH_DATA_SIMULATION_MESH
        return np.array(pybullet.getMeshData(self.body, -1, flags=flags)[1])

    def load(self, share):
        pybullet.setGravity(*(float(g) for g in self.trial.gravity_m_s2 * share))

    def step(self, ticks):
        for _ in range(ticks):
            pybullet.stepSimulation()

    def fastest_m_s(self):
        before = self.places()
        self.step(1)
        speeds = (self.places() - before)[self.is_free] / self.trial.tick_s
        return np.linalg.norm(speeds, axis=1).max()

    def displacement_m(self):
        places = self.trial.held_m(1.0)
        places[self.used[self.is_free]] = self.places()[self.is_free]
        return places - self.trial.nodes_m


def package_version():
    from importlib.metadata import version

    return version("pybullet")


def vtk(points, corners):
    """A tetrahedral mesh in VTK's text format."""
    lines = ["# vtk DataFile Version 2.0", "organ", "ASCII", "DATASET UNSTRUCTURED_GRID"]
    lines.append(f"POINTS {len(points)} double")
    lines += [" ".join(f"{c:.9g}" for c in p) for p in points]
    lines.append(f"CELLS {len(corners)} {5 * len(corners)}")
    lines += ["4 " + " ".join(str(i) for i in t) for t in corners]
    lines.append(f"CELL_TYPES {len(corners)}")
    lines += ["10"] * len(corners)
    return "\n".join(lines) + "\n"
