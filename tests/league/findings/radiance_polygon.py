"""Radiance: irradiance under a round light made of a polygon. pip install pyradiance"""
import math, os, subprocess
import pyradiance

home = os.path.dirname(pyradiance.__file__)
os.environ["RAYPATH"] = ".:" + os.path.join(home, "lib")
copies = 20000


def irradiance(corners, size, h=1.0):
    """Mean of rtrace, and Lambert's sum over the edges, under the middle of a regular polygon."""
    points = [(size * math.cos(-2 * math.pi * i / corners), size * math.sin(-2 * math.pi * i / corners), h) for i in range(corners)]
    scene = f"void light lum\n0\n0\n3 1 1 1\nlum polygon source\n0\n0\n{3 * corners} " + " ".join("%.12g" % x for p in points for x in p)
    with open("polygon.oct", "wb") as file:
        file.write(subprocess.run([home + "/bin/oconv", "-"], input=scene.encode(), capture_output=True, check=True).stdout)
    command = [home + "/bin/rtrace", "-h", "-I", "-ab", "0", "-lw", "0", "-ds", ".05", "-dt", "0", "-dj", "1", "polygon.oct"]
    out = subprocess.run(command, input=b"0 0 0 0 0 1\n" * copies, capture_output=True, check=True).stdout.decode()
    values = [float(line.split()[0]) for line in out.splitlines() if line.strip()]
    apothem = size * math.cos(math.pi / corners)
    exact = corners * apothem / math.hypot(apothem, h) * math.atan(size * math.sin(math.pi / corners) / math.hypot(apothem, h))
    return sum(values) / copies, exact


for corners in (4, 5, 6, 8, 64):
    found, exact = irradiance(corners, 0.5)
    print(f"{corners:3} corners: rtrace {found:.5f}, exact {exact:.5f}: {100 * (found / exact - 1):+.2f} %")
