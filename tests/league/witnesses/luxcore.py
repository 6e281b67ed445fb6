"""LuxCore (PyPI: pyluxcore), images by PATHCPU with `path.pathdepth.total` 1: direct light.

Units      `emission` with `gain` 1 and `power` 0 is the radiance; E = pi L / rho.
Images     bottom row first: turned over here. The picture lies one pixel row off: pixel (x, y) shows the world at y + one pixel
           height (fitted on the control, as `row_shift`); the window is moved back by that row. `batch.haltspp` is a lower
           bound: a pixel takes that many samples or some more, so counts in the table are lower bounds, too.
Seeds      `renderengine.seed`; images of one seed agree only as far as both took the same samples.
Settings   sampler (RANDOM, SOBOL), row_shift (1; 0: as released), sides (256: corners of a disk of straight edges, of its area)
"""
import os
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import numpy as np
import pyluxcore as lux

import ball
import protocol


def properties(table):
    made = lux.Properties()
    for key, value in table.items():
        made.Set(lux.Property(key, value))
    return made


def build(job):
    half_x, half_y, height = job.level_camera()
    half_x, half_y = float(half_x), float(half_y)
    row = job.get("row_shift", 1) * 2 * half_y / job.height
    scene = lux.Scene()
    table = {
        "scene.camera.type": "orthographic",
        "scene.camera.lookat.orig": [0.0, 0.0, float(height)],
        "scene.camera.lookat.target": [0.0, 0.0, 0.0],
        "scene.camera.up": [0.0, 1.0, 0.0],
        "scene.camera.screenwindow": [-half_x, half_x, -half_y - row, half_y - row],
        "scene.camera.cliphither": height / 1000,
        "scene.camera.clipyon": 100.0,
        "scene.camera.autovolume.enable": False,
        "scene.epsilon.min": 1e-5,
    }
    for name, kd in (("grey", job.rho), ("black", 0.0)):
        table |= {f"scene.materials.{name}.type": "matte", f"scene.materials.{name}.kd": [kd] * 3}
    for i, source in enumerate(job.sources):
        name = f"scene.materials.glow{i}"
        table |= {f"{name}.type": "matte", f"{name}.kd": [0.0] * 3, f"{name}.emission": [source["radiance"]] * 3,
                  f"{name}.emission.gain": [1.0] * 3, f"{name}.emission.power": 0.0, f"{name}.emission.theta": 90.0}
    scene.Parse(properties(table))
    # Beyond the window, so that a row that is off still sees it.
    wide = 20.0
    floor = {"kind": "rectangle", "center": [0, 0, 0], "edge_u": [2 * wide, 0, 0], "edge_v": [0, 2 * wide, 0]}
    parts = [("receiver", floor, "grey")] + [(f"source{i}", s, f"glow{i}") for i, s in enumerate(job.sources)]
    for name, given, stuff in parts + [(f"occluder{i}", o, "black") for i, o in enumerate(job.occluders)]:
        if given["kind"] == "sphere":
            if stuff != "black":
                raise protocol.Inexpressible("a sphere as a light: the adapter has triangles")
            vertices, faces = ball.ball(given)
            triangles = [t for f in faces for t in ([f] if len(f) == 3 else [f[:3], (f[0], f[2], f[3])])]
        else:
            vertices, triangles = protocol.triangles(given, job.get("sides", 256))
        points = [tuple(map(float, v)) for v in vertices]
        scene.DefineMesh(name + "_mesh", points, [tuple(map(int, t)) for t in triangles], None, None, None, None)
        scene.Parse(properties({f"scene.objects.{name}.shape": name + "_mesh", f"scene.objects.{name}.material": stuff}))
    return scene


def settings(job, seed):
    return properties({
        "renderengine.type": "PATHCPU",
        "renderengine.seed": int(seed),
        "native.threads.count": 1,
        "sampler.type": job.get("sampler", "RANDOM"),
        "sampler.random.adaptive.strength": 0.0,
        "sampler.sobol.adaptive.strength": 0.0,
        "film.width": job.width,
        "film.height": job.height,
        "film.filter.type": "BOX",
        "film.filter.width": 0.5,
        "film.filter.xwidth": 0.5,
        "film.filter.ywidth": 0.5,
        "film.noiseestimation.warmup": 0,
        "film.outputs.0.type": "RGB",
        "film.outputs.0.filename": "unused.exr",
        "film.imagepipelines.0.0.type": "NOP",
        "path.pathdepth.total": 1,
        "path.pathdepth.diffuse": 1,
        "path.pathdepth.glossy": 1,
        "path.pathdepth.specular": 1,
        "path.clamping.variance.maxvalue": 0.0,
        "path.russianroulette.depth": 100,
        "path.hybridbackforward.enable": False,
        "lightstrategy.type": job.get("strategy", "POWER"),
        "accelerator.instances.enable": False,
        "batch.haltspp": job.samples,
        "batch.halttime": 0,
        "batch.haltthreshold": 0.0,
    })


def images(job):
    lux.Init()
    lux.SetLogHandler(lambda text: None)
    scene, passes = build(job), set()
    for k in range(job.count):
        session = lux.RenderSession(lux.RenderConfig(settings(job, job.seed(k)), scene))
        session.Start()
        while not session.HasDone():
            session.UpdateStats()
            time.sleep(0.001)
        session.UpdateStats()
        passes.add(session.GetStats().Get("stats.renderengine.pass").GetInt())
        pixels = np.zeros(job.width * job.height * 3, np.float32)
        session.GetFilm().GetOutputFloat(lux.FilmOutputType.RGB, pixels, 0, True)
        session.Stop()
        yield pixels.reshape(job.height, job.width, 3)[::-1, :, 0]
    job.notes.append(f"{min(passes)} to {max(passes)} samples a pixel")


protocol.main(lambda: f"LuxCore {lux.Version()}", "E = pi L / rho", images=images)
