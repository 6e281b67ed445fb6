"""LuxCore (PyPI: pyluxcore), images by PATHCPU with `path.pathdepth.total` 1: direct light; 2 where there is a mirror.

Units      `emission` with `gain` 1 and `power` 0 is the radiance; E = pi L / rho.
Images     bottom row first: turned over here. The picture lies one pixel row off: pixel (x, y) shows the world at y + one pixel
           height (fitted on the control, as `row_shift`); the window is moved back by that row. `batch.haltspp` is a lower
           bound: a pixel takes that many samples or some more, so counts in the table are lower bounds, too.
Seeds      `renderengine.seed`; images of one seed agree only as far as both took the same samples.
Settings   sampler (RANDOM, SOBOL), row_shift (1; 0: as released), sides (256: corners of a disk of straight edges, of its area),
Textures   `imagemap` of a file with filter `nearest`; a mirror is the material `mirror`, for which paths take three bounces: so that
           no light comes back by the receiver, that is all but black there, and the image scaled back
Not used   BIDIRCPU, LIGHTCPU: with an orthographic camera they do not agree on the control (pixels at the rim off by a tenth)
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
    for name, kd in (("grey", reflectance(job)), ("black", 0.0)):
        table |= {f"scene.materials.{name}.type": "matte", f"scene.materials.{name}.kd": [kd] * 3}
    for i, source in enumerate(job.sources):
        name, shining = f"scene.materials.glow{i}", [source["radiance"]] * 3
        values = protocol.fields(source)
        if values is not None:
            shining, (rows, columns) = f"fields{i}", values.shape
            # The format's rows go up; where v is 0 is its top (as the textured case shows). The filter counts for files only.
            picture = os.path.join(job.folder, f"fields{i}.pfm")
            with open(picture, "wb") as file:
                file.write(f"PF\n{columns} {rows}\n-1.0\n".encode() + np.repeat(values[::-1, :, None], 3, axis=2).astype("<f4").tobytes())
            table |= {f"scene.textures.fields{i}.type": "imagemap", f"scene.textures.fields{i}.file": picture,
                      f"scene.textures.fields{i}.gamma": 1.0, f"scene.textures.fields{i}.filter": "nearest"}
        table |= {f"{name}.type": "matte", f"{name}.kd": [0.0] * 3, f"{name}.emission": shining,
                  f"{name}.emission.gain": [1.0] * 3, f"{name}.emission.power": 0.0, f"{name}.emission.theta": 90.0}
    for i, mirror in enumerate(job.mirrors):
        table |= {f"scene.materials.polished{i}.type": "mirror", f"scene.materials.polished{i}.kr": [mirror["reflectance"]] * 3}
    scene.Parse(properties(table))
    # Beyond the window, so that a row that is off still sees it.
    wide = 20.0
    floor = {"kind": "rectangle", "center": [0, 0, 0], "edge_u": [2 * wide, 0, 0], "edge_v": [0, 2 * wide, 0]}
    if job.mirrors:
        floor["edge_u"], floor["edge_v"] = [2 * half_x, 0, 0], [0, 2 * half_y, 0]  # nothing of it may lie behind the mirror
    parts = [("receiver", floor, "grey")] + [(f"source{i}", s, f"glow{i}") for i, s in enumerate(job.sources)]
    parts += [(f"mirror{i}", m, f"polished{i}") for i, m in enumerate(job.mirrors)]
    for name, given, stuff in parts + [(f"occluder{i}", o, "black") for i, o in enumerate(job.occluders)]:
        if given["kind"] == "sphere":
            if stuff != "black":
                raise protocol.Inexpressible("a sphere as a light: the adapter has triangles")
            vertices, faces = ball.ball(given)
            triangles = [t for f in faces for t in ([f] if len(f) == 3 else [f[:3], (f[0], f[2], f[3])])]
        else:
            vertices, triangles = protocol.triangles(given, job.get("sides", 256))
        points = [tuple(map(float, v)) for v in vertices]
        uv = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] if "fields" in given else None
        scene.DefineMesh(name + "_mesh", points, [tuple(map(int, t)) for t in triangles], None, uv, None, None)
        scene.Parse(properties({f"scene.objects.{name}.shape": name + "_mesh", f"scene.objects.{name}.material": stuff}))
    return scene


def reflectance(job):
    """Of the receiver. Where it might light itself by the mirror, so little that this is below a millionth."""
    return 1e-6 if job.mirrors else job.rho


def settings(job, seed):
    bounces = 3 if job.mirrors else 1
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
        "path.pathdepth.total": bounces,
        "path.pathdepth.diffuse": bounces,
        "path.pathdepth.glossy": bounces,
        "path.pathdepth.specular": bounces,
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
        yield pixels.reshape(job.height, job.width, 3)[::-1, :, 0] * (job.rho / reflectance(job))
    job.notes.append(f"{min(passes)} to {max(passes)} samples a pixel")


protocol.main(lambda: f"LuxCore {lux.Version()}", "E = pi L / rho", images=images, knows=("mirrors", "fields"))
