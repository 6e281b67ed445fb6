"""Radiance: rtrace -I measures 1e-4 units above the point given. pip install pyradiance"""
import math, os, subprocess
import pyradiance

home = os.path.dirname(pyradiance.__file__)
os.environ["RAYPATH"] = ".:" + os.path.join(home, "lib")
s, h, copies = 0.002, 0.01, 20000  # Half a side and height of a small square light: a difference of 1e-4 is 1 % of the height.
corners = [(-s, -s, h), (-s, s, h), (s, s, h), (s, -s, h)]
scene = "void light lum\n0\n0\n3 1 1 1\nlum polygon source\n0\n0\n12 " + " ".join("%.12g" % x for p in corners for x in p)
with open("height.oct", "wb") as file:
    file.write(subprocess.run([home + "/bin/oconv", "-"], input=scene.encode(), capture_output=True, check=True).stdout)
exact = lambda z: 4 * s / math.hypot(s, h - z) * math.atan(s / math.hypot(s, h - z))  # Lambert's formula under a square
for z in (0.0, -1e-4):
    command = [home + "/bin/rtrace", "-h", "-I", "-ab", "0", "-lw", "0", "-ds", ".05", "-dt", "0", "-dj", "1", "height.oct"]
    out = subprocess.run(command, input=f"0 0 {z} 0 0 1\n".encode() * copies, capture_output=True, check=True).stdout.decode()
    values = [float(line.split()[0]) for line in out.splitlines() if line.strip()]
    found = sum(values) / copies
    print(f"point at z = {z:+.4f}: rtrace {found:.6f}; exact there {exact(z):.6f}, 1e-4 higher {exact(z + 1e-4):.6f}")
