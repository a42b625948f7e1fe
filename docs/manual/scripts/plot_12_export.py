"""
What an export loses
====================

PBR maps hold less than a shading map, shaders that look its slices up hold all of it. Each target of an export states
its error against the material itself.
"""

from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt

import lightarc

folder = Path(mkdtemp())
lightarc.simulate_capture(folder / "capture", elevations_deg=(10, 30, 50, 70, 90), size=32)
stack = lightarc.import_capture(folder / "capture", folder / "stack", motion="none")
material = lightarc.build_material(stack, representation="shading-map")
record = lightarc.export(material, folder / "out", to=["textures", "gltf", "usd", "shaders"], stack=stack)

names = [each["target"] for each in record["targets"]]
figure, axes = plt.subplots(figsize=(7, 3))
axes.barh(names, [100 * each["rmse_rel_reference"] for each in record["targets"]])
axes.invert_yaxis()
axes.margins(x=0.2)
axes.set_xlabel("relative RMSE against the material, %")
for place, each in enumerate(record["targets"]):
    axes.annotate(f" {each['bytes'] / 1e3:.0f} kB", (100 * each["rmse_rel_reference"], place), va="center")
figure.tight_layout()
