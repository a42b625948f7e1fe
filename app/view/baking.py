"""Baked light in the View workspace: the estimate of a bake, the bake, and its relighting under each new light.

For each method one bake is drawn; all are kept beside the project (`app.project.bakes`), and one that was made before
is read instead of made. It belongs to a model on a ground and, unless the method can put in another BRDF, to a BRDF.
Estimates, bakes and light all come from jobs; of the light only the newest matters, and until it is there the image
keeps the one before. Effects that a user switched off in the plan of the scene (`app.view.planning`) are left out.

Where a bake is on screen and its visibility is kept, another BRDF is baked without a click, in the background and
without rays; the next one that a user chooses takes its place.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from PySide6.QtCore import QObject, Signal

from app.commands.workbench import Workbench
from app.document.bake_request import (
    BakeChoices,
    Estimate,
    Made,
    Wanted,
    choices_for,
    decide,
    make_request,
    same_light,
)
from app.document.variation import Variation, light_with, select_shown
from app.jobs.jobs import Job
from app.jobs.newest import Latest
from app.project.bakes import bake_and_keep, bake_or_cost
from app.view.first_image import FirstImage, Relit
from engine.core.errors import InputError, UsageError
from engine.core.steps import Step, Steps
from engine.scene.scene import Scene, brdfs_of_parts
from engine.transport.method import Method
from engine.transport.relight import light_of

if TYPE_CHECKING:
    from engine.planning.plan import EffectsPlan
    from engine.transport.relight import RelightTransport


def relight_or_explain(made: Made, scene: Scene, asked: Any) -> Steps[RelightTransport | str]:
    """The bake relit, or the sentence why it cannot be: a near lamp may touch the model, or an image be gone."""
    try:
        return (yield from relight_transport(made, scene, asked))
    except (UsageError, InputError) as error:
        return f"The image keeps the light before: {error}."


def relight_transport(made: Made, scene: Scene, asked: Any) -> Steps[RelightTransport]:
    """Relight the bake by the light of `scene`, with the `asked` settings of the light."""
    yield Step(0.0, "compiling (first use only)")
    return (yield from made.relighter(light_of(scene), asked, scene.brdf))


def serves(made: Wanted, wanted: Wanted) -> bool:
    """True if a bake of `made` shows all of `wanted`."""
    return made.fits(wanted) and made.reflects_as(wanted) and made.covers(wanted)


#: Said of a bake that is stopped.
RESUMED = "What is baked is kept, and the next bake goes on from there."


class Baking(QObject):
    """One method's bake. `changed` follows its state, `relit_changed` each light that can be drawn."""

    changed = Signal()
    relit_changed = Signal()

    def __init__(self, bench: Workbench, method: Method) -> None:
        super().__init__()
        self.bench, self.method = bench, method
        self.estimate: Estimate | None = None
        self.made: Made | None = None
        self.job: Job | None = None
        self.plan: EffectsPlan | None = None
        self.is_planning = False
        self._wanted: Wanted | None = None
        self._scene: Scene | None = None
        self._asked: Wanted | None = None
        self._folder = bench.folder
        self.is_awaited = False
        self._awaits_plan = False
        self._follows: Wanted | None = None
        self._declined: Wanted | None = None
        self._relit: tuple[Wanted, RelightTransport] | None = None
        self._light: tuple[Scene, object] | None = None
        self._estimating = Latest(bench.jobs, "Estimating a bake")
        self._lighting = Latest(bench.jobs, "Relighting")
        self.first = FirstImage(bench.jobs, method)
        self.first.changed.connect(self.relit_changed)
        self.first.changed.connect(self.changed)

    def want(self, scene: Scene, plan: EffectsPlan | None = None, *, is_planning: bool = False) -> None:
        """Show `scene`: relight its bake, or estimate the bake that is missing.

        While a `plan` is on the way, the one before holds for what is there; a bake that was asked for waits for it
        only where it has to follow wishes of a user.
        """
        if self._folder != self.bench.folder:  # another project, with bakes of its own
            self._folder, self.made, self.estimate, self._asked = self.bench.folder, None, None, None
        self._awaits_plan = is_planning
        self._scene, self.is_planning = scene, is_planning and not (self.is_awaited and not self._has_wishes)
        if not is_planning:
            self.plan = plan
        self._want()

    @property
    def _has_wishes(self) -> bool:
        look = self.bench.document.project.look
        return bool(look.forced or look.skipped)

    @property
    def choices(self) -> BakeChoices:
        """The settings of the next bake and of the light on it, which the project has."""
        return choices_for(self.method.name, **self.bench.document.project.bakes.get(self.method.name, {}))

    def choose(self, choices: BakeChoices, words: str = "") -> None:
        """Bake the next time with these choices."""
        if choices != self.choices:
            self.bench.document.change(words or f"Settings of {self.method.noun}", bakes=self.with_choices(choices))
        self._want()

    def with_choices(self, choices: BakeChoices) -> dict[str, Any]:
        """The settings of all bakes of the project, with these of this one."""
        return {**self.bench.document.project.bakes, self.method.name: choices.values}

    def _want(self) -> None:
        scene = self._scene
        if scene is not None:
            self._wanted = self._of(scene)
            if self._awaits_plan and self._differs_by_brdf(self._wanted) and not self._has_wishes:
                self.is_planning, self._wanted = False, self._of(scene, is_planned=False)  # leaves nothing out
            if self._follows is not None and not serves(self._follows, self._wanted):
                self.cancel()
            if self._usable(self._wanted):
                self._relight(scene)
            elif self._differs_by_brdf(self._wanted):
                self.first.want(self._wanted, scene)
            if not self.is_made and self.job is None and not self.is_planning:
                self._ask(self._wanted)
        self._begin_awaited()
        self.changed.emit()

    def go_on(self) -> None:
        """Bake with what is known by now, unless the bake is there; one that was interrupted goes on."""
        self.is_awaited = True
        if self.is_planning and not self._has_wishes:
            self.is_planning, self.plan = False, None
        self._want()

    def _differs_by_brdf(self, wanted: Wanted) -> bool:
        """True if the bake that there is needs nothing but another BRDF."""
        made = self.made
        if made is None or not made.wanted.fits(wanted) or made.wanted.choices != wanted.choices:
            return False
        return not made.wanted.reflects_as(wanted) and bool(self._why_stale(made, wanted))

    def _follow(self, estimate: Estimate) -> None:
        """Bake another BRDF unasked, where that casts no ray."""
        wanted = estimate.wanted
        is_cheap = not (estimate.casts_rays or estimate.why_not)
        is_declined = self._declined is not None and serves(self._declined, wanted)
        if is_cheap and self._differs_by_brdf(wanted) and not is_declined:
            self._submit(estimate, is_followed=True)

    def begin_or_stop(self) -> None:
        """Bake; or stop the bake that runs, or the one that is about to begin."""
        if self.job is not None:
            self._declined = self._follows
            self.cancel()
        elif self.is_awaited:
            self.is_awaited = False
            self.changed.emit()
        else:
            self.go_on()

    def _begin_awaited(self) -> None:
        if self.is_awaited and not self.is_planning and (self.is_made or self.ready is not None):
            self.is_awaited = False
            if not self.is_made:
                self.bake()

    def _of(self, scene: Scene, *, is_planned: bool = True) -> Wanted:
        plan = self.plan if is_planned else None
        parts = brdfs_of_parts(scene.mesh, scene.material)
        return make_request(scene.mesh, scene.ground, scene.brdf, self.choices, plan, self._variations, parts)

    @property
    def _variations(self) -> tuple[Variation, ...]:
        return self.bench.document.project.variations

    def _light_of(self, scene: Scene) -> Any:
        """The chosen settings of the light, with what of the variations can be put on a finished bake."""
        return light_with(self.choices.light, select_shown(self.method, scene.brdf, self._variations))

    @property
    def chosen(self) -> BakeChoices:
        """The choices, and what the plan decides of them."""
        return decide(self.choices, self.plan)

    @property
    def is_made(self) -> bool:
        """True if the image shows the requested bake."""
        made, wanted = self.made, self._wanted
        return made is not None and self._usable(wanted) and wanted is not None and made.wanted.covers(wanted)

    @property
    def is_drawn(self) -> bool:
        """True if the image shows a bake, even one of other choices."""
        return self._usable(self._wanted)

    @property
    def first_image(self) -> Relit | None:
        """The first image of the requested BRDF, where it stands for a bake that is not there yet."""
        wanted = self._wanted
        return None if wanted is None or self._usable(wanted) else self.first.find(wanted)

    def is_drawable(self, scene: Scene) -> bool:
        """True if the present bake can be drawn of `scene`."""
        return self._usable(self._of(scene))

    def _usable(self, wanted: Wanted | None) -> bool:
        return self.made is not None and wanted is not None and not self._why_stale(self.made, wanted)

    @property
    def why_stale(self) -> str:
        """The reason why the bake that there is cannot be drawn; empty where it can, or where there is none."""
        return self._why_stale(self.made, self._wanted) if self.made is not None and self._wanted is not None else ""

    def _why_stale(self, made: Made, wanted: Wanted) -> str:
        if made.wanted.mesh is not wanted.mesh:
            return "The bake is of another model."
        if not made.wanted.fits(wanted):
            return "The bake is of another ground."
        if made.wanted.parts != wanted.parts:
            return "The bake is of other materials of the parts."
        if made.wanted.reflects_as(wanted):
            return ""
        return made.why_baked_for_one

    @property
    def difference(self) -> str:
        """Findings of the check of the bake about the light on screen, as a sentence; empty where it passes."""
        if self.made is None or self._scene is None:
            return ""
        return " ".join(f"{text[:1].upper()}{text[1:]}." for text in self.made.differences(self._scene))

    def relit(self, scene: Scene) -> RelightTransport | None:
        """The relit bake to draw of `scene`: under its light, or under the light before while its own is computed.

        The first image of another BRDF where there is no bake of it yet.
        """
        wanted = self._of(scene)
        if not self._usable(wanted):
            first = self.first.find(wanted)
            return None if first is None else first.relit
        if self._relit is None or self.made is None or self._relit[0] is not self.made.wanted:
            return None
        return self._relit[1]

    def _ask(self, wanted: Wanted) -> None:
        if not wanted.is_as(self._asked):
            self._asked, self.estimate = wanted, None
            folders = tuple(dict.fromkeys((self.bench.own, self.bench.folder)))
            self._estimating.ask(lambda: bake_or_cost(wanted, folders), lambda found: self._found(wanted, *found))

    def _found(self, wanted: Wanted, made: Made | None, estimate: Estimate | None) -> None:
        """A bake that was made before, or the cost of one; the former is drawn also where another plan led to it."""
        if self._asked is not wanted:
            return
        if made is not None and (estimate is None or not self.is_drawn):
            self.made, self._relit, self._light = made, None, None
            self.relit_changed.emit()
        if self._asked is wanted:
            self.estimate = estimate
            self._begin_awaited()
            if self.job is None and self.ready is not None:
                self._follow(self.ready)
            self.changed.emit()

    @property
    def ready(self) -> Estimate | None:
        """The estimate of the requested bake, which may begin; None until it is known."""
        estimate = self.estimate
        return (
            estimate if estimate is not None and estimate.wanted.is_as(self._wanted) and not self.is_planning else None
        )

    def bake(self) -> None:
        """Start the estimated bake; a cancelled bake with equal settings resumes."""
        estimate = self.ready
        if estimate is None or estimate.why_not or self.job is not None:
            return
        self._submit(estimate)

    def _submit(self, estimate: Estimate, *, is_followed: bool = False) -> None:
        """Start a bake that the user asked for; or one that follows a BRDF, which nobody waits for."""
        folder, around = self.bench.own, self._scene.environment if self._scene is not None else None
        own = () if around is None else (around,)
        title, again = f"Baking {self.method.noun}", {"kind": "bake", "method": self.method.name}
        job = self.bench.jobs.submit(
            title,
            lambda: bake_and_keep(estimate, folder, own, is_checked=not is_followed),
            lane="background" if is_followed else "compute",
            again=None if is_followed else again,
            resource="bakes that follow" if is_followed else "bakes",
            on_stop=RESUMED if folder == self.bench.folder else "Nothing is written if you stop it.",
        )
        self.job, self._follows = job, estimate.wanted if is_followed else None
        job.succeeded.connect(self._keep)
        job.failed.connect(lambda _error: self._on_ended())
        job.cancelled.connect(self._on_ended)
        job.progressed.connect(lambda _step: self.changed.emit())
        self.changed.emit()

    def cancel(self) -> None:
        """Stop the bake; its finished chunks are kept for the next."""
        if self.job is not None:
            self.bench.jobs.cancel(self.job)

    def _keep(self, made: Made) -> None:
        self.made, self._relit, self._light = made, None, None
        self._on_ended()
        self.relit_changed.emit()

    def _on_ended(self) -> None:
        followed, self.job = self._follows is not None, None
        self._asked = self._follows = None
        if followed:
            self._want()
        else:
            self.changed.emit()

    @property
    def relighting(self) -> Callable[[Scene], Steps[RelightTransport]] | None:
        """Relights the bake on screen by the light of any scene of its surface; None where there is no such bake."""
        made = self.made
        if made is None or self._scene is None or not self.is_drawn:
            return None
        asked = self._light_of(self._scene)
        return lambda scene: relight_transport(made, scene, asked)

    def _relight(self, scene: Scene) -> None:
        """Relight the bake by the light of `scene`, unless that is done or under way."""
        made = self.made
        assert made is not None
        asked, before = self._light_of(scene), self._light
        if before is not None and before[1] == asked and same_light(before[0], scene, self.method):
            return
        self._light = (scene, asked)
        self._lighting.ask(lambda: relight_or_explain(made, scene, asked), lambda found: self._take(made, found))

    def _take(self, made: Made, relit: RelightTransport | str) -> None:
        if isinstance(relit, str):
            self.bench.said.emit(relit)
        elif made is self.made:
            self._relit = (made.wanted, relit)
            self.relit_changed.emit()
