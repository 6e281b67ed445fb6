"""What the league found, for the pages of the report: which entries show it, what explains it, what to do, and a draft to the authors.

Numbers in braces are filled in from the results; a finding whose entries passed, or were not run, says so on its page.
"""

FINDINGS = [
    {
        "slug": "radiance-disk", "witness": "radiance", "title": "Radiance: a disk light is sampled with equal weights on a map that does not keep areas",
        "entries": [("disk-025", "jittered"), ("disk-050", "jittered"), ("disk-100", "jittered"), ("disk-occluder", "jittered"),
                    ("annular-eclipse", "jittered")],
        "passes": [("disk-050", "jittered, disk as strips"), ("rectangle", "jittered")],
        "hypothesis": "warped_disk", "script": "radiance_ring.py",
        "what": "Irradiance under a `ring` that is a light comes out too low near the axis and too high far from it. More samples do not "
                "change it. The deviation grows with the square of radius over height: on the axis about -(1/9)(a/h)^2. A square is laid onto the "
                "disk by x = u sqrt(1 - v^2/2), y = v sqrt(1 - u^2/2); the map's cells have different areas and are counted alike, so that the "
                "rim weighs too much (mean r^2 = 5/9 a^2 instead of 1/2 a^2). That prediction was computed by a sum over the square, with its "
                "orientation fitted, and agrees with what was measured. The program draws that orientation anew in each run, from the clock: sizes at points "
                "off the axis differ from run to run, the verdict does not.",
        "scope": "Far from a lamp (a/h below 0.1) it is 0.1 % and of no consequence for lighting design. It matters for large round sources "
                 "close by. Rectangles are not concerned.",
        "workaround": "Model the disk as a row of rectangles of the same total area (the row `disk as strips` passes).",
        "draft": """Subject: Direct irradiance under a ring light: a small bias that does not go away with sampling

Dear Radiance developers,

we compared `rtrace -I` ({version}) with closed forms of irradiance, with direct jitter 1, subdivision and no threshold
(`-ab 0 -dj 1 -dt 0 -ds .05`). Rectangular lights agree to the noise (below 0.1 %). A `ring` light of radius a at height h over a point on
its axis comes out low by about (1/9)(a/h)^2, and slightly high far from the axis. For a/h = 0.5:

{table}

The script below needs `pip install pyradiance` and nothing else.

The deviation is what one gets from mapping the unit square onto the disk by x = u sqrt(1 - v^2/2), y = v sqrt(1 - u^2/2) with equal weight
for each cell. That map is smooth, but its area element varies from 1 in the middle to less at the rim. A sum over the square with
that map agrees with our measurements at every point (chi2/n = {chi2}, {n} points, the orientation of the square being fitted). If this is what
the code does, weighting each cell with the area element, or an equal-area map (Shirley and Chiu's concentric map), would remove it.

This is small for ordinary luminaires; we noticed because we had the exact value. Thank you for Radiance.""",
    },
    {
        "slug": "radiance-polygon", "witness": "radiance", "title": "Radiance: a polygon light with other than four corners loses part of its light",
        "entries": [("disk-050", "jittered, disk as 64-gon"), ("disk-100", "jittered, disk as 64-gon"), ("disk-occluder", "jittered, disk as 64-gon"),
                    ("annular-eclipse", "jittered, disk as 64-gon")],
        "passes": [("rectangle", "jittered"), ("rectangle-occluder", "jittered")],
        "hypothesis": "equal_area_square", "script": "radiance_polygon.py",
        "what": "A light in the form of a regular 64-gon gives some 8 % too little. The program samples a square of the same area, and samples "
                "that miss the polygon count as nothing. It says so: it warns of an `aiming failure`. A sum over such a square, clipped by the "
                "outline, predicts what was measured.",
        "scope": "Quadrilaterals are sampled exactly. The program's warning is on stderr and easily missed in a script.",
        "workaround": "Build lights from rectangles, which the program samples right.",
        "draft": """Subject: Polygon lights with 5 or more corners are 7 to 9 % too dim; could samples that miss be redistributed?

Dear Radiance developers,

`rtrace -I` ({version}, `-ab 0 -dj 1 -dt 0 -ds .05`) under a regular n-gon of circumradius 0.5 at height 1, against Lambert's formula (script below,
`pip install pyradiance`): 4 corners +0.0 %, 5 corners -8.6 %, 6 corners -7.9 %, 8 corners -7.3 %, 64 corners -7.5 %. oconv and rtrace warn of an
"aiming failure", so this is known to the program; our point is only how large it is.

Sampling a square of the polygon's area, with nothing for the samples that miss it, reproduces our profile at every point
(chi2/n = {chi2}, {n} points):

{table}

Dividing by the share of samples that meet the polygon would already remove most of it. Thank you for Radiance.""",
    },
    {
        "slug": "radiance-height", "witness": "radiance", "title": "Radiance: irradiance is measured 1e-4 units above the point given",
        "entries": [("rectangle", "jittered, points as asked, to 1e-5")],
        "passes": [("rectangle", "jittered, points lowered by 1e-4, to 1e-5")],
        "hypothesis": "receiver_raised", "script": "radiance_height.py",
        "what": "`rtrace -I` answers for a point 1e-4 length units along the normal. In a room modelled in metres that is a tenth of a millimetre "
                "and some 1e-4 of the irradiance; in a model of small things it is not small. Exact values at the raised points agree with what was "
                "measured; so do the exact values themselves once the points are given 1e-4 lower.",
        "scope": "A convention rather than a fault: the offset keeps rays off the surface. All other rows of Radiance have their points lowered by "
                 "1e-4, a convention that was fitted.",
        "workaround": "Give points 1e-4 below the surface, or model in larger units.",
        "draft": """Subject: Documenting the 1e-4 offset of rtrace -I

Dear Radiance developers,

irradiance from `rtrace -I` ({version}) is that of a point 1e-4 units along the given direction. For a square light of 0.004 at height 0.01 the
value is 1.9 % high, and equals the exact one 1e-4 higher to five digits (script below). In ordinary models this is far below any other
error; a sentence in the manual page of rtrace would help whoever models in kilometres, or compares with closed forms.

{table}""",
    },
    {
        "slug": "radiance-grid", "witness": "radiance", "title": "Radiance: without jitter a light is 8 x 8 points, and penumbras have steps",
        "entries": [("rectangle-occluder", "-dt 0, -ds finer"), ("rectangle-occluder", "defaults, -ds finer"), ("rectangle", "defaults, -ds finer")],
        "passes": [("rectangle-occluder", "jittered"), ("rectangle", "jittered")],
        "hypothesis": "few_cells", "script": "radiance_grid.py",
        "what": "The default `-dj 0` samples a light at the middles of cells. `-ds` asks for smaller cells, but there are never more than 64: the "
                "penumbra keeps its steps, up to {worst} of the brightest point, however small `-ds`. Sums over 8 x 8 middles predict the "
                "values to all their digits when `-dt 0` is given; the default threshold adds to that.",
        "scope": "A choice of the program, and documented as one: jitter is what it offers against it. `-dj 1` is exact on average (the rows `jittered`).",
        "workaround": "`-dj 1`, and enough values to average. With `-dj` between 0 and 1 a bias remains.",
        "draft": """Subject: -ds has no effect below a certain size: 64 partitions a source

Dear Radiance developers,

no bug: a question about documentation. Without jitter, `rtrace` ({version}) gives identical values for `-ds .05`, `.02` and `.01` in front of a square
light behind a square blocker, because a source has at most 64 partitions. The penumbra then keeps steps of an eighth:

{table}

A sum over 8 x 8 middles agrees with the values to {fit} of the brightest. A sentence under `-ds` in the manual page ("at most 64
partitions; use -dj 1 for converging penumbras") would have saved us an afternoon. Thank you for Radiance.""",
    },
    {
        "slug": "povray-circular", "witness": "povray", "title": "POV-Ray: the penumbra of a `circular` area light depends on how its grid is turned",
        "entries": [("distant-disk", "soft shadow, circular, turned 0 degrees"), ("distant-disk", "soft shadow, circular, turned 22.5 degrees"),
                    ("distant-disk", "soft shadow, circular, turned 45 degrees"), ("disk-025", "area_illumination")],
        "passes": [("distant-rectangle", "soft shadow"), ("disk-occluder", "single lights")],
        "hypothesis": "grid_visibility", "script": "povray_circular.py",
        "what": "An area light with `circular` draws a square grid onto circles along each point's own direction. The radii come out right; on "
                "each circle the points stand twice as dense on the diagonals as on the axes. An open light does not mind. A shadow's edge does: "
                "the share of the light that is seen is off by up to {worst} of full light in the penumbra, with a sign that depends on how the axes "
                "are turned, at any grid size. The formula also needs a shift of the grid by a thousandth of its width along both axes; with it "
                "predicted and measured values agree to the last of sixteen bits. The shift alone leaves an open disk 0.1 % off (`disk-025`).",
        "scope": "Measured for a distant light, where irradiance is proportional to the visible area: the use that area lights are documented for. "
                 "The uneven grid is known upstream (POV-Ray issue 222).",
        "workaround": "`jitter` does not help with it. Leave `circular` out and use a square light, or place single lights on equal areas.",
        "draft": """**Title**: `circular` area lights: penumbra off by up to 2 % of full light (numbers for #222)

**Summary**
With `circular`, the fraction of an area light that a shadow test sees differs from the visible area fraction, at any grid size, and
changes when axis1/axis2 are rotated about the light's axis.

**Steps to reproduce** (script below, POV-Ray {version}): a light of radius 1 behind a straight edge at 0.6 of its radius; exact: 0.1424.
A 257 x 257 grid gives 0.1410, 0.1429 and 0.1450 with the axes turned by 0, 22.5 and 45 degrees.

**Analysis**
A grid point (u, v) in [-1, 1]^2 goes to (u, v) max(|u|, |v|) / hypot(u, v): right in radius, but per angle twice as dense on the diagonals.
Together with an offset of 0.001 of the light's width in u and v, this reproduces {n} pixels across a penumbra to {fit} of full light
(one digit of a 16-bit image).

{table}

**Suggestion**
Spread the points of each square ring evenly over its circle (angle proportional to the position along the ring; Shirley and Chiu 1997).""",
    },
    {
        "slug": "povray-area-illumination", "witness": "povray",
        "title": "POV-Ray: `area_illumination` behind an occluder is mean light times mean visibility",
        "entries": [("rectangle-occluder", "area_illumination"), ("disk-occluder", "area_illumination"), ("annular-eclipse", "area_illumination"),
                    ("sphere-occluder", "area_illumination")],
        "passes": [("rectangle", "area_illumination"), ("rectangle-occluder", "single lights")],
        "hypothesis": "grid_visibility", "script": "povray_area_illumination.py",
        "what": "With `area_illumination` the light that arrives is averaged over the grid, and so is visibility, each by itself; the pixel is their "
                "product. Where an occluder hides the nearer part of the light, that is too much, where it hides the farther part too little: up to "
                "{worst} of the brightest point. Finer grids converge to the product, not to the irradiance. The product, with the program's own grid, "
                "predicts the pixels to the last of sixteen bits. A grid of single lights, which the option is said to stand for, converges to "
                "the irradiance.",
        "scope": "Measured where source, occluder and receiver are a few source widths apart. For distant lights the product is right, and the rows "
                 "of distant lights show it.",
        "workaround": "A grid of single point lights in place of the area light.",
        "draft": """**Title**: `area_illumination`: shadowed light is mean light x mean visibility, not the sum over the lights

**Summary**
The documentation says that with `area_illumination on` an area light is treated as individual lights. Shadows are not: visibility is averaged
over the grid separately, and multiplied with the averaged light.

**Steps to reproduce** (script below, POV-Ray {version}): an area light of 2 x 1 samples at x = 0 and x = 2, height 1, `fade_power 3`; a small disc
hides the nearer one from the point at the origin. Two point lights there leave 3.8 % of the free value, the area light leaves exactly 50 %.

**How far it is off**

{table}

With the grid as the program has it, light with weight 1 for each point and visibility with the weights of a mean over cells, the
product reproduces {n} pixels to {fit} of the brightest.

**Expected**: sum over samples of (light x visibility), as the name and the documentation suggest; or a sentence in the documentation.
Related: #224.""",
    },
    {
        "slug": "cycles-first-sample", "witness": "cycles", "title": "Cycles: the first of a pixel's samples is always at its centre",
        "entries": [("control", "area light, 1 sample, as if spread over the pixel"), ("control", "area light, 4 samples, as if spread over the pixel")],
        "passes": [("control", "area light, 1 sample"), ("control", "area light, 4 samples"), ("control", "area light")],
        "hypothesis": "first_sample_at_centre", "script": "cycles_first_sample.py",
        "what": "Whatever the seed, sample 0 of N looks through the middle of the pixel. The mean over seeds is then not the average over the pixel but "
                "average + (centre - average)/N. Images that were measured agree with that formula, and disagree with the plain average when pixels are "
                "coarse and samples few.",
        "scope": "Presumably intended (the first sample of a preview is a clean one). With pixels of ordinary size or some hundred samples nothing "
                 "of it is left. It matters to whoever averages many seeds of few samples each. All other rows of Cycles allow for it.",
        "workaround": "Ask for many samples in one render rather than averaging many renders of few samples.",
        "draft": """**System information**: Linux x86-64, CPU. **Blender version**: {version} (`pip install bpy==5.0.1`)

**Short description of error**
With pixel filter "Box" (and presumably others), sample 0 is always at the pixel's centre, for any seed. The average over many seeds at N
samples is average + (centre - average)/N, not the pixel's average. This may be intended; we did not find it documented.

**Exact steps for others to reproduce the error**
Run the script below: a surface that shines covers a quarter of a pixel beside its centre. 200 seeds at 1, 2, 4, 16 samples: the mean is 0, then about
(N - 1)/N of 0.25.

In a lit scene (5 x 5 pixels under a rectangle light):

{table}

With the formula in place of the plain average: chi2/n = {chi2}, {n} pixels.""",
    },
    {
        "slug": "cycles-contact", "witness": "cycles", "title": "Cycles: a rectangle light that fills the hemisphere is taken for a tiny one",
        "entries": [("contact-1mm", "area light")],
        "passes": [("contact-3mm", "area light"), ("contact-10mm", "area light"), ("contact-1mm", "mesh light")],
        "hypothesis": "planar_density", "script": "cycles_contact.py",
        "what": "Where all four edges of a rectangle area light are farther away, along the floor, than 316 times its height, irradiance is off by +18 % to "
                "-88 %, by the place; the same light as a mesh that shines is right, and so is the area light beyond that square. The sampling of a "
                "rectangle by its solid angle has a fallback for lights that are too small for single precision: the density of a far, small light, "
                "t^3/(h A). One of the two tests for it, that the least of y^2/(y^2 + h^2) over the edges exceeds 0.99999, is meant for grazing views and "
                "also holds right under a large light. The directions are still drawn evenly over the solid angle, so draw and density disagree. That, "
                "with the power heuristic between light and surface samples, predicts all pixels within their noise; nothing is fitted. The test was "
                "read in the public source after its border had been measured.",
        "scope": "A light 0.8 m wide has to be nearer than 1.27 mm; one of 10 m, nearer than 16 mm. Not a usual scene.",
        "workaround": "A mesh light, or some more distance.",
        "draft": """**System information**: Linux x86-64, CPU. **Blender version**: {version} (`pip install bpy==5.0.1`)

**Short description of error**
A rectangle area light of 0.8 x 0.8 m, 1 mm above a diffuse floor, gives wrong irradiance in a square of 0.165 m under its middle; outside of it, and
everywhere at 1.5 mm, it is right. A mesh emitter in its place is right at 1 mm, too.

**Exact steps for others to reproduce the error**
Run the script below. Expected: values near 1 in all nine pixels.

Over 9 x 9 pixels of 0.1 m, against the exact pixel averages:

{table}

**Likely cause**
`area_light_rect_sample` in `intern/cycles/kernel/light/area.h` returns the planar density if `S < 1e-5f || reduce_min(sqr(nz)) > 0.99999f`. The second test
is there for small lights at grazing angles (#98930), but `nz` also approaches 1 on all four sides when the shading point is close under a large light
and S approaches 2 pi. The sample itself is still drawn by solid angle. Computing the pixels from that mismatch (density t^3/(h A) in
place of 1/S, power heuristic) reproduces them within their noise: chi2/n = {chi2}, {n} pixels, nothing fitted.

Requiring a small S in the second test as well (say S < 0.1) would leave the grazing case as it is.""",
    },
    {
        "slug": "luxcore-row", "witness": "luxcore", "title": "LuxCore: the image of an orthographic camera lies one pixel row off",
        "entries": [("control", "random, as released")],
        "passes": [("control", "random"), ("rectangle", "random")],
        "hypothesis": "shifted_row", "script": "luxcore_row.py",
        "what": "Pixel (x, y) shows the world one pixel height further. Exact pixel averages, moved by one row, agree with the image; moved up, or by "
                "half a pixel, they do not. Columns are right.",
        "scope": "One row of 9 is a lot, one of 1080 is not seen. Perspective cameras were not tested.",
        "workaround": "Move `scene.camera.screenwindow` by one pixel height; all other rows of LuxCore have that.",
        "draft": """**Title**: Image is shifted by one pixel row (orthographic camera, {version})

**Describe the bug**
With `screenwindow` -1 1 -1 1 and 8 rows, a strip that covers exactly the second row from the top appears in the third.

**To reproduce**
Script below: `pip install pyluxcore==2.11.2 numpy`.

**Expected behaviour**
rows from the top: 0 1 0 0 0 0 0 0; found: 0 0 1 0 0 0 0 0. Horizontally the image is right.

**Additional context**
In a lit scene, exact pixel averages moved by one row agree with the image (chi2/n = {chi2}, {n} pixels):

{table}

Perhaps the film's y is turned over as `height - y` rather than `height - 1 - y`; a guess from outside.""",
    },
    {
        "slug": "mitsuba-stratified", "witness": "mitsuba", "title": "Mitsuba: the `stratified` sampler is biased where pixel position and light sample both matter",
        "entries": [("disk-025", "stratified"), ("disk-050", "stratified"), ("disk-100", "stratified"), ("rectangle", "stratified")],
        "passes": [("disk-050", "independent"), ("disk-050", "multijitter"), ("disk-occluder", "independent")],
        "hypothesis": "stratum_pairs", "script": "../../../reports/mitsuba/stratified_bias.py",
        "what": "With coarse pixels and 16 samples, the mean over thousands of seeds differs from the exact average, by up to {worst} of the brightest "
                "pixel and in a pattern of quadrants; `independent` and `multijitter` agree with it. The permutations of successive "
                "two-dimensional draws are not independent: of the 256 pairs of strata some never meet, others meet 1.4 times as often as they should. "
                "Counting the pairs from the sampler alone (`stratum_pairs.py`: no scene, no image) and summing the light over strata with those counts "
                "predicts every pixel within its noise. Nothing is fitted.",
        "scope": "Pixels of 0.42 m under a light at 1 m. With pixels of ordinary size the place in the pixel hardly matters, and the deviation "
                 "shrinks with them; it cancels in the mean over the image.",
        "workaround": "`multijitter`, which stratifies as well and passes.",
        "draft": """**Title**: `stratified` sampler: biased direct illumination, because permutations of successive 2D draws are correlated

**Summary**
With `stratified`, the mean over many seeds differs from the exact value where the place in the pixel and the sample of an emitter both matter.
`independent` and `multijitter` agree ({version}, `scalar_rgb`, `path` with `max_depth` 2, box filter, seeds 100003 apart).

{table}

**To reproduce**
Script below: `pip install mitsuba numpy`.

**Analysis**
Counting which of the 16 strata of the first `next_2d` (the place in the pixel) meets which of the second (the emitter) and of the one after a
`next_1d` (the direction), over 300,000 seeds: some of the 256 pairs practically never occur, others 1.4 times as often as they should. Light summed over
pairs of strata with those counts in place of 1/256 predicts the deviation of every pixel (chi2/n = {chi2}, {n} pixels, nothing fitted).

**Likely place**: the permutation seeds of successive dimensions in `stratified.cpp`: two hashes of neighbouring seeds seem not to be
independent enough for 16 elements. Read from outside.""",
    },
    {
        "slug": "mitsuba-offset", "witness": "mitsuba", "title": "Mitsuba: `ptracer` weighs light by the direction from a point that is off the surface",
        "entries": [("ball-control", "ptracer"), ("ball", "ptracer")],
        "passes": [("mirror", "ptracer"), ("mirror", "path"), ("control", "independent")],
        "hypothesis": "rays_off_surfaces", "script": "mitsuba_offset.py",
        "what": "A beam on a floor, seen by a perspective camera 12 cm above it, comes out 0.1 to 0.15 % too dark, without noise to speak of. So that rays "
                "do not meet the surface that they leave, they start off it, by 1500/2^24 times one more than the greatest coordinate: here 0.2 mm. "
                "`ptracer` takes the direction to the camera from that point, and the cosine that goes with it. It is less by (delta/h) r^2/(r^2 + h^2), "
                "which agrees with the measured power to four digits (script below); nothing is fitted. Behind a ball of glass the same distance moves where "
                "rays land. There the exact values also keep the two polarisations apart, while the usual variants of Mitsuba do not, as most "
                "renderers do not: -1 % where light is bent most. Both together predict all pixels behind the ball within their noise.",
        "scope": "Proportional to the offset over the camera's distance: with a camera 1 m away nothing of it is seen (the rows `mirror`). That light is not "
                 "polarised is a choice, and documented; polarised variants exist and were not run.",
        "workaround": "Model in smaller coordinates, keep the camera away, or use a variant in double precision.",
        "draft": """**Title**: `ptracer`: cosine at the last surface is taken of the ray after its self-intersection offset

**Summary**
In `ptracer`, light that is connected to the sensor is weighed by the BSDF for the direction of the ray from `spawn_ray_to`, which starts off the surface.
With the sensor at a height h over a diffuse floor, the result is too dark by (delta/h) r^2/(r^2 + h^2), delta being the offset ({version},
`scalar_rgb`).

**To reproduce**
Script below: `pip install mitsuba numpy`. A beam of radius 0.3 on a floor at z = -1.25, camera 0.125 above: power off by -0.1074 %, predicted -0.1075 %;
radius 0.65: -0.1410 %, predicted -0.1411 %.

**What we measured**

{table}

Using the direction between the two points themselves for the weight, and the offset ray for the visibility test only, would remove it.""",
    },
]

WITNESSES = {
    "etendue": ("etendue", "The harness's own estimator, judged by the same gate and against the same exact values."),
    "mitsuba": ("Mitsuba 3", "Images by `path`, and by `ptracer` with a perspective camera square on. E = pi L / rho. Fitted: a picture's v begins at its top row."),
    "cycles": ("Blender Cycles", "Images of direct light, by a mirror with reflective caustics. Radiance of an area light: W / (pi area). Rows turned over. Fitted: the first sample of a "
                                 "pixel is at its centre."),
    "luxcore": ("LuxCore", "Images by PATHCPU, emission as radiance. Rows turned over. Fitted: the image lies one row off, and is "
                           "moved back; a picture's v begins at its top row. Sample counts are lower bounds."),
    "radiance": ("Radiance", "Irradiance at points by `rtrace -I`, factor 1. No seeds can be given, the clock is taken: values come again in distribution only. Fitted: points "
                             "are given 1e-4 m lower."),
    "raysect": ("raysect", "Power on a pixel of 1e-6 m at each point, E = power / area. Flat things are slabs of 1e-6 m. No convention had to be fitted."),
    "povray": ("POV-Ray", "A row of pixels along the line of points, 16 bits, deterministic. Lights with `fade_power 3` stand for Lambertian ones; "
                          "the factor follows from its documentation and was not fitted."),
}

NOT_TESTED = ["textures other than even fields on a rectangle", "mirrors that are curved or cut the light off; mirrors in Radiance, raysect and POV-Ray (what is "
              "judged at points is direct light)", "glass other than a ball, glass before an area light; `path` before a beam, which it cannot meet",
              "LuxCore's BIDIRCPU and LIGHTCPU (with an orthographic camera their control does not agree: no convention was found), METROPOLIS; Cycles' shadow caustics and path guiding", "raysect at contact and at grazing height (hours)",
              "more than one bounce between diffuse surfaces, materials other than diffuse, media", "spectra and colour", "GPU back-ends, perspective cameras",
              "other versions than those named", "speed: seconds are those of a shared machine, and no comparison",
              "Radiance's `rpict` and raysect's cameras", "LuxCore's sphere lights and BIDIR; Cycles' light tree with many lights"]
