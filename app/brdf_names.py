"""What reflectance models and their parameters are called in the window."""

from __future__ import annotations

BRDF_NAMES = {
    "lambert": "Lambert",
    "oren-nayar": "Oren–Nayar",
    "phong": "Phong",
    "blinn-phong": "Blinn–Phong",
    "lafortune": "Lafortune",
    "lafortune-three-lobes": "Lafortune, three lobes",
    "ward": "Ward",
    "ashikhmin-shirley": "Ashikhmin–Shirley",
    "cook-torrance": "Cook–Torrance",
    "ggx": "GGX",
    "ggx-anisotropic": "GGX, anisotropic",
    "poulin-fournier": "Poulin–Fournier",
    "metallic-roughness": "Metallic–roughness (glTF)",
}
BRDF_LABELS = {
    "kd": "Diffuse",
    "ks": "Highlight",
    "f0": "Head-on",
    "alpha": "Width α",
    "alpha_x": "Width α along",
    "alpha_y": "Width α across",
    "sigma_deg": "Slope angle σ",
    "m": "Slope m",
    "nu": "Exponent along",
    "nv": "Exponent across",
    "cxy": "Along surface",
    "cz": "Along normal",
    **{f"cxy{lobe}": f"Along surface {lobe}" for lobe in (1, 2, 3)},
    **{f"cz{lobe}": f"Along normal {lobe}" for lobe in (1, 2, 3)},
    **{f"exponent{lobe}": f"Exponent {lobe}" for lobe in (1, 2, 3)},
}
