"""The scene that `evaluate accuracy --peers` writes, and the course of its load."""

import json

import numpy as np

FREE, FIXED, MOVED = 0, 1, 2


class Trial:
    """A body, its holds and its load, all in SI units."""

    def __init__(self, path):
        with open(path, encoding="utf-8") as file:
            data = json.load(file)
        for key, value in data.items():
            setattr(self, key, np.array(value) if isinstance(value, list) else value)
        self.axis = int(self.axis)
        self.free = self.held == FREE
        self.moved = self.held == MOVED

    def volumes_at_rest(self):
        """Geometric volume of each tetrahedron, m3."""
        a, b, c, d = (self.nodes_m[self.tetrahedra[:, i]] for i in range(4))
        return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6.0

    def free_part(self):
        """The tetrahedra with a free node: nothing else changes the result."""
        return np.flatnonzero(self.free[self.tetrahedra].any(axis=1))

    def held_m(self, share):
        """Places of all nodes if they followed the moved end at this share of the load, m.

        Nodes of the fixed end stay at rest. The values for free nodes have no meaning.
        """
        turn = self.turn_rad * share
        angle = np.linalg.norm(turn)
        arm = self.nodes_m - self.pivot_m
        if angle > 0.0:
            axis = turn / angle
            arm = (
                arm * np.cos(angle)
                + np.cross(axis, arm) * np.sin(angle)
                + np.outer(arm @ axis, axis) * (1.0 - np.cos(angle))
            )
        place = self.pivot_m + arm + self.shift_m * share
        return np.where(self.moved[:, None], place, self.nodes_m)

    def lame(self, share):
        """Lame's constants for this share of the Young's modulus: mu and lambda, Pa."""
        young, nu = self.young_pa * share, self.poisson
        return young / (2 * (1 + nu)), young * nu / ((1 + nu) * (1 - 2 * nu))


class Failed(Exception):
    """The competitor does not take this scene. The text says why."""


def settle(peer, trial):
    """Loads the body as `evaluate` does, and lets it come to rest. Returns the ticks, and whether
    it rests."""
    for tick in range(int(trial.ramp_ticks + trial.settle_ticks)):
        share = min((tick + 1) / trial.ramp_ticks, 1.0)
        if tick < trial.ramp_ticks:
            peer.load(share)
        peer.step(1)
        if tick % 48 == 0:
            speed = peer.fastest_m_s()
            if not np.isfinite(speed) or speed > 1e3:
                return tick, False
            if tick > trial.ramp_ticks + 100 and speed < trial.still_m_s:
                return tick, True
    return int(trial.ramp_ticks + trial.settle_ticks), False
