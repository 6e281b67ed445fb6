"""Cycles: a rectangle light 1 mm above a floor. pip install bpy==5.0.1 numpy"""
import math, os, sys, tempfile
import bpy, numpy as np

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
mesh = bpy.data.meshes.new("floor")
mesh.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
grey = bpy.data.materials.new("grey")
grey.use_nodes = True
grey.node_tree.nodes.clear()
out, diffuse = grey.node_tree.nodes.new("ShaderNodeOutputMaterial"), grey.node_tree.nodes.new("ShaderNodeBsdfDiffuse")
diffuse.inputs["Color"].default_value = (0.5, 0.5, 0.5, 1)
grey.node_tree.links.new(diffuse.outputs[0], out.inputs["Surface"])
mesh.materials.append(grey)
scene.collection.objects.link(bpy.data.objects.new("floor", mesh))
side = 0.8
light = bpy.data.lights.new("light", "AREA")
light.shape, light.size, light.size_y, light.energy = "RECTANGLE", side, side, math.pi * side * side  # radiance 1
lamp = bpy.data.objects.new("light", light)
scene.collection.objects.link(lamp)
camera = bpy.data.cameras.new("eye")
camera.type, camera.ortho_scale = "ORTHO", 1.0
eye = bpy.data.objects.new("eye", camera)
scene.collection.objects.link(eye)
scene.camera = eye
r, c = scene.render, scene.cycles
r.engine, r.resolution_x, r.resolution_y = "CYCLES", 5, 5
r.image_settings.file_format, r.image_settings.color_depth = "OPEN_EXR", "32"
c.samples, c.use_adaptive_sampling, c.use_denoising, c.pixel_filter_type, c.max_bounces = 1024, False, False, "BOX", 0
path = os.path.join(tempfile.mkdtemp(), "contact.exr")
a = side / 2
exact = lambda h: 4 / math.pi * a / math.hypot(a, h) * math.atan(a / math.hypot(a, h))  # Lambert's formula, of radiance 1
for height in (0.001, 0.0015, 0.003, 0.01):
    lamp.location, eye.location = (0, 0, height), (0, 0, height / 2)
    camera.clip_start = height / 1000
    r.filepath = path
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Non-Color"
    pixels = np.array(image.pixels[:]).reshape(5, 5, -1)[1:4, 1:4, 0] * 2  # of the light's radiance; 1 where it fills the hemisphere
    bpy.data.images.remove(image)
    print(f"height {1000 * height:4} mm, 3 x 3 pixels of 0.2 m under the light (exact in the middle: {exact(height):.3f}):\n{np.round(pixels, 3)}",
          file=sys.stderr)
