"""The BRDF workspace: library, plots, lobes, fits."""
