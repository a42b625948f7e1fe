"""A bake of another BRDF from the visibility of the first: no ray is cast, and the file of the first stays as it is.

The transport is that of `lightarc bake` with the new BRDF, made of the surface and the settings in the file, and so is
its error. Bound by the factors of the BRDF (wavelets) or the fit (Gaussians).
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from engine.brdf.brdf import Brdf
from engine.core.errors import UsageError
from engine.core.figure_text import time_text
from engine.core.steps import Steps, part
from engine.light.environment import EnvironmentMap
from engine.transport.baking.file import TransportFile
from engine.transport.method import Subject, method_of

#: Vertices that the error of the new transport is measured at, in about a second.
VERTICES = 64


@dataclass(frozen=True, eq=False)
class Reused:
    """The transport of another BRDF, which is no file of the user, and the record of its `error`."""

    file: TransportFile
    error: dict[str, Any]


def with_brdf(
    file: TransportFile, brdf: Brdf, kept: Path | None, tested: EnvironmentMap | None = None
) -> Steps[Reused]:
    """The bake in `file` with another `brdf`, from records of visibility in `kept`; its error is that under `tested`.

    UsageError where rays would have to be cast, with the time that a bake takes, and where the file cannot say how it
    was baked.
    """
    method = method_of(file.kind)
    work = yield from part(method.baking.again(file, brdf, kept), 0.0, 0.2)
    if method.baking.casts_rays(work):
        raise UsageError(
            f"--brdf is part of the bake {file.path.name}, and its visibility is not kept on this machine; bake again "
            f"with the other BRDF, which takes about {time_text(method.baking.estimate_s(work))}"
        )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / file.path.name
        baked = yield from part(method.baking.bake(path, work), 0.2, 0.9)
    subject = Subject(file.mesh, brdf, kept=kept)
    steps = method.baking.measure(work, subject, method.settings(), tested, VERTICES)
    return Reused(baked.file, (yield from part(steps, 0.9, 1.0)))
