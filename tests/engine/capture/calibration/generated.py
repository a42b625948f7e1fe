"""Photographs of a known surface under known lamps, with everything that goes wrong in captures.

A height field with a reflectance is lit by lamps at a finite distance, with cast shadows found by marching along the
light, room light from one side, lamps of unequal intensity and a camera that moves. Nothing here is taken from the
program: neither its simulation nor its fit, so that both can be judged by it.

Axes: x to the right and y up in the image, z towards the camera; the unit of length is the width of the image.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy import ndimage

Array = NDArray[np.float64]

#: Texels around the image, from which a moving camera takes what comes into view.
MARGIN = 12

FORMATS = ("jpg", "png16", "tif16", "tif32")
MATERIALS = ("matte", "plastic", "phong", "rough metal", "satin metal")
LISTS = ("right", "shifted", "reversed", "mirrored x", "mirrored y", "swapped", "turned")


@dataclass(frozen=True)
class Capture:
    """What a capture is made with.

    Attributes
    ----------
    seed : of the surface, the noise, and all that is drawn.
    surface : 'relief', 'grains', 'coin' or 'domes'.
    material : one of `MATERIALS`.
    lamps : number of lamps.
    distance : of the lamps from the middle of the image, in widths of the image.
    gains : least and largest intensity of a lamp.
    room : irradiance by room light over that by a lamp, from one side.
    motion_px : step of the random walk of the camera, with one bump of ten times as much.
    file_format : one of `FORMATS`, or 'linear16' for linear TIFF of 16 bits that do not say so.
    light_list : what is wrong with the list of lights, one of `LISTS`.
    """

    seed: int = 0
    height: int = 80
    width: int = 96
    surface: str = "relief"
    material: str = "matte"
    lamps: int = 24
    distance: float = math.inf
    gains: tuple[float, float] = (1.0, 1.0)
    room: float = 0.0
    motion_px: float = 0.0
    file_format: str = "tif16"
    light_list: str = "right"
    steepness: float = 0.35
    noise: float = 0.002


@dataclass(frozen=True, eq=False)
class Rendered:
    """Photographs (N, H, W, 3), linear, 1 = white, and the truth about them.

    `normals` (H, W, 3) and `heights` (H, W) are those of the camera that has not moved; `shifts` (N, 2) in pixels to
    the right and down say where the sample lies in each photograph; `listed` (N, 3) are the directions of the list.
    """

    capture: Capture
    photographs: NDArray[np.float32]
    normals: Array
    heights: Array
    directions: Array
    listed: Array
    gains: Array
    shifts: Array

    @property
    def names(self) -> list[str]:
        suffix = {"jpg": "jpg", "png16": "png"}.get(self.capture.file_format, "tif")
        return [f"photo_{index:03d}.{suffix}" for index in range(len(self.photographs))]


def draw(seed: int, light_list: str = "right", **fixed: object) -> Capture:
    """A capture drawn by `seed` from those that users make."""
    random = np.random.default_rng([seed, 77])
    distance = math.inf if random.random() < 0.25 else float(np.exp(random.uniform(math.log(1.2), math.log(8.0))))
    unequal = random.random() < 0.5
    made = Capture(
        seed=seed,
        surface=str(random.choice(["relief", "grains", "coin", "domes"])),
        material=str(random.choice(MATERIALS, p=[0.4, 0.2, 0.1, 0.15, 0.15])),
        lamps=int(random.integers(9, 65)),
        distance=distance,
        gains=(0.5, 1.5) if unequal else (1.0, 1.0),
        room=float(random.uniform(0.0, 0.2)) if random.random() < 0.5 else 0.0,
        motion_px=float(random.uniform(0.1, 0.5)) if random.random() < 0.25 else 0.0,
        file_format=str(random.choice(FORMATS)),
        light_list=light_list,
        steepness=float(random.uniform(0.15, 0.45)),
    )
    return replace(made, **fixed)  # type: ignore[arg-type]


def render(capture: Capture) -> Rendered:
    """The photographs of a capture."""
    random = np.random.default_rng([capture.seed, 1])
    height = _height(capture, random)
    unit = 1.0 / capture.width
    down, right = np.gradient(height, unit)
    normals = np.stack([-right, down, np.ones_like(right)], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    rows, columns = np.mgrid[: height.shape[0], : height.shape[1]] - float(MARGIN)
    places = np.stack(
        [(columns + 0.5) * unit - 0.5, (0.5 * capture.height - 0.5 - rows) * unit, height - height.mean()], axis=-1
    )
    colour = draw_colour(height.shape, random)
    directions = dome(capture.lamps, random)
    gains = random.uniform(*capture.gains, capture.lamps)
    shifts = _shifts(capture, random)
    side = random.uniform(0.0, 2.0 * math.pi)
    room = capture.room * _room(places, normals, colour, side, unit)
    photographs = []
    for direction, gain, shift in zip(directions, gains, shifts, strict=True):
        lit = room + gain * find_lit(places, normals, colour, direction, capture, unit)
        if capture.motion_px:
            lit = np.stack(
                [ndimage.shift(lit[..., band], shift[::-1], order=3, mode="nearest") for band in range(3)], -1
            )
        photographs.append(lit[MARGIN:-MARGIN, MARGIN:-MARGIN])
    stack = np.stack(photographs)
    stack *= 0.85 / np.quantile(stack, 0.995)
    deviation = capture.noise * np.sqrt(0.05 + np.maximum(stack, 0.0))
    stack = np.clip(stack + deviation * random.standard_normal(stack.shape), 0.0, 1.0)
    inside = np.s_[MARGIN:-MARGIN, MARGIN:-MARGIN]
    return Rendered(
        capture,
        stack.astype(np.float32),
        normals[inside],
        height[inside],
        directions,
        join_names(directions, capture.light_list, random),
        gains,
        shifts,
    )


def dome(count: int, random: np.random.Generator) -> Array:
    """(N, 3) directions on rings, as domes have them, in the order in which they are lit."""
    rings = 1 if count < 8 else 2 if count < 16 else 3 if count < 36 else 4
    rises = np.radians(np.linspace(random.uniform(20.0, 30.0), random.uniform(62.0, 75.0), rings))
    shares = np.cos(rises)
    numbers = np.maximum(3, np.floor(shares / shares.sum() * count).astype(int))
    numbers[0] += count - numbers.sum()
    found = []
    for rise, number in zip(rises, numbers, strict=True):
        around = random.uniform(0.0, 2.0 * math.pi) + np.arange(number) * 2.0 * math.pi / number
        found += [(math.cos(rise) * math.cos(a), math.cos(rise) * math.sin(a), math.sin(rise)) for a in around]
    return np.array(found)


def join_names(directions: Array, how: str, random: np.random.Generator) -> Array:
    """The directions as a list with this fault has them."""
    if how == "shifted":
        return np.roll(directions, int(random.choice([-2, -1, 1, 2])), axis=0)
    if how == "reversed":
        return directions[::-1]
    if how == "mirrored x":
        return directions * (-1.0, 1.0, 1.0)
    if how == "mirrored y":
        return directions * (1.0, -1.0, 1.0)
    if how == "turned":
        return directions * (-1.0, -1.0, 1.0)
    return directions[:, [1, 0, 2]] if how == "swapped" else directions


def write(rendered: Rendered, folder: Path) -> Path:
    """The capture as files: photographs and `lights.lp`."""
    folder.mkdir(parents=True, exist_ok=True)
    lines = [str(len(rendered.photographs))]
    for name, photograph, direction in zip(rendered.names, rendered.photographs, rendered.listed, strict=True):
        _write(folder / name, photograph, rendered.capture.file_format)
        lines.append(f"{name} " + " ".join(f"{value:.6f}" for value in direction))
    (folder / "lights.lp").write_text("\n".join(lines) + "\n")
    return folder


def _write(path: Path, linear: NDArray[np.float32], file_format: str) -> None:
    if file_format == "tif32":
        cv2.imwrite(str(path), linear[..., ::-1])
        return
    if file_format == "linear16":
        cv2.imwrite(str(path), np.rint(65535.0 * linear[..., ::-1]).astype(np.uint16))
        return
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9) ** (1.0 / 2.4) - 0.055)
    if file_format == "jpg":
        quality = [cv2.IMWRITE_JPEG_QUALITY, 95]
        cv2.imwrite(str(path), np.rint(255.0 * encoded[..., ::-1]).astype(np.uint8), quality)
    else:
        cv2.imwrite(str(path), np.rint(65535.0 * encoded[..., ::-1]).astype(np.uint16))


def _height(capture: Capture, random: np.random.Generator) -> Array:
    """(H, W) height in widths of the image, of slopes whose root mean square is the steepness."""
    shape = (capture.height + 2 * MARGIN, capture.width + 2 * MARGIN)
    rows, columns = np.mgrid[: shape[0], : shape[1]].astype(float)
    if capture.surface in ("relief", "grains"):
        scales = (4.0, 9.0) if capture.surface == "relief" else (2.2, 3.0)
        found = np.zeros(shape)
        for scale in scales:
            field = ndimage.gaussian_filter(random.standard_normal(shape), scale, mode="nearest")
            found += scale * field / field.std()
    elif capture.surface == "coin":
        out = np.hypot(rows - shape[0] / 2, columns - shape[1] / 2) / (0.36 * capture.height)
        found = 4.0 / (1.0 + np.exp((out - 1.0) * 9.0))
        field = ndimage.gaussian_filter(random.standard_normal(shape), 3.0, mode="nearest")
        found += field / field.std()
    else:
        found = np.zeros(shape)
        for _ in range(7):
            row, column = random.uniform(0, shape[0]), random.uniform(0, shape[1])
            radius = random.uniform(0.08, 0.25) * capture.width
            squared = ((rows - row) ** 2 + (columns - column) ** 2) / radius**2
            found += radius * random.choice([-0.7, 1.0]) * np.exp(-2.0 * squared)
    down, right = np.gradient(found)
    return found * (capture.steepness / math.sqrt(float((down**2 + right**2).mean()))) / capture.width


def draw_colour(shape: tuple[int, int], random: np.random.Generator) -> Array:
    """(H, W, 3) reflectance: broad patches of colour with a fine grain."""
    broad = [ndimage.gaussian_filter(random.standard_normal(shape), 12.0, mode="nearest") for _ in range(3)]
    fine = ndimage.gaussian_filter(random.standard_normal(shape), 1.2, mode="nearest")
    mixed = np.stack([0.4 * b / b.std() + 0.25 * fine / fine.std() for b in broad], axis=-1)
    return np.clip(0.45 + 0.12 * mixed + 0.1 * random.uniform(-1.0, 1.0, 3), 0.08, 0.9)


def _shifts(capture: Capture, random: np.random.Generator) -> Array:
    """(N, 2) a random walk with one bump."""
    if not capture.motion_px:
        return np.zeros((capture.lamps, 2))
    steps = capture.motion_px * random.standard_normal((capture.lamps, 2))
    steps[int(random.integers(1, capture.lamps))] *= 6.0
    steps[0] = 0.0
    return np.clip(np.cumsum(steps, axis=0), -MARGIN + 2.0, MARGIN - 2.0)


def find_lit(places: Array, normals: Array, colour: Array, direction: Array, capture: Capture, unit: float) -> Array:
    """(H, W, 3) radiance under a lamp of unit intensity."""
    if math.isfinite(capture.distance):
        way = capture.distance * direction - places
        far = np.linalg.norm(way, axis=-1, keepdims=True)
        towards, strength = way / far, (capture.distance / far) ** 2
    else:
        towards, strength = np.broadcast_to(direction, places.shape), np.ones((*places.shape[:2], 1))
    cosine = np.maximum((normals * towards).sum(axis=-1, keepdims=True), 0.0)
    lit = _unshadowed(np.ascontiguousarray(places[..., 2]), np.ascontiguousarray(towards), unit)[..., None]
    return strength * lit * cosine * _reflectance(normals, towards, cosine, colour, capture.material)


def _reflectance(normals: Array, towards: Array, cosine: Array, colour: Array, material: str) -> Array:
    """π times the BRDF, for a camera straight above."""
    if material == "matte":
        return colour
    view = normals[..., 2:]
    if material == "phong":
        mirrored = 2.0 * cosine * normals - towards
        return colour + 0.5 * np.maximum(mirrored[..., 2:], 0.0) ** 18
    roughness, f0, diffuse = {
        "plastic": (0.4, np.full(3, 0.04), 1.0),
        "rough metal": (0.65, colour, 0.0),
        "satin metal": (0.45, colour, 0.0),
    }[material]
    half = towards + np.array([0.0, 0.0, 1.0])
    half = half / np.linalg.norm(half, axis=-1, keepdims=True)
    n_h = np.maximum((normals * half).sum(axis=-1, keepdims=True), 0.0)
    v_h = np.maximum(half[..., 2:], 0.0)
    squared = roughness**4
    lobe = squared / (math.pi * (n_h**2 * (squared - 1.0) + 1.0) ** 2)

    def hidden(cos: Array) -> Array:
        return 2.0 / (1.0 + np.sqrt(1.0 + squared * (1.0 / np.maximum(cos, 1e-4) ** 2 - 1.0)))

    fresnel = f0 + (1.0 - f0) * (1.0 - v_h) ** 5
    specular = lobe * fresnel * hidden(cosine) * hidden(view) / np.maximum(4.0 * cosine * view, 1e-4)
    return diffuse * colour * (1.0 - f0) + math.pi * specular


def _room(places: Array, normals: Array, colour: Array, side: float, unit: float) -> Array:
    """(H, W, 3) radiance by a broad window on one side, 30 degrees high and wide."""
    found = np.zeros_like(normals)
    spread = [(rise, around) for rise in (30.0, 45.0, 60.0) for around in (-15.0, 0.0, 15.0)]
    for rise, around in spread:
        up, turn = math.radians(rise), side + math.radians(around)
        direction = np.array([math.cos(up) * math.cos(turn), math.cos(up) * math.sin(turn), math.sin(up)])
        towards = np.ascontiguousarray(np.broadcast_to(direction, places.shape))
        cosine = np.maximum((normals * towards).sum(axis=-1, keepdims=True), 0.0)
        lit = _unshadowed(np.ascontiguousarray(places[..., 2]), towards, unit)[..., None]
        found += lit * cosine * colour / len(spread)
    return found


@njit(cache=True)
def _unshadowed(height, towards, unit):  # type: ignore[no-untyped-def]
    """(H, W) 1 where nothing stands between a texel and the lamp; soft over a tenth of a texel of height."""
    rows, columns = height.shape
    top = height.max()
    found = np.ones((rows, columns))
    for row in range(rows):
        for column in range(columns):
            x, y, z = towards[row, column]
            across = math.sqrt(x * x + y * y)
            if across < 1e-6:
                continue
            rise = z / across * unit
            step_column, step_row = x / across, -y / across
            nearest = 1e9
            for k in range(1, 4 * (rows + columns)):
                reach = 0.5 * k + 0.5
                at_row, at_column = row + reach * step_row, column + reach * step_column
                above = height[row, column] + reach * rise
                if above > top or at_row < 0 or at_column < 0 or at_row > rows - 1.001 or at_column > columns - 1.001:
                    break
                r, c = int(at_row), int(at_column)
                u, v = at_row - r, at_column - c
                there = (1 - u) * ((1 - v) * height[r, c] + v * height[r, c + 1]) + u * (
                    (1 - v) * height[r + 1, c] + v * height[r + 1, c + 1]
                )
                nearest = min(nearest, (above - there) / unit)
            found[row, column] = min(max(0.5 + 5.0 * nearest, 0.0), 1.0)
    return found
