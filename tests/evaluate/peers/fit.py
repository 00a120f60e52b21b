"""Tells the error of a competitor for several shares of Young's modulus.

fit.py SCENE NAME SHARE...    prints each share, the rms distance of the free spheres from the
                              reference in mm, and the processor time of a tick in us
"""

import sys
import time

import numpy as np

from serve import COMPETITORS
from trial import Trial, settle


def main(words):
    scene, name, *shares = words
    for share in shares:
        trial = Trial(scene)
        peer = COMPETITORS[name][1](trial, share=float(share))
        settle(peer, trial)
        error = (peer.displacement_m() - trial.reference_m)[trial.free]
        rms = np.sqrt((error**2).sum(axis=1).mean()) * 1e3
        start = time.process_time()
        peer.step(30)
        spent = (time.process_time() - start) / 30e-6
        print(f"{name} {share}: {rms:.3f} mm, {spent:.0f} us", flush=True)


if __name__ == "__main__":
    np.seterr(all="ignore")
    main(sys.argv[1:])
