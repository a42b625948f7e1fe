"""Errors of bakes with interreflection over those without, each against the reference with and without bounces.

Models stand on a bright floor that lights them from below, and are seen as `lightarc bake` checks its bakes: from two
sides, under three environments and a lamp. The error of a bake is that over all of them, relative to the reference.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.measure import Accuracy
from benchmarks.transport.reuse import thin_out
from engine.accuracy.bake_check import check_bake
from engine.brdf.brdf import brdf_from_text
from engine.core.steps import Step, Steps, drain
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.geometry.shapes import shape
from engine.transport.method import Subject, method_of

#: Models of some thousand vertices.
MODELS: dict[str, Callable[[], Mesh]] = {
    "torus-knot": lambda: thin_out(shape("torus-knot"), (65, 769), (4, 12)),
    "blob": lambda: thin_out(shape("blob"), (257, 385), (8, 8)),
}

#: A paint and a metal; a floor that reflects most light; and the ratio that is promised.
BRDFS = ("ggx:kd=0.6,alpha=0.3,f0=0.1", "ggx:kd=0,alpha=0.4,f0=0.9/0.6/0.3")
FLOOR, WORSE = Ground(albedo=0.8), 1.3


def interreflection(_folder: Path) -> Steps[list[Accuracy]]:
    """Ratio of the errors of every model, BRDF and mode."""
    found, cases = [], [(model, text) for model in MODELS for text in BRDFS]
    for number, (model, text) in enumerate(cases):
        yield Step(number / len(cases), f"baking {model} of {text}")
        subject = Subject(MODELS[model](), brdf_from_text(text), FLOOR)
        for mode in ("sh", "wavelet", "gaussian"):
            without, with_it = (_error(subject, mode, bounces) for bounces in (False, True))
            what = f"{model} of {text} over a bright floor, {mode}: error with interreflection over that without"
            more = {"error_without": without, "error_with": with_it}
            name = f"interreflection-{model}-{mode}-{BRDFS.index(text)}"
            found.append(Accuracy(name, with_it / without, what, WORSE, more))
    return found


def _error(subject: Subject, mode: str, bounces: bool) -> float:
    """RMS over the lights of the relative errors of a bake."""
    method = method_of(mode)
    settings = replace(method.settings(), interreflection=bounces)
    with tempfile.TemporaryDirectory() as name:
        own = replace(subject, kept=Path(name) / "visibility")
        work = drain(method.baking.prepare(own, settings))
        baked = drain(method.baking.bake(Path(name) / "a.transport", work))
        check = drain(check_bake(baked.transport, method, own, settings))
    assert check is not None
    return math.sqrt(float(np.mean([light.rmse_rel**2 for light in check.lights])))
