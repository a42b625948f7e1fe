"""Photographs of a known material through parallel and crossed polarisers, written down without the program's kernels.

Diffuse light has lost its polarisation, so that either position of the camera's filter passes half of it; specular
light keeps it, so that the parallel position passes all and the crossed one what filters leak. A filter factor,
exposure and the colour of the filters scale the crossed photographs. A white card that faces a lamp has the radiance
one in the parallel photograph.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Pairs:
    """What a capture of pairs is made with.

    Attributes
    ----------
    gain : brightness of crossed over parallel photographs of a diffuse surface, for red, green, blue.
    leak : share of specular light that crossed filters pass.
    roughness, f0, metallic : of the material; `spread` is by how much roughness differs over the image.
    shift : pixels to the right and down by which crossed photographs are moved.
    noise : standard deviation at the white level, of photons.
    """

    seed: int = 1
    size: int = 64
    lamps: int = 24
    gain: tuple[float, float, float] = (0.43, 0.43, 0.43)
    leak: float = 0.0
    roughness: float = 0.4
    spread: float = 0.0
    f0: float = 0.04
    metallic: float = 0.0
    shift: tuple[float, float] = (0.0, 0.0)
    noise: float = 0.002
    distance: float = np.inf
    gains: tuple[float, float] = (1.0, 1.0)
    room: float = 0.0


@dataclass(frozen=True, eq=False)
class Photographs:
    """(N, H, W, 3) photographs, (N, 3) directions of lamps, and the truth (H, W, …)."""

    parallel: Array
    crossed: Array
    directions: Array
    normals: Array
    base_colour: Array
    roughness: Array


def photograph(pairs: Pairs) -> Photographs:
    """The photographs of a capture."""
    random = np.random.default_rng([pairs.seed, 5])
    size = pairs.size
    relief = ndimage.gaussian_filter(random.standard_normal((size, size)), size / 12, mode="wrap")
    relief *= 0.35 / np.sqrt((np.gradient(relief)[0] ** 2 + np.gradient(relief)[1] ** 2).mean())
    down, right = np.gradient(relief)
    normals = np.stack([-right, down, np.ones_like(right)], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    grain = ndimage.gaussian_filter(random.standard_normal((size, size, 3)), (1.5, 1.5, 0), mode="wrap")
    grain /= np.abs(grain).max()
    base = np.clip(np.array([0.45, 0.32, 0.22]) * (1.0 + 0.8 * grain), 0.03, 0.9)
    slow = ndimage.gaussian_filter(random.standard_normal((size, size)), size / 6, mode="wrap")
    roughness = np.clip(pairs.roughness + pairs.spread * slow / np.abs(slow).max(), 0.15, 1.0)
    directions = _dome(pairs.lamps)
    strength = random.uniform(*pairs.gains, pairs.lamps)
    rows, columns = np.mgrid[:size, :size]
    place = np.stack([(columns + 0.5) / size - 0.5, 0.5 - (rows + 0.5) / size, np.zeros((size, size))], axis=-1)
    room = pairs.room * np.clip(normals @ np.array([0.6, 0.0, 0.8]), 0.0, None)[..., None] * base
    photographs: tuple[list[Array], list[Array]] = ([], [])
    for direction, factor in zip(directions, strength, strict=True):
        towards = direction - place / pairs.distance
        distance = np.linalg.norm(towards, axis=-1, keepdims=True)
        lit = factor / distance**2
        diffuse, specular = _reflect(normals, towards / distance, base, roughness, pairs)
        for side, share, scale in ((0, 1.0, np.ones(3)), (1, pairs.leak, np.array(pairs.gain))):
            radiance = scale * (lit * (diffuse + 2.0 * share * specular) + room)
            if side and pairs.shift != (0.0, 0.0):
                moved = [ndimage.shift(radiance[..., c], pairs.shift[::-1], order=3, mode="wrap") for c in range(3)]
                radiance = np.stack(moved, axis=-1)
            radiance = radiance + pairs.noise * np.sqrt(0.05 + np.maximum(radiance, 0.0)) * random.standard_normal(
                radiance.shape
            )
            photographs[side].append(np.clip(radiance, 0.0, 1.0))
    parallel, crossed = (np.stack(each) for each in photographs)
    return Photographs(parallel, crossed, directions, normals, base, roughness)


def save(found: Photographs, folder: Path, names: str = "names", lights: str = "both") -> Path:
    """TIFF of 16 bits in `folder`, by 'names' or 'folders'; `lights` of 'both' or of 'parallel' ones are listed."""
    folder.mkdir(parents=True, exist_ok=True)
    lines = []
    for side, images in (("parallel", found.parallel), ("crossed", found.crossed)):
        place = folder if names == "names" else folder / side
        place.mkdir(exist_ok=True)
        for index, image in enumerate(images):
            name = f"img_{index:03d}_{side}.tif" if names == "names" else f"img_{index:03d}.tif"
            coded = np.where(image <= 0.0031308, 12.92 * image, 1.055 * np.maximum(image, 1e-9) ** (1 / 2.4) - 0.055)
            assert cv2.imwrite(str(place / name), np.rint(65535.0 * coded[..., ::-1]).astype(np.uint16))
            if lights == "both" or side == "parallel":
                lines.append(f"{name} {' '.join(f'{value:.9f}' for value in found.directions[index])}")
    (folder / "lights.lp").write_text("\n".join([str(len(lines)), *lines, ""]))
    return folder


def _dome(count: int) -> Array:
    """Directions (N, 3) from 20 to 80 degrees of elevation on a spiral."""
    turn = np.arange(count) * np.pi * (3.0 - np.sqrt(5.0))
    rise = np.sin(np.radians(20.0)) + (np.arange(count) + 0.5) / count * (
        np.sin(np.radians(80.0)) - np.sin(np.radians(20.0))
    )
    across = np.sqrt(1.0 - rise**2)
    return np.stack([across * np.cos(turn), across * np.sin(turn), rise], axis=1)


def _reflect(normals: Array, towards: Array, base: Array, roughness: Array, pairs: Pairs) -> tuple[Array, Array]:
    """π f cos of the diffuse and of the specular part (H, W, 3), seen from straight above: GGX, Smith, Schlick."""
    eye = np.array([0.0, 0.0, 1.0])
    half = (towards + eye) / np.linalg.norm(towards + eye, axis=-1, keepdims=True)
    n_l = np.clip((normals * towards).sum(axis=-1), 0.0, None)
    n_v, n_h = normals[..., 2], (normals * half).sum(axis=-1)
    h_l = np.clip((half * towards).sum(axis=-1), 0.0, 1.0)
    squared = roughness**4
    distribution = squared / (np.pi * (n_h**2 * (squared - 1.0) + 1.0) ** 2)
    joint = n_l * np.sqrt(squared + (1.0 - squared) * n_v**2) + n_v * np.sqrt(squared + (1.0 - squared) * n_l**2)
    visible = 0.5 / np.maximum(joint, 1e-9)
    normal_reflectance = pairs.f0 * (1.0 - pairs.metallic) + base * pairs.metallic
    fresnel = normal_reflectance + (1.0 - normal_reflectance) * ((1.0 - h_l) ** 5)[..., None]
    diffuse = (1.0 - fresnel) * (1.0 - pairs.metallic) * base * n_l[..., None]
    specular = np.pi * fresnel * (distribution * visible * n_l)[..., None]
    return diffuse, specular
