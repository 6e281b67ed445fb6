#!/usr/bin/env python3
"""Renders the scene beside this file as independent images, for `etendue verify`.

    pip install mitsuba numpy
    python render.py 64                        64 images as independent.npy, an array [image, row, column]
    python render.py 64 --sampler multijitter  another sampler: multijitter.npy
    python render.py 64 --exr images           64 files images/0000.exr instead
    etendue verify CASE independent.npy        (from this folder: the manifest lies beside the images)
"""
import argparse
import json
import os
import sys
import time

import mitsuba as mi
import numpy as np

here = os.path.dirname(os.path.abspath(__file__))
with open(os.path.join(here, "manifest.json")) as file:
    manifest = json.load(file)

words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
words.add_argument("images", type=int, help="how many")
words.add_argument("--sampler", default="independent")
words.add_argument("--skip", type=int, default=0, help="begin with a later seed: images that others have not")
words.add_argument("--variant", default="scalar_rgb")
words.add_argument("--out", help="where the array goes (default: SAMPLER.npy)")
words.add_argument("--exr", metavar="DIR", help="write a file for each image instead")
given = words.parse_args()

first, spacing = manifest["seeds"]["first"], manifest["seeds"]["spacing"]
if given.images < 1 or first + (given.skip + given.images) * spacing >= 2**32:
    sys.exit(f"{given.images} images after {given.skip}: seeds have 32 bits and are {spacing} apart")

mi.set_variant(given.variant)
spp = manifest["samples_per_pixel"]
scene = mi.load_file(os.path.join(here, "scene.xml"), sampler=given.sampler, spp=str(spp))
count = scene.sensors()[0].sampler().sample_count()
if count != spp:
    sys.exit(f"{given.sampler} takes {count} samples where the manifest says {spp}: etendue export --samples {count}")

width, height = manifest["pixels"]["width"], manifest["pixels"]["height"]
stack = np.zeros((given.images, height, width), dtype=np.float32)
if given.exr:
    os.makedirs(given.exr, exist_ok=True)
begin = time.time()
for k in range(given.images):
    image = mi.render(scene, seed=first + (given.skip + k) * spacing, spp=spp)
    pixels = np.array(image)
    if pixels.shape[2] == 3 and not np.allclose(pixels[..., 0], pixels[..., 2], rtol=1e-5, atol=0):
        sys.exit("the image is coloured; the scene is not")
    stack[k] = pixels[..., 0]
    if given.exr:
        mi.util.write_bitmap(os.path.join(given.exr, f"{k:04d}.exr"), image, write_async=False)
if not given.exr:
    out = given.out or os.path.join(here, f"{given.sampler}.npy")
    np.save(out, stack)
print(f"{given.images} images of {width} x {height}, {count} samples a pixel, {given.sampler}, Mitsuba {mi.__version__}, "
      f"{time.time() - begin:.1f} s", file=sys.stderr)
