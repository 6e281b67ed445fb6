"""Mitsuba 3 (PyPI: mitsuba), images by `path` with max_depth 2: direct light; 3 where there is a mirror.

Units      emitters have radiance L; a pixel is radiance, E = pi L / rho.
Images     first row on top, first column left, as the league has them: no flags. Box filter, 32 bits.
Seeds      `mi.render(seed=...)`; neighbouring seeds share streams in the scalar variants, ours are 100003 apart.
Settings   sampler (independent, multijitter, stratified, ldsampler, orthogonal), variant, rfilter (box), integrator (path;
           ptracer: light is traced, seen by a perspective camera square on, whose pixels lie as evenly on the receiver, for it
           has none that it could connect to an orthographic one)
Textures   `bitmap`, nearest texel, raw; a mirror is a `conductor` of no material; a beam is a disk with `directionalarea`, whose
           radiance is the beam's irradiance (as the control shows)
"""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
# This file is called as the package that it asks for: its folder must not come first.
sys.path = [p for p in sys.path if os.path.abspath(p or ".") != os.path.dirname(os.path.abspath(__file__))]
import mitsuba as mi
import numpy as np

import protocol


def placed(x, y, z, origin):
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2], matrix[:3, 3] = x, y, z, origin
    return mi.ScalarTransform4f(matrix)


def shape(job, given, name):
    kind = given["kind"]
    if kind == "sphere":
        return {"type": "sphere", "center": given["center"], "radius": given["radius"]}
    if kind == "disk":
        u, v, n = protocol.frame(given["normal"])
        return {"type": "disk", "to_world": placed(u * given["radius"], v * given["radius"], n, given["center"])}
    if kind == "rectangle":
        u, v = np.array(given["edge_u"]) / 2, np.array(given["edge_v"]) / 2
        return {"type": "rectangle", "to_world": placed(u, v, given["normal"], given["center"])}
    vertices, triangles = protocol.triangles(given)
    path = os.path.join(job.folder, name + ".obj")
    with open(path, "w") as file:
        file.writelines("v %r %r %r\n" % tuple(map(float, v)) for v in vertices)
        file.writelines("f %d %d %d\n" % tuple(int(i) + 1 for i in t) for t in triangles)
    return {"type": "obj", "filename": path, "face_normals": True}


def radiance(source):
    values = protocol.fields(source)
    if values is None:
        return {"type": "rgb", "value": source["radiance"]}
    # Its first row is where v is 0 (as the textured case shows).
    picture = mi.Bitmap(np.ascontiguousarray(values[:, :, None], np.float32))
    return {"type": "bitmap", "bitmap": picture, "filter_type": "nearest", "wrap_mode": "clamp", "raw": True}


def images(job):
    mi.set_variant(job.get("variant", "scalar_rgb"))
    centre, u, v, n, height = job.camera()
    if job.get("integrator", "path") == "ptracer":
        a, b = np.linalg.norm(u), np.linalg.norm(v)
        sensor = {"type": "perspective", "to_world": placed(-u / a, v / b, -n, centre + height * n), "fov_axis": "x",
                  "fov": float(np.degrees(2 * np.arctan(a / height)))}
    else:
        sensor = {"type": "orthographic", "to_world": placed(-u, v, -n, centre + height * n)}
    black = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.0}}}
    scene = {
        "type": "scene",
        "integrator": {"type": job.get("integrator", "path"), "max_depth": job.depth},
        "sensor": {
            **sensor,
            "near_clip": height / 1000, "far_clip": 2 * height,
            "sampler": {"type": job.get("sampler", "independent"), "sample_count": job.samples},
            "film": {"type": "hdrfilm", "width": job.width, "height": job.height, "pixel_format": "rgb",
                     "component_format": "float32", "rfilter": {"type": job.get("rfilter", "box")}},
        },
        "receiver": {"type": "rectangle", "to_world": placed(u, v, n, centre),
                     "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": job.rho}}},
    }
    for i, source in enumerate(job.sources):
        light = {"type": "area", "radiance": radiance(source)}
        scene[f"source{i}"] = {**shape(job, source, f"source{i}"), "bsdf": black, "emitter": light}
    for i, occluder in enumerate(job.occluders):
        scene[f"occluder{i}"] = {**shape(job, occluder, f"occluder{i}"), "bsdf": black}
    for i, mirror in enumerate(job.mirrors):
        sides = {"type": "conductor", "material": "none", "specular_reflectance": {"type": "rgb", "value": mirror["reflectance"]}}
        scene[f"mirror{i}"] = {**shape(job, mirror, f"mirror{i}"), "bsdf": {"type": "twosided", "bsdf": sides}}
    for i, beam in enumerate(job.beams):
        given = {"kind": "disk", "center": beam["center"], "normal": beam["direction"], "radius": beam["radius"]}
        light = {"type": "directionalarea", "radiance": {"type": "rgb", "value": beam["irradiance"]}}
        scene[f"beam{i}"] = {**shape(job, given, f"beam{i}"), "bsdf": black, "emitter": light}
    for i, ball in enumerate(job.glass):
        scene[f"glass{i}"] = {**shape(job, ball, f"glass{i}"), "bsdf": {"type": "dielectric", "int_ior": ball["index"], "ext_ior": 1.0}}
    loaded = mi.load_dict(scene)
    count = loaded.sensors()[0].sampler().sample_count()
    if count != job.samples:
        raise SystemExit(f"{job.get('sampler', 'independent')} takes {count} samples where {job.samples} are asked for")
    for k in range(job.count):
        yield np.array(mi.render(loaded, seed=job.seed(k), spp=job.samples))[..., 0]


protocol.main(lambda: f"Mitsuba {mi.__version__}", "E = pi L / rho", images=images, knows=("mirrors", "fields", "glass"))
