"""Blender Cycles (PyPI: bpy), images of direct light: `max_bounces` 0; 1 where there is a mirror, with reflective caustics.

Units      an area light of W watts has radiance W / (pi area), a point light of radius r W / (4 pi^2 r^2); an emission shader's
           strength is the radiance. E = pi L / rho.
Images     bottom row first: turned over here. The first of N samples of a pixel is at its centre (the manifest's
           `first_sample_at_centre`). Box filter, 32-bit EXR read as non-colour data.
Seeds      the scene's `cycles.seed`.
Settings   light (area: Cycles' own lights; mesh: surfaces that shine), pattern (TABULATED_SOBOL, BLUE_NOISE)
Textures   on a mesh that shines, by an image texture with `Closest`; a mirror is a glossy surface of roughness 0
Left at    adaptive sampling, denoising, clamping, light threshold: off
"""
import math
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
# A file of this name would hide Blender's own add-on `cycles`: its folder must not be searched.
sys.path = [p for p in sys.path if os.path.abspath(p or ".") != os.path.dirname(os.path.abspath(__file__))]
import bpy
import numpy as np
from mathutils import Matrix

import ball
import protocol

SIDES = 1024  # Corners of a disk made of straight edges, of the disk's area.


def material(name, kind, **inputs):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes = made.node_tree.nodes
    nodes.clear()
    out, shader = nodes.new("ShaderNodeOutputMaterial"), nodes.new(kind)
    for key, value in inputs.items():
        shader.inputs[key].default_value = value
    made.node_tree.links.new(shader.outputs[0], out.inputs["Surface"])
    return made


def grey(value):
    return (value, value, value, 1.0)


def mesh(name, vertices, faces, stuff):
    made = bpy.data.meshes.new(name)
    made.from_pydata([tuple(map(float, v)) for v in vertices], [], [tuple(map(int, f)) for f in faces])
    made.materials.append(stuff)
    bpy.context.scene.collection.objects.link(bpy.data.objects.new(name, made))


def shining(name, source):
    """Emission, of fields by a picture on the whole of the surface's UV map."""
    values = protocol.fields(source)
    if values is None:
        return material(name, "ShaderNodeEmission", Color=grey(1.0), Strength=source["radiance"])
    made = material(name, "ShaderNodeEmission", Strength=1.0)
    rows, columns = values.shape
    picture = bpy.data.images.new(name, columns, rows, float_buffer=True)
    picture.colorspace_settings.name = "Non-Color"
    picture.pixels.foreach_set(np.repeat(values[:, :, None], 4, axis=2).astype(np.float32).ravel())
    picture.update()
    picture.pack()
    nodes = made.node_tree.nodes
    texture = nodes.new("ShaderNodeTexImage")
    texture.image, texture.interpolation, texture.extension = picture, "Closest", "EXTEND"
    shader = next(node for node in nodes if node.type == "EMISSION")
    made.node_tree.links.new(texture.outputs["Color"], shader.inputs["Color"])
    return made


def surface(name, given, stuff):
    if given["kind"] == "sphere":
        mesh(name, *ball.ball(given), stuff)
    elif given["kind"] == "mesh":
        mesh(name, given["vertices"], given["triangles"], stuff)
    else:
        corners = protocol.outline(given, SIDES)
        mesh(name, corners, [range(len(corners))], stuff)
        if "fields" in given:
            data = bpy.data.objects[name].data
            data.uv_layers.new().data.foreach_set("uv", [0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0])


def lamp(name, given, bounces):
    kind, c = given["kind"], np.array(given["center"])
    if "fields" in given:
        raise protocol.Inexpressible("an area light whose radiance varies over it (a mesh that shines can have it)")
    made = bpy.data.lights.new(name, "POINT" if kind == "sphere" else "AREA")
    turned = np.eye(4)
    turned[:3, 3] = c
    if kind == "sphere":
        made.shadow_soft_size, made.use_soft_falloff = given["radius"], False
        made.energy = given["radiance"] * 4 * math.pi**2 * given["radius"] ** 2
    elif kind == "disk":
        u, _, n = protocol.frame(given["normal"])
        made.shape, made.size = "DISK", 2 * given["radius"]
        made.energy = given["radiance"] * math.pi**2 * given["radius"] ** 2
        turned[:3, 0], turned[:3, 1], turned[:3, 2] = u, -np.cross(n, u), -n
    elif kind == "rectangle":
        u, v, n = (np.array(given[k]) for k in ("edge_u", "edge_v", "normal"))
        a, b = np.linalg.norm(u), np.linalg.norm(v)
        made.shape, made.size, made.size_y = "RECTANGLE", a, b
        made.energy = given["radiance"] * math.pi * a * b
        turned[:3, 0], turned[:3, 1], turned[:3, 2] = u / a, -v / b, -n
    else:
        raise protocol.Inexpressible(f"an area light that is a {kind}")
    made.cycles.max_bounces = bounces
    held = bpy.data.objects.new(name, made)
    held.matrix_world = Matrix(turned.tolist())
    bpy.context.scene.collection.objects.link(held)


def build(job):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    half_x, half_y, height = job.level_camera()
    black = material("black", "ShaderNodeBsdfDiffuse", Color=grey(0.0))
    for i, source in enumerate(job.sources):
        if job.get("light", "area") == "mesh":
            surface(f"source{i}", source, shining(f"glow{i}", source))
        else:
            lamp(f"source{i}", source, 2 if job.mirrors else 0)
    for i, occluder in enumerate(job.occluders):
        surface(f"occluder{i}", occluder, black)
    for i, mirror in enumerate(job.mirrors):
        polished = material(f"polished{i}", "ShaderNodeBsdfAnisotropic", Color=grey(mirror["reflectance"]), Roughness=0.0)
        surface(f"mirror{i}", mirror, polished)
    floor = {"kind": "rectangle", "center": [0, 0, 0], "edge_u": [2 * half_x, 0, 0], "edge_v": [0, 2 * half_y, 0]}
    surface("receiver", floor, material("grey", "ShaderNodeBsdfDiffuse", Color=grey(job.rho), Roughness=0.0))
    camera = bpy.data.cameras.new("eye")
    camera.type, camera.ortho_scale = "ORTHO", 2 * max(half_x, half_y)
    camera.clip_start, camera.clip_end = height / 1000, 2 * height
    eye = bpy.data.objects.new("eye", camera)
    eye.location = (0, 0, height)
    scene.collection.objects.link(eye)
    scene.camera = eye
    scene.world = bpy.data.worlds.new("dark")
    scene.world.use_nodes = True
    for node in scene.world.node_tree.nodes:
        if node.type == "BACKGROUND":
            node.inputs["Color"].default_value, node.inputs["Strength"].default_value = grey(0.0), 0.0
    r, c = scene.render, scene.cycles
    r.engine = "CYCLES"
    r.resolution_x, r.resolution_y, r.resolution_percentage = job.width, job.height, 100
    r.use_compositing = r.use_sequencer = r.film_transparent = False
    r.dither_intensity = 0.0
    r.use_persistent_data = True
    r.threads_mode, r.threads = "FIXED", 1
    r.image_settings.file_format, r.image_settings.color_mode, r.image_settings.color_depth = "OPEN_EXR", "RGB", "32"
    scene.view_settings.view_transform = "Raw"
    c.device, c.samples, c.sampling_pattern = "CPU", job.samples, job.get("pattern", "TABULATED_SOBOL")
    c.use_adaptive_sampling = c.use_denoising = c.caustics_reflective = c.caustics_refractive = False
    c.sample_clamp_direct = c.sample_clamp_indirect = c.light_sampling_threshold = 0.0
    c.pixel_filter_type, c.film_exposure = job.get("filter", "BOX"), 1.0
    c.max_bounces = c.diffuse_bounces = c.glossy_bounces = c.transmission_bounces = job.depth - 2
    if job.mirrors:
        c.caustics_reflective, c.blur_glossy = True, 0.0
    return scene


def images(job):
    scene = build(job)
    path = os.path.join(job.folder, "frame.exr")
    for k in range(job.count):
        scene.cycles.seed = job.seed(k)
        scene.render.filepath = path
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(path, check_existing=False)
        image.colorspace_settings.name = "Non-Color"
        pixels = np.empty(job.width * job.height * image.channels, np.float32)
        image.pixels.foreach_get(pixels)
        yield pixels.reshape(job.height, job.width, -1)[::-1, :, 0]
        bpy.data.images.remove(image)
        os.remove(path)


protocol.main(f"Blender Cycles {bpy.app.version_string}", "E = pi L / rho", images=images, knows=("mirrors", "fields"))
