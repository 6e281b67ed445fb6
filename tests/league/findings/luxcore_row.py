"""LuxCore: an orthographic image lies one pixel row off. pip install pyluxcore==2.11.2 numpy"""
import time
import numpy as np, pyluxcore as lux


def properties(**table):
    made = lux.Properties()
    for key, value in table.items():
        made.Set(lux.Property(key.replace("__", "."), value))
    return made


lux.Init()
lux.SetLogHandler(lambda text: None)
scene, size = lux.Scene(), 8
# A strip that shines, seen from above: y from 0.5 to 0.75 of a window from -1 to 1; with 8 rows that is exactly the second from the top.
scene.Parse(properties(scene__camera__type="orthographic", scene__camera__lookat__orig=[0.0, 0.0, 1.0], scene__camera__lookat__target=[0.0, 0.0, 0.0],
                       scene__camera__up=[0.0, 1.0, 0.0], scene__camera__screenwindow=[-1.0, 1.0, -1.0, 1.0], scene__camera__autovolume__enable=False,
                       scene__materials__glow__type="matte", scene__materials__glow__kd=[0.0] * 3, scene__materials__glow__emission=[1.0] * 3,
                       scene__materials__glow__emission__gain=[1.0] * 3, scene__materials__glow__emission__power=0.0))
scene.DefineMesh("strip", [(-2.0, 0.5, 0.0), (2.0, 0.5, 0.0), (2.0, 0.75, 0.0), (-2.0, 0.75, 0.0)], [(0, 1, 2), (0, 2, 3)], None, None, None, None)
scene.Parse(properties(scene__objects__strip__shape="strip", scene__objects__strip__material="glow"))
config = {"renderengine.type": "PATHCPU", "sampler.type": "RANDOM", "film.width": size, "film.height": size, "film.filter.type": "BOX",
          "film.filter.width": 0.5, "film.outputs.0.type": "RGB", "film.outputs.0.filename": "unused.exr", "film.imagepipelines.0.0.type": "NOP",
          "path.pathdepth.total": 1, "batch.haltspp": 256}
session = lux.RenderSession(lux.RenderConfig(properties(**{k.replace(".", "__"): v for k, v in config.items()}), scene))
session.Start()
while not session.HasDone():
    session.UpdateStats()
    time.sleep(0.01)
pixels = np.zeros(size * size * 3, np.float32)
session.GetFilm().GetOutputFloat(lux.FilmOutputType.RGB, pixels, 0, True)
session.Stop()
rows = pixels.reshape(size, size, 3)[::-1, :, 0].mean(axis=1)  # the film's bottom row comes first
print("rows from the top, found:   ", np.round(rows, 3))
print("rows from the top, expected:", np.array([0, 1, 0, 0, 0, 0, 0, 0.0]))
