"""Mitsuba: a beam on a floor, seen by `ptracer` from close above. pip install mitsuba numpy"""
import math, sys
import mitsuba as mi, numpy as np

mi.set_variant("scalar_rgb")
depth, half = 1.25, 0.7  # the floor lies at z = -depth and is 2 half wide, as far as the camera sees
epsilon = 1500 * 2.0**-24


def matrix(x, y, z, origin):
    made = np.eye(4)
    made[:3, 0], made[:3, 1], made[:3, 2], made[:3, 3] = x, y, z, origin
    return mi.ScalarTransform4f(made)


for radius in (0.3, 0.65):
    for height in (0.125, 0.5):
        scene = mi.load_dict({
            "type": "scene", "integrator": {"type": "ptracer", "max_depth": 2},
            "camera": {"type": "perspective", "to_world": matrix((-1, 0, 0), (0, 1, 0), (0, 0, -1), (0, 0, height - depth)), "near_clip": height / 1000,
                       "far_clip": 2 * height, "fov": math.degrees(2 * math.atan(half / height)),
                       "film": {"type": "hdrfilm", "width": 7, "height": 7, "rfilter": {"type": "box"}, "pixel_format": "rgb", "component_format": "float32"}},
            "floor": {"type": "rectangle", "to_world": matrix((half, 0, 0), (0, half, 0), (0, 0, 1), (0, 0, -depth)),
                      "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.5}}},
            "beam": {"type": "disk", "to_world": matrix((radius, 0, 0), (0, -radius, 0), (0, 0, -1), (0, 0, 3)),
                     "emitter": {"type": "directionalarea", "radiance": {"type": "rgb", "value": 1.0}}}})
        image = np.array(mi.render(scene, spp=4096))[..., 0]
        power = image.mean() * math.pi / 0.5 * (2 * half) ** 2  # E = pi L / rho, times the area; exact: pi radius^2
        # The cosine at the floor is taken of the direction from a point that is delta above it: less by (delta / h) r^2 / (r^2 + h^2).
        delta = epsilon * (1 + depth)
        share = 1 - height**2 / radius**2 * math.log(1 + radius**2 / height**2)
        print(f"beam of {radius} m, camera {height} m above: power off by {100 * (power / (math.pi * radius**2) - 1):+.4f} %, "
              f"predicted {-100 * delta / height * share:+.4f} %", file=sys.stderr)
