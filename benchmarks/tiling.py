"""Hexagonal cells: what is left of the period, how far histograms and means are off, and the time of a frame."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.measure import Accuracy, Measure, best_of
from engine.core.steps import Step, Steps
from engine.geometry.camera import frame
from engine.geometry.shapes import shape
from engine.gl.context import create_context
from engine.gl.direct import DirectRenderer
from engine.render.hex_tiling import Maps, grid_tiles, hex_tiles, values_at
from engine.scene.material import Material
from engine.scene.scene import Scene
from engine.shading.shading_map import ShadingMap
from engine.simulate.height_fields import sample

Array = NDArray[np.float64]

KINDS = ("woven", "hammered", "leather")

#: Side of samples, repeats over which they are compared, and mip levels.
SIDE, REPEATS, LEVELS = 64, 8, (0.0, 1.0, 2.5)

#: Light from the left, by the tangent of its angle from the normal, in slices of which the last is the brightest.
TILTS = (5.0, 2.0, 1.0, 0.3)

#: Pixels of a frame, and repeats over the model.
SIZE, FRAME_REPEATS = (960, 600), 8.0


def hex_tiling(_folder: Path) -> Steps[list[Accuracy]]:
    """Largest autocorrelation at one repeat, and mean distance of cumulative histograms from those of a grid, over
    slices and mip levels."""
    found: list[Accuracy] = []
    for kind in KINDS:
        yield Step(len(found) / (2 * len(KINDS)), f"tiling {kind}")
        grid, cells = (_images(kind, hexagonal=each) for each in (False, True))
        period, distance = max(map(_correlation, cells)), max(map(_distance, grid, cells))
        found.append(Accuracy(f"hex-period-{kind}", period, "autocorrelation at one repeat", 0.2))
        found.append(Accuracy(f"hex-histogram-{kind}", distance, "mean distance of cumulative histograms", 0.02))
    return found


def gl_frame_hex() -> Measure:
    """The look-ups of a frame in cells against three times those in a grid; frames less that of the BRDF alone."""
    mesh = shape("sphere")
    material = Material(_slices("leather"), None, elevation_deg=(10.0, 80.0))
    plain = Scene(mesh, frame(mesh.positions, SIZE[0] / SIZE[1]), material.reflectance)
    grid = replace(plain, material=material, repeats=FRAME_REPEATS)
    with create_context() as context:
        renderer = DirectRenderer(context)
        target = context.framebuffer([context.renderbuffer(SIZE)])

        def time_s(scene: Scene) -> float:
            def draw() -> None:
                renderer.draw(scene, target, SIZE, samples=1)
                context.finish()

            return best_of(draw)

        bare, once, cells = (time_s(scene) for scene in (plain, grid, replace(grid, tiling_mode="hex")))
        renderer.release()
        target.release()
    return Measure("gl-frame-hex", cells - bare, 3.0 * (once - bare), "three times the look-ups of a grid")


def _slices(kind: str) -> ShadingMap:
    """A sample under light from the left, ever higher."""
    made = sample(kind, SIDE)
    slope = 0.5 * (np.roll(made.height, -1, 1) - np.roll(made.height, 1, 1))
    albedo = made.albedo if made.albedo.ndim == 3 else np.repeat(made.albedo[..., None], 3, axis=2)
    lit = [np.maximum(1.0 + tilt * slope, 0.0) / np.hypot(1.0, tilt) / np.sqrt(1.0 + slope**2) for tilt in TILTS]
    slices = np.stack([np.zeros_like(albedo), *(albedo * each[..., None] for each in lit)]).astype(np.float32)
    means = slices.mean(axis=(1, 2, 3), dtype=np.float64)
    return ShadingMap(slices, float(means[-1]), means)


def _images(kind: str, *, hexagonal: bool) -> list[Array]:
    """Green of all slices at all levels, (REPEATS SIDE, REPEATS SIDE) each."""
    slices = _slices(kind)
    maps: Maps = hex_tiles(slices) if hexagonal else grid_tiles(slices)
    across = (np.arange(REPEATS * SIDE) + 0.5) / SIDE
    uv = np.stack(np.meshgrid(across, across), axis=-1).reshape(-1, 2)
    return [
        values_at(maps, layer, uv, np.full(len(uv), level))[:, 1].reshape(REPEATS * SIDE, -1)
        for level in LEVELS
        for layer in range(1, len(slices.slices))
    ]


def _correlation(image: Array) -> float:
    apart = image - image.mean()
    return abs(float((apart[:, :-SIDE] * apart[:, SIDE:]).mean() / apart.var()))


def _distance(grid: Array, cells: Array) -> float:
    bins = np.linspace(grid.min(), grid.max(), 65)
    bins[0], bins[-1] = -np.inf, np.inf
    shares = [np.histogram(image, bins)[0] / image.size for image in (grid, cells)]
    return float(np.abs(np.cumsum(shares[0] - shares[1])).mean())
