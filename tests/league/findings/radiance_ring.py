"""Radiance: irradiance under a disk light. pip install pyradiance"""
import math, os, subprocess
import pyradiance

home = os.path.dirname(pyradiance.__file__)
os.environ["RAYPATH"] = ".:" + os.path.join(home, "lib")
a, h, copies = 0.5, 1.0, 20000
scene = f"void light lum\n0\n0\n3 1 1 1\nlum ring source\n0\n0\n8 0 0 {h} 0 0 -1 0 {a}\n"
with open("ring.oct", "wb") as file:
    file.write(subprocess.run([home + "/bin/oconv", "-"], input=scene.encode(), capture_output=True, check=True).stdout)
# The default grid without jitter is left aside: each value is a fully jittered one, and the values are independent.
command = [home + "/bin/rtrace", "-h", "-I", "-ab", "0", "-lw", "0", "-ds", ".05", "-dt", "0", "-dj", "1", "ring.oct"]
out = subprocess.run(command, input=b"0 0 0 0 0 1\n" * copies, capture_output=True, check=True).stdout.decode()
values = [float(line.split()[0]) for line in out.splitlines() if line.strip()]
mean = sum(values) / len(values)
error = math.sqrt(sum((v - mean) ** 2 for v in values)) / len(values)
exact = math.pi * a * a / (a * a + h * h)
print(f"rtrace {mean:.6f} +- {error:.6f}, exact {exact:.6f}: {100 * (mean / exact - 1):+.3f} % +- {100 * error / exact:.3f} %")
