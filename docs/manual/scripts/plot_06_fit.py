"""
A model fitted to another BRDF
==============================

GGX is fitted to the model of Cook and Torrance, by values all over the hemisphere.
"""

import matplotlib.pyplot as plt
import numpy as np

import lightarc

wanted = lightarc.CookTorrance()
fitted = lightarc.fit_brdf(wanted, "ggx", samples=1024)
print(fitted.brdf)
print(f"relative RMSE {fitted.before.rmse_rel:.3f} before, {fitted.after.rmse_rel:.3f} after")

angle = np.radians(np.linspace(-85, 85, 341))
wo = np.column_stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)])
wi = (-0.5, 0.0, np.sqrt(0.75))
figure, axes = plt.subplots(figsize=(7, 4))
for brdf, label in ((wanted, "Cook-Torrance"), (fitted.brdf, "GGX, fitted")):
    axes.semilogy(np.degrees(angle), lightarc.evaluate_brdf(brdf, wi, wo).mean(axis=-1), label=label)
axes.set_xlabel("angle of the view in the plane of incidence (°), light from 30°")
axes.set_ylabel("BRDF (1/sr)")
axes.legend()
