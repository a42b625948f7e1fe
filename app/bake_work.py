"""What a bake of the View workspace is of, what it would take, and the bake itself, on the threads of jobs.

Where the scene has a plan, a bake follows it (`engine.effects.bake`): what the plan leaves out is not worked out, and
what is forced on is. The knobs are the person's own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from engine.brdf.brdf import Brdf
from engine.effects.setting import KNOBS, Setting
from engine.ground import Ground
from engine.mesh import Mesh
from engine.steps import Step, Steps, part

if TYPE_CHECKING:
    from engine.effects.plan import Effect, EffectsPlan
    from engine.transport.sh import Window
    from engine.transport.wavelet_relight import Relighter

Method = Literal["sh", "wavelet", "gaussian"]

WORDS: dict[Method, str] = {"sh": "Baking harmonics", "wavelet": "Baking wavelets", "gaussian": "Baking Gaussians"}

#: Fields of the choices for a bake that are called otherwise than the knobs of a setting.
SPELLED = {"edge": "cube"}

#: Effects that a bake works out or not, and those among them that are told where it does not.
DECIDED = ("self-shadowing", "glossy", "anisotropy", "fresnel", "retro-reflection")
LEFT_OUT = ("self-shadowing", "interreflection", "glossy", "anisotropy")

NAMES: dict[Method, str] = {"sh": "harmonics", "wavelet": "wavelets", "gaussian": "Gaussians"}


@dataclass(frozen=True)
class BakeChoices:
    """What is chosen for the next bake, and for the light on it.

    Attributes
    ----------
    order : bands of harmonics.
    interreflection : with light that comes by way of the model; of harmonics and Gaussians. None for what the plan of
        the scene says, and without one where there is no plan.
    window : what damps high bands of harmonics against ringing. It belongs to the light, and asks for no bake.
    terms : of the factors of wavelets.
    coefficients : wavelets kept for each vertex and term.
    edge : texels along a face of the wavelets' light.
    occluder_cells : cells in which what shades wavelets is simplified; 0 for the model itself.
    lobes : Gaussians for each vertex and view.
    """

    order: int = 5
    interreflection: bool | None = None
    window: Window = "none"
    terms: int = 4
    coefficients: int = 96
    edge: int = 64
    occluder_cells: int = 0
    lobes: int = 1

    @property
    def baked(self) -> BakeChoices:
        """The same where nothing is chosen of the light."""
        return replace(self, window="none")


@dataclass(frozen=True, eq=False)
class Wanted:
    """What a bake would be of. `plan` is what it follows, with the knobs of `choices`; None where there is none."""

    mesh: Mesh
    ground: Ground | None
    brdf: Brdf
    choices: BakeChoices
    plan: EffectsPlan | None = None

    def is_as(self, other: Wanted | None) -> bool:
        return other is not None and self.fits(other) and self.brdf == other.brdf and self.asks_for_the_same(other)

    def fits(self, other: Wanted) -> bool:
        """Whether both are of one surface."""
        return self.mesh is other.mesh and self.ground == other.ground

    def asks_for_the_same(self, other: Wanted) -> bool:
        """Whether both have the same knobs, and leave out the same."""
        return self.choices == other.choices and self.decided == other.decided

    @property
    def decided(self) -> tuple[object, ...]:
        """What the plan decides of a bake: equal for plans that are baked alike."""
        if self.plan is None:
            return ()
        return tuple(_baked_as(effect) for effect in self.plan.effects if effect.effect in DECIDED)

    @property
    def left_out(self) -> tuple[Effect, ...]:
        """What the plan leaves out of the bake."""
        effects = self.plan.effects if self.plan is not None else ()
        return tuple(effect for effect in effects if effect.effect in LEFT_OUT and not effect.on)


def _baked_as(effect: Effect) -> tuple[str, bool, bool]:
    """An effect, whether it is worked out, and whether even where the scene does not call for it."""
    is_idle = effect.effect == "self-shadowing" or effect.estimated_error_rel == 0.0
    return effect.effect, effect.on, effect.decision == "forced on" and is_idle


def wanted_of(
    method: Method, mesh: Mesh, ground: Ground | None, brdf: Brdf, choices: BakeChoices, plan: EffectsPlan | None
) -> Wanted:
    """What a bake is of that has the knobs of `choices` and, for the rest, follows the `plan` of the scene."""
    chosen = decided_by(method, choices, plan).baked
    if plan is None:
        return Wanted(mesh, ground, brdf, chosen)
    effects = tuple(_for_method(method, effect, chosen) for effect in plan.effects)
    return Wanted(mesh, ground, brdf, chosen, replace(plan, effects=effects, setting=setting_for(method, chosen)))


def decided_by(method: Method, choices: BakeChoices, plan: EffectsPlan | None) -> BakeChoices:
    """`choices` with all that was left to the plan, or is forced there."""
    if "interreflection" not in KNOBS[method]:
        return choices
    chosen = choices.interreflection
    if plan is not None:
        decision = plan.decision("interreflection")
        if chosen is None or decision.startswith("forced"):
            chosen = decision in ("needed", "forced on")
    return replace(choices, interreflection=bool(chosen))


def _for_method(method: Method, effect: Effect, choices: BakeChoices) -> Effect:
    """An effect as a bake of `method` decides it, where nobody forces it.

    Gaussians are of the highlights alone, which a plan of another mode may have left out.
    """
    if effect.decision.startswith("forced"):
        return effect
    if effect.effect == "interreflection":
        return replace(effect, decision="needed" if choices.interreflection else "skipped")
    if method == "gaussian" and effect.effect in ("glossy", "anisotropy") and effect.estimated_error_rel > 0.0:
        return replace(effect, decision="needed")
    if method != "sh" and effect.effect == "self-shadowing" and effect.estimated_error_rel > 0.0:
        return replace(effect, decision="needed")
    return effect


def setting_for(mode: str, choices: BakeChoices) -> Setting:
    """The knobs of `choices` that a mode has."""
    values = {SPELLED.get(each.name, each.name): getattr(choices, each.name) for each in fields(choices)}
    return Setting(mode, {name: int(value or 0) for name, value in values.items() if name in KNOBS[mode]})


@dataclass(frozen=True, eq=False)
class Estimate:
    """A bake that could begin: its work, what does it, and the seconds that it would take; or why it cannot."""

    wanted: Wanted
    work: Any
    bake_s: float
    start: Callable[[Path], Steps[Any]] | None = None
    why_not: str = ""

    @property
    def size_bytes(self) -> int:
        return int(self.work.size_bytes) if self.work is not None else 0


@dataclass(frozen=True, eq=False)
class Made:
    """A finished bake: `engine.transport` of one method, and what it took."""

    wanted: Wanted
    transport: Any
    bake_s: float
    size_bytes: int

    @cached_property
    def relighter(self) -> Relighter:
        """Of wavelets: what keeps of one light what is the same under the next."""
        from engine.transport.wavelet_relight import Relighter

        return Relighter(self.transport)


def estimated(method: Method, wanted: Wanted) -> Steps[Estimate]:
    """What a bake would take."""
    yield Step(0.0, "preparing kernels")
    try:
        work, start = yield from part(_prepared(method, wanted), 0.0, 0.8)
    except ValueError as reason:
        return Estimate(wanted, None, 0.0, why_not=f"{str(reason)[:1].upper()}{str(reason)[1:]}.")
    yield Step(0.8, "estimating")
    return Estimate(wanted, work, _module(method).estimate_s(work), start)


def _module(method: Method) -> Any:
    """`engine.transport`'s bake of a method; imported on the thread that asks, because it compiles kernels."""
    if method == "sh":
        from engine.transport import sh_bake

        return sh_bake
    if method == "wavelet":
        from engine.transport import wavelet_bake

        return wavelet_bake
    from engine.transport import gaussian_bake

    return gaussian_bake


def _prepared(method: Method, wanted: Wanted) -> Steps[tuple[Any, Callable[[Path], Steps[Any]]]]:
    """The work of a bake, and what does it."""
    bake = _module(method).bake
    if wanted.plan is None:
        work = yield from WORKS[method](wanted)
        return work, lambda path: bake(path, work)
    from engine.effects.bake import prepare

    ready = yield from prepare(wanted.plan, wanted.mesh, wanted.brdf, wanted.ground)
    cells = wanted.choices.occluder_cells
    if method != "wavelet" or not cells or wanted.plan.decision("self-shadowing") == "forced on":
        return ready.work, ready.start
    from engine.transport.occluder import simplified

    settings = replace(ready.work.settings, occluder_cells=cells)
    shaded = replace(ready.work, settings=settings, occluder=simplified(ready.work.surface, cells))
    return shaded, lambda path: bake(path, shaded)


def _work_sh(wanted: Wanted) -> Steps[Any]:
    from engine.effects.bake import BOUNCES
    from engine.transport import sh_bake

    settings = sh_bake.BakeSettings(wanted.choices.order, bounces=BOUNCES if wanted.choices.interreflection else 0)
    return (yield from sh_bake.prepare(wanted.mesh, wanted.brdf, settings, wanted.ground))


def _work_wavelets(wanted: Wanted) -> Steps[Any]:
    from engine.transport import wavelet_bake

    choices = wanted.choices
    factors = yield from wavelet_bake.factors_for(wanted.brdf, choices.terms)
    settings = wavelet_bake.BakeSettings(choices.edge, choices.coefficients, occluder_cells=choices.occluder_cells)
    return wavelet_bake.prepare(wanted.mesh, factors, settings, wanted.ground)


def _work_gaussians(wanted: Wanted) -> Steps[Any]:
    from engine.transport import gaussian_bake

    settings = gaussian_bake.BakeSettings(wanted.choices.lobes, indirect=bool(wanted.choices.interreflection))
    return (yield from gaussian_bake.prepare(wanted.mesh, wanted.brdf, settings, wanted.ground))


WORKS: dict[Method, Callable[[Wanted], Steps[Any]]] = {
    "sh": _work_sh,
    "wavelet": _work_wavelets,
    "gaussian": _work_gaussians,
}


def baked(path: Path, estimate: Estimate) -> Steps[Made]:
    """Bake into the file `path`; an equal bake that was interrupted goes on."""
    yield Step(0.0, "preparing kernels")
    assert estimate.start is not None
    made = yield from estimate.start(path)
    return Made(estimate.wanted, made.transport, made.bake_s, made.file.size_bytes)
