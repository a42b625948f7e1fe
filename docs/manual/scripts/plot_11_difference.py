"""
The error of one image against another
======================================

Direct light is compared with the path-traced reference: what is missing is light that surfaces reflect to each other.
"""

from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt
import numpy as np

import lightarc

folder = Path(mkdtemp())
scene = {"brdf": "lambert:albedo=0.8", "light_deg": (40, 30), "ground_albedo": 0.8, "size": (160, 120)}
direct = lightarc.render("torus-knot", mode="direct", samples=2, **scene)
reference = lightarc.render("torus-knot", mode="reference", samples=16, max_depth=3, **scene)
error = lightarc.compare(direct, reference)
print(f"relative RMSE {error.rmse_rel:.3f}")

figure, axes = plt.subplots(1, 3, figsize=(10, 2.8))
for place, image, title in zip(axes[:2], (direct, reference), ("direct", "reference"), strict=True):
    lightarc.save_image(folder / "image.png", image)
    place.imshow(plt.imread(folder / "image.png"))
    place.set_title(title)
missing = (reference - direct)[..., :3].mean(axis=-1)
limit = float(np.percentile(abs(missing), 99))
shown = axes[2].imshow(missing, cmap="RdBu", vmin=-limit, vmax=limit)
axes[2].set_title("reference − direct")
figure.colorbar(shown, ax=axes[2], label="radiance")
for place in axes:
    place.set_axis_off()
