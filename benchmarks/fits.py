"""Fits of models to measured BRDFs, seen on a sphere in the studio: the light and the colour that they keep.

The data are the smooth BRDF through the samples of each generated instrument (`benchmarks.generated_brdfs`) and each
measured file. Of `MODELS_TRIED` the one that is nearest in each norm is taken, as `lightarc brdf fit --rank` offers it.
The sphere is seen from the front; its colour is that of all its light together, relative to a white one in the same
light.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.generated_brdfs import generate
from benchmarks.measure import Accuracy
from engine.brdf.brdf import MODELS, Brdf
from engine.brdf.fit import WEIGHTINGS, fit, fit_data, fit_error
from engine.brdf.models.diffuse import Lambert
from engine.brdf.models.sampling_lobes import CosineLobe, GaussianHalfVectors, HalfVectorLobe, Mixture
from engine.brdf.readers.read import read_brdf_steps
from engine.brdf.scattered import fit_scattered
from engine.core.colour import luminance, xyz_from_srgb
from engine.core.colour_difference import delta_e_2000, lab_from_xyz
from engine.core.directions import normalize
from engine.core.errors import InputError
from engine.core.steps import Step, Steps
from engine.light.sky import studio

#: Generated materials where no number is asked for, and the goals for albedo and colour.
SAMPLINGS, ALBEDO, COLOUR = 12, 0.05, 3.0

#: Models of base and highlight, of which the nearest is taken: facets, brushed facets, and a lobe back to the light.
MODELS_TRIED = ("ggx", "ggx-anisotropic", "ashikhmin-shirley", "lafortune")

#: Normals of the sphere, and directions of light for each.
NORMALS, LIGHTS = 400, 1024

#: XYZ of the white of sRGB.
_D65 = np.array([0.95047, 1.0, 1.08883])


def fits(_folder: Path, data: Path | None = None, samplings: int = SAMPLINGS, seed: int = 0) -> Steps[list[Accuracy]]:
    """Rows for each material: the error of albedo and the colour difference ΔE2000 of a fit in the joint norm.

    `more` has those of the other norms. A generated material takes some seconds, a file up to a minute.
    """
    rows: list[Accuracy] = []
    paths = sorted(path for path in data.rglob("*") if path.is_file()) if data is not None else []
    for path in paths:
        yield Step(len(rows) / (2 * (len(paths) + samplings)), f"fitting {path.name}")
        try:
            brdf: Any = yield from read_brdf_steps(path)
        except InputError:
            continue
        rows += row(path.name, brdf, (yield from _fit_all(brdf)))
    for number in range(seed, seed + samplings):
        yield Step(len(rows) / (2 * (len(paths) + samplings)), f"fitting sampling {number}")
        samples = generate(number).samples
        brdf = yield from fit_scattered(samples)
        rows += row(samples.name, brdf, (yield from _fit_all(brdf)))
    return rows


def _fit_all(brdf: Brdf) -> Steps[dict[str, tuple[Brdf, float]]]:
    """The nearest fit in each norm, and its linear error."""
    data = fit_data(brdf)
    found: dict[str, tuple[Brdf, float]] = {}
    for weighting in WEIGHTINGS:
        fitted = []
        for name in MODELS_TRIED:
            if not (name == "ggx-anisotropic" and brdf.isotropic):
                fitted.append((yield from fit(data, MODELS[name](), weighting=weighting)))
        best = min(fitted, key=lambda each: each.after.objective)
        found[weighting] = best.brdf, fit_error(best.brdf, data).rmse_rel
    return found


def row(name: str, brdf: Brdf, found: dict[str, tuple[Brdf, float]]) -> list[Accuracy]:
    """The errors of the fits of one BRDF."""
    truth = sphere(brdf)
    more: dict[str, float] = {}
    for weighting, (fitted, rmse_rel) in found.items():
        shown = sphere(fitted)
        more[f"{weighting}_albedo"] = float(abs(luminance(shown) / luminance(truth) - 1.0))
        more[f"{weighting}_delta_e"] = float(delta_e_2000(_lab(shown), _lab(truth)))
        more[f"{weighting}_rmse_rel"] = rmse_rel
    return [
        Accuracy(f"fit {name}", more["joint_albedo"], "error of a sphere's light", ALBEDO, more),
        Accuracy(f"fit {name}, colour", more["joint_delta_e"], "ΔE2000 of a sphere's light", COLOUR),
    ]


def sphere(brdf: Brdf) -> NDArray[np.float64]:
    """The mean radiance (3,) of a sphere of `brdf` in the studio, seen from the front, over that of a white one."""
    return _light(brdf) / _light(Lambert((1.0, 1.0, 1.0)))


def _light(brdf: Brdf) -> NDArray[np.float64]:
    rng = np.random.default_rng(4)
    radius, turn = np.sqrt((np.arange(NORMALS) + 0.5) / NORMALS) * 0.99, np.pi * (1.0 + 5.0**0.5) * np.arange(NORMALS)
    across, up = radius * np.cos(turn), radius * np.sin(turn)
    normals = np.column_stack([across, up, np.sqrt(1.0 - radius**2)])
    lobes: Sequence[Any] = (CosineLobe(), *(HalfVectorLobe(GaussianHalfVectors(a, a)) for a in (0.3, 0.08, 0.02)))
    sampler = Mixture(tuple(lobes), (0.4, 0.2, 0.2, 0.2))
    total = np.zeros(3)
    for normal in normals:
        tangent = normalize(np.cross([0.0, 1.0, 0.0], normal))
        frame = np.stack([tangent, np.cross(normal, tangent), normal])
        wo = np.broadcast_to(frame @ (0.0, 0.0, 1.0), (LIGHTS, 3))
        wi = sampler.sample(wo, rng.random((LIGHTS, 3)))
        density = sampler.pdf(wi, wo)
        above = wi[:, 2] > 0.0
        weight = np.where(above, wi[:, 2], 0.0) / density / LIGHTS
        values = brdf.f(np.where(above[:, None], wi, (0.0, 0.0, 1.0)), wo)
        total += (np.maximum(values, 0.0) * studio(wi @ frame) * weight[:, None]).sum(axis=0)
    return total


def _lab(share: NDArray[np.float64]) -> NDArray[np.float64]:
    return lab_from_xyz(xyz_from_srgb(share), _D65)
