"""
Bake once, light many times
===========================

Precomputed radiance transfer keeps for each vertex what the model does to light from every direction. A new light then
costs a product of numbers.
"""

import time
from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt

import lightarc

folder = Path(mkdtemp())
begun = time.perf_counter()
lightarc.bake("sphere", "lambert:albedo=0.6", folder / "sphere.transport", method="sh", order=4, cube=16, check=False)
print(f"bake: {time.perf_counter() - begun:.1f} s")

figure, axes = plt.subplots(1, 3, figsize=(9, 2.6))
for place, name in zip(axes, ("studio", "sunset", "window"), strict=True):
    begun = time.perf_counter()
    image = lightarc.relight(folder / "sphere.transport", environment=name, size=(200, 150), samples=1)
    print(f"{name}: {time.perf_counter() - begun:.1f} s")
    lightarc.save_image(folder / "image.png", image)
    place.imshow(plt.imread(folder / "image.png"))
    place.set_title(name)
    place.set_axis_off()
