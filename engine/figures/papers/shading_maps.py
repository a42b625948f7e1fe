"""Kautz2004 Table 1 and Figure 6: the error of the power law, and four ways to look a shading map up.

The paper's photographs are not public. Samples of `engine.simulate` stand in for them: ten photographs of each, along
one arc of lamps, as even slices. As there, RMS errors are of values whose white is 1.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np
from numpy.typing import NDArray

from engine.brdf.brdf import brdf_from_text
from engine.capture.stack import ImageStack
from engine.core.colour import LUMINANCE, to_display8
from engine.core.figure_text import number
from engine.core.steps import Step, Steps, part
from engine.figures.contact_sheet import Panel, Row, with_colour_bar
from engine.figures.figure import Figure, Image, Settings, ShownRow, camera_of, compare_with
from engine.render.direct import radiance
from engine.render.reference import ReferenceImage
from engine.scene.material import Material
from engine.scene.scene import Lookup, Scene
from engine.shading.power_law import PowerLawMap, fit
from engine.shading.shading_map import ShadingMap, build
from engine.simulate.arc import LightArc, Shot
from engine.simulate.rig import light_up, photograph, prepare

#: Samples in place of the paper's materials, of Table 1 and of the rows of Figure 6, with Phong's exponent there.
TABLE = (("woven", "suede"), ("medal", "plastic"), ("leather", "wood"), ("hammered", "stone"))
ROWS = (
    ("medal", "plastic", 5),
    ("medal", "plastic", 60),
    ("woven", "cloth", 10),
    ("leather", "wool", 10),
    ("hammered", "stone", 10),
)

#: RMS errors of Table 1.
RMS = {"suede": 0.064878, "plastic": 0.049011, "wood": 0.046052, "stone": 0.040058}

#: Elevations of the lamps, texels a side of a sample, and slices.
ELEVATIONS_DEG, SIZE, SLICES = tuple(np.linspace(8.0, 85.0, 10)), 256, 8

#: Share of the texels that are darker than `WHITE`, which is what a camera's exposure would do.
EXPOSED, WHITE = 99.9, 0.9

#: The look-ups from left to right, and what the paper calls them.
LOOKUPS: tuple[tuple[Lookup, str], ...] = (
    ("texture", "lit texture"),
    ("outgoing", "look-up with L"),
    ("angle", "look-up by angle"),
    ("radiance", "look-up with r"),
)

#: Directions towards the lamp, which leaves grazing light on the model.
LIGHT = (0.55, 0.45, 0.70)


def shading_map_table(settings: Settings) -> Steps[Figure]:
    """The brightest slice of each sample, of its power law, and the error of it, with the RMS of all slices."""
    rows, table = [], []
    for place, (name, stands_for) in enumerate(TABLE):
        share = place / len(TABLE), (place + 1) / len(TABLE)
        middle = share[0] + 0.9 * (share[1] - share[0])
        shading_map = yield from part(_shading_map(name, settings), share[0], middle)
        law: PowerLawMap = yield from part(fit(shading_map), middle, share[1])
        at = 0.5 * shading_map.r_max
        both = shading_map.slice_image(at), law.slice_image(at)
        error = with_colour_bar(np.asarray(law.error_map), "RMS", 360)
        panels = (
            Panel(to_display8(both[0]), "slices, half as bright as the brightest"),
            Panel(to_display8(both[1]), "power law there"),
            Panel(error, "RMS error of a texel over its slices"),
        )
        rms = f"RMS {number(law.rms, 3)}; {stands_for} in the paper {number(RMS[stands_for], 3)}"
        rows.append(Row(f"{name.capitalize()}: {rms}", panels))
        table.append({"sample": name, "rms": law.rms, "paper": stands_for, "paper_rms": RMS[stands_for]})
    return Figure(
        "shading-map-1",
        "Errors of the power law",
        "Kautz, Sattler, Sarlette, Klein and Seidel 2004, Table 1 and Figure 5, with simulated samples in place of the "
        "paper's photographs; RMS over texels, slices and channels",
        table=tuple(table),
        extra=tuple(rows),
    )


def shading_map_lookups(settings: Settings) -> Steps[Figure]:
    """Four materials by each of the four look-ups; the last is the method's."""
    maps: dict[str, ShadingMap] = {}
    names = list(dict.fromkeys(name for name, _, _ in ROWS))
    for place, name in enumerate(names):
        share = 0.5 * place / len(names), 0.5 * (place + 1) / len(names)
        maps[name] = yield from part(_shading_map(name, settings), *share)
    mesh = settings.model
    scene_of = partial(Scene, mesh, camera_of(mesh, settings.size), light=LIGHT, irradiance=math.pi, repeats=3.0)
    rows = []
    for place, (name, stands_for, exponent) in enumerate(ROWS):
        text = f"phong:exponent={exponent}"
        material = Material(maps[name], None, text, elevation_deg=ELEVATIONS_DEG, name=name)
        images: list[Image] = []
        for column, (lookup, _) in enumerate(LOOKUPS):
            done = (place + column / len(LOOKUPS)) / len(ROWS)
            scene = scene_of(brdf_from_text(text), material, lookup=lookup)
            steps = radiance(scene, settings.size, samples=1 if settings.quick else 2)
            images.append((yield from part(steps, 0.5 + 0.5 * done, 0.5 + 0.5 * done)))
        panels = [
            (words, {"lookup": lookup, "exponent": exponent}, image)
            for (lookup, words), image in zip(LOOKUPS[:-1], images[:-1], strict=True)
        ]
        heading = f"{name.capitalize()} (the paper: {stands_for}), N = {exponent}"
        rows.append(ShownRow(heading, compare_with(panels, _exact(images[-1]), LOOKUPS[-1][1])))
        yield Step(0.5 + 0.5 * (place + 1) / len(ROWS), f"looking up {name}")
    return Figure(
        "shading-map-6",
        "Four look-ups of a shading map",
        f"{mesh.name} (the paper: a house) under one distant lamp, after Kautz, Sattler, Sarlette, Klein and Seidel "
        "2004, Figure 6, with simulated samples; differences are relative RMSE from the look-up "
        "with r",
        tuple(rows),
    )


def _exact(image: Image) -> ReferenceImage:
    """An image without noise, to compare others with."""
    return ReferenceImage(image, None, 1, 1, 0, 0)


def _shading_map(name: str, settings: Settings) -> Steps[ShadingMap]:
    """The shading map of a simulated sample."""
    elevation = tuple(np.radians(ELEVATIONS_DEG))
    size = SIZE // 4 if settings.quick else SIZE
    arc = LightArc(name, elevation=elevation, size=size, noise=0.0, misalignment_px=0.0)
    table = yield from part(prepare(arc), 0.0, 0.5)
    images: list[NDArray[np.float32]] = []
    for place, angle in enumerate(elevation):
        share = 0.5 + 0.4 * place / len(elevation), 0.5 + 0.4 * (place + 1) / len(elevation)
        image = yield from part(light_up(table, angle, 0.0), *share)
        images.append(photograph(table, image, Shot("", angle, 0.0, 1.0, 0.0, 0.0, 0.0)))
    radiances = np.stack(images)
    white = np.percentile(radiances[-1], EXPOSED)
    radiances = np.clip(radiances * np.float32(WHITE / white), 0.0, 1.0).astype(np.float32)
    means = radiances.mean(axis=(1, 2), dtype=np.float64) @ LUMINANCE
    names = tuple(f"{angle:.0f}°" for angle in ELEVATIONS_DEG)
    unclipped = np.zeros(radiances.shape[:3], np.bool_)
    stack = ImageStack(radiances, unclipped, np.array(elevation), None, means, names, "")
    return (yield from part(build(stack, SLICES), 0.9, 1.0))
