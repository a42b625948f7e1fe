"""The analytic BRDF models, one noun each."""
