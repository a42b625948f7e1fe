"""Error of normals of surfaces whose diffuse part is not Lambert's, against generated reliefs.

The diffuse part enters and leaves through an interface (exact Fresnel terms of index 1.5), is that of a rough surface
(Oren1994, in the form of Fujii), Burley's, or falls as a power of the cosine; GGX highlights lie over it,
but for one. Albedo, roughness, relief, lamps and noise are drawn by seed; relief casts shadows on itself. The models
are written anew here. Errors are mean angles in degrees.
Cost: some 5 s of CPU time for each surface and seed.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.measure import Accuracy
from benchmarks.relighting import draw_lamps, draw_waves, sees
from engine.capture.stack import ImageStack
from engine.core.steps import Steps, part
from engine.surface.recover import recover

Array = NDArray[np.float64]

LAWS = ("lambert", "transmitted", "oren-nayar", "oren-nayar-matte", "burley", "power")

#: Seeds that are measured, lamps of each, noise, and the largest mean angle that is promised, degrees.
SEED, SCENES, COUNTS, NOISE, MEAN_DEG = 0, 3, (50, 24, 96), 0.01, 2.5


def measure_fall_off(_folder: Path, scenes: int = SCENES, seed: int = SEED) -> Steps[list[Accuracy]]:
    """The largest mean angle of each law over the seeds, and the shares of texels within one and two deviations."""
    found = []
    for at, law in enumerate(LAWS):
        angles, one, two = [], [], []
        for number in range(seed, seed + scenes):
            stack, normal, white = generate(law, number)
            start = (at + (number - seed) / scenes) / len(LAWS)
            used = np.arange(len(stack.sources))
            work = part(recover(stack, used, white=white, left_out=False), start, start + 1.0 / scenes / len(LAWS))
            maps = (yield from work).maps
            assert maps.uncertainty is not None
            apart = angle(maps.normal, normal)
            angles.append(math.degrees(float(apart.mean())))
            one.append(float(np.mean(apart < maps.uncertainty.normal)))
            two.append(float(np.mean(apart < 2.0 * maps.uncertainty.normal)))
        more = {"mean_deg": float(np.mean(angles)), "within_sigma": min(one), "within_2_sigma": min(two)}
        what = f"largest mean angle of normals of {scenes} surfaces; at least {min(two):.0%} lie within 2 σ, °"
        found.append(Accuracy(f"normals-{law}", max(angles), what, MEAN_DEG, more))
    return found


def angle(one: NDArray[np.floating], other: Array) -> Array:
    """(H, W) angles between unit vectors, radians."""
    one = one.astype(np.float64)
    return np.asarray(np.arctan2(np.linalg.norm(np.cross(one, other), axis=-1), (one * other).sum(axis=-1)))


def generate(law: str, seed: int) -> tuple[ImageStack, Array, float]:
    """Photographs, normals (H, W, 3), and the radiance of a white card that faces a lamp."""
    random = np.random.default_rng((seed, 77, LAWS.index(law)))
    lights = draw_lamps(random, COUNTS[seed % len(COUNTS)], bool(seed % 2))
    height = draw_waves(random, random.uniform(4.0, 9.0), random.uniform(0.2, 1.2))
    down, right = (0.5 * (np.roll(height, -1, axis) - np.roll(height, 1, axis)) for axis in (0, 1))
    scale = random.uniform(0.2, 0.5) / np.sqrt(np.mean(right**2 + down**2))
    normal = np.stack([-scale * right, scale * down, np.ones_like(height)], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    albedo = np.clip(random.uniform(0.1, 0.7, 3) * (1.0 + 0.2 * draw_waves(random, 12.0, 0.5)[..., None]), 0.03, 0.95)
    alpha, rough = random.uniform(0.3, 0.7) ** 2, random.uniform(0.35, 0.9)
    has_highlights = law not in ("lambert", "oren-nayar-matte")
    images = []
    for light in lights:
        cosine = np.maximum(normal @ light, 0.0)
        diffuse = albedo * (cosine * diffuse_factor(law, cosine, normal, light, rough))[..., None]
        gloss = highlight(cosine, normal, light, alpha)[..., None] if has_highlights else 0.0
        images.append((diffuse + gloss) * np.where(sees(scale * height, light), 1.0, 0.03)[..., None])
    radiance = np.stack(images)
    white = 0.9 / float(np.percentile(radiance, 99.7))
    radiance *= white
    radiance += NOISE * np.sqrt(0.99 * np.maximum(radiance, 0.0) + 0.01) * random.standard_normal(radiance.shape)
    clipped = np.asarray((radiance >= 1.0).any(axis=-1))
    radiance = np.clip(radiance, 0.0, 1.0)
    elevation, azimuth = np.arcsin(lights[:, 2]), np.arctan2(lights[:, 1], lights[:, 0])
    names, means = tuple(f"{index}.exr" for index in range(len(lights))), radiance.mean(axis=(1, 2, 3))
    return ImageStack(radiance.astype(np.float32), clipped, elevation, azimuth, means, names, ""), normal, white


def diffuse_factor(law: str, cosine: Array, normal: Array, light: Array, rough: float) -> Array:
    """(H, W) the diffuse part over that of Lambert's; `rough` is the deviation of facets, or what else a law has."""
    above = normal[..., 2]
    if law == "transmitted":
        return np.asarray((1.0 - fresnel(cosine)) * (1.0 - fresnel(above)))
    if law.startswith("oren-nayar"):
        s = light[2] - (normal @ light) * above
        t = np.where(s > 0.0, np.maximum(np.maximum(cosine, above), 1e-6), 1.0)
        squared = rough**2
        return np.asarray(1.0 - 0.5 * squared / (squared + 0.33) + 0.45 * squared / (squared + 0.09) * s / t)
    if law == "burley":
        half_squared = 0.5 * (1.0 + light[2])
        grazing = 2.0 * rough * half_squared - 0.5
        return np.asarray((1.0 + grazing * (1.0 - cosine) ** 5) * (1.0 + grazing * (1.0 - above) ** 5))
    return np.asarray(cosine ** (0.6 * rough) if law == "power" else np.ones_like(cosine))


def fresnel(cosine: Array, index: float = 1.5) -> Array:
    """Reflectance of unpolarised light at an interface."""
    inside = np.sqrt(1.0 - (1.0 - cosine**2) / index**2)
    across = (cosine - index * inside) / (cosine + index * inside)
    along = (index * cosine - inside) / (index * cosine + inside)
    return np.asarray(0.5 * (across**2 + along**2))


def highlight(cosine: Array, normal: Array, light: Array, alpha: float, f0: float = 0.04) -> Array:
    """(H, W) GGX with separable masking times π, seen from above."""
    half = light + np.array([0.0, 0.0, 1.0])
    half /= np.linalg.norm(half)
    squared = alpha * alpha
    spread = squared / (math.pi * ((normal @ half) ** 2 * (squared - 1.0) + 1.0) ** 2)
    masks = [2.0 * n / (n + np.sqrt(squared + (1.0 - squared) * n * n) + 1e-9) for n in (cosine, normal[..., 2])]
    mirrored = f0 + (1.0 - f0) * (1.0 - half[2]) ** 5
    return np.asarray(math.pi * mirrored * spread * masks[0] * masks[1] / (4.0 * normal[..., 2]) * (cosine > 0.0))
