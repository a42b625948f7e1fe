"""
What a shading map holds
========================

A shading map shows for each brightness of a smooth surface what the material looks like there.
"""

from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt
import numpy as np

import lightarc

folder = Path(mkdtemp())
lightarc.simulate_capture(folder / "capture", sample="leather", elevations_deg=(10, 25, 40, 55, 70, 90), size=64)
stack = lightarc.import_capture(folder / "capture", folder / "stack", motion="none")
material = lightarc.build_material(stack, slices=6, representation="shading-map")

# %%
# Each slice is an image of the sample; dark ones show the shadows of the grain, bright ones its highlights.

slices = material.shading_map.slices
figure, axes = plt.subplots(2, 6, figsize=(10, 4), height_ratios=(2, 1))
for number, (image, curve) in enumerate(axes.T):
    image.imshow((slices[number].astype(float) / slices.max()).clip(0, 1) ** 0.45)
    image.set_title(f"slice {number + 1}")
    image.set_axis_off()
    curve.hist(slices[number].mean(axis=-1).ravel(), bins=np.linspace(0, float(slices.max()), 24))
    curve.set_yticks([])
figure.supxlabel("radiance of the texels")
