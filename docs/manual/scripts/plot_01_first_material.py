"""
Photographs become a material
=============================

A virtual arc of lamps photographs a woven cloth, and the photographs become a material on a ball.
"""

from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt

import lightarc

folder = Path(mkdtemp())

# %%
# Six photographs of the sample, a lamp at another elevation in each. The import finds the elevations in a file beside
# the photographs.

lightarc.simulate_capture(folder / "capture", elevations_deg=(10, 25, 40, 55, 70, 90), size=96)
stack = lightarc.import_capture(folder / "capture", folder / "stack", motion="none")
print(stack)

# %%
# The material is the shading map of these photographs and a BRDF, which gives the large-scale reflectance.

material = lightarc.build_material(stack, brdf=lightarc.Ggx(alpha=0.4), representation="shading-map")
image = lightarc.render("sphere", material=material, light_deg=(50, 30), size=(240, 180), samples=2)
lightarc.save_image(folder / "ball.png", image)

figure, axes = plt.subplots(1, 3, figsize=(9, 3))
for place, photograph in zip(axes[:2], (0, 4), strict=True):
    place.imshow((stack.radiance[photograph] / stack.radiance[4].max()).clip(0, 1) ** 0.45)
    place.set_title(f"lamp at {stack.elevation_deg[photograph]:.0f}°")
axes[2].imshow(plt.imread(folder / "ball.png"))
axes[2].set_title("on a ball")
for place in axes:
    place.set_axis_off()
