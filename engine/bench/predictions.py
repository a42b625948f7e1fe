"""Predicted errors of generated scenes against those of pictures, one setting of each mode a scene.

What a plan would tell of a setting is compared with the relative RMSE of a small picture of it, by the camera that
frames the model, against a path-traced reference of direct light. Pixels of silhouettes do not count.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from engine.accuracy.compare import ErrorEstimate
from engine.bench.transport.generated import generated
from engine.core.steps import drain
from engine.planning.choices import probed
from engine.planning.costs.setting import Setting, shows
from engine.planning.effects.estimates import Scenery, estimates, scenery
from engine.planning.effects.mode_error import mode_errors
from engine.render.reference import reference
from engine.scene.scene import Scene
from engine.tradeoff.bake_group import bake_alone, bake_group, groups, relit
from engine.tradeoff.draw import SAMPLES, Drawer, Picture, shown_vertices
from engine.tradeoff.reference_error import COVERED, FEW_PASSES, Refining
from engine.tradeoff.sweep import OTHER_SEED, scene_of
from engine.transport import method as transport

#: Side of a picture in pixels, and the noise of its reference, relative to the picture.
SIDE, NOISE = 48, 0.01

#: Seconds after which a reference is taken as it is; the errors then tell their own uncertainty.
MOST_S = 2.0

#: Gaussians take as long as all else together: they are measured in one scene of so many.
EVERY = 6

#: Knobs of the settings that are drawn, of each mode.
KNOBS: dict[str, dict[str, tuple[int, ...]]] = {
    "direct": {"directions": (4, 16, 64, 256)},
    "sh": {"order": (3, 5, 8)},
    "wavelet": {"terms": (1, 2, 4), "coefficients": (24, 96, 384), "cube": (16, 32)},
    "gaussian": {"lobes": (1, 2)},
    "reference": {"samples": (1, 4, 16)},
}

#: The effect that pictures of direct light do not have.
WITHOUT = frozenset({"interreflection"})


@dataclass(frozen=True)
class Compared:
    """A setting of a scene: its error as predicted, as measured, and how uncertain the measured one is."""

    seed: int
    scene: str
    setting: Setting
    predicted: float
    measured: float
    uncertainty: float


def drawn_settings(seed: int, modes: Sequence[str]) -> list[Setting]:
    """A setting of each of `modes` by seed."""
    rng = np.random.default_rng((29, seed))
    turned = {mode: {name: values[rng.integers(len(values))] for name, values in KNOBS[mode].items()} for mode in KNOBS}
    return [Setting(mode, turned[mode]) for mode in modes]


def compared(seed: int, drawer: Drawer, data: Path | None = None) -> list[Compared]:
    """The scene of `seed`, predicted and measured."""
    name, scene = generated(seed, data)
    looked = looked_at(scene)
    errors = mode_errors(looked)
    modes = [mode for mode in KNOBS if mode == "reference" or errors.knows(mode)]
    if seed % EVERY:
        modes = [mode for mode in modes if mode != "gaussian"]
    settings = drawn_settings(seed, modes)
    found = measured(scene, settings, drawer)
    return [
        Compared(seed, name, each, predicted(scene, looked, each), error.rmse_rel, error.uncertainty)
        for each, error in found.items()
    ]


def looked_at(scene: Scene) -> Scenery:
    """The scene as a plan looks at it."""
    assert scene.environment is not None
    return scenery(scene.mesh, scene.brdf, scene.environment, rotation=scene.environment_rotation)


def predicted(scene: Scene, looked: Scenery, setting: Setting) -> float:
    """The error that a plan tells of direct light: the method's own, and what it does not show."""
    if setting.mode == "reference":
        brdf: Any = scene.brdf
        place = {"environment": scene.environment, "environment_rotation": scene.environment_rotation}
        return probed(scene.mesh, brdf, 1, **place) / math.sqrt(setting["samples"])
    missing = 0.0 if shows(setting.mode, "self-shadowing") else estimates(looked)["self-shadowing"].error_rel
    return mode_errors(looked).of(setting) + missing


def measured(scene: Scene, settings: Sequence[Setting], drawer: Drawer) -> dict[Setting, ErrorEstimate]:
    """The error of a picture of each setting, against a reference whose noise is low."""
    size = drawer.size
    with closing(Refining(scene, size, 1, 0)) as refining:
        plain = drain(drawer.draw(dataclasses.replace(scene, directions=4)))
        refining.covered = plain.picture[..., 3] >= COVERED
        truth = drain(refining.refine(MOST_S, NOISE, FEW_PASSES))
    return {setting: truth.error(picture) for setting, picture in _pictures(scene, settings, drawer)}


def _pictures(scene: Scene, settings: Sequence[Setting], drawer: Drawer) -> Iterator[tuple[Setting, Picture]]:
    shown, known = shown_vertices(scene, drawer.size, SAMPLES), dict[Any, Any]()
    baked = [each for each in settings if each.mode in transport.names()]
    shared = groups(baked)
    alone = [each for each in baked if not any(each in group for group in shared)]
    jobs = [bake_group(scene, group, shown=shown, known=known) for group in shared]
    for job in (*jobs, *(bake_alone(scene, each, shown=shown) for each in alone)):
        for bake in drain(job)[0]:
            lit = dataclasses.replace(scene, relit=relit(bake, scene))
            yield bake.setting, drain(drawer.draw(lit)).picture
    for each in settings:
        if each.mode == "reference":
            found = drain(reference(scene, drawer.size, samples=each["samples"], max_depth=1, seed=OTHER_SEED))
            yield each, found.picture
        elif each.mode == "direct":
            yield each, drain(drawer.draw(scene_of(each, scene))).picture
