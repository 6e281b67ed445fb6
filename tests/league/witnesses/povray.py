"""POV-Ray (Debian: povray), one row of pixels along the line of points; deterministic, so judged by convergence.

Units      a pixel is colour x diffuse x cos(theta_i): no 1/pi, no 1/r2, no cosine at the source. With `fade_power 3` and a
           tiny `fade_distance` f a light falls off as 2 (f/r)^3, which for a source parallel to the receiver at height H
           carries cos(theta_s) / r2 = H / r^3: colour = gain L A H / (2 f^3) makes a pixel gain x E.
Images     orthographic camera, a value at each pixel's centre, 16-bit linear PPM; the gain puts the brightest at 0.9.
Efforts    n: an n x n grid on each source
Settings   recipe: `area_illumination` (the program's own for light by area), `shadow` (an area light without it: light from
           its centre, times how much of it is seen; in cases where the source is distant), `points` (n x n single lights in
           the middles of equal areas: what the program's area lights stand for); turn (degrees by which a grid is turned);
           jitter, adaptive, square (a disk's grid without `circular`)
"""
import math
import os
import re
import shutil
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
import numpy as np

import protocol

FADE = 0.01
STEEP = 1e-6  # height of a pixel, metres: the row is a line


def vector(v):
    return "<%.15g,%.15g,%.15g>" % tuple(v)


def area(source):
    if source["kind"] == "disk":
        return math.pi * source["radius"] ** 2
    return float(np.linalg.norm(np.cross(source["edge_u"], source["edge_v"])))


def axes(job, source):
    """Edges of the square that the grid spans."""
    if source["kind"] == "disk":
        u, v = np.array([2 * source["radius"], 0, 0]), np.array([0, 2 * source["radius"], 0])
    else:
        u, v = np.array(source["edge_u"]), np.array(source["edge_v"])
    t = math.radians(job.get("turn", 0.0))
    if t and source["kind"] != "disk":
        raise protocol.Inexpressible("a turned grid on a rectangle")
    return u * math.cos(t) + v * math.sin(t), v * math.cos(t) - u * math.sin(t)


def middles(source, n):
    """Points in the middles of n x n parts of equal area."""
    g = (np.arange(n) + 0.5) / n
    s, t = (a.ravel() for a in np.meshgrid(g, g))
    c = np.array(source["center"])
    if source["kind"] == "disk":
        r, turn = source["radius"] * np.sqrt(s), 2 * math.pi * (t + (math.sqrt(5) - 1) / 2 * np.round(s * n))
        return c + np.column_stack([r * np.cos(turn), r * np.sin(turn), 0 * r])
    return c + np.outer(s - 0.5, source["edge_u"]) + np.outer(t - 0.5, source["edge_v"])


def lights(job, n, gain):
    recipe, text = job.get("recipe", "area_illumination"), ""
    for source in job.sources:
        if source["kind"] not in ("disk", "rectangle") or source["normal"][2] != -1:
            raise protocol.Inexpressible("an area light that is no level disk or rectangle")
        power = gain * source["radiance"] * area(source) * source["center"][2] / (2 * FADE**3)
        fade = f"fade_distance {FADE} fade_power 3"
        if recipe == "points":
            text += "".join(f"light_source {{ {vector(p)} color rgb {power / n**2:.15g} {fade} }}\n" for p in middles(source, n))
            continue
        u, v = axes(job, source)
        text += f"light_source {{ {vector(source['center'])} color rgb {power:.15g} {fade} area_light {vector(u)}, {vector(v)}, {n}, {n}"
        text += " area_illumination on" if recipe == "area_illumination" else ""
        text += " circular" if source["kind"] == "disk" and not job.get("square", False) else ""
        text += " jitter" if job.get("jitter", False) else ""
        text += f" adaptive {job.settings['adaptive']}" if "adaptive" in job.settings else ""
        text += " }\n"
    return text


def occluder(shape):
    if shape["kind"] == "sphere":
        return f"sphere {{ {vector(shape['center'])}, {shape['radius']:.15g} }}\n"
    if shape["kind"] == "disk":
        return f"disc {{ {vector(shape['center'])}, {vector(shape['normal'])}, {shape['radius']:.15g} }}\n"
    corners = [vector(c) for c in protocol.outline(shape)]
    return f"polygon {{ {len(corners) + 1}, {', '.join(corners + corners[:1])} }}\n"


def brightest(job):
    """A bound on the irradiance at the points, W/m2: each source as a point at its nearest."""
    total = np.zeros(len(job.positions))
    for s in job.sources:
        r = np.maximum(np.linalg.norm(job.positions - np.array(s["center"]), axis=1), 1e-9)
        total += np.minimum(math.pi * s["radiance"], s["radiance"] * area(s) * (s["center"][2] / r) ** 2 / r**2)
    return total.max()


def efforts(job):
    first, last, count = job.positions[0], job.positions[-1], len(job.positions)
    step = (last - first) / (count - 1)
    if np.abs(job.positions - (first + np.outer(np.arange(count), step))).max() > 1e-12 or np.any(job.normals != [0, 0, 1]) or first[2]:
        raise protocol.Inexpressible("points that do not lie on a level line, evenly")
    gain = 0.9 / brightest(job)
    along = step / np.linalg.norm(step)
    rows = job.get("rows", 1)
    camera = (first + last) / 2 + [0, 0, job.scene["camera_height"] / 10 if job.scene["camera_height"] < 0.1 else 0.01]
    for n in job.efforts:
        side = math.isqrt(n)
        with open(os.path.join(job.folder, "scene.pov"), "w") as file:
            file.write("#version 3.7;\nglobal_settings { assumed_gamma 1.0 max_trace_level 1 }\n"
                       f"camera {{ orthographic location {vector(camera)} direction <0,0,-1> right {vector(step * count)} "
                       f"up {vector(STEEP * rows * np.array([-along[1], along[0], 0]))} }}\n"
                       "plane { <0,0,1>, 0 pigment { color rgb 1 } finish { ambient 0 emission 0 diffuse 1 } }\n"
                       + lights(job, side, gain) + "".join(map(occluder, job.occluders)))
        subprocess.run(["povray", "+Wt1", "+Iscene.pov", "+Oscene.ppm", "+FP16", f"+W{count}", f"+H{rows}", "-D", "-A", "File_Gamma=1.0"],
                       cwd=job.folder, stdout=2, check=True)
        with open(os.path.join(job.folder, "scene.ppm"), "rb") as file:
            raw = file.read()
        head = re.match(rb"P6\s+(?:#.*\s+)*(\d+)\s+(\d+)\s+(\d+)\s", raw)
        pixels = np.frombuffer(raw[head.end():], ">u2").reshape(rows, count, 3)[:, :, 0] / int(head.group(3))
        if pixels.max() >= 1:
            raise SystemExit("a pixel is clipped")
        yield pixels.mean(axis=0) / gain


def version():
    said = subprocess.run(["povray", "--version"], capture_output=True, text=True)
    return "POV-Ray " + re.search(r"POV-Ray (\S+)", said.stdout + said.stderr).group(1)


if shutil.which("povray") is None:
    raise SystemExit("povray is not on the PATH (apt-get install povray)")
protocol.main(version, "E = pixel / gain", efforts=efforts)
