"""Mitsuba's `stratified` sampler is biased: a disk over a diffuse floor, against its closed form.

    pip install mitsuba==3.9.1 numpy && python stratified_bias.py [samples a pixel] [images]
"""
import sys

import mitsuba as mi
import numpy as np

spp = int(sys.argv[1]) if len(sys.argv) > 1 else 16
images = int(sys.argv[2]) if len(sys.argv) > 2 else 3000
N, WIDTH, RADIUS, HEIGHT, RHO = 5, 0.42, 0.5, 1.0, 0.5
mi.set_variant("scalar_rgb")
T = mi.ScalarTransform4f


def scene(sampler):
    half = 0.5 * N * WIDTH
    return mi.load_dict({
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 2},
        "sensor": {
            "type": "orthographic",
            # Between the floor and the lamp, so that it sees nothing but the floor.
            "to_world": T().look_at(origin=[0, 0, 0.5], target=[0, 0, 0], up=[0, 1, 0]) @ T().scale([half, half, 1]),
            "near_clip": 1e-3,
            "sampler": {"type": sampler, "sample_count": spp},
            "film": {"type": "hdrfilm", "width": N, "height": N, "component_format": "float32", "rfilter": {"type": "box"}},
        },
        "floor": {"type": "rectangle", "to_world": T().scale([half, half, 1]),
                  "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": RHO}}},
        "lamp": {"type": "disk",
                 "to_world": T().translate([0, 0, HEIGHT]) @ T().rotate([1, 0, 0], 180) @ T().scale([RADIUS, RADIUS, 1]),
                 "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 1.0}}},
    })


# Irradiance under a parallel disk of radiance 1 at a distance a from its axis, averaged over each pixel by 16 x 16 Gauss points.
nodes, weights = np.polynomial.legendre.leggauss(16)
middles = (np.arange(N) - 0.5 * (N - 1)) * WIDTH
x = middles[:, None] + 0.5 * WIDTH * nodes[None, :]
exact = np.zeros((N, N))
for row in range(N):
    for column in range(N):
        a2 = x[row][:, None]**2 + x[column][None, :]**2
        z = HEIGHT**2 + a2 + RADIUS**2
        irradiance = 0.5 * np.pi * (1 - (HEIGHT**2 + a2 - RADIUS**2) / np.sqrt(z * z - 4 * a2 * RADIUS**2))
        exact[row, column] = (0.5 * weights) @ irradiance @ (0.5 * weights)
exact *= RHO / np.pi

for sampler in ["independent", "multijitter", "stratified"]:
    made = scene(sampler)
    stack = np.array([np.array(mi.render(made, seed=1 + 1000003 * k, spp=spp))[..., 0] for k in range(images)], dtype=np.float64)
    z = (stack.mean(0) - exact) / (stack.std(0, ddof=1) / np.sqrt(images))
    means = stack.mean(axis=(1, 2))
    bias = 100 * (stack.mean(0) / exact - 1)
    worst = np.unravel_index(np.abs(z).argmax(), z.shape)
    print(f"{sampler:12} {images} images, {spp} samples a pixel: image mean {100 * (means.mean() / exact.mean() - 1):+.4f} % "
          f"(z = {(means.mean() - exact.mean()) / (means.std(ddof=1) / np.sqrt(images)):+.1f}); worst pixel {bias[worst]:+.3f} % (z = {z[worst]:+.1f})")
