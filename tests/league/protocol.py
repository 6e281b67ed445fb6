"""What every witness shares: a job comes in as JSON, an array or a table goes out, one line says how it went.

A witness is a program of its own, in an environment of its own:  python witnesses/NAME.py JOB.json

    job       {"mode": "images" | "points" | "efforts", "scene": scene.json, "manifest": manifest.json, "out": FILE,
               "settings": {...}, "samples": N, "count": images or replicates, "first": index of the first of them, "seed_set": 1, 2..,
               "efforts": [..] for a deterministic witness}
    images    out.npy, float32 [image, row, column]: radiance; row 0 on the +edge_v side, column 0 on the -edge_u side
    points    out.csv, point,replicate,samples,value: irradiance in W/m2; efforts: the same, one replicate for each effort
    stdout    one JSON line: {"version", "seconds", "units", "notes": [...]}, after the file has its name

The file is written under another name and renamed: it is there whole, or not at all. What a renderer prints goes to stderr.
"""
import csv
import json
import os
import sys
import time

import numpy as np


class Inexpressible(Exception):
    """The witness has no words for something in the scene: reported as such, and no fault of either side."""


class Job:
    """A job with its scene and manifest read."""

    def __init__(self, path):
        with open(path) as file:
            self.__dict__.update(json.load(file))
        with open(self.scene) as file:
            self.scene = json.load(file)
        with open(self.manifest) as file:
            self.manifest = json.load(file)
        self.sources, self.occluders = self.scene["sources"], self.scene["occluders"]
        self.mirrors, self.depth = self.scene.get("mirrors", []), self.manifest["depth"]
        self.beams, self.glass = self.scene.get("beams", []), self.scene.get("glass", [])
        self.rho = self.manifest["rho"]
        self.width, self.height = self.manifest["pixels"]["width"], self.manifest["pixels"]["height"]
        self.positions = np.array([p["position"] for p in self.scene["points"]])
        self.normals = np.array([p["normal"] for p in self.scene["points"]])
        self.folder = os.path.dirname(os.path.abspath(path))
        self.notes = []

    def get(self, name, default):
        """A setting of this entry of the plan."""
        return self.settings.get(name, default)

    def seed(self, k):
        """Seed of image or replicate k of this job: spaced, for neighbouring seeds share streams in some renderers."""
        return self.manifest["seeds"]["first"] + (self.seed_set - 1) * 50021 + (self.first + k) * 100003

    def camera(self):
        """Centre, half edges, normal and height of the orthographic camera that sees the receiver and nothing else."""
        r = self.scene["receiver"]
        if r is None or self.scene["camera_height"] is None:
            raise Inexpressible("a receiver that no camera sees alone")
        return (np.array(r["center"]), np.array(r["edge_u"]) / 2, np.array(r["edge_v"]) / 2, np.array(r["normal"]),
                self.scene["camera_height"])

    def level_camera(self):
        """Half widths and height, for recipes that know a level, axis-parallel receiver around the origin only."""
        centre, u, v, n, height = self.camera()
        if np.any(centre) or u[1] or u[2] or v[0] or v[2] or n[2] != 1 or u[0] <= 0 or v[1] <= 0:
            raise Inexpressible("a receiver that is not level around the origin")
        return u[0], v[1], height


    def must_know(self, knows):
        """What an adapter does not know by name it would pass over in silence."""
        if self.mirrors and "mirrors" not in knows:
            raise Inexpressible("a mirror: the adapter has none")
        if self.glass and "glass" not in knows:
            raise Inexpressible("a beam and a ball of glass: the adapter has none")
        if any("fields" in s for s in self.sources) and "fields" not in knows:
            raise Inexpressible("a light whose radiance varies over it")


def fields(source):
    """Radiance of a rectangle's fields: [row along edge_v][column along edge_u]; None of one that shines evenly."""
    f = source.get("fields")
    return None if f is None else np.array(f["radiance"]).reshape(f["rows"], f["columns"])


def frame(normal):
    """Two unit vectors that make a right-handed frame with a normal."""
    n = np.array(normal, float)
    n /= np.linalg.norm(n)
    u = np.cross(n, [1.0, 0.0, 0.0] if abs(n[0]) < 0.9 else [0.0, 1.0, 0.0])
    u /= np.linalg.norm(u)
    return u, np.cross(n, u), n


def outline(shape, sides=256):
    """Corners of a flat shape, counter-clockwise seen from its lit side; a disk becomes a polygon of the same area."""
    if shape["kind"] == "polygon":
        return np.array(shape["vertices"])
    c = np.array(shape["center"])
    if shape["kind"] == "rectangle":
        u, v = np.array(shape["edge_u"]) / 2, np.array(shape["edge_v"]) / 2
        return np.array([c - u - v, c + u - v, c + u + v, c - u + v])
    if shape["kind"] == "disk":
        u, v, _ = frame(shape["normal"])
        r = shape["radius"] * np.sqrt(2 * np.pi / sides / np.sin(2 * np.pi / sides))
        turns = 2 * np.pi * np.arange(sides) / sides
        return c + r * (np.outer(np.cos(turns), u) + np.outer(np.sin(turns), v))
    raise Inexpressible(f"a {shape['kind']} as a flat outline")


def triangles(shape, sides=256):
    """Vertices and triangles of a flat shape or a mesh."""
    if shape["kind"] in ("polygon", "mesh"):
        return np.array(shape["vertices"]), np.array(shape["triangles"])
    corners = outline(shape, sides)
    return corners, np.array([(0, i, i + 1) for i in range(1, len(corners) - 1)])


def _finish(job, write):
    part = job.out + ".part"
    with open(part, "wb") as file:
        write(file)
        file.flush()
        os.fsync(file.fileno())
    os.replace(part, job.out)


def main(version, units, images=None, points=None, efforts=None, knows=()):
    """Runs the job that the command line names. `images` yields arrays [row, column], `points` yields an array of values
    for each replicate, `efforts` one for each effort; `knows` names what the adapter can do of `mirrors`, `fields` and `glass`."""
    sys.stdout.flush()
    answer = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    job = Job(sys.argv[1])
    begin = time.time()
    try:
        job.must_know(knows)
        if job.mode == "images":
            stack = np.zeros((job.count, job.height, job.width), np.float32)
            for k, image in enumerate(images(job)):
                stack[k] = image
            _finish(job, lambda file: np.save(file, stack))
        else:
            made = points(job) if job.mode == "points" else efforts(job)
            table = []
            for k, values in enumerate(made):
                replicate, samples = (k, job.samples) if job.mode == "points" else (0, job.efforts[k])
                table += [(i, replicate, samples, repr(float(v))) for i, v in enumerate(values)]
            text = "point,replicate,samples,value\n" + "".join(",".join(map(str, row)) + "\n" for row in table)
            _finish(job, lambda file: file.write(text.encode()))
        said = {"version": version() if callable(version) else version, "units": units,
                "seconds": round(time.time() - begin, 3), "notes": sorted(set(job.notes))}
    except Inexpressible as what:
        said = {"inexpressible": str(what)}
    answer.write(json.dumps(said) + "\n")
    answer.flush()


def read_points(path):
    """A table of estimates as {samples: array [replicate, point]}."""
    found = {}
    with open(path) as file:
        for row in csv.DictReader(file):
            found.setdefault(int(row["samples"]), {})[int(row["replicate"]), int(row["point"])] = float(row["value"])
    tables = {}
    for samples, values in found.items():
        shape = (1 + max(k for k, _ in values), 1 + max(i for _, i in values))
        table = np.full(shape, np.nan)
        for at, value in values.items():
            table[at] = value
        tables[samples] = table
    return tables
