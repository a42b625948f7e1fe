"""Mixed compression: the power law where it is good enough, the slices in the tiles where it is not.

The bound is on the error of each texel, the root mean square over slices and channels
(`engine.shading.power_law_error`).
"""

from __future__ import annotations

import dataclasses
from types import MappingProxyType

from engine.core.figure_text import percent
from engine.core.health import Finding, Health, Verdict
from engine.core.steps import Steps
from engine.shading.kept_tiles import cut_tiles, tile_maxima
from engine.shading.power_law import PowerLawMap
from engine.shading.power_law_error import measure
from engine.shading.shading_map import ShadingMap

#: Texels along the side of a tile.
TILE_SIZE = 16


def keep_tiles(
    power_law: PowerLawMap, shading_map: ShadingMap, bound: float, size: int = TILE_SIZE
) -> Steps[PowerLawMap]:
    """`power_law` with the slices of every tile in which the error of a texel reaches `bound`.

    Parameters
    ----------
    power_law : fitted to `shading_map`.
    bound : units of radiance, >= 0: 0 keeps every tile, infinity none. What is left is below it everywhere.
    size : texels along the side of a tile.
    """
    if not bound >= 0.0 or size < 1:
        raise ValueError(f"an error bound of {bound} or tiles of {size} texels are not possible")
    kept = tile_maxima(power_law.error_map, size) >= bound
    tiles = cut_tiles(shading_map.slices, kept, size) if kept.any() else None
    health = _health(power_law, float(kept.mean()), bound)
    return (yield from measure(dataclasses.replace(power_law, kept=tiles, health=health), shading_map))


def _health(power_law: PowerLawMap, fraction: float, bound: float) -> Health:
    figures = {
        **power_law.health.figures,
        "kept_tile_fraction": fraction,
        "error_bound": bound,
        "rms_without_kept_tiles": power_law.rms,
    }
    findings = power_law.health.findings
    if fraction > 0.5:
        text = f"{percent(fraction)} of the tiles keep their slices; a power law describes this material badly"
        findings = (*findings, Finding(Verdict.NOTE, text))
    return Health(MappingProxyType(figures), findings)
