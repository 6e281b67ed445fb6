"""Spheres for witnesses that have flat faces only."""
import numpy as np


def ball(given, around=128):
    """A sphere of flat faces, vertices and faces of three or four corners; its silhouette has the right area on average."""
    rings = around // 2
    polar, turn = np.pi * np.arange(1, rings) / rings, 2 * np.pi * np.arange(around) / around
    unit = [[np.sin(p) * np.cos(t), np.sin(p) * np.sin(t), np.cos(p)] for p in polar for t in turn] + [[0, 0, 1], [0, 0, -1]]
    radius = given["radius"] * (1 + (np.pi / around) ** 2 / 3)
    top, bottom = len(unit) - 2, len(unit) - 1
    at = lambda ring, k: ring * around + k % around
    faces = [(at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)) for i in range(rings - 2) for k in range(around)]
    faces += [(top, at(0, k), at(0, k + 1)) for k in range(around)]
    faces += [(bottom, at(rings - 2, k + 1), at(rings - 2, k)) for k in range(around)]
    return np.array(given["center"]) + radius * np.array(unit), faces
