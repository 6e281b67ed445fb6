"""Does the league tell a witness that crashes, hangs or writes half a file from one that is wrong? With a made-up one.

    python selftest.py --etendue PROGRAM
"""
import argparse
import os
import sys
import tempfile
import types

import league

# Two pixels' worth of an honest renderer: the exact averages, with some noise; then all that can go wrong.
WITNESS = '''
import os, sys, time
sys.path.insert(0, {here!r})
import numpy as np
import protocol

def images(job):
    how = job.get("how", "honest")
    if how == "crashes" or how == "crashes once" and not os.path.exists(mark := os.path.join(os.path.dirname(__file__), "crashed")):
        how == "crashes" or open(mark, "w").close()
        os._exit(3)
    if how == "hangs":
        time.sleep(60)
    if how == "cannot":
        raise protocol.Inexpressible("that shape")
    grid, source = job.manifest["pixels"], job.sources[0]
    node, weight = np.polynomial.legendre.leggauss(8)
    place = lambda k: (node + 1) / 2 + k
    u, v = np.array(source["edge_u"])[0] / 2, abs(np.array(source["edge_v"])[1]) / 2
    c, out = source["center"], np.zeros((job.height, job.width))
    corner = lambda s, t, h: (s / np.hypot(h, s) * np.arctan2(t, np.hypot(h, s)) + t / np.hypot(h, t) * np.arctan2(s, np.hypot(h, t))) / (2 * np.pi)
    for row in range(job.height):
        for column in range(job.width):
            x, y = np.meshgrid(grid["corner_m"][0] + place(column) * grid["per_column_m"][0], grid["corner_m"][1] + place(row) * grid["per_row_m"][1])
            f = sum(a * b * corner(c[0] + a * u - x, c[1] + b * v - y, c[2]) for a in (-1, 1) for b in (-1, 1))
            out[row, column] = (f * np.outer(weight, weight)).sum() / 4
    for k in range(job.count):
        noise = 1 + 0.02 * np.random.default_rng(job.seed(k)).standard_normal(out.shape)
        yield job.rho * out * noise * (1.01 if how == "wrong" else 1) + (np.nan if how == "nan" and k == 3 else 0)

if len(sys.argv) > 1:
    protocol.main("made up", "E = pi L / rho", images=images)
    how = protocol.Job(sys.argv[1])
    if how.get("how", "") == "half":
        os.truncate(how.out, 1000)
    if how.get("how", "") == "dies after":
        os._exit(11)
'''
DUE = {"honest": "pass", "wrong": "fail", "crashes": "crashed", "crashes once": "pass", "hangs": "hung", "half": "broken output", "nan": "broken output",
       "cannot": "inexpressible", "dies after": "pass"}


def main():
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--etendue", required=True)
    given, bad = words.parse_args(), 0
    with tempfile.TemporaryDirectory() as folder:
        asked = league.League(types.SimpleNamespace(etendue=given.etendue, dir=folder, quick=False, seed_set=1, judge=False))
        asked.witnesses, asked.python, asked.installed, asked.wants = folder, lambda w: sys.executable, lambda w: None, lambda w: b""
        with open(os.path.join(folder, "made-up.py"), "w") as file:
            file.write(WITNESS.format(here=league.HERE))
        for how, due in DUE.items():
            entry = {"witness": "made-up", "case": "control", "label": how, "settings": {"how": how}, "control": False, "mode": "images", "pixels": "5x5",
                     "samples": 16, "count": 200, "most": 200, "tolerance": 1e-5, "smallest": "5e-3,5e-2", "timeout": 10}
            row = asked.run(entry)
            told = any("crashed once" in note for note in row.get("notes", []))
            bad += row["verdict"] != due or told != (how == "crashes once")
            print(f"{'as due' if row['verdict'] == due else 'NOT AS DUE':10} {how:12} {row['verdict']:14} {row.get('words', '')[:110]}")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
