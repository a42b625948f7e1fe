"""The plan of the scene in the View workspace: made anew, in a job, when the scene or the wishes have come to rest.

Its errors are those of the image that is on screen when it is made; another view does not call for another plan.
The Effects dock shows it, bakes follow it, and it predicts the error of a setting before that is measured.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QTimer, Signal

from app.commands.workbench import Workbench
from app.document.document import Project
from app.document.variation import VariedParameter, as_baked, find_varied_in
from app.jobs.newest import Latest
from engine.core.errors import FileError, UsageError
from engine.core.steps import Step, Steps, part
from engine.geometry.camera import Camera
from engine.planning.costs.setting import Setting
from engine.scene.scene import Scene
from engine.tradeoff.front import Budget, budget_from_text

if TYPE_CHECKING:
    from engine.planning.plan import EffectsPlan

#: Pause after the last change before the scene is planned anew.
AT_REST_MS = 500

LOOKING = "Analysing the scene…"

FAILED = "this scene could not be planned"
STOPPED = "Planning was stopped. Any change of the scene or of the budget plans again."


@dataclass(frozen=True, eq=False)
class Asked:
    """The inputs of a plan."""

    scene: Scene
    budget: Budget
    forced: tuple[str, ...]
    skipped: tuple[str, ...]
    variations: tuple[VariedParameter, ...] = ()

    def is_as(self, other: Asked | None) -> bool:
        if other is None or self.wishes != other.wishes:
            return False
        one, two = self.scene, other.scene
        same = (one.mesh is two.mesh, one.environment is two.environment, one.material is two.material)
        return all(same) and (one.brdf, one.ground) == (two.brdf, two.ground)

    @property
    def wishes(self) -> tuple[object, ...]:
        """All but the scene."""
        return self.budget, self.forced, self.skipped, self.variations


class Planning(QObject):
    """Plans while somebody watches. `changed` follows each new `plan`, and each new reason why there is none.

    Attributes
    ----------
    plan : of the scene as it is; None while there is none.
    before : the last plan, of whatever scene.
    words : why there is no plan, or what is being done for one; empty where there is one.
    """

    changed = Signal()

    def __init__(
        self,
        bench: Workbench,
        scene_of: Callable[[Project], Scene | None],
        size: Callable[[], tuple[int, int]],
        parent: QObject,
    ) -> None:
        super().__init__(parent)
        self.bench = bench
        self.plan: EffectsPlan | None = None
        self.before: EffectsPlan | None = None
        self.words = ""
        self._scene_of, self._size = scene_of, size
        self._watchers: set[str] = set()
        self._asked: Asked | None = None
        self._max_memory: float | None = None
        self._latest = Latest(bench.jobs, "Planning effects", self._on_progressed, self._on_stopped, lane="background")
        self.at_rest = QTimer(self)
        self.at_rest.setSingleShot(True)
        self.at_rest.setInterval(AT_REST_MS)
        self.at_rest.timeout.connect(self._ask)

    @property
    def is_coming(self) -> bool:
        """True if a plan of the present scene will be ready soon."""
        return self.at_rest.isActive() or (self._latest.busy and self._asked is not None and self.plan is None)

    def hurry(self) -> None:
        """The user waits for the plan now: it is made at once, next to whatever else is computed."""
        if self.at_rest.isActive():
            self.at_rest.stop()
            self._ask()
        self._latest.hurry()

    def predicted(self, setting: Setting) -> tuple[float, tuple[float, float]] | None:
        """The relative error that the plan expects of `setting`, and its interval; None where it is of another one."""
        if self.plan is None or self.plan.setting != setting:
            return None
        return self.plan.predicted_error_rel, self.plan.error_interval_rel

    def max_memory(self, max_bytes: float | None) -> None:
        """Let plans choose nothing that takes more; None for half of what is free. A budget says it for one project."""
        self._max_memory = max_bytes

    def watch(self, who: str, watches: bool) -> None:
        """Plan for as long as anybody watches."""
        before = bool(self._watchers)
        (self._watchers.add if watches else self._watchers.discard)(who)
        if bool(self._watchers) != before:
            self.refresh()

    def refresh(self) -> None:
        """Plan, where the scene or the wishes are others."""
        wanted, why_not = self._wanted(self.bench.document.project)
        if wanted is not None and not self._watchers:
            wanted = wanted if wanted.is_as(self._asked) else None
        if wanted is None:
            self.at_rest.stop()
            is_other = self._asked is not None or self.words != why_not
            self._asked = self.plan = self.before = None
            self.words = why_not
            if is_other:
                self.changed.emit()
        elif not wanted.is_as(self._asked):
            self._asked, self.plan, self.words = wanted, None, LOOKING
            self.at_rest.start()
            self.changed.emit()

    def _wanted(self, project: Project) -> tuple[Asked | None, str]:
        """The inputs of the next plan, or the reason why there can be none."""
        scene, look = self._scene_of(project), project.look
        if scene is None:
            return None, ""
        if scene.environment is None:
            return None, "A plan needs an environment: choose one under Light."
        try:
            budget = budget_from_text(look.plan_budget)
        except UsageError:
            return None, "Enter the budget as '1 %' or '8 ms'."
        if budget.error is not None and budget.time_s is not None:
            return None, "A plan keeps within an error or a time: give only one of the two."
        return Asked(scene, budget, look.forced, look.skipped, find_varied_in(scene.brdf, project.variations)), ""

    def _ask(self) -> None:
        """Plan the last requested scene, once nothing has changed for a while."""
        wanted = self._asked
        if not self._watchers:
            self._asked = None
        elif wanted is not None and self.plan is None:
            width, height = self._size()
            now = self._scene_of(self.bench.document.project)
            camera = wanted.scene.camera if now is None else now.camera
            self._latest.ask(
                lambda: plan(wanted, camera, (width, height), self._max_memory),
                lambda plan: self._take(wanted, plan),
                lambda _error: self._take(wanted, FAILED),
            )

    def _on_progressed(self, step: Step) -> None:
        """Show the progress of a new plan: the first on a machine measures its profile."""
        if self.is_coming and step.note:
            self.words = f"{step.note[:1].upper()}{step.note[1:]}…"
            self.changed.emit()

    def _on_stopped(self) -> None:
        """A user cancelled the plan: there is none until something changes."""
        if self._asked is not None and self.plan is None:
            self.before, self.words = None, STOPPED
            self.changed.emit()

    def _take(self, wanted: Asked, plan: EffectsPlan | str) -> None:
        if wanted is not self._asked:
            return
        if isinstance(plan, str):
            self.before, self.words = None, f"{plan[:1].upper()}{plan[1:]}."
        else:
            self.plan = self.before = plan
            self.words = ""
        self.changed.emit()


def plan(
    asked: Asked, camera: Camera, size: tuple[int, int], max_memory: float | None = None
) -> Steps[EffectsPlan | str]:
    """The plan of a scene for the image of `camera` of a `size` (width, height), or why there can be none.

    The first of a machine measures its costs.
    """
    yield Step(0.0, "compiling (first use only)")
    from app.session.machine_profile import cost_model
    from engine.planning.ceilings import usual
    from engine.planning.plan import plan_in_steps

    scene, budget = asked.scene, asked.budget
    model = yield from part(cost_model(), 0.0, 0.5)
    assert scene.environment is not None
    width, height = max(1, size[0]), max(1, size[1])
    steps = plan_in_steps(
        scene.mesh,
        scene.brdf,
        scene.environment,
        cost=model,
        error=budget.error,
        time_ms=1e3 * budget.time_s if budget.time_s is not None else None,
        force=asked.forced,
        skip=asked.skipped,
        ground=scene.ground,
        rotation=scene.environment_rotation,
        material=scene.material,
        variations=as_baked(asked.variations),
        pixels=width * height,
        aspect=width / height,
        ceilings=usual(memory_bytes=budget.bytes or max_memory),
        camera=camera,
    )
    try:
        return (yield from part(steps, 0.5, 1.0))
    except (
        UsageError,
        FileError,
    ) as reason:  # wishes that no mode can have, a memory that none fits in, a lost image
        return str(reason)
