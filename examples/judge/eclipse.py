"""Irradiance behind a disk, estimated: etendue judge penumbra/eclipse -- python3 eclipse.py

The room (metres): a disk source of radius 0.5 at height 2 that faces down, 1 W/m2; a disk of radius 0.35 at height 1.
"""

import csv
import math
import random
import sys

SOURCE_RADIUS, SOURCE_HEIGHT = 0.5, 2.0
OCCLUDER_RADIUS, OCCLUDER_HEIGHT = 0.35, 1.0


def estimate(point, normal, samples, rng):
    """Mean of A M cos_i cos_s / (pi d^2) over points that are uniform on the source."""
    total = 0.0
    for _ in range(samples):
        radius = SOURCE_RADIUS * math.sqrt(rng.random())
        turn = 2.0 * math.pi * rng.random()
        dx = radius * math.cos(turn) - point[0]
        dy = radius * math.sin(turn) - point[1]
        dz = SOURCE_HEIGHT - point[2]
        # Where the shadow ray crosses the plane of the occluder.
        t = (OCCLUDER_HEIGHT - point[2]) / dz
        if 0.0 < t < 1.0 and math.hypot(point[0] + t * dx, point[1] + t * dy) < OCCLUDER_RADIUS:
            continue
        facing = dx * normal[0] + dy * normal[1] + dz * normal[2]
        if facing > 0.0 and dz > 0.0:
            d2 = dx * dx + dy * dy + dz * dz
            total += facing * dz / (d2 * d2)
    return SOURCE_RADIUS**2 * total / samples


def main():
    print("point,replicate,samples,value")
    for row in csv.DictReader(sys.stdin):
        point = [float(row[key]) for key in ("x_m", "y_m", "z_m")]
        normal = [float(row[key]) for key in ("nx", "ny", "nz")]
        samples = int(row["samples"])
        value = estimate(point, normal, samples, random.Random(int(row["seed"])))
        print(f"{row['point']},{row['replicate']},{samples},{value!r}")


if __name__ == "__main__":
    main()
