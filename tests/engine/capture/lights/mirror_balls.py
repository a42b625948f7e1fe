"""Captures with a mirror ball by a renderer of their own, and how far the lights are measured from the true ones.

    python -m tests.engine.capture.lights.mirror_balls SEED COUNT

Capture N is made by a generator with the seed N: a plane with a texture, relief and coins or a printed ring under 6 to
14 lamps (bulbs of 1 to 5 degrees, softboxes of up to 25), with a chrome or black glossy ball that stands on the plane,
or partly outside the image, and mirrors room light, windows, the lit plane and the lamps. The orthographic camera looks
along -z. The renderer shares no code with the program.
"""

from __future__ import annotations

import math
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: Samples of a pixel in each direction, and for lamps that are smaller than a pixel.
SAMPLES, FINE = 3, 9


@dataclass(frozen=True)
class Capture:
    """Images (N, H, W) in [0, 1] as a camera encodes them, unit vectors to the lamps (N, 3), and the ball's outline.

    `kind` names what makes the capture hard.
    """

    images: NDArray[np.float32]
    lights: Floats
    ball: tuple[float, float, float]
    kind: str


@dataclass(frozen=True)
class _Disc:
    column: float
    row: float
    radius: float
    albedo: float
    gloss: float
    ring: float


@dataclass(frozen=True)
class _Window:
    direction: Floats
    right: Floats
    width: float
    height: float
    radiance: float


def _unit(vector: Floats) -> Floats:
    return vector / np.linalg.norm(vector, axis=-1, keepdims=True)


def _direction(elevation: float, azimuth: float) -> Floats:
    return np.array(
        [math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth), math.sin(elevation)]
    )


KINDS = ("plain", "window", "softbox", "coin", "cut", "black", "black window", "ring", "rich")


def generate(seed: int) -> Capture:
    """The capture of a seed."""
    rng = np.random.default_rng(seed)
    kind = KINDS[seed % len(KINDS)]
    width = int(rng.integers(300, 560))
    height = int(width * rng.uniform(0.66, 1.0))
    radius = width * rng.uniform(0.07, 0.16)
    ball = _place(rng, width, height, radius, cut="cut" in kind)
    count = int(rng.integers(6, 15))
    lights = np.stack(
        [
            _direction(math.radians(rng.uniform(22, 80)), 2 * math.pi * (index + rng.uniform(0, 0.6)) / count)
            for index in range(count)
        ]
    )
    soft = kind == "softbox" or (kind == "rich" and rng.random() < 0.3)
    half_angle = math.radians(rng.uniform(8, 25) if soft else rng.uniform(1, 5))
    reflectance = rng.uniform(0.03, 0.08) if "black" in kind else rng.uniform(0.5, 0.95)
    windows = [_window(rng) for _ in range(int(rng.integers(1, 4)))] if "window" in kind or kind == "rich" else []
    room = rng.uniform(0, 0.05)
    discs = []
    if kind in ("coin", "ring", "rich"):
        for _ in range(int(rng.integers(1, 4))):
            size = radius * rng.uniform(0.5, 2.2)
            column, row = rng.uniform(0, width), rng.uniform(0, height)
            if math.hypot(column - ball[0], row - ball[1]) < size + radius * 1.2:
                continue
            ring = 0.0 if kind == "coin" else rng.uniform(0.05, 0.3)
            discs.append(_Disc(column, row, size, rng.uniform(0.05, 0.9), rng.uniform(0, 3), ring))
    texture = _texture(rng, height, width)
    images = _render(lights, half_angle, ball, reflectance, windows, room, discs, texture, rng)
    return Capture(images, lights, ball, kind)


def _place(
    rng: np.random.Generator, width: int, height: int, radius: float, *, cut: bool
) -> tuple[float, float, float]:
    if not cut:
        return (
            float(rng.uniform(radius * 1.1, width - radius * 1.1)),
            float(rng.uniform(radius * 1.1, height - radius * 1.1)),
            radius,
        )
    outside = radius * rng.uniform(-0.2, 0.65)  # the centre lies up to 0.2 radii beyond the edge
    along = float(rng.uniform(radius * 1.1, width - radius * 1.1))
    return along, float(height - outside) if rng.random() < 0.5 else outside, radius


def _window(rng: np.random.Generator) -> _Window:
    direction = _direction(math.radians(rng.uniform(15, 75)), rng.uniform(0, 2 * math.pi))
    right = _unit(np.cross(direction, [0, 0, 1.0]))
    return _Window(direction, right, rng.uniform(0.1, 0.5), rng.uniform(0.1, 0.6), rng.uniform(0.3, 6))


def _texture(rng: np.random.Generator, height: int, width: int) -> tuple[Floats, Floats]:
    """Albedo (H, W) and unit normals (H, W, 3) of the plane."""
    albedo = np.full((height, width), rng.uniform(0.1, 0.7))
    for scale in (2.0, 8.0, 30.0):
        noise = cv2.GaussianBlur(rng.normal(size=(height, width)), (0, 0), scale)
        albedo *= np.exp(rng.uniform(0, 0.4) * noise / noise.std())
    relief = cv2.GaussianBlur(rng.normal(size=(height, width)), (0, 0), rng.uniform(2, 6))
    relief *= rng.uniform(0, 2) / relief.std()
    slope_y, slope_x = np.gradient(relief)
    return np.clip(albedo, 0.02, 0.9), _unit(np.stack([-slope_x, slope_y, np.ones_like(relief)], -1))


def _render(
    lights: Floats,
    half_angle: float,
    ball: tuple[float, float, float],
    reflectance: float,
    windows: list[_Window],
    room: float,
    discs: list[_Disc],
    texture: tuple[Floats, Floats],
    rng: np.random.Generator,
) -> NDArray[np.float32]:
    albedo, normals = (value.copy() for value in texture)
    height, width = albedo.shape
    column0, row0, radius = ball
    rows, columns = (grid + 0.5 for grid in np.mgrid[:height, :width].astype(np.float64))
    gloss = np.zeros_like(albedo)
    for disc in discs:
        distance = np.hypot(columns - disc.column, rows - disc.row)
        inside = distance < disc.radius
        if disc.ring:
            inside &= distance > disc.radius * (1 - disc.ring)
        albedo[inside], gloss[inside] = disc.albedo, disc.gloss
        rim = inside & (distance > disc.radius - 3)
        outwards = np.stack([columns - disc.column, disc.row - rows], -1) / np.maximum(distance, 1)[..., None]
        if not disc.ring:
            normals[rim] = _unit(np.concatenate([outwards * 0.7, np.ones((height, width, 1))], -1))[rim]
    # the plane, z = 0, with x to the right and y up from the lower left corner
    plane = np.stack([columns, height - rows, np.zeros_like(rows)], -1)
    centre = np.array([column0, height - row0, radius])
    exposure = rng.uniform(0.6, 1.4)
    shaded = [_shade(plane, light, albedo, normals, gloss, centre, radius) + room * albedo for light in lights]
    # the ball, with several samples in a pixel
    left, right = max(0, math.floor(column0 - radius - 1)), min(width, math.ceil(column0 + radius + 1))
    top, bottom = max(0, math.floor(row0 - radius - 1)), min(height, math.ceil(row0 + radius + 1))
    samples = FINE if half_angle * radius < 3 else SAMPLES
    offsets = (np.arange(samples) + 0.5) / samples
    y, x = np.meshgrid(
        (np.arange(top, bottom)[:, None] + offsets).ravel(),
        (np.arange(left, right)[:, None] + offsets).ravel(),
        indexing="ij",
    )
    nx, ny = (x - column0) / radius, (row0 - y) / radius
    inside = nx**2 + ny**2 < 1
    nz = np.sqrt(np.clip(1 - nx**2 - ny**2, 0, 1))
    normal = np.stack([nx, ny, nz], -1)
    mirrored = 2 * nz[..., None] * normal - np.array([0, 0, 1.0])
    fresnel = reflectance + (1 - reflectance) * (1 - nz) ** 5
    sky = np.full(nx.shape, room)
    for window in windows:
        up = np.cross(window.right, window.direction)
        seen = (mirrored @ window.direction > 0) & (np.abs(mirrored @ window.right) < window.width / 2)
        sky = np.where(seen & (np.abs(mirrored @ up) < window.height / 2), window.radiance, sky)
    down = mirrored[..., 2] < -1e-3
    along = np.where(down, (radius + radius * nz) / np.where(down, -mirrored[..., 2], 1), 0)
    hit = centre + radius * normal + along[..., None] * mirrored
    map_x, map_y = (hit[..., 0] - 0.5).astype(np.float32), (height - hit[..., 1] - 0.5).astype(np.float32)
    images = []
    for light, surface in zip(lights, shaded, strict=True):
        reflected = cv2.remap(surface.astype(np.float32), map_x, map_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
        lamp = math.pi / (math.pi * math.sin(half_angle) ** 2)
        seen = mirrored @ light > math.cos(half_angle)
        radiance = fresnel * np.where(down, reflected, np.where(seen, lamp, sky))
        under = surface[top:bottom, left:right].repeat(samples, 0).repeat(samples, 1)
        fine = np.where(inside, radiance, under) * exposure
        image = surface * exposure
        image[top:bottom, left:right] = fine.reshape(bottom - top, samples, right - left, samples).mean((1, 3))
        images.append(image)
    linear = cv2.GaussianBlur(np.stack(images, -1), (0, 0), 0.6).transpose(2, 0, 1)
    linear = np.clip(linear + rng.normal(scale=0.002, size=linear.shape), 0, 1)
    return np.where(linear < 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055).astype(np.float32)


def _shade(
    plane: Floats, light: Floats, albedo: Floats, normals: Floats, gloss: Floats, centre: Floats, radius: float
) -> Floats:
    """Radiance (H, W) of the plane under a distant lamp of irradiance pi, in the shadow of the ball."""
    offset = centre - plane
    along = offset @ light
    shadowed = (along > 0) & ((offset**2).sum(-1) - along**2 < radius**2)
    half = _unit(light + np.array([0, 0, 1.0]))
    glossy = gloss * np.clip(normals @ half, 0, 1) ** 60
    return np.where(shadowed, 0, (albedo + glossy) * np.clip(normals @ light, 0, None))


def write(capture: Capture, folder: Path) -> None:
    """Photographs as JPEG files."""
    folder.mkdir(parents=True, exist_ok=True)
    for index, image in enumerate(capture.images):
        code = np.uint8(np.rint(255 * image))
        cv2.imwrite(str(folder / f"photo_{index:02}.jpg"), cv2.merge([code] * 3), [cv2.IMWRITE_JPEG_QUALITY, 95])


def measure(capture: Capture) -> tuple[Floats, tuple[float, float, float]] | str:
    """Errors of the lights in degrees (N,) and the outline that the program finds, or its refusal."""
    from engine.capture.lights.mirror_sphere import Circle
    from engine.capture.lights.sphere_lights import measure_lights
    from engine.core.errors import LightarcError
    from engine.core.steps import drain
    from lightarc import open_capture

    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        write(capture, folder)
        try:
            sources = open_capture(folder, sphere="auto")
            found = drain(measure_lights(sources, "auto"))
        except LightarcError as error:
            return str(error)
        names = [path.name for path in found.photographs]
        order = np.argsort(names)
    assert found.azimuth is not None
    lights = np.stack(
        [
            np.cos(found.elevation) * np.cos(found.azimuth),
            np.cos(found.elevation) * np.sin(found.azimuth),
            np.sin(found.elevation),
        ],
        -1,
    )[order]
    off = np.degrees(np.arccos(np.clip((lights * capture.lights).sum(-1), -1, 1)))
    sphere = found.sphere
    assert isinstance(sphere, Circle)
    return off, (sphere.column, sphere.row, sphere.radius)


def main(seed: int, count: int) -> None:
    """Print each capture with an error above 1 degree or a refusal, and the figures."""
    images, within, worst, refused = 0, 0, list[float](), 0
    for number in range(seed, seed + count):
        capture = generate(number)
        result = measure(capture)
        true = " ".join(f"{value:.1f}" for value in capture.ball)
        if isinstance(result, str):
            refused += 1
            print(f"{number} {capture.kind}: refused: {result[:150]} (true {true})", flush=True)
            continue
        off, outline = result
        images, within = images + len(off), within + int((off <= 1).sum())
        worst.append(float(off.max()))
        if off.max() > 1:
            found = " ".join(f"{value:.1f}" for value in outline)
            print(
                f"{number} {capture.kind}: median {np.median(off):.2f}, worst {off.max():.2f} degrees; "
                f"outline {found}, true {true}",
                flush=True,
            )
    print(
        f"{count} captures, {refused} refused; lights within 1 degree in {within / max(images, 1):.1%} of {images} "
        f"images and all of them in {sum(one <= 1 for one in worst)} captures; median of the worst "
        f"{np.median(worst):.2f}, {sum(one > 3 for one in worst)} captures with one more than 3 degrees off"
    )


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
