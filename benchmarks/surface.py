"""Error of recovered surfaces: simulated domes against their ground truth, and a bump that is computed.

Domes have `AZIMUTHS` × `ELEVATIONS` lamps and noise of `NOISE`, a signal-to-noise ratio of 30 dB at the white level.
Photographs are relit by the maps and by the directional map of the same photographs, both in sample.
Cost: some 3 minutes of CPU time for each sample, and 120 MB in the working folder.

The stated deviations are counted on materials that are generated: relief, colour, gloss, lamps and noise are drawn by
seed, and photographed with bounced light, soft shadows and the lens. Cost: a second of CPU time for each.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.measure import Accuracy
from engine.capture.import_stack import ImportSettings, import_stack
from engine.capture.lights.sources import find
from engine.capture.stack import ImageStack
from engine.core.directions import surface_direction
from engine.core.steps import Step, Steps, drain, part
from engine.images.decode import read_image
from engine.shading.directional.planes import fit
from engine.simulate import rig
from engine.simulate.arc import LightArc, Shot, dome_azimuths_deg, dome_elevations_deg
from engine.simulate.height_fields import Sample
from engine.simulate.shading import surface_slope
from engine.simulate.simulate import simulate
from engine.surface import horizon
from engine.surface.pbr_maps import PbrMaps
from engine.surface.recover import recover

SAMPLES = ("woven", "hammered", "leather")
SIZE, AZIMUTHS, ELEVATIONS = 384, 8, 5

#: 30 dB at the white level.
NOISE = 10.0 ** (-30.0 / 20.0)

#: Largest errors that are promised: degrees on the bump and on the samples, one minus the correlation of heights, and
#: the error of relit photographs over that of the directional map.
BUMP_DEG, SAMPLE_DEG, DECORRELATION, OVER_MAP = 0.1, 3.0, 0.05, 1.3

#: Materials that are generated and texels of a side; shares within a deviation of an error, and within the root mean
#: square of an angle, whose two parts err so; and by how much a share may differ.
SCENES, SIDE = 24, 48
WITHIN, WITHIN_ANGLE, OFF = 0.683, 0.632, 0.1


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


@dataclass(frozen=True, eq=False)
class Generated:
    """Photographs of a generated material, the radiance of a white card in them, and the maps of `reference_maps`."""

    stack: ImageStack
    white: float
    is_metal: bool
    truth: dict[str, NDArray[np.float32]]


def deviations(folder: Path, scenes: int = SCENES, seed: int = 0) -> Steps[list[Accuracy]]:
    """Shares of texels whose truth lies within one and two stated deviations; `folder` is not used."""
    within: dict[str, list[tuple[float, float]]] = {}
    for index in range(scenes):
        yield Step(index / scenes, "looking at a generated material")
        made = generate(seed + index)
        used = np.arange(len(made.stack.sources))
        maps = (
            yield from part(
                recover(made.stack, used, white=made.white, left_out=False),
                (index + 0.5) / scenes,
                (index + 1) / scenes,
            )
        ).maps
        for name, ratio in errors_over_sigma(made, maps).items():
            within.setdefault(name, []).append((float(np.mean(ratio < 1.0)), float(np.mean(ratio < 2.0))))
    found = []
    for name, shares in within.items():
        one, two = np.mean(shares, axis=0)
        more = {"within_sigma": float(one), "within_2_sigma": float(two), "materials": len(shares)}
        normally = WITHIN_ANGLE if name == "normal" else WITHIN
        what = (
            f"share of texels within σ, of {len(shares)} materials, off {normally:.0%}: {one:.0%}, {two:.0%} within 2 σ"
        )
        found.append(Accuracy(f"sigma-{name}", abs(float(one) - normally), what, OFF, more))
    return found


def errors_over_sigma(made: Generated, maps: PbrMaps) -> dict[str, NDArray[np.float64]]:
    """Errors of maps over their stated deviations: f0 of dielectrics, base colour of either, and the others of all."""
    sigma, truth = maps.uncertainty, made.truth
    assert sigma is not None
    assert sigma.height is not None
    assert maps.height is not None
    height = truth["height"] - truth["height"].mean()
    found = {
        "normal": _angle(maps.normal, truth["normal"]) / sigma.normal,
        "height": np.abs(maps.height - height) / sigma.height,
        "roughness": np.abs(maps.roughness - truth["roughness"]) / sigma.roughness,
    }
    if made.is_metal:
        found["metal_colour"] = np.abs(maps.base_colour - truth["specular"]) / sigma.base_colour
    else:
        found["f0"] = np.abs(maps.f0 - truth["specular"].mean(axis=-1)) / sigma.f0
        base = truth["albedo"] / (1.0 - truth["specular"])
        found["base_colour"] = np.abs(maps.base_colour - base) / sigma.base_colour
    return {name: np.asarray(ratio, np.float64) for name, ratio in found.items()}


def generate(seed: int, size: int = SIDE) -> Generated:
    """A material of `size` texels along each side, one in four a metal, under a dome of 18 to 60 lamps."""
    random = np.random.default_rng((seed, 79))
    arc = LightArc(
        elevation=tuple(map(math.radians, dome_elevations_deg(int(random.choice([3, 4, 5]))))),
        azimuth=tuple(map(math.radians, dome_azimuths_deg(int(random.choice([6, 8, 12]))))),
        size=size,
        misalignment_px=0.0,
    )
    is_metal = seed % 4 == 2
    table = _on_the_table(arc, _material(random, size * rig.FINE, is_metal, ridged=seed % 4 == 3))
    lamps = [(elevation, azimuth) for elevation in arc.elevation for azimuth in arc.azimuth]
    seen = np.stack([_photograph(table, *lamp) for lamp in lamps])
    gain = 0.9 / float(np.percentile(seen[-1], 99.9))
    noise = 10.0 ** (-random.uniform(25.0, 40.0) / 20.0)
    seen *= np.float32(gain)
    seen += (noise * np.sqrt(0.99 * np.maximum(seen, 0.0) + 0.01) * random.standard_normal(seen.shape)).astype(
        np.float32
    )
    elevation, azimuth = np.array(lamps).T
    names = tuple(f"{index}.exr" for index in range(len(lamps)))
    clipped = np.asarray((seen >= 1.0).any(axis=-1))
    seen = np.clip(seen, 0.0, 1.0)
    stack = ImageStack(seen, clipped, elevation, azimuth, seen.mean(axis=(1, 2, 3), dtype=np.float64), names, "")
    truth = {**rig.reference_maps(table), "height": rig.height_px(table)}
    return Generated(stack, gain / math.pi, is_metal, truth)


def _material(random: np.random.Generator, size: int, is_metal: bool, *, ridged: bool) -> Sample:
    waves = _waves(random, size, random.uniform(5.0, 12.0), random.uniform(0.2, 1.2))
    relief = np.abs(waves) - 0.3 * np.clip(waves, 0.0, 1.0) if ridged else waves
    steepness = np.sqrt(np.mean(np.sum(np.square(np.gradient(relief)), axis=0)))
    uneven = [1.0 + spread * _waves(random, size, 8.0, 0.8)[..., None] for spread in (0.15, 0.1)]
    albedo = random.uniform(0.05, 0.6, 3) * uneven[0]
    specular = random.uniform(0.4, 0.95, 3) if is_metal else np.repeat(random.uniform(0.02, 0.08), 3)
    roughness = np.clip(random.uniform(0.25, 0.8) + 0.05 * _waves(random, size, 8.0, 0.8), 0.15, 0.95)
    return Sample(
        (relief * random.uniform(0.08, 0.35) / steepness).astype(np.float32),
        np.clip(0.0 if is_metal else albedo, 0.0, np.broadcast_to(0.95, albedo.shape)).astype(np.float32),
        np.clip(specular * uneven[1], 0.0, 1.0).astype(np.float32),
        np.square(roughness).astype(np.float32),
    )


def _waves(random: np.random.Generator, size: int, most: float, falloff: float) -> NDArray[np.float64]:
    """(size, size) periodic noise of deviation 1: up to `most` periods, amplitudes that fall as f^-(1 + falloff)."""
    frequency = np.hypot(*np.meshgrid(size * np.fft.fftfreq(size), np.arange(size // 2 + 1), indexing="ij"))
    gain = np.where((frequency >= 1.0) & (frequency <= most), np.maximum(frequency, 1.0) ** -(1.0 + falloff), 0.0)
    noise = np.fft.irfft2(gain * np.fft.rfft2(random.standard_normal((size, size))), s=(size, size))
    return np.asarray(noise / noise.std())


def _on_the_table(arc: LightArc, sample: Sample) -> rig.Table:
    lowest = min(arc.elevation) - rig.LAMP_RADIUS
    horizons = {azimuth: horizon.horizon_slope(sample.height, azimuth, lowest) for azimuth in arc.azimuth}
    return rig.Table(arc, sample, surface_slope(sample.height), drain(horizon.openness(sample.height)), horizons)


def _photograph(table: rig.Table, elevation: float, azimuth: float) -> NDArray[np.float32]:
    still = Shot("", elevation, azimuth, 1.0, 0.0, 0.0, 0.0)
    return rig.photograph(table, drain(rig.light_up(table, elevation, azimuth)), still)
