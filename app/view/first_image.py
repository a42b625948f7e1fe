"""The first image of another BRDF on a baked model: spherical harmonics from kept visibility, until a bake is there.

The matrices of a model are made once, at the first change of its BRDF; after that another BRDF takes a table. The
error is that of the method in the studio, and comes after the image.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, Signal

from app.document.bake_request import Wanted, same_light
from app.jobs.jobs import Jobs
from app.jobs.newest import Latest
from engine.core.steps import Step, Steps, part
from engine.transport.method import Method, Relight, method_of
from engine.transport.relight import Light, light_of

if TYPE_CHECKING:
    from engine.scene.scene import Scene
    from engine.transport.relight import RelightTransport


@dataclass(frozen=True, eq=False)
class Relit:
    """A model with the BRDF that is `wanted`, relit, and what relights it; `error_rel` is None until it is known."""

    wanted: Wanted
    relight: Relight
    relit: RelightTransport
    error_rel: float | None = None


class FirstImage(QObject):
    """`changed` follows each image and each error; `shown` is the last one."""

    changed = Signal()

    def __init__(self, jobs: Jobs, method: Method) -> None:
        super().__init__()
        self._method = method
        self.shown: Relit | None = None
        self._asked: tuple[Wanted, Scene] | None = None
        self._drawing = Latest(jobs, "Drawing a first image", self._take)

    def want(self, wanted: Wanted, scene: Scene) -> None:
        """Draw `wanted` under the light of `scene`, unless that is done or under way."""
        before = self._asked
        if before is not None and is_same(before[0], wanted) and same_light(before[1], scene, self._method):
            return
        self._asked = wanted, scene
        light = light_of(scene if self._method.near_light else replace(scene, near_lamps=()))
        self._drawing.ask(lambda: relight_first(wanted, light, self._find_relighter(wanted)), self._keep)

    def _find_relighter(self, wanted: Wanted) -> Relight | None:
        """The relighter of the model that is wanted, where there is one when the job begins."""
        shown = self.shown
        return shown.relight if shown is not None and shown.wanted.fits(wanted) and not wanted.parts else None

    def find(self, wanted: Wanted) -> Relit | None:
        """The last image, where it is of the model and the BRDF that are `wanted`."""
        return self.shown if self.shown is not None and is_same(self.shown.wanted, wanted) else None

    def _take(self, step: Step) -> None:
        if isinstance(step.partial, Relit):
            self._keep(step.partial)

    def _keep(self, found: Relit | None) -> None:
        if found is not None:
            self.shown = found
            self.changed.emit()


def is_same(one: Wanted, other: Wanted) -> bool:
    """True if both are of one surface with one BRDF, whatever the settings of their bakes are."""
    return one.fits(other) and one.reflects_as(other)


def relight_first(wanted: Wanted, light: Light, known: Relight | None) -> Steps[Relit | None]:
    """The image of `wanted`, by a relighter that is `known` of its model; then its error. None without visibility."""
    from engine.light.environment_file import open_environment
    from engine.transport.preview import ORDER, preview
    from engine.transport.reuse import VERTICES

    sh, subject = method_of("sh"), wanted.subject
    relight = known
    if relight is None:
        transport = yield from part(preview(subject), 0.0, 0.6)
        if transport is None:
            return None
        relight = sh.baking.relighter(transport, subject)
    found = Relit(wanted, relight, (yield from part(relight(light, sh.light(), wanted.brdf), 0.6, 0.7)))
    yield Step(0.7, "measuring the error", found)
    settings = sh.with_values({"order": ORDER})
    work = yield from part(sh.baking.prepare(subject, settings), 0.7, 0.8)
    steps = sh.baking.measure(work, subject, settings, open_environment("studio"), VERTICES)
    error = yield from part(steps, 0.8, 1.0)
    return replace(found, error_rel=error["error_rmse_rel"])
