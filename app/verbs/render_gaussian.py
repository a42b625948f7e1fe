"""`lightarc render` of Gaussian transport."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from app.verbs.lights import Illuminated, Light
from engine.steps import Step

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from engine.transport.transport_file import TransportFile


def add_arguments(_parser: argparse.ArgumentParser) -> None:
    """This mode has no options of its own."""


def check_absent(_arguments: argparse.Namespace) -> None:
    """So none of them can be given to another one."""


def illuminate(
    file: TransportFile, arguments: argparse.Namespace, light: Light, show: Callable[[Step], None]
) -> Illuminated:
    """The lobes of `file` under `light`."""
    from app.cli import usage
    from engine.transport.gaussian import radiance_towards
    from engine.transport.gaussian_bake import transport_of
    from engine.transport.gaussian_lighting import filtered_for, levels_under
    from engine.transport.lit import lit_gaussians

    usage(_check, arguments)
    transport = transport_of(file)
    show(Step(0.0, "filtering the light"))
    before = time.perf_counter()
    figures: dict[str, Any] = {}
    if light.environment is not None:
        levels = levels_under(light.environment, transport.sigma_range)
        filtered_for(light.environment, levels)
        figures = {"light_cube": levels.edge, "light_levels": len(levels.sigma)}
    filtered = time.perf_counter()
    lit = lit_gaussians(transport, light.environment, rotation=light.rotation, factor=light.factor, lamps=light.lamps)
    figures |= {
        "brdf": transport.brdf,
        "lobes": transport.lobes,
        "indirect": len(transport.components) > 1,
        "light_s": filtered - before,
        "relight_s": time.perf_counter() - filtered,
    }
    return Illuminated(
        lit,
        figures,
        lambda eye: _negative_rel(radiance_towards(transport, lit.light, lit.matt, eye)),
        "bake the matt part with a higher --order",
    )


def _check(arguments: argparse.Namespace) -> None:
    if arguments.brdf is not None:
        raise ValueError("--brdf is part of what was baked; bake again with another")
    if arguments.window != "none":
        raise ValueError("--window is for the mode sh")


def _negative_rel(radiance: NDArray[np.float64]) -> float:
    """How much of it is below 0, over what is not."""
    kept = float(radiance.clip(0.0).sum())
    return float((-radiance).clip(0.0).sum()) / kept if kept > 0.0 else 0.0
