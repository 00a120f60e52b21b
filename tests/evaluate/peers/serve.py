"""Runs one competitor in one scene for `evaluate accuracy --peers`. See README.md.

serve.py --list          names of the competitors that are installed
serve.py SCENE NAME      loads the scene, answers with the displacements, then with times
"""

import importlib.util
import os
import sys
import time

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np  # noqa: E402  (one thread must be set first)

from trial import Failed, Trial, settle  # noqa: E402

SPHERES = (250, 581)


def few(trial, why):
    """Refuses bodies of more than the fewest spheres."""
    if len(trial.nodes_m) > SPHERES[0]:
        raise Failed(f"runs with {SPHERES[0]} spheres alone: {why}")


def full(material, share, **how):
    def make(trial, share=share):
        import mujoco_flex

        return mujoco_flex.Full(trial, material, share, **how)

    return "mujoco", make


def cells(order, grid, share):
    def make(trial, share=share):
        import mujoco_flex

        if len(trial.nodes_m) < SPHERES[1]:
            raise Failed("its nodes do not depend on the spheres, so it runs with most of them")
        return mujoco_flex.Reduced(trial, order, grid, share)

    return "mujoco", make


def newton(iterations, share):
    def make(trial, share=share):
        import newton_solvers

        # The first number is for a body with weight, which one iteration does not hold.
        count = iterations[0] if trial.gravity_m_s2.any() else iterations[1]
        return newton_solvers.Solid(trial, count, share)

    return "newton", make


def pypbd(kind, iterations, substeps, share):
    def make(trial, share=share):
        import pypbd_solvers

        few(trial, "its velocities are damped from Python, node by node")
        if trial.gravity_m_s2.any():
            raise Failed("it takes no stiffness for each tetrahedron, so its weight would be unfair")
        return pypbd_solvers.Solid(trial, kind, iterations, substeps, share)

    return "pypbd", make


# The last number is the share of Young's modulus: of Calot for its own tetrahedra, else all.
COMPETITORS = {
    "mujoco-stvk": full(0, 0.965),
    "mujoco-neo-hookean": full(1, 0.965, solver="NEWTON", iterations=100),
    "mujoco-trilinear-1": cells(1, (2, 1, 1), 1.0),
    "mujoco-trilinear-2": cells(1, (3, 3, 2), 1.0),
    "mujoco-quadratic-1": cells(2, (1, 1, 1), 1.0),
    "mujoco-quadratic-2": cells(2, (2, 1, 1), 1.0),
    "mujoco-quadratic-3": cells(2, (3, 3, 2), 1.0),
    "newton-vbd": newton((2, 1), 0.965),
    "pypbd-xpbd-1": pypbd("XPBD FEM", 1, 1, 1.0),
    "pypbd-xpbd-4": pypbd("XPBD FEM", 1, 4, 1.0),
}


def main(words):
    if words == ["--list"]:
        for name, (package, _) in COMPETITORS.items():
            if importlib.util.find_spec(package):
                print(name)
        return
    scene, name = words
    trial = Trial(scene)
    # MuJoCo writes its warnings into a file of the current folder.
    os.chdir(os.path.dirname(os.path.abspath(scene)))
    # Libraries print to standard output; the answers go to a copy of it.
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    try:
        if len(trial.nodes_m) not in SPHERES:
            raise Failed(f"competitors run with {SPHERES} spheres")
        peer = COMPETITORS[name][1](trial)
    except Failed as error:
        answers.write(f"{error}\n".replace("\n", " ").strip() + "\n")
        return
    ticks, is_at_rest = settle(peer, trial)
    sys.stderr.write(f"  {name}: {ticks} ticks, {'at rest' if is_at_rest else 'not at rest'}\n")
    if getattr(peer, "must_rest", False) and not is_at_rest:
        answers.write("it does not come to rest with these settings, so they are not fair\n")
        return
    moves = peer.displacement_m()
    answers.write(f"ready\t{peer.method}\t{peer.setting}\t{peer.nodes}\n")
    for move in moves:
        answers.write(" ".join(f"{c:.9g}" for c in move) + "\n")
    answers.flush()
    turn = int(trial.turn_ticks)
    # Damping that a library does not have is added from outside, and is no part of its time.
    step = getattr(peer, "bare", peer.step)
    for _ in sys.stdin:
        start = time.process_time()
        step(turn)
        answers.write(f"{(time.process_time() - start) * 1e6 / turn:.3f}\n")
        answers.flush()


if __name__ == "__main__":
    np.seterr(all="ignore")
    main(sys.argv[1:])
