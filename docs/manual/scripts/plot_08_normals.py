"""
Normals from photographs of a dome
==================================

Lamps on all sides give the slopes of the surface. Here a virtual dome photographs a medal.
"""

from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt

import lightarc

folder = Path(mkdtemp())
lightarc.simulate_capture(
    folder / "capture", sample="medal", elevations_deg=(25, 50, 75), azimuths_deg=range(0, 360, 45), size=64
)
stack = lightarc.import_capture(folder / "capture", folder / "stack", motion="none")
surface = lightarc.recover_normals(stack, errors=False)

figure, axes = plt.subplots(1, 3, figsize=(9, 3.3))
axes[0].imshow((stack.radiance[0] / stack.radiance[0].max()).clip(0, 1) ** 0.45)
axes[0].set_title("one of 24 photographs")
axes[1].imshow(0.5 + 0.5 * surface.maps.normal)
axes[1].set_title("normals")
axes[2].imshow(surface.maps.roughness, cmap="gray", vmin=0, vmax=1)
axes[2].set_title("roughness")
for place in axes:
    place.set_axis_off()
