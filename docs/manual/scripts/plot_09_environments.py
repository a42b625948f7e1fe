"""
One material in six environments
================================

Built-in environments are a studio, a sky at several hours and lamps for tests of highlights.
"""

from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt

import lightarc

folder = Path(mkdtemp())
figure, axes = plt.subplots(2, 3, figsize=(9, 5))
for place, name in zip(axes.flat, ("studio", "noon", "sunset", "overcast", "softboxes", "ring-light"), strict=True):
    image = lightarc.render("sphere", brdf=lightarc.Ggx(alpha=0.2), environment=name, size=(160, 120), samples=1)
    lightarc.save_image(folder / "ball.png", image)
    place.imshow(plt.imread(folder / "ball.png"))
    place.set_title(name)
    place.set_axis_off()
