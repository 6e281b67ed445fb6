"""Counts which stratum of Mitsuba's first 2D draw of a sample meets which of a later one, from the sampler alone.

    python stratum_pairs.py OUT.json      (in Mitsuba's environment)

A sample draws its place in the pixel (2D), a point on an emitter (2D), a choice and a direction (1D, 2D) for its path. Counted
for 16 samples, over many seeds: share[first][later], which is 1/256 for all pairs where the draws are independent.
"""
import json
import sys

import mitsuba as mi
import numpy as np

SAMPLES, SIDE, SEEDS = 16, 4, 300000
mi.set_variant("scalar_rgb")


def stratum(p):
    return min(int(p[0] * SIDE), SIDE - 1) + SIDE * min(int(p[1] * SIDE), SIDE - 1)


source = mi.load_dict({"type": "stratified", "sample_count": SAMPLES})
emitter, direction = np.zeros((SAMPLES, SAMPLES)), np.zeros((SAMPLES, SAMPLES))
for k in range(SEEDS):
    source.seed((1 + k * 100003) % 2**32)
    for _ in range(SAMPLES):
        film, light = stratum(source.next_2d()), stratum(source.next_2d())
        source.next_1d()
        emitter[film, light] += 1
        direction[film, stratum(source.next_2d())] += 1
        source.advance()
total = SEEDS * SAMPLES
with open(sys.argv[1], "w") as file:
    json.dump({"version": mi.__version__, "seeds": SEEDS, "emitter": (emitter / total).tolist(), "direction": (direction / total).tolist()}, file)
