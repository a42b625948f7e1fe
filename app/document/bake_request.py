"""A bake of the View workspace: its request, its estimate and the bake itself, on the threads of jobs.

A bake shows all that its method can show of the scene, shadows first of all: a plan (`engine.planning.plan`) advises,
and only an effect that the user switches off there is left out. What adds nothing to the scene costs nothing. The
parameters are the user's own; interreflection follows the plan where they leave it open.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from app.document.variation import Variation, as_baked, select_baked, settings_with
from app.session.cache import visibility_folder
from engine.brdf.brdf import Brdf
from engine.core.cached import cached_property
from engine.core.errors import InputError, UsageError
from engine.core.health import Finding, Health, Verdict
from engine.core.steps import Step, Steps, part
from engine.core.stopwatch import read_clock
from engine.geometry.backs import with_backs
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.geometry.parts import split_parts
from engine.planning.costs.setting import Setting
from engine.transport.baking.check import NOT_COMPARED, BakeCheck, warnings_at_render, warnings_of_check
from engine.transport.method import Method, Relight, Subject, method_of

if TYPE_CHECKING:
    from engine.light.environment import EnvironmentMap
    from engine.planning.plan import Effect, EffectsPlan
    from engine.scene.scene import Scene

#: Parameters of the BRDF that vary over the model.
VARYING = "spatially-varying-gloss"

#: Effects that a bake computes or leaves out, and those among them that are reported if left out.
DECIDED = ("self-shadowing", "glossy", "anisotropy", "fresnel", "retro-reflection")
LEFT_OUT = ("self-shadowing", "interreflection", "glossy", "anisotropy", VARYING)

#: Without these a BRDF is not an analytic model any more, of which parameters could vary.
CUT = ("glossy", "anisotropy", "fresnel", "retro-reflection")


@dataclass(frozen=True)
class BakeChoices:
    """The chosen `settings` of the next bake with a method, and the chosen `light`, which needs no bake.

    Interreflection None follows the plan of the scene; without a plan it is left out.
    """

    method: Method
    settings: Any
    light: Any

    @property
    def baked(self) -> BakeChoices:
        """The same choices with the default light."""
        return replace(self, light=self.method.light())

    @property
    def values(self) -> dict[str, Any]:
        """The settings of the bake and of the light that are not the method's defaults."""
        default = choices_for(self.method.name)
        names = [each.name for of in (self.settings, self.light) for each in fields(of)]
        return {name: self.value(name) for name in names if self.value(name) != default.value(name)}

    def value(self, name: str) -> Any:
        """A setting of the bake or of the light."""
        return getattr(self.settings if hasattr(self.settings, name) else self.light, name)

    def with_values(self, values: Mapping[str, Any]) -> BakeChoices:
        """These with other values; those that the method does not have are left out."""
        of_light = {each.name for each in fields(self.light)}
        settings = self.method.with_values(values, self.settings)
        return replace(
            self,
            settings=settings,
            light=replace(self.light, **{name: value for name, value in values.items() if name in of_light}),
        )


def choices_for(method: str, **values: Any) -> BakeChoices:
    """The defaults of a method, but for `values`."""
    of = method_of(method)
    return BakeChoices(of, of.settings(), of.light()).with_values(values)


@dataclass(frozen=True, eq=False)
class Wanted:
    """The request for a bake. `plan` has the effects as the bake decides them, and the parameters of `choices`, or is
    None.

    `variations` are those of the project that are part of the bake, and `parts` the BRDFs of the parts of the model.
    `predicted_s` is how long the machine profile says that it takes, where it is the very bake that the plan chose.
    """

    mesh: Mesh
    ground: Ground | None
    brdf: Brdf
    choices: BakeChoices
    plan: EffectsPlan | None = None
    predicted_s: float | None = None
    variations: tuple[Variation, ...] = ()
    parts: tuple[Brdf, ...] = ()

    def is_as(self, other: Wanted | None) -> bool:
        return other is not None and self.fits(other) and self.reflects_as(other) and self.asks_for_the_same(other)

    def reflects_as(self, other: Wanted) -> bool:
        """True if both have one BRDF that varies alike, or parts with the same BRDFs."""
        same = self.brdf == other.brdf or bool(self.parts)
        return same and self.parts == other.parts and self.variations == other.variations

    @property
    def subject(self) -> Subject:
        """The subject of the bake, for the method."""
        mesh = with_backs(split_parts(self.mesh) if self.parts else self.mesh, self.ground)
        return Subject(mesh, self.brdf, self.ground, as_baked(self.variations), visibility_folder(), self.parts)

    def fits(self, other: Wanted) -> bool:
        """True if both are of the same surface."""
        return self.mesh is other.mesh and self.ground == other.ground

    def asks_for_the_same(self, other: Wanted) -> bool:
        """True if both have the same parameters and leave out the same effects."""
        return self.choices == other.choices and self.decided == other.decided

    def covers(self, other: Wanted) -> bool:
        """True if a bake of this shows what `other` asks for.

        One that began before the plan of the scene was known leaves nothing out; it serves unless a user decides
        otherwise.
        """
        effects = other.plan.effects if other.plan is not None else ()
        is_whole = self.plan is None and not any(each.decision.startswith("forced") for each in effects)
        return self.choices == other.choices and (is_whole or self.decided == other.decided)

    @property
    def decided(self) -> tuple[object, ...]:
        """The decisions that a bake depends on: equal for plans that lead to the same bake, empty without wishes."""
        effects = self.plan.effects if self.plan is not None else ()
        made = (
            _describe_effect(effect) for effect in effects if effect.effect in DECIDED or self._is_held_at_mean(effect)
        )
        return tuple((name, on, idle) for name, on, idle in made if idle or not on)

    def _is_held_at_mean(self, effect: Effect) -> bool:
        """True if a user wants nothing to vary although something does."""
        return effect.effect == VARYING and effect.decision == "forced off" and bool(self.variations)

    @property
    def left_out(self) -> tuple[Effect, ...]:
        """The effects that the bake leaves out although the scene has them, or because a user says so."""
        effects = self.plan.effects if self.plan is not None else ()
        off = (effect for effect in effects if effect.effect in LEFT_OUT and not effect.on)
        return tuple(each for each in off if each.decision == "forced off" or each.estimated_error_rel > 0.0)


def _describe_effect(effect: Effect) -> tuple[str, bool, bool]:
    """An effect, whether it is worked out, and whether even where the scene does not call for it."""
    is_idle = effect.effect == "self-shadowing" or effect.estimated_error_rel == 0.0
    return effect.effect, effect.on, effect.decision == "forced on" and is_idle


def make_request(
    mesh: Mesh,
    ground: Ground | None,
    brdf: Brdf,
    choices: BakeChoices,
    plan: EffectsPlan | None,
    variations: Sequence[Variation] = (),
    parts: tuple[Brdf, ...] = (),
) -> Wanted:
    """The request for a bake with the parameters of `choices`, and without the effects that were switched off in
    `plan`.

    Of the `variations` of a project it has those that the method bakes; `parts` are as for `Wanted`.
    """
    chosen, varied = decide(choices, plan).baked, select_baked(choices.method, brdf, variations)
    if plan is None:
        return Wanted(mesh, ground, brdf, chosen, variations=varied, parts=parts)
    effects = tuple(_for_method(effect, chosen) for effect in plan.effects)
    if any(effect.decision == "forced off" for effect in effects if effect.effect in CUT):
        effects = tuple(plan_s if e.effect == VARYING else e for e, plan_s in zip(effects, plan.effects, strict=True))
    setting = setting_for(chosen)
    predicted_s = plan.cost.bake_s if (setting, effects) == (plan.setting, plan.effects) and not parts else None
    planned = replace(plan, effects=effects, setting=setting)
    return Wanted(mesh, ground, brdf, chosen, planned, predicted_s, varied, parts)


def same_light(one: Scene, other: Scene, method: Method) -> bool:
    """True where two scenes have one light for bakes of a method, of which the BRDF is part where it can be changed."""
    names = ["light", "irradiance", "environment", "environment_rotation", "lamps"]
    names += ["brdf"] * method.takes_brdf + ["near_lamps"] * method.near_light
    return all(getattr(one, name) == getattr(other, name) for name in names)


def decide(choices: BakeChoices, plan: EffectsPlan | None) -> BakeChoices:
    """`choices` with all that was left to the plan, or is forced there."""
    if not hasattr(choices.settings, "interreflection"):
        return choices
    chosen = choices.settings.interreflection
    if plan is not None:
        decision = plan.decision("interreflection")
        if chosen is None or decision.startswith("forced"):
            chosen = decision in ("needed", "included", "forced on")
    return choices.with_values({"interreflection": bool(chosen)})


def _for_method(effect: Effect, choices: BakeChoices) -> Effect:
    """An effect as a bake with the method decides it, where nobody forces it: shown, unless it adds nothing."""
    if effect.decision.startswith("forced"):
        return effect
    if effect.effect == "interreflection":
        is_shown = getattr(choices.settings, "interreflection", False)
        return replace(effect, decision="needed" if is_shown else "skipped")
    is_seen = effect.effect == "self-shadowing" or effect.estimated_error_rel > 0.0
    return replace(effect, decision="needed") if is_seen and not effect.on else effect


def setting_for(choices: BakeChoices) -> Setting:
    """The parameters of `choices`."""
    method = choices.method
    return Setting(method.name, {each.name: int(choices.value(each.name) or 0) for each in method.parameters})


@dataclass(frozen=True, eq=False)
class Estimate:
    """A bake that could begin: its work, its baker and its predicted seconds; or the reason why it cannot begin.

    One of a model whose visibility is kept casts no rays.
    """

    wanted: Wanted
    work: Any
    bake_s: float
    start: Callable[[Path], Steps[Any]] | None = None
    why_not: str = ""
    casts_rays: bool = True

    @property
    def size_bytes(self) -> int:
        """Size of the file, roughly."""
        return self.wanted.choices.method.estimate_file_bytes(self.work.size_bytes) if self.work is not None else 0


@dataclass(frozen=True, eq=False)
class Made:
    """A finished bake: the transport of one method, its time, its size and its check against the reference.

    `bake_s` is None where nobody knows it, `check` where there is none. `another_s` are the seconds of a bake of
    another BRDF, without rays, and `error` the method's own record of its error in place of the check; None where
    nobody found them.
    """

    wanted: Wanted
    transport: Any
    bake_s: float | None
    size_bytes: int
    check: BakeCheck | None = None
    another_s: float | None = None
    error: Mapping[str, Any] | None = None

    def differences(self, scene: Scene) -> list[str]:
        """Return what the check says of an image of `scene`; nothing of another BRDF, which was not checked."""
        wanted = self.wanted
        if self.check is None or (scene.brdf != wanted.brdf and not wanted.parts):
            return []
        name = None if scene.environment is None else scene.environment.name
        return warnings_at_render(self.check, self.wanted.choices.method.name, name, _label)

    @cached_property
    def health(self) -> Health:
        """The errors of the check, and the lights under which the bake does not pass; a note where there is none."""
        if self.check is None:
            return Health(findings=(Finding(Verdict.NOTE, NOT_COMPARED),))
        figures = {f"error_under_{each.light.replace(' ', '_')}_rel": each.rmse_rel for each in self.check.lights}
        said = warnings_of_check(self.check, self.wanted.choices.method.name, _label)
        return Health(MappingProxyType(figures), tuple(Finding(Verdict.WARNING, text) for text in said))

    @cached_property
    def relighter(self) -> Relight:
        """Lights it, one light after the other."""
        return self.wanted.choices.method.baking.relighter(self.transport, self.wanted.subject)

    @property
    def why_baked_for_one(self) -> str:
        """The reason why another BRDF asks for another bake; empty where it does not."""
        return self.wanted.choices.method.baking.why_baked_for_one(self.transport)


def _label(mode: str) -> str:
    """The name of a mode in the window."""
    return method_of(mode).short


def estimate(wanted: Wanted) -> Steps[Estimate]:
    """Estimate the time and bytes of a bake; modules and kernels are loaded on the thread that asks."""
    yield Step(0.0, "compiling (first use only)")
    try:
        work, start = yield from part(_prepare(wanted), 0.0, 0.8)
    except (UsageError, InputError) as reason:
        return Estimate(wanted, None, 0.0, why_not=f"{str(reason)[:1].upper()}{str(reason)[1:]}.")
    yield Step(0.8, "estimating")
    baking = wanted.choices.method.baking
    return Estimate(wanted, work, baking.estimate_s(work), start, casts_rays=baking.casts_rays(work))


def _prepare(wanted: Wanted) -> Steps[tuple[Any, Callable[[Path], Steps[Any]]]]:
    """The work of a bake, and its baker."""
    settings, subject = settings_with(wanted.choices.settings, wanted.variations), wanted.subject
    wanted.choices.method.check_parts(subject)
    if wanted.plan is None:
        baking = wanted.choices.method.baking
        work = yield from baking.prepare(subject, settings)
        return work, lambda path: baking.bake(path, work)
    from engine.planning.bake import prepare

    ready = yield from prepare(
        wanted.plan,
        wanted.mesh,
        wanted.brdf,
        wanted.ground,
        variations=subject.variations,
        settings=settings,
        kept=subject.kept,
        parts=wanted.parts,
    )
    return ready.work, ready.start


def bake(path: Path, estimate: Estimate, own: Sequence[EnvironmentMap] = (), *, is_checked: bool = True) -> Steps[Made]:
    """Bake into the file `path` and check it, also under environments `own`; an interrupted equal bake goes on.

    A bake without effects that the user left out is not checked, because the reference shows them. One that is not to
    be checked has the method's own error at some vertices, which takes a second.
    The machine profile learns from one that it predicted and that ran from its start to its end.
    """
    from app.session.machine_profile import learn
    from engine.accuracy.bake_check import check_file

    yield Step(0.0, "compiling (first use only)")
    assert estimate.start is not None
    wanted = estimate.wanted
    since = read_clock()
    made = yield from part(estimate.start(path), 0.0, 0.95)
    if wanted.predicted_s is not None and not made.resumed_chunks:
        learn(wanted.choices.method.name, wanted.predicted_s, made.bake_s, since)
    check, error = None, None
    if not is_checked:
        error = yield from part(_measure(wanted, estimate.work), 0.95, 1.0)
    elif not any(effect.decision == "forced off" for effect in (wanted.plan.effects if wanted.plan else ())):
        settings = settings_with(wanted.choices.settings, wanted.variations)
        steps = check_file(path, made.transport, wanted.choices.method, wanted.subject, settings, own)
        check = yield from part(steps, 0.95, 1.0)
    casts_rays = wanted.choices.method.baking.casts_rays(estimate.work)
    another_s = None if made.resumed_chunks or casts_rays else max(made.bake_s - made.visibility_s, 0.0)
    return Made(wanted, made.transport, made.bake_s, made.file.size_bytes, check, another_s, error)


def _measure(wanted: Wanted, work: Any) -> Steps[dict[str, Any]]:
    """The record of the method's own error in the studio."""
    from engine.light.environment_file import open_environment
    from engine.transport.reuse import VERTICES

    baking, settings = wanted.choices.method.baking, settings_with(wanted.choices.settings, wanted.variations)
    return (yield from baking.measure(work, wanted.subject, settings, open_environment("studio"), VERTICES))
