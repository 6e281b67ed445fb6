"""Who is asked what: each entry is a witness, a case, settings under a label, and how much work.

    control     the entries that must agree before anything else is judged of a witness
    quick       what `--quick` runs, and with how much work
Images: `pixels`, `samples` a pixel, images from `count` up to `most`: as many as the smallest bias needs. Points: `samples` for
one replicate, replicates likewise. Efforts: a list, for deterministic witnesses.
"""

SMALLEST = "1e-3,2e-2"  # Relative bias that a verdict must be able to see: in the mean, at the worst place.
SMALLEST_QUICK = "3e-3,6e-2"
OPEN = ["disk-025", "disk-050", "disk-100", "rectangle", "grazing", "fields"]
SHADOWS = ["rectangle-occluder", "disk-occluder", "annular-eclipse"]
BALLS = ["sphere-light", "sphere-occluder"]
CONTACTS = ["contact-100mm", "contact-10mm", "contact-3mm", "contact-1mm"]
ENTRIES = []


def add(witness, case, label, settings=None, **more):
    ENTRIES.append({"witness": witness, "case": case, "label": label, "settings": settings or {}, "control": False, "quick": None,
                    "tolerance": 1e-5, "smallest": SMALLEST, "timeout": 3600, **more})


def images(witness, case, label, settings=None, pixels="7x7", samples=64, count=400, most=8000, **more):
    add(witness, case, label, settings, mode="images", pixels=pixels, samples=samples, count=count, most=most, **more)


def points(witness, case, label, settings=None, samples=8, count=400, most=4000, **more):
    add(witness, case, label, settings, mode="points", pixels="7x7", samples=samples, count=count, most=most, **more)


def efforts(witness, case, label, settings=None, efforts=(81, 289, 1089, 4225, 16641, 66049), **more):
    add(witness, case, label, settings, mode="efforts", pixels="7x7", samples=1, count=1, most=1, efforts=list(efforts), **more)


# etendue's own estimator, judged like the rest.
for strategy in ("random", "stratified"):
    for case in ["control", *OPEN, "textured", *SHADOWS, *BALLS, "contact-100mm", "contact-10mm"]:
        add("etendue", case, strategy, mode="own", samples=16, pixels="7x7", count=1, most=1, quick={} if case == "control" else None,
            control=case == "control")
add("etendue", "contact-10mm", "solid-angle", mode="own", samples=16, pixels="7x7", count=1, most=1)

# Mitsuba: the sampler that one meets first, and the two that promise less noise.
images("mitsuba", "control", "independent", {"sampler": "independent"}, pixels="9x9", samples=16, count=2000, most=10000, control=True,
       quick={"count": 500, "most": 500})
for case in OPEN[:4]:
    images("mitsuba", case, "independent", {"sampler": "independent"}, pixels="5x5", samples=64, count=6000, most=30000)
for case in OPEN[4:] + SHADOWS + BALLS + CONTACTS[:2]:
    images("mitsuba", case, "independent", {"sampler": "independent"}, samples=256, count=1000, most=4000 if case == "contact-10mm" else 20000,
           quick={"count": 400, "most": 400} if case == "disk-occluder" else None)
for sampler in ("multijitter", "stratified"):
    for case in OPEN[:4]:
        images("mitsuba", case, sampler, {"sampler": sampler}, pixels="5x5", samples=16, count=8000, most=30000,
               quick={"count": 4000, "most": 4000} if case == "disk-050" else None)
    for case in ["rectangle-occluder", "disk-occluder"] + (["sphere-light"] if sampler == "multijitter" else []):
        images("mitsuba", case, sampler, {"sampler": sampler}, samples=256, count=1000, most=12000)

images("mitsuba", "textured", "independent", {"sampler": "independent"}, samples=64, count=1000, most=20000, quick={"count": 1600, "most": 1600})
for integrator in ("path", "ptracer"):
    images("mitsuba", "mirror", integrator, {"integrator": integrator}, samples=1024, count=200, most=20000)
for case in ("ball-control", "ball"):
    images("mitsuba", case, "ptracer", {"integrator": "ptracer"}, samples=4096, count=200, most=8000)

# Radiance: with full jitter; a disk as the program has it, as strips, as a polygon; then as a user meets it.
# Points stand 1e-4 m lower than asked, for the program lifts them by as much (its own entries, to 1e-5, show it).
JITTER = "-ds .05 -dt 0 -dj 1 -u+"
LOWERED = {"options": JITTER, "raise": -1e-4}
points("radiance", "control", "jittered", LOWERED, control=True, quick={"count": 200, "most": 400})
for case in ("rectangle", "fields", "grazing", "rectangle-occluder", "sphere-light", "contact-100mm", "contact-10mm"):
    points("radiance", case, "jittered", LOWERED, most=60000 if case in ("sphere-light", "contact-100mm") else 4000,
           quick={"count": 200, "most": 800} if case == "rectangle-occluder" else None)
points("radiance", "textured", "jittered", LOWERED)
points("radiance", "mirror", "jittered", LOWERED)
for case in ("disk-025", "disk-050", "disk-100", "disk-occluder", "annular-eclipse", "sphere-occluder"):
    quick = {"count": 300, "most": 400} if case == "disk-050" else None
    points("radiance", case, "jittered", LOWERED, quick=quick)
    points("radiance", case, "jittered, disk as 64-gon", {**LOWERED, "disk": "polygon"}, quick=quick)
    points("radiance", case, "jittered, disk as strips", {**LOWERED, "disk": "strips"}, samples=1, count=400, most=1600, tolerance=1e-4)
points("radiance", "rectangle", "jittered, points as asked, to 1e-5", {"options": JITTER}, count=14000, most=14000, smallest="5e-5,1e-3", tolerance=1e-6)
points("radiance", "rectangle", "jittered, points lowered by 1e-4, to 1e-5", LOWERED, count=14000, most=14000,
       smallest="5e-5,1e-3", tolerance=1e-6)
for case in ("rectangle", "rectangle-occluder"):
    efforts("radiance", case, "defaults, -ds finer", {"options": ""}, efforts=(5, 10, 20, 40, 80),
            quick={} if case == "rectangle-occluder" else None)
    efforts("radiance", case, "-dt 0, -ds finer", {"options": "-dt 0"}, efforts=(5, 10, 20, 40, 80))

# raysect: rays aimed at the sources' bounding spheres. Some 400,000 rays a second, so fewer cases than the others have.
points("raysect", "control", "targeted", {"observer": "targeted"}, samples=4000, count=400, most=8000, control=True,
       quick={"samples": 500, "count": 800, "most": 800, "smallest": "1e-2,6e-2"})
for case in ("disk-050", "rectangle-occluder", "disk-occluder", "sphere-light", "sphere-occluder"):
    points("raysect", case, "targeted", {"observer": "targeted"}, samples=4000, count=100 if case == "sphere-light" else 400, most=6000,
           quick={"samples": 500, "count": 800, "most": 800, "smallest": "1e-2,1e-1"} if case in ("sphere-light", "disk-occluder") else None)
for case in ("textured", "mirror"):
    points("raysect", case, "targeted", {"observer": "targeted"}, samples=500, count=2000, most=60000)

# POV-Ray: what it offers for light by area, what it offers for soft shadows alone, and the sum of single lights.
efforts("povray", "control", "area_illumination", {"recipe": "area_illumination"}, control=True, quick={})
for case in ("disk-025", "disk-050", "disk-100", "rectangle", "fields"):
    efforts("povray", case, "area_illumination", {"recipe": "area_illumination"})
for case in SHADOWS + ["sphere-occluder"]:
    efforts("povray", case, "area_illumination", {"recipe": "area_illumination"}, quick={} if case == "rectangle-occluder" else None)
    efforts("povray", case, "single lights", {"recipe": "points"}, efforts=(81, 289, 1089, 4225, 16641))
for case in ("textured", "mirror"):
    efforts("povray", case, "area_illumination", {"recipe": "area_illumination"})
efforts("povray", "distant-rectangle", "soft shadow", {"recipe": "shadow"}, quick={})
for turn in (0, 22.5, 45):
    efforts("povray", "distant-disk", f"soft shadow, circular, turned {turn:g} degrees", {"recipe": "shadow", "turn": turn},
            quick={} if turn == 0 else None)
efforts("povray", "distant-rectangle", "soft shadow, jitter, 64 rows", {"recipe": "shadow", "jitter": True, "rows": 64},
        efforts=(81, 289, 1089, 4225))
efforts("povray", "distant-rectangle", "soft shadow, adaptive 1", {"recipe": "shadow", "adaptive": 1})

# Cycles: its own area lights, and meshes that shine; few samples in coarse pixels show where the first sample goes.
CENTRE = {"first_sample_at_centre": True}
images("cycles", "control", "area light", CENTRE, pixels="9x9", samples=64, count=64, most=1500, control=True)
for case in OPEN + SHADOWS + BALLS + CONTACTS:
    many = case in SHADOWS + ["grazing", "sphere-occluder", "contact-10mm"]
    images("cycles", case, "area light", CENTRE, pixels="9x9" if "contact" in case else "7x7", samples=256 if many else 64, count=96,
           most=1500 if many else 4000)
for case in ("disk-050", "rectangle", "rectangle-occluder", "disk-occluder", "contact-1mm"):
    images("cycles", case, "mesh light", {**CENTRE, "light": "mesh"}, pixels="9x9" if "contact" in case else "7x7",
           samples=4096 if "occluder" in case else 256 if case == "disk-050" else 64, count=96, most=1500)
for case in ("textured", "mirror"):
    for light in ("area", "mesh"):
        images("cycles", case, f"{light} light", {**CENTRE, "light": light}, samples=1024, count=96, most=1500)
images("cycles", "control", "area light, 1 sample, as if spread over the pixel", {}, pixels="5x5", samples=1, count=1500, most=1500)
images("cycles", "control", "area light, 1 sample", CENTRE, pixels="5x5", samples=1, count=1500, most=12000)
images("cycles", "control", "area light, 4 samples, as if spread over the pixel", {}, pixels="5x5", samples=4, count=1500, most=1500)
images("cycles", "control", "area light, 4 samples", CENTRE, pixels="5x5", samples=4, count=1500, most=12000)
images("cycles", "control", "area light, blue noise", {**CENTRE, "pattern": "BLUE_NOISE"}, pixels="5x5", samples=16, count=500, most=1500)

# LuxCore: the image is a pixel row off, which the control shows; the rest is judged with the row put back.
images("luxcore", "control", "random, as released", {"sampler": "RANDOM", "row_shift": 0}, pixels="9x9", samples=64, count=64, most=400)
images("luxcore", "control", "random", {"sampler": "RANDOM"}, pixels="9x9", samples=64, count=400, most=3000, control=True)
# Starting an image takes as long as some 4000 samples, so images have many where much is asked of them.
for case in OPEN + SHADOWS[:2] + ["sphere-occluder", "textured", "mirror"]:
    images("luxcore", case, "random", {"sampler": "RANDOM"}, pixels="9x9" if case in SHADOWS else "7x7", samples=1024, count=128, most=5000)
for case in ("annular-eclipse", "contact-100mm"):
    images("luxcore", case, "random", {"sampler": "RANDOM"}, pixels="9x9" if case in SHADOWS else "7x7", samples=64, count=400, most=4000)
for case in ("rectangle", "rectangle-occluder"):
    images("luxcore", case, "sobol", {"sampler": "SOBOL"}, samples=64, count=400, most=12000)
