"""POV-Ray: how much of a `circular` area light is seen past a straight edge. apt-get install povray"""
import math, re, subprocess

turns, n = (0, 22.5, 45), 257
for turn in turns:
    t = math.radians(turn)
    u, v = (2 * math.cos(t), 2 * math.sin(t)), (-2 * math.sin(t), 2 * math.cos(t))
    # A light of radius 1 at height 100; at height 50 an edge that lets the part x > 0.6 of the light be seen from the origin.
    scene = f"""#version 3.7; global_settings {{ assumed_gamma 1.0 }}
camera {{ orthographic location <0,0,1> direction <0,0,-1> right <1e-6,0,0> up <0,1e-6,0> }}
plane {{ <0,0,1>, 0 pigment {{ color rgb 1 }} finish {{ ambient 0 emission 0 diffuse 1 }} }}
light_source {{ <0,0,100> color rgb 0.9 area_light <{u[0]},{u[1]},0>, <{v[0]},{v[1]},0>, {n}, {n} circular }}
box {{ <-9,-9,49.999>, <0.3,9,50> pigment {{ color rgb 0 }} }}
"""
    with open("circular.pov", "w") as file:
        file.write(scene)
    subprocess.run(["povray", "+Icircular.pov", "+Ocircular.ppm", "+FP16", "+W1", "+H1", "-D", "-A", "File_Gamma=1.0"], check=True, capture_output=True)
    with open("circular.ppm", "rb") as file:
        raw = file.read()
    head = re.match(rb"P6\s+(?:#.*\s+)*(\d+)\s+(\d+)\s+(\d+)\s", raw)
    seen = int.from_bytes(raw[head.end():head.end() + 2], "big") / int(head.group(3)) / 0.9
    exact = (math.acos(0.6) - 0.6 * 0.8) / math.pi
    print(f"grid turned by {turn:4} degrees: {seen:.4f} of the light is seen, exact {exact:.4f}: {100 * (seen / exact - 1):+.1f} %")
