"""Cycles: with one sample a pixel, all samples are at the pixel's centre, whatever the seed. pip install bpy==5.0.1 numpy"""
import os, sys, tempfile
import bpy, numpy as np

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
# 4 x 4 pixels of width 1. A plane that shines covers the right quarter of the third column (x from 0 to 1), not the pixels' centres.
mesh = bpy.data.meshes.new("quarter")
mesh.from_pydata([(0.75, -3, 0), (3, -3, 0), (3, 3, 0), (0.75, 3, 0)], [], [(0, 1, 2, 3)])
glow = bpy.data.materials.new("glow")
glow.use_nodes = True
glow.node_tree.nodes.clear()
out, shine = glow.node_tree.nodes.new("ShaderNodeOutputMaterial"), glow.node_tree.nodes.new("ShaderNodeEmission")
glow.node_tree.links.new(shine.outputs[0], out.inputs["Surface"])
mesh.materials.append(glow)
scene.collection.objects.link(bpy.data.objects.new("quarter", mesh))
camera = bpy.data.cameras.new("eye")
camera.type, camera.ortho_scale = "ORTHO", 4.0
eye = bpy.data.objects.new("eye", camera)
eye.location = (0, 0, 1)
scene.collection.objects.link(eye)
scene.camera = eye
r, c = scene.render, scene.cycles
r.engine, r.resolution_x, r.resolution_y = "CYCLES", 4, 4
r.image_settings.file_format, r.image_settings.color_depth = "OPEN_EXR", "32"
c.use_adaptive_sampling = c.use_denoising = False
c.pixel_filter_type = "BOX"
path = os.path.join(tempfile.mkdtemp(), "one.exr")
for samples in (1, 2, 4, 16):
    c.samples, values = samples, []
    for k in range(200):
        c.seed, r.filepath = 1 + 100003 * k, path
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(path)
        image.colorspace_settings.name = "Non-Color"
        values.append(np.array(image.pixels[:]).reshape(4, 4, -1)[1, 2, 0])
        bpy.data.images.remove(image)
    mean, error = np.mean(values), np.std(values) / 200**0.5
    print(f"{samples:3} samples: mean of 200 seeds {mean:.4f} +- {error:.4f}; covered 0.25; (N - 1)/N of it {0.25 * (samples - 1) / samples:.4f}", file=sys.stderr)
