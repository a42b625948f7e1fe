"""
A BRDF as products of textures
==============================

Separable factors are sums of products of a map of the view and a map of the light. Each further term lowers the error.
"""

import matplotlib.pyplot as plt
import numpy as np

import lightarc

found = lightarc.factor_brdf("phong:exponent=12", method="svd", terms=6, size=12, samples=4000)

terms = [each.terms for each in found.term_errors]
angle = np.radians(np.linspace(-80, 80, 161))
wo = np.column_stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)])
wi = (-0.5, 0.0, np.sqrt(0.75))

# %%
# The error of each number of terms, and the product in the plane of incidence beside the model.

figure, axes = plt.subplots(1, 2, figsize=(9, 3.5))
axes[0].semilogy(terms, [each.rms_cosine_weighted for each in found.term_errors], "o-")
axes[0].set_xlabel("terms")
axes[0].set_ylabel("RMS, weighted by the cosine (1/sr)")
axes[0].set_xticks(terms)
for brdf, label in (("phong:exponent=12", "model"), (found.factors, f"{terms[-1]} terms")):
    axes[1].plot(np.degrees(angle), lightarc.evaluate_brdf(brdf, wi, wo).mean(axis=-1), label=label)
axes[1].set_xlabel("angle of the view (°)")
axes[1].set_ylabel("BRDF (1/sr)")
axes[1].legend()
figure.tight_layout()
