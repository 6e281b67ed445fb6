"""One of the rooms of ours.rs in Mitsuba 3 (LLVM, single precision, one thread): samples a second at 65 points.

    python mitsuba_room.py a|c|d|e SAMPLES
    python mitsuba_room.py a|c|d|e 0 TARGET      one point in mid-penumbra, until its relative standard error is that small

`scene.sample_emitter_direction` in a recorded loop, a shadow ray each, one lane for a part of one point's samples: the fastest
route that was found for a user of its Python interface. Needs `pip install mitsuba numpy` and LLVM 19 (DRJIT_LIBLLVM_PATH names the
library where it is not found). Seeds go through `dr.opaque`: a literal one would be compiled into the kernel. One line of JSON:
median of five rounds after one that compiles.
"""
import json, math, os, resource, sys, time

LLVM = "/usr/lib/x86_64-linux-gnu/libLLVM-19.so"
if "DRJIT_LIBLLVM_PATH" not in os.environ and os.path.exists(LLVM):
    os.environ["DRJIT_LIBLLVM_PATH"] = LLVM
import numpy as np
import drjit as dr
import mitsuba as mi

POINTS, LANES, ROUNDS = 65, 1024, 5
room, samples = sys.argv[1], int(sys.argv[2])
target = float(sys.argv[3]) if len(sys.argv) > 3 else None
places = np.linspace(-1.5, 1.5, 65)
if target:
    POINTS, LANES, samples, places = 1, 8192, 65536, places[47:48]
mi.set_variant("llvm_ad_rgb")
dr.set_thread_count(1)


def flat(kind, half, z, down=False):
    place = mi.ScalarTransform4f().translate([0, 0, z])
    if down:
        place = place @ mi.ScalarTransform4f().rotate([1, 0, 0], 180)
    return {"type": kind, "to_world": place @ mi.ScalarTransform4f().scale([half, half, 1])}


def disk_mesh(spokes=224):
    """The disk of ours.rs: as many rings as spokes."""
    turn = 2 * np.pi * np.arange(spokes) / spokes
    ring = np.stack([np.cos(turn), np.sin(turn), np.zeros(spokes)], 1)
    corners = np.concatenate([[[0, 0, 1]]] + [[0, 0, 1] + 0.35 * i / spokes * ring for i in range(1, spokes + 1)])
    at = lambda i, j: 1 + (i - 1) * spokes + j % spokes
    faces = [[0, at(1, j), at(1, j + 1)] for j in range(spokes)]
    for i in range(1, spokes):
        for j in range(spokes):
            faces += [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
    return corners, np.array(faces)


source = flat("disk" if room in "ad" else "rectangle", 0.5, 2, True)
source["emitter"] = {"type": "area", "radiance": {"type": "rgb", "value": 1 / math.pi}}
scene = {"type": "scene", "source": source}
if room == "c":
    scene["occluder"] = flat("rectangle", 0.35, 1)
elif room == "d":
    scene["occluder"] = flat("disk", 0.35, 1)
elif room == "e":
    corners, faces = disk_mesh()
    mesh = mi.Mesh("occluder", len(corners), len(faces))
    parts = mi.traverse(mesh)
    parts["vertex_positions"] = np.ascontiguousarray(corners, np.float32).ravel()
    parts["faces"] = np.ascontiguousarray(faces, np.uint32).ravel()
    parts.update()
    scene["occluder"] = mesh
scene = mi.load_dict(scene)


@dr.syntax
def gathered(point, random, count):
    i, total = mi.UInt32(0), mi.Float64(0)
    while i < count:
        square = mi.Point2f(random.next_float32(), random.next_float32())
        sample, weight = scene.sample_emitter_direction(point, square, True)
        total += mi.Float64(weight[0] * dr.maximum(sample.d.z, 0))
        i += 1
    return total


def lanes_of(seed):
    """Sums of each lane."""
    n = POINTS * LANES
    x = dr.gather(mi.Float, mi.Float(places), dr.arange(mi.UInt32, n) // LANES)
    state, stream = mi.sample_tea_32(dr.arange(mi.UInt32, n), dr.opaque(mi.UInt32, seed))
    random = mi.PCG32(size=n, initstate=mi.UInt64(state), initseq=mi.UInt64(stream))
    point = dr.zeros(mi.SurfaceInteraction3f, n)
    point.p, point.n = mi.Point3f(x, 0, 0), mi.Normal3f(0, 0, 1)
    point.sh_frame = mi.Frame3f(point.n)
    total = gathered(point, random, dr.opaque(mi.UInt32, samples // LANES))
    dr.eval(total)
    return np.array(total)


def round_of(seed):
    """Sums of each point."""
    return lanes_of(seed).reshape(POINTS, LANES).sum(1)


if target:
    # A round of eight samples a lane; lanes' own sums are replicates.
    n, mean, squares, seed = 0, 0.0, 0.0, 0
    while n == 0 or math.sqrt(squares / (n - 1) / n) > target * mean:
        seed += 1
        for estimate in lanes_of(seed) / (samples // LANES):
            n += 1
            step = estimate - mean
            mean += step / n
            squares += step * (estimate - mean)
    print(json.dumps({"who": f"mitsuba {mi.__version__}", "room": room, "samples": n * (samples // LANES), "mean": mean}))
    sys.exit()
seconds = []
for seed in range(ROUNDS + 1):
    begin = time.perf_counter()
    estimates = round_of(seed + 1) / (samples // LANES * LANES)
    seconds.append(time.perf_counter() - begin)
per_round = POINTS * (samples // LANES * LANES)
print(json.dumps({
    "who": f"mitsuba {mi.__version__}", "room": room, "samples": samples // LANES * LANES,
    "msamples_per_s": round(per_round / sorted(seconds[1:])[ROUNDS // 2] / 1e6, 3), "first_round_s": round(seconds[0], 3),
    "at_the_middle": float(estimates[POINTS // 2]), "at_the_47th": float(estimates[47]),
    "peak_mib": round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024, 1)}))
