"""The demo's contact sheet: photographs, slices, the compressed pair with its error, the model."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.capture.stack import ImageStack
from engine.core.colour import to_display8
from engine.core.figure_text import percent, size_text
from engine.figures.contact_sheet import Image, Panel, Row, draw_sheet, panel_width, plot, with_colour_bar
from engine.scene.scene import Source
from engine.shading.power_law import PowerLawMap
from engine.shading.shading_map import ShadingMap
from engine.simulate.simulate import Capture


@dataclass(frozen=True, eq=False)
class Shown:
    """Parts of the sheet; None for what could not be made."""

    name: str
    capture: Capture | None
    stack: ImageStack | None
    shading_map: ShadingMap | None
    power_law: PowerLawMap | None
    images: Mapping[Source, Image] | None


def sheet(shown: Shown, reason: str, time_s: float) -> Image:
    """(H, W, 3) uint8 contact sheet; `reason` stands where an image is missing."""
    rows = (
        _row("Photographs, by elevation of the lamp", _photographs(shown.stack), reason),
        _row("Shading map: slices whose mean radiance grows in equal steps", _slices(shown.shading_map), reason),
        _row("Compressed: in each texel and channel a scale and an exponent of r / r max", _pair(shown), reason),
        _row("On a model, under one lamp", _models(shown.images), reason, aspect=1.6),
    )
    return draw_sheet(f"{shown.name.capitalize()} sample", _subtitle(shown, time_s), rows)


def _row(heading: str, panels: tuple[Panel, ...], reason: str, aspect: float = 1.0) -> Row:
    """A row of panels, or a low band with the reason why there are none."""
    return Row(heading, panels, aspect) if panels else Row(heading, (Panel(None, reason or "not made"),), 16.0)


def _photographs(stack: ImageStack | None) -> tuple[Panel, ...]:
    if stack is None:
        return ()
    chosen = np.linspace(0, len(stack.elevation) - 1, min(len(stack.elevation), 10)).round().astype(int)
    gain = _gain(stack.radiance[-1])
    return tuple(Panel(_image(stack.radiance[i], gain), f"{stack.elevation_deg[i]:.4g}°") for i in chosen)


def _slices(shading_map: ShadingMap | None) -> tuple[Panel, ...]:
    if shading_map is None:
        return ()
    gain = _gain(shading_map.slices[-1])
    pairs = zip(shading_map.slices, shading_map.mean_radiance, strict=True)
    return tuple(Panel(_image(image, gain), f"r = {mean:.3f}") for image, mean in pairs)


def _pair(shown: Shown) -> tuple[Panel, ...]:
    if shown.power_law is None or shown.stack is None:
        return ()
    scale, error = shown.power_law.scale, shown.power_law.error_map
    size = panel_width(4)
    exponent = shown.power_law.exponent.mean(axis=2)
    curve = plot(
        shown.stack.elevation_deg, shown.stack.mean_radiance, "elevation of the lamp in °", "mean radiance", size
    )
    return (
        Panel(_image(scale, _gain(scale)), "scale: the brightest slice"),
        Panel(with_colour_bar(exponent, "exponent", size), "exponent, mean of the channels"),
        Panel(with_colour_bar(error, "RMS error in radiance", size), f"error of the compression: {_per_cent(shown)}"),
        Panel(curve, "mean radiance of the photographs"),
    )


def _models(images: Mapping[Source, Image] | None) -> tuple[Panel, ...]:
    captions: dict[Source, str] = {"slices": "from the slices", "power-law": "from the compressed pair"}
    return tuple(Panel(image, captions[source]) for source, image in (images or {}).items())


def _subtitle(shown: Shown, time_s: float) -> str:
    parts = []
    if shown.stack is not None:
        count, height, width = shown.stack.radiance.shape[:3]
        parts.append(f"{count} photographs of {width} × {height} pixels on the virtual light arc")
    if shown.power_law is not None and shown.shading_map is not None:
        before, after = shown.shading_map.slices.nbytes, shown.power_law.scale.nbytes + shown.power_law.exponent.nbytes
        parts.append(f"{size_text(before)} of slices become {size_text(after)}")
    return "   ·   ".join([*parts, f"made in {time_s:.1f} s"])


def _per_cent(shown: Shown) -> str:
    assert shown.power_law is not None
    return f"RMS {percent(shown.power_law.rms / shown.power_law.r_max, 3)} of r max"


def _image(radiance: NDArray[np.float32], gain: float) -> Image:
    return to_display8(np.asarray(radiance) * np.float32(gain))


def _gain(brightest: NDArray[np.float32]) -> float:
    """Makes the brightest parts of an image just not clip on the display."""
    top = float(np.percentile(brightest, 99.5))
    return 0.9 / top if top > 0 and math.isfinite(top) else 1.0
