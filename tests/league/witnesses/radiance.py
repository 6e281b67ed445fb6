"""Radiance (PyPI: pyradiance, whose wheel carries the programs), irradiance at points by `rtrace -I`.

Units      `light` has radiance L; the value printed is the irradiance: factor 1. Lights count on their front only.
Seeds      none that one could give: the stream begins with the clock (runs within a second repeat each other, later ones do not).
           Replicates are copies of the list of points in one input; those of later runs and of other seed sets lie further
           down the same stream, which is run through and thrown away. `-u+`: values are independent of one another.
Settings   options (of rtrace), disk (ring: the program's own; strips: rectangles of the same total area; polygon: a
           64-gon of the same area), raise (metres added to the points: -1e-4 undoes what the program adds), average
           (values averaged for one replicate)
Textures   a rectangle's fields by `brightfunc`
Efforts    `-ds` from the list of efforts, 1/effort, for settings without jitter
"""
import math
import os
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import numpy as np
import pyradiance

import protocol

HOME = os.path.dirname(pyradiance.__file__)
ENVIRONMENT = {**os.environ, "RAYPATH": ".:" + os.path.join(HOME, "lib")}  # rtrace stops without rayinit.cal
STRIPS = 64


def polygon(material, name, corners):
    numbers = " ".join("%.12g" % x for corner in corners for x in corner)
    return f"{material} polygon {name}\n0\n0\n{3 * len(corners)} {numbers}\n"


def strips(material, name, shape):
    """A disk as rectangles side by side, each as long as the disk is there on average."""
    u, v, _ = protocol.frame(shape["normal"])
    a, c = shape["radius"], np.array(shape["center"])
    edges = np.linspace(-a, a, STRIPS + 1)
    area = lambda t: 0.5 * (t * math.sqrt(max(a * a - t * t, 0.0)) + a * a * math.asin(max(-1.0, min(1.0, t / a))))
    text = ""
    for i, (lo, hi) in enumerate(zip(edges[:-1], edges[1:])):
        half = (area(hi) - area(lo)) / (hi - lo)
        text += polygon(material, f"{name}_{i}", [c + lo * u - half * v, c + hi * u - half * v, c + hi * u + half * v, c + lo * u + half * v])
    return text


def shape(job, given, material, name, light):
    c, kind = given.get("center"), given["kind"]
    if kind == "sphere":
        return f"{material} sphere {name}\n0\n0\n4 {c[0]:.12g} {c[1]:.12g} {c[2]:.12g} {given['radius']:.12g}\n"
    if kind == "disk":
        how = job.get("disk", "ring") if light else "ring"
        if how == "strips":
            return strips(material, name, given)
        if how == "polygon":
            return polygon(material, name, protocol.outline(given, 64))
        numbers = " ".join("%.12g" % x for x in [*c, *given["normal"], 0.0, given["radius"]])
        return f"{material} ring {name}\n0\n0\n8 {numbers}\n"
    if kind in ("rectangle", "polygon"):
        return polygon(material, name, protocol.outline(given))
    vertices, triangles = protocol.triangles(given)
    return "".join(polygon(material, f"{name}_{i}", vertices[t]) for i, t in enumerate(triangles))


def pattern(job, source, i):
    """The name of what modifies the light, after its definition: fields of a rectangle, by the place on it."""
    values = protocol.fields(source)
    if values is None:
        return "", "void"
    u, v = np.array(source["edge_u"]), np.array(source["edge_v"])
    corner, (rows, columns) = np.array(source["center"]) - u / 2 - v / 2, values.shape
    along = lambda e: " + ".join(f"(P{x} - ({corner[k]:.17g})) * ({e[k] / (e @ e):.17g})" for k, x in enumerate("xyz"))
    place = lambda name, n, e: f"{name}raw = floor({n} * ({along(e)}));\n{name} = if({name}raw - {n} + 0.5, {n - 1}, if({name}raw + 0.5, {name}raw, 0));\n"
    shares = ", ".join("%.12g" % x for x in (values / source["radiance"]).ravel())
    with open(os.path.join(job.folder, f"fields{i}.cal"), "w") as file:
        file.write(place("column", columns, u) + place("line", rows, v) + f"share = select(line * {columns} + column + 1, {shares});\n")
    return f"void brightfunc fields{i}\n2 share {os.path.join(job.folder, f'fields{i}.cal')}\n0\n0\n", f"fields{i}"


def octree(job):
    text = "void plastic black\n0\n0\n5 0 0 0 0 0\n"
    for i, source in enumerate(job.sources):
        told, modifier = pattern(job, source, i)
        text += told + f"{modifier} light lum{i}\n0\n0\n3 {' '.join(['%.12g' % source['radiance']] * 3)}\n"
        text += shape(job, source, f"lum{i}", f"source{i}", True)
    for i, occluder in enumerate(job.occluders):
        text += shape(job, occluder, "black", f"occluder{i}", False)
    made = subprocess.run([os.path.join(HOME, "bin", "oconv"), "-"], input=text.encode(), capture_output=True, check=True, env=ENVIRONMENT)
    path = os.path.join(job.folder, "scene.oct")
    with open(path, "wb") as file:
        file.write(made.stdout)
    return path


def traced(job, tree, copies, options):
    lines = ["%.12g %.12g %.12g %.12g %.12g %.12g" % (*(p + job.get("raise", 0.0) * n), *n) for p, n in zip(job.positions, job.normals)]
    command = [os.path.join(HOME, "bin", "rtrace"), "-h", "-I", "-faa", "-ab", "0", "-lw", "0", *options.split(), tree]
    text = ("\n".join(lines) + "\n") * copies
    done = subprocess.run(command, input=text.encode(), capture_output=True, check=True, env=ENVIRONMENT)
    job.notes += [line.strip() for line in done.stderr.decode().splitlines() if "warning" in line]
    values = [float(line.split()[0]) for line in done.stdout.decode().splitlines() if line.strip()]
    return np.array(values).reshape(copies, len(job.positions))


def points(job):
    average = job.samples
    skip = (job.first + (job.seed_set - 1) * job.most) * average
    values = traced(job, octree(job), skip + job.count * average, job.get("options", ""))[skip:]
    return values.reshape(job.count, average, -1).mean(axis=1)


def efforts(job):
    tree = octree(job)
    for effort in job.efforts:
        yield traced(job, tree, 1, job.get("options", "") + f" -ds {1 / effort:.6g}")[0]


def version():
    said = subprocess.run([os.path.join(HOME, "bin", "rtrace"), "-version"], capture_output=True, env=ENVIRONMENT).stdout.decode()
    return f"{' '.join(said.split()[:2])} (pyradiance {pyradiance.__version__})"


protocol.main(version, "E = the value printed", points=points, efforts=efforts, knows=("fields",))
