"""
Drawing directions of a BRDF
============================

Directions are drawn where f cos θ is large. Their density must be the one that is stated, and the mean of f cos θ over
the density is the albedo.
"""

import matplotlib.pyplot as plt
import numpy as np

import lightarc

brdf = lightarc.Ggx(alpha=0.3)
tilt = np.radians(40)
wo = np.tile((np.sin(tilt), 0.0, np.cos(tilt)), (40_000, 1))
wi = lightarc.sample_brdf(brdf, wo, seed=1)
weight = np.where(wi[:, 2] > 0, brdf.f(wi, wo)[:, 0] * wi[:, 2] / lightarc.evaluate_pdf(brdf, wi, wo), 0.0)
print(f"albedo {weight.mean():.4f} ± {weight.std() / np.sqrt(len(weight)):.4f}")

# %%
# A histogram of the drawn directions over the hemisphere, seen from above, beside the density times its area.

edges = np.linspace(-1, 1, 41)
counted, _, _ = np.histogram2d(wi[wi[:, 2] > 0, 0], wi[wi[:, 2] > 0, 1], bins=(edges, edges))
centre = (edges[:-1] + edges[1:]) / 2
x, y = np.meshgrid(centre, centre, indexing="ij")
inside = x * x + y * y < 1
up = np.stack([x, y, np.sqrt(1 - x * x - y * y, where=inside, out=np.ones_like(x))], axis=-1)[inside]
density = np.zeros_like(x)
density[inside] = lightarc.evaluate_pdf(brdf, up, np.broadcast_to(wo[0], up.shape)) / up[:, 2]

figure, axes = plt.subplots(1, 2, figsize=(8, 3.8))
expected = density * (edges[1] - edges[0]) ** 2 * len(wi)
for place, values, title in zip(axes, (counted, expected), ("drawn", "density"), strict=True):
    place.imshow(values.T, origin="lower", extent=(-1, 1, -1, 1), vmin=0, vmax=expected.max())
    place.set_title(title)
    place.set_axis_off()
