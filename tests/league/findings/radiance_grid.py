"""Radiance: without jitter a light is sampled at 8 x 8 points at most, whatever -ds asks for. pip install pyradiance"""
import os, subprocess
import pyradiance

home = os.path.dirname(pyradiance.__file__)
os.environ["RAYPATH"] = ".:" + os.path.join(home, "lib")
# A square light of 1 at height 2, half hidden by a black square at height 1; a point in the penumbra, of which 0.53 of the light's
# columns are seen: on a grid of 8 x 8 that is 4 or 5 of 8, never 0.53.
square = lambda name, stuff, s, h: f"{stuff} polygon {name}\n0\n0\n12 {-s} {-s} {h} {-s} {s} {h} {s} {s} {h} {s} {-s} {h}\n"
scene = "void light lum\n0\n0\n3 1 1 1\nvoid plastic black\n0\n0\n5 0 0 0 0 0\n" + square("source", "lum", 0.5, 2) + square("blocker", "black", 0.35, 1)
with open("grid.oct", "wb") as file:
    file.write(subprocess.run([home + "/bin/oconv", "-"], input=scene.encode(), capture_output=True, check=True).stdout)
for options in ("", "-dt 0", "-dt 0 -ds .05", "-dt 0 -ds .02", "-dt 0 -ds .01", "-dt 0 -ds .05 -dj 1"):
    command = [home + "/bin/rtrace", "-h", "-I", "-ab", "0", "-lw", "0", *options.split(), "grid.oct"]
    copies = 20000 if "-dj" in options else 1
    out = subprocess.run(command, input=b"0.73 0.1 0 0 0 1\n" * copies, capture_output=True, check=True).stdout.decode()
    values = [float(line.split()[0]) for line in out.splitlines() if line.strip()]
    print(f"rtrace {options:24} {sum(values) / copies:.5f}" + (f"   (mean of {copies})" if copies > 1 else ""))
