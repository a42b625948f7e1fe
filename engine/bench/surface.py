"""Error of recovered surfaces: simulated domes against their ground truth, and a bump that is computed.

Domes have `AZIMUTHS` × `ELEVATIONS` lamps and noise of `NOISE`, a signal-to-noise ratio of 30 dB at the white level.
Photographs are relit by the maps and by the directional map of the same photographs, both in sample.
Cost: some 3 minutes of processor time for each sample, and 120 MB in the working folder.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.bench.measure import Accuracy
from engine.capture.import_stack import ImportSettings, import_stack
from engine.capture.lights.sources import find
from engine.capture.stack import ImageStack
from engine.core.directions import surface_direction
from engine.core.steps import Steps, part
from engine.images.decode import read_image
from engine.shading.directional.planes import fit
from engine.simulate.arc import LightArc, dome_azimuths_deg, dome_elevations_deg
from engine.simulate.simulate import simulate
from engine.surface.recover import recover

SAMPLES = ("woven", "hammered", "leather")
SIZE, AZIMUTHS, ELEVATIONS = 384, 8, 5

#: 30 dB at the white level.
NOISE = 10.0 ** (-30.0 / 20.0)

#: Largest errors that are promised: degrees on the bump and on the samples, one minus the correlation of heights, and
#: the error of relit photographs over that of the directional map.
BUMP_DEG, SAMPLE_DEG, DECORRELATION, OVER_MAP = 0.1, 3.0, 0.05, 1.3


def surface(folder: Path) -> Steps[list[Accuracy]]:
    """All errors; `folder` is a working folder, in which captures and stacks are left."""
    found = yield from part(_bump(), 0.0, 0.05)
    for index, name in enumerate(SAMPLES):
        start = 0.05 + 0.95 * index / len(SAMPLES)
        found += yield from part(_sample(name, folder), start, start + 0.95 / len(SAMPLES))
    return found


def _bump(size: int = 64) -> Steps[list[Accuracy]]:
    """A Lambertian bump under the lamps of the domes, without noise and shadows that it casts."""
    row, column = np.mgrid[:size, :size] + 0.5
    x, y, width = column - 0.5 * size, 0.5 * size - row, size / 5
    height = 0.175 * size * np.exp(-(x**2 + y**2) / (2 * width**2))
    normal = np.stack([height * x / width**2, height * y / width**2, np.ones_like(x)], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    elevation = np.repeat(np.radians(dome_elevations_deg(ELEVATIONS)), AZIMUTHS)
    azimuth = np.tile(np.radians(dome_azimuths_deg(AZIMUTHS)), ELEVATIONS)
    cosine = np.maximum(normal @ surface_direction(0.5 * np.pi - elevation, azimuth).T, 0.0)
    radiance = (np.moveaxis(cosine, -1, 0)[..., None] * (0.6, 0.4, 0.2)).astype(np.float32)
    names = tuple(f"{index}.exr" for index in range(len(radiance)))
    stack = ImageStack(
        radiance, np.zeros(radiance.shape[:3], np.bool_), elevation, azimuth, radiance.mean(axis=(1, 2, 3)), names, ""
    )
    maps = (yield from recover(stack, np.arange(len(names)), left_out=False)).maps
    worst = float(_angle(maps.normal, normal).max())
    return [Accuracy("normals-bump", math.degrees(worst), "largest angle of normals on a Lambertian bump, °", BUMP_DEG)]


def _sample(name: str, folder: Path) -> Steps[list[Accuracy]]:
    arc = LightArc(
        name,
        elevation=tuple(map(math.radians, dome_elevations_deg(ELEVATIONS))),
        azimuth=tuple(map(math.radians, dome_azimuths_deg(AZIMUTHS))),
        size=SIZE,
        noise=NOISE,
        misalignment_px=0.0,
    )
    capture = yield from part(simulate(arc, folder / name), 0.0, 0.3)
    settings = ImportSettings(motion="none")
    stack: ImageStack = yield from part(
        import_stack(find([capture.folder]), settings, folder / f"{name}-stack"), 0.3, 0.5
    )
    used = np.arange(len(stack.sources))
    maps = (yield from part(recover(stack, used), 0.5, 0.9)).maps
    planes = yield from part(fit(stack, used), 0.9, 1.0)
    reference = capture.folder / "truth"
    normal = read_image(reference / "normal.exr").pixels
    height = np.atleast_3d(read_image(reference / "height.exr").pixels)[..., 0]
    angle = _angle(maps.normal, normal)
    sigma = maps.uncertainty.normal if maps.uncertainty is not None else np.ones_like(angle)
    assert maps.height is not None
    alike = float(np.corrcoef(maps.height.ravel(), height.ravel())[0, 1])
    figures = {
        "median_deg": math.degrees(float(np.median(angle))),
        "error_over_sigma": float(np.sqrt(np.mean(angle**2) / np.mean(sigma**2))),
        "within_sigma": float(np.mean(angle < sigma)),
        "within_2_sigma": float(np.mean(angle < 2.0 * sigma)),
    }
    apart = np.abs(maps.height - (height - height.mean()))
    height_sigma = maps.uncertainty.height if maps.uncertainty is not None else None
    assert height_sigma is not None
    heights = {
        "rms_texels": float(np.sqrt(np.mean(apart**2))),
        "within_sigma": float(np.mean(apart < height_sigma)),
        "within_2_sigma": float(np.mean(apart < 2.0 * height_sigma)),
    }
    relit = {
        "in_sample_rmse_srgb8": maps.errors.in_sample,
        "leave_one_out_rmse_srgb8": maps.errors.left_out,
        "mean_picture_rmse_srgb8": maps.errors.mean_picture,
        "directional_in_sample_rmse_srgb8": planes.in_sample,
        "directional_leave_one_out_rmse_srgb8": planes.leave_one_out,
    }
    mean = math.degrees(float(angle.mean()))
    return [
        Accuracy(f"normals-{name}", mean, "mean angle of normals at 30 dB, °", SAMPLE_DEG, figures),
        Accuracy(f"height-{name}", 1.0 - alike, "one minus the correlation of heights", DECORRELATION, heights),
        Accuracy(
            f"relit-{name}",
            maps.errors.in_sample / planes.in_sample,
            "error of relit photographs over that of the directional map",
            OVER_MAP,
            relit,
        ),
    ]


def _angle(one: NDArray[np.float32], other: NDArray[np.floating]) -> NDArray[np.float64]:
    """(H, W) angles between unit vectors, radians."""
    cross = np.linalg.norm(np.cross(one.astype(np.float64), other), axis=-1)
    return np.asarray(np.arctan2(cross, (one * other).sum(axis=-1)))
