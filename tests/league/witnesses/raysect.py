"""raysect (PyPI: raysect), power on a tiny pixel at each point.

Units      emission 1 W/(m2 sr nm) over a band of 1 nm is the radiance; E = power / area of the pixel, no further factor.
Seeds      `raysect.core.math.random.seed`, with the serial engine; one seed a replicate.
Shapes     solids are closed: flat sources and occluders are slabs of 1e-6 m that reach behind the lit side, and emit from
           their backs and sides, too (nothing is there to see it).
Settings   observer (targeted: rays go to the bounding spheres of the sources; hemisphere: everywhere)
"""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
# This file is called as the package that it asks for: its folder must not come first.
sys.path = [p for p in sys.path if os.path.abspath(p or ".") != os.path.dirname(os.path.abspath(__file__))]
import numpy as np
import raysect
from raysect.core import AffineMatrix3D, Point3D
from raysect.core.math.random import seed
from raysect.core.workflow import SerialEngine
from raysect.optical import ConstantSF, World
from raysect.optical.material import AbsorbingSurface, UniformSurfaceEmitter
from raysect.optical.observer import Pixel, PowerPipeline0D, TargetedPixel
from raysect.primitive import Box, Cylinder, Mesh, Sphere

import protocol

THICK, WIDE = 1e-6, 1e-6


def placed(x, y, z, origin):
    return AffineMatrix3D(np.block([[np.column_stack([x, y, z]), np.array(origin, float)[:, None]], [np.zeros(3), np.ones(1)]]).tolist())


def solid(shape, world, material):
    """The shape's lit side at its place, its body behind it."""
    kind = shape["kind"]
    if kind == "sphere":
        return Sphere(shape["radius"], world, placed(*np.eye(3), shape["center"]), material)
    if kind == "disk":
        u, v, n = protocol.frame(shape["normal"])
        return Cylinder(shape["radius"], THICK, world, placed(u, v, n, np.array(shape["center"]) - THICK * n), material)
    if kind == "rectangle":
        u, v, n = (np.array(shape[k]) for k in ("edge_u", "edge_v", "normal"))
        a, b = np.linalg.norm(u), np.linalg.norm(v)
        return Box(Point3D(-a / 2, -b / 2, -THICK), Point3D(a / 2, b / 2, 0), world, placed(u / a, v / b, n, shape["center"]), material)
    raise protocol.Inexpressible(f"a {kind}: the adapter makes disks, rectangles and spheres")


def points(job):
    world = World()
    sources = [solid(s, world, UniformSurfaceEmitter(ConstantSF(s["radiance"]))) for s in job.sources]
    for occluder in job.occluders:
        solid(occluder, world, AbsorbingSurface())
    pipe = PowerPipeline0D(accumulate=False)
    options = dict(pipelines=[pipe], x_width=WIDE, y_width=WIDE, min_wavelength=500, max_wavelength=501, spectral_bins=1,
                   pixel_samples=job.samples, parent=world, render_engine=SerialEngine(), quiet=True)
    if job.get("observer", "targeted") == "targeted":
        eye = TargetedPixel(sources, targeted_path_prob=1.0, **options)
    else:
        eye = Pixel(**options)
    eye.ray_extinction_prob = 0.0
    for k in range(job.count):
        seed(job.seed(k))
        values = []
        for position, normal in zip(job.positions, job.normals):
            eye.transform = placed(*protocol.frame(normal), position)
            eye.observe()
            values.append(pipe.value.mean / WIDE**2)
        yield values


protocol.main(f"raysect {getattr(raysect, '__version__', '?')}", "E = power / pixel area", points=points)
