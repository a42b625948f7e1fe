"""
Lobes of BRDF models
====================

Five models in the plane of incidence, with light from 45°.
"""

import matplotlib.pyplot as plt
import numpy as np

import lightarc

angle = np.radians(np.linspace(-89, 89, 357))
wo = np.column_stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)])
wi = (-np.sin(np.radians(45)), 0.0, np.cos(np.radians(45)))

figure = plt.figure(figsize=(7, 4.5))
axes = figure.add_subplot(projection="polar")
for text in ("lambert:albedo=0.8", "phong:exponent=20", "ward", "cook-torrance", "ggx:alpha=0.25"):
    values = lightarc.evaluate_brdf(text, wi, wo).mean(axis=-1)
    axes.plot(angle, values / values.max(), label=text)
axes.set_theta_zero_location("N")
axes.set_theta_direction(-1)
axes.set_thetalim(-np.pi / 2, np.pi / 2)
axes.set_rticks([])
axes.legend(loc="lower center", bbox_to_anchor=(0.5, -0.15), ncols=2, title="each relative to its largest value")
