"""
Two numbers in place of all slices
==================================

The power law S(r) = k (r / r_max)^K keeps a scale k and an exponent K for each texel and channel.
"""

from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt

import lightarc

folder = Path(mkdtemp())
lightarc.simulate_capture(folder / "capture", sample="hammered", elevations_deg=(10, 25, 40, 55, 70, 90), size=64)
stack = lightarc.import_capture(folder / "capture", folder / "stack", motion="none")
material = lightarc.build_material(stack, representation="shading-map")
packed = lightarc.compress_material(material)
law = packed.power_law
print(f"slices {material.shading_map.slices.nbytes / 1e3:.0f} kB, power law {law.size_bytes / 1e3:.0f} kB")

# %%
# The exponent tells how a texel follows the light: 1 is matt, more is glossy, and less than 1 lies in relief that
# catches grazing light.

figure, axes = plt.subplots(1, 2, figsize=(8, 3.5))
axes[0].imshow((law.scale / law.scale.max()).clip(0, 1) ** 0.45)
axes[0].set_title("scale k")
shown = axes[1].imshow(law.exponent.mean(axis=-1), cmap="viridis")
axes[1].set_title("exponent K")
figure.colorbar(shown, ax=axes[1])
for place in axes:
    place.set_axis_off()
