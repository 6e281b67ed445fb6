"""POV-Ray: an area light of two samples with area_illumination, one of them blocked. apt-get install povray"""
import re, subprocess

FADE = "fade_distance 0.01 fade_power 3"
AREA = f"light_source {{ <1,0,1> color rgb 2e5 {FADE} area_light <2,0,0>, <0,0,0>, 2, 1 area_illumination on }}"
TWO = "".join(f"light_source {{ <{x},0,1> color rgb 1e5 {FADE} }}" for x in (0, 2))
BLOCK = "disc { <0,0,0.5>, <0,0,1>, 0.1 }"  # before the nearer sample, at x = 0


def pixel(lights, occluder):
    with open("two.pov", "w") as file:
        file.write(f"""#version 3.7; global_settings {{ assumed_gamma 1.0 }}
camera {{ orthographic location <0,0,0.1> direction <0,0,-1> right <1e-6,0,0> up <0,1e-6,0> }}
plane {{ <0,0,1>, 0 pigment {{ color rgb 1 }} finish {{ ambient 0 emission 0 diffuse 1 }} }}
{lights} {occluder}""")
    subprocess.run(["povray", "+Itwo.pov", "+Otwo.ppm", "+FP16", "+W1", "+H1", "-D", "-A", "File_Gamma=1.0"], check=True, capture_output=True)
    with open("two.ppm", "rb") as file:
        raw = file.read()
    head = re.match(rb"P6\s+(?:#.*\s+)*(\d+)\s+(\d+)\s+(\d+)\s", raw)
    return int.from_bytes(raw[head.end():head.end() + 2], "big") / int(head.group(3))


for name, lights in (("area light of 2 x 1, area_illumination", AREA), ("two point lights", TWO)):
    free, blocked = pixel(lights, ""), pixel(lights, BLOCK)
    print(f"{name:40} free {free:.4f}, nearer one blocked {blocked:.4f}: {blocked / free:.3f} is left")
