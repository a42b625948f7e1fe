"""Names of projections: a linear one is named by its weights of the two directions.

Labels of BRDF models and of their parameters in the window.

Effects as users read them, and from which error on one is worth a figure.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from engine.factor.projections import LinearProjection, Projection

FIXED = {
    "wi": "light",
    "wo": "view",
    "half": "half vector",
    "wi-dot-h": "angles θh, θd",
    "elevations": "angles θi, θo",
    "elevations-exchanged": "angles θo, θi",
    "half-mean": "angles θh, θm",
    "wi-dot-h-mean": "angles θd, θm",
}
MEASURES = {
    "radii": "angles",
    "cosines": "cosines of",
    "sines": "sines of",
    "squares": "squares of",
    "turned": "rotated angles",
}
DISKS = {"in-out": ("light", "view"), "half-diff": ("half vector", "difference")}

#: Largest distance from a named projection that still gets its name, as a share of its length.
NEAR = 0.12


def projection_name(projection: Projection, parametrisation: str) -> str:
    """A few words: 'light', 'sum', 'difference', 'rotated sum', 'mixture'; McCool's are as he has them.

    Turning or mirroring a texture changes nothing, so a name stands for all projections that differ by that only.
    """
    if not hasattr(projection, "rows"):
        words = FIXED[projection.angles or projection.name]
        return words.replace("angles", MEASURES[projection.measure], 1)
    first, second = projection.rows[:, :2], projection.rows[:, 2:]
    one, other = DISKS[parametrisation]
    if np.linalg.norm(second) < NEAR * np.sqrt(2.0):
        return one
    if np.linalg.norm(first) < NEAR * np.sqrt(2.0):
        return other
    if parametrisation == "in-out" and _even(first) and _even(second):
        turn = np.linalg.solve(first, second)
        if np.linalg.norm(turn - np.eye(2)) < 2.0 * NEAR:
            return "sum"
        if np.linalg.norm(turn + np.eye(2)) < 2.0 * NEAR:
            return "difference"
        if np.linalg.norm(turn.T @ turn - np.eye(2)) < 2.0 * NEAR:
            return "rotated sum" if np.linalg.det(turn) > 0.0 else "mirrored sum"
    return "mixture"


def shares(projection: LinearProjection) -> tuple[float, float]:
    """The shares of the two disks in a linear projection; they add up to 1."""
    squares = (np.asarray(projection.rows) ** 2).reshape(2, 2, 2).sum(axis=(0, 2)) / 2.0
    return float(squares[0]), float(squares[1])


def _even(part: NDArray[np.float64]) -> bool:
    """True if a disk keeps its shape under this half of a projection."""
    long, short = np.linalg.svd(part, compute_uv=False)
    return bool(short > (1.0 - 2.0 * NEAR) * long)


BRDF_LABELS = {
    "kd": "Diffuse",
    "ks": "Highlight",
    "f0": "F0",
    "alpha": "Roughness α",
    "alpha_x": "Roughness αx",
    "alpha_y": "Roughness αy",
    "sigma_deg": "Slope angle σ",
    "m": "Slope m",
    "nu": "Exponent along",
    "nv": "Exponent across",
    "cxy": "Along surface",
    "cz": "Along normal",
    **{f"cxy{lobe}": f"Along surface {lobe}" for lobe in (1, 2, 3)},
    **{f"cz{lobe}": f"Along normal {lobe}" for lobe in (1, 2, 3)},
    **{f"exponent{lobe}": f"Exponent {lobe}" for lobe in (1, 2, 3)},
    "base_diffuse_roughness": "Diffuse roughness",
    "base_metalness": "Metalness",
    "specular_ior": "Specular IOR",
    "coat_ior": "Coat IOR",
    "thin_film_weight": "Film weight",
    "thin_film_thickness": "Film thickness",
    "thin_film_ior": "Film IOR",
    "specular_roughness_anisotropy": "Anisotropy",
    "coat_roughness_anisotropy": "Coat anisotropy",
}


#: Names by those of `engine.planning.effects.estimates`; an effect that is not among them is shown by its own.
NAMES = {
    "self-shadowing": "Shadows",
    "interreflection": "Interreflection",
    "glossy": "Gloss",
    "anisotropy": "Anisotropy",
    "all-frequency-light": "Sharp light",
    "sun-split": "Sun",
    "mesostructure": "Mesostructure",
    "spatially-varying-gloss": "Varying gloss",
    "fresnel": "Fresnel",
    "retro-reflection": "Retro-reflection",
}

#: Relative errors below this are no loss.
MIN_ERROR = 1e-5
