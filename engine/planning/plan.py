"""The plan of a scene: which effects it calls for, and the mode and parameters that show them within a budget.

Every way to draw it (`choices`) has an error and a cost. Effects are left out from the least upwards, together at most
half of an error budget, so that a larger budget offers every choice of a smaller one and never ends in a costlier plan:

    budget of error   the cheapest within it, a bake being spread over `FRAMES` frames and a light over `LIGHTS`
    budget of time    the least error whose frame is within it

Only what keeps below the `ceilings` is offered, while there is any of it; the reference is chosen where no other mode
meets the budget. An effect whose estimate is 0 is always left out, one that the user forces never. Where nothing
satisfies the budget, error is weighed against cost (`Choice.overrun`), the plan says so, and names what would meet it
beyond the ceilings.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from engine.core.cached import remember
from engine.core.errors import UsageError
from engine.core.figure_text import percent, size_text
from engine.core.steps import Step, Steps, drain, part
from engine.core.suggestion import suggest
from engine.core.summary import Summary
from engine.geometry.backs import with_backs
from engine.geometry.camera import Camera
from engine.geometry.ground import Ground
from engine.geometry.mesh import Mesh
from engine.light.environment import EnvironmentMap
from engine.planning.ceilings import Ceilings, usual
from engine.planning.choices import (
    DIRECTIONS,
    FRAMES,
    HIGH,
    LOW,
    PIXELS,
    Choice,
    Choices,
    Wishes,
    is_low,
    probe,
)
from engine.planning.costs.cost_model import Cost, CostModel
from engine.planning.costs.planned import planning_of
from engine.planning.costs.setting import Setting, parameters_of, shows
from engine.planning.effects.estimates import EFFECTS, Estimate, Scenery, estimates, scenery
from engine.planning.effects.simplified import (
    Brushed,
    GlossyLambert,
    Unbrushed,
    WithoutRetro,
    WithoutRise,
    lambertian,
)
from engine.planning.predicted_error import REFERENCE_DEPTH, depth_of, shows_bounces
from engine.planning.prior import direct_light
from engine.planning.small_images import Measured, measure_small
from engine.scene.material import Material
from engine.scene.mode import DIRECT
from engine.scene.scene import Scene
from engine.transport import method as transport
from engine.transport.baking.spatially_varying import Variation, with_parameters
from engine.transport.sh.transfer import is_diffuse

if TYPE_CHECKING:
    from engine.brdf.brdf import Brdf

#: Factor on the least cost of all, below which settings are offered where none keeps below a ceiling.
RAISED = 2.0

#: An error that is told as 0 %: an effect that is worth no more is not needed.
NOTHING = 5e-4

#: Settings of small images, the cheapest of their modes by far, and those that are measured where the plan by the first
#: does not meet the budget: their BRDF has to be factored.
SMALL = (
    (*(Setting("direct", {"directions": directions}) for directions in (4, 16, 64)), Setting("sh", {"order": 8})),
    tuple(Setting("wavelet", {"terms": terms, "coefficients": kept, "cube": 32}) for terms, kept in ((1, 24), (4, 96))),
)

#: Directions up to which a small image is soon drawn.
QUICK_DIRECTIONS = 128

#: Modes whose errors take seconds to predict.
SLOW = ("gaussian",)

#: Words for what is done before anything is measured.
ANALYSING = "analysing the scene"

#: Effects that change the cost of a setting.
COSTING = ("self-shadowing", "interreflection", "glossy", "anisotropy", "sun-split", "spatially-varying-gloss")


#: Decisions on effects that images show.
SHOWN = ("needed", "included", "forced on")


@dataclass(frozen=True)
class Effect:
    """A row of the plan.

    Attributes
    ----------
    decision : "needed", "skipped", "forced on" or "forced off"; "included" where the mode shows it at no error saved.
    reason : in words, with its number.
    estimated_error_rel : relative error of an image without the effect.
    saves_s, saves_bytes : of the bake and its file, by leaving it out.
    """

    effect: str
    decision: str
    reason: str
    estimated_error_rel: float
    saves_s: float
    saves_bytes: int

    @property
    def on(self) -> bool:
        return self.decision in SHOWN


@dataclass(frozen=True)
class Beyond:
    """A setting that would meet the budget of error, but is beyond the ceilings named in `exceeded`.

    `max_depth` are points of the surface that light of a reference may touch.
    """

    setting: Setting
    max_depth: int
    error_rel: float
    cost: Cost
    exceeded: tuple[str, ...]


@dataclass(frozen=True)
class Alternative:
    """The choice where times are up to `times_within` longer or, where not `slower`, shorter than predicted.

    It is another one than the plan's because a time of either is near one of the `ceilings`.
    """

    slower: bool
    setting: Setting
    error_rel: float
    cost: Cost
    satisfied: bool
    ceilings: tuple[str, ...]


@dataclass(frozen=True, eq=False, repr=False)
class EffectsPlan(Summary):
    """Plan of a scene: the effects that it calls for, and the setting that shows them.

    `predicted_error_rel` holds what is left out too, and 95 of 100 such scenes have an error within
    `error_interval_rel`. `probability` is that of meeting a budget of error, None for one of time. `satisfied` says
    whether the budget is met, by the image of a camera in at least 95 of 100 scenes; `exceeded` names
    the `ceilings` that the setting is beyond, because every other is too. Where the budget is not met, `beyond` is what
    would meet it. `alternatives` are what would be chosen on a machine that is slower or faster than predicted.
    `excluded` has, for each effect that is left out though it is worth more than the budget, the ceilings that every
    mode which shows it is beyond. `unoccluded_fraction` of the vertices see their whole hemisphere: they need no rays
    and no visibility, whatever the others need. `mean` is what parameters that vary over the surface stand at where
    that is left out. `casts_shadows` says that lights which are summed cast shadows where they are sharp.
    Times are within a factor of `times_within` of what is predicted (`CostModel.within`).
    """

    effects: tuple[Effect, ...]
    setting: Setting
    predicted_error_rel: float
    error_interval_rel: tuple[float, float]
    cost: Cost
    satisfied: bool
    unoccluded_fraction: float
    times_within: float
    ceilings: Ceilings
    exceeded: tuple[str, ...] = ()
    beyond: Beyond | None = None
    alternatives: tuple[Alternative, ...] = ()
    excluded: Mapping[str, tuple[str, ...]] = field(default_factory=lambda: MappingProxyType({}))
    mean: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    probability: float | None = None
    casts_shadows: bool = False

    @property
    def mode(self) -> str:
        return self.setting.mode

    @property
    def parameters(self) -> dict[str, int | float]:
        return dict(self.setting.parameters)

    @property
    def predicted_frame_s(self) -> float:
        return self.cost.frame_s

    @property
    def max_depth(self) -> int:
        """Points of the surface that light of the reference may touch."""
        return REFERENCE_DEPTH if self.shows("interreflection") else 1

    def shows(self, effect: str) -> bool:
        """True if images of this plan have the effect."""
        return next(each.on for each in self.effects if each.effect == effect)

    def decision(self, effect: str) -> str:
        return next(each.decision for each in self.effects if each.effect == effect)

    def summary(self) -> dict[str, Any]:
        """Return what `repr` says."""
        needed = ", ".join(each.effect for each in self.effects if each.on)
        facts: dict[str, Any] = {"setting": str(self.setting), "effects": needed or "none"}
        facts |= {"predicted_error": self.predicted_error_rel, "frame": f"{self.cost.frame_s:.3g} s"}
        return {**facts, "satisfied": self.satisfied}


def plan(mesh: Mesh, brdf: Brdf, environment: EnvironmentMap, *, cost: CostModel, **options: Any) -> EffectsPlan:
    """The plan that `plan_in_steps` makes, at once."""
    return drain(plan_in_steps(mesh, brdf, environment, cost=cost, **options))


def plan_in_steps(
    mesh: Mesh,
    brdf: Brdf,
    environment: EnvironmentMap,
    *,
    cost: CostModel,
    error: float | None = None,
    time_ms: float | None = None,
    force: Collection[str] = (),
    skip: Collection[str] = (),
    modes: Collection[str] | None = None,
    ground: Ground | None = None,
    rotation: float = 0.0,
    material: Material | None = None,
    variations: Sequence[Variation] = (),
    pixels: int = PIXELS,
    aspect: float = 1.0,
    frames: int = FRAMES,
    ceilings: Ceilings | None = None,
    camera: Camera | None = None,
) -> Steps[EffectsPlan]:
    """The plan for a budget: `error` relative (0.01 where neither is given) or `time_ms` of a frame.

    `variations` move parameters of the BRDF over the mesh. `modes` narrows the choice. A bake is spread over
    `frames`; `ceilings` are the usual ones where they are None. Errors are those of the image of `camera`, or without
    one of images from all around, which are known much less well. UsageError for both budgets,
    budgets that are not positive, and effects that are not known or both forced and skipped. Less than a second for
    50,000 vertices once mesh and BRDF are known, half as much again where no cheap method meets the budget.
    """
    check_effects(force, skip)
    if error is not None and time_ms is not None:
        raise UsageError("a plan has one budget: of error or of time")
    budget = 0.01 if error is None and time_ms is None else error
    for value, name in ((budget, "error"), (time_ms, "time")):
        if value is not None and not 0.0 < value < float("inf"):
            raise UsageError(f"a budget of {name} of {value} is not above 0")
    yield Step(0.0, ANALYSING)
    mesh = with_backs(mesh, ground)
    looked: dict[str, Any] = {"rotation": rotation, "ground": ground, "camera": camera}
    scene = scenery(mesh, brdf, environment, material=material, variations=variations, **looked)
    place = {"environment": environment, "environment_rotation": rotation, "ground": ground}

    def noise(depth: int) -> float:
        return probe(mesh, brdf, depth, **place)

    wishes = frozenset(force), frozenset(skip)
    asked = (scene, cost, budget, time_ms, *wishes, modes, pixels, frames, ceilings, noise, aspect)
    if camera is None or material is not None or variations:
        return plan_of(*asked)
    shown = Scene(mesh, camera, brdf, environment=environment, environment_rotation=rotation, ground=ground)
    small: dict[Setting, Measured] = {}
    for number, settings in enumerate(SMALL):
        allowed = tuple(each for each in settings if modes is None or each.mode in modes)
        share = (1.0 + number) / (1.0 + len(SMALL))
        small |= yield from part(small_errors(shown, allowed), share - 0.3, share)
        found = plan_of(*asked, small)
        if found.satisfied:
            break
        yield Step(share, ANALYSING)
    if budget is not None and (further := select_doubtful(found.setting, small)):
        small |= yield from part(small_errors(shown, further), 0.9, 1.0)
        found = plan_of(*asked, small)
    return found


def select_doubtful(chosen: Setting, small: Mapping[Setting, Measured]) -> tuple[Setting, ...]:
    """Settings of which small images settle whether a choice is right: those that are soon drawn.

    Of directions, fewer than the chosen ones, down to the number that was measured before: which lights stand for an
    environment changes with their number, so that errors lie on no curve. Of harmonics, the chosen order and the one
    below it, where that was not measured.
    """
    if chosen.mode == DIRECT.name:
        most = chosen["directions"]
        measured = [each["directions"] for each in small if each.mode == chosen.mode and each["directions"] < most]
        counts = [each for each in DIRECTIONS if max(measured, default=0) < each <= min(most, QUICK_DIRECTIONS)]
        return tuple(each for count in counts if (each := chosen.replace(directions=count)) not in small)
    if "order" in chosen.parameters:
        plain = direct_light(chosen)
        below = [each for each in parameters_of(chosen.mode)["order"].sweep if each < chosen["order"]]
        if plain not in small:
            found = (plain.replace(order=order) for order in (*below[-1:], chosen["order"]))
            return tuple(each for each in found if each not in small)
    return ()


def small_errors(scene: Scene, settings: tuple[Setting, ...]) -> Steps[Mapping[Setting, Measured]]:
    """The errors of small images of those of `settings` that can draw the scene; remembered, some 2 s."""
    place = scene.environment, scene.environment_rotation, scene.ground
    kept = _recall_small(scene.mesh, scene.camera, scene.brdf, place)
    new = [each for each in settings if each not in kept]
    can_draw = [each.mode not in transport.names() or planning_of(each.mode).can_draw(scene) for each in new]
    asked = [each for each, can in zip(new, can_draw, strict=True) if can]
    if asked:
        kept |= {**dict.fromkeys(new), **(yield from measure_small(scene, asked))}
    return {each: found for each in settings if (found := kept.get(each)) is not None}


@remember(8)
def _recall_small(_mesh: Mesh, _camera: Camera, _brdf: Brdf, _place: tuple[Any, ...]) -> dict[Setting, Measured | None]:
    """Errors that have been measured for these arguments, None of those that noise hides; empty at first."""
    return {}


def check_effects(force: Collection[str], skip: Collection[str]) -> None:
    """UsageError for names that are not effects, and for one that is in both."""
    for name in (*force, *skip):
        if name not in EFFECTS:
            raise UsageError(f"unknown effect {name!r}{suggest(name, EFFECTS)}; choose from {', '.join(EFFECTS)}")
    both = sorted(set(force) & set(skip))
    if both:
        raise UsageError(f"{both[0]} cannot be forced and skipped at once")


def plan_of(
    scene: Scenery,
    cost: CostModel,
    error: float | None,
    time_ms: float | None,
    force: frozenset[str] = frozenset(),
    skip: frozenset[str] = frozenset(),
    modes: Collection[str] | None = None,
    pixels: int = PIXELS,
    frames: int = FRAMES,
    ceilings: Ceilings | None = None,
    noise: Callable[[int], float] | None = None,
    aspect: float = 1.0,
    small: Mapping[Setting, Measured] | None = None,
) -> EffectsPlan:
    """As `plan`, of a scene that has been looked at.

    `noise` is that of a reference of one sample, by the points of the surface that light may touch; without it there
    is no reference to choose. `small` are the errors of small images.
    """
    wishes = Wishes(force, skip, modes, pixels, aspect, frames)
    _check_varied(scene, force, skip)
    found = estimates(scene)
    offers = Choices(scene, found, cost, wishes, noise, small or {})
    limits = usual() if ceilings is None else ceilings
    time_s = None if time_ms is None else 1e-3 * time_ms
    if time_s is not None and time_s > limits.frame_s:
        limits = replace(limits, frame_s=time_s)  # whoever asks for slow frames has them
    choices = list(offers.all(error))
    fitting = [each for each in choices if "memory_bytes" not in each.exceeded(limits)]
    if not fitting:
        raise UsageError(f"no mode is left to choose from in {size_text(limits.memory_bytes)} of memory")
    chosen, satisfied = best(offer(fitting, limits), error, time_s)
    exceeded = chosen.exceeded(limits)
    beyond = None if satisfied or error is None else _beyond(choices, error, limits)
    effects = tuple(_effect(name, found[name], chosen, offers, force, skip) for name in EFFECTS)
    interval = offers.errors.interval(chosen.setting, chosen.skipped)
    summary = (
        chosen.setting,
        chosen.error,
        interval,
        chosen.cost,
        satisfied,
        scene.sample.unoccluded_fraction,
        cost.within,
    )
    alternatives = tuple(_alternatives(fitting, limits, cost.within, chosen, error, time_s))
    excluded = _find_exclusions(effects, choices, limits, error)
    probability = None if error is None else chosen.probability(error)
    further = limits, exceeded, beyond, alternatives, excluded, scene.mean, probability
    return EffectsPlan(effects, *summary, *further, casts_shadows=chosen.casts)


def _alternatives(
    choices: list[Choice], ceilings: Ceilings, within: float, chosen: Choice, error: float | None, time_s: float | None
) -> Iterator[Alternative]:
    """What is chosen where times are longer, and where they are shorter, by the factor `within`."""
    for slower, factor in ((True, 1.0 / within), (False, within)):
        moved = replace(ceilings, bake_s=ceilings.bake_s * factor, frame_s=ceilings.frame_s * factor)
        other, satisfied = best(offer(choices, moved), error, None if time_s is None else time_s * factor)
        one, two = (set(each.exceeded(moved if slower else ceilings)) for each in (chosen, other))
        near = one if slower else two
        if other.setting != chosen.setting and near:
            yield Alternative(slower, other.setting, other.error, other.cost, satisfied, tuple(sorted(near)))


def _find_exclusions(
    effects: Sequence[Effect], choices: list[Choice], ceilings: Ceilings, error: float | None
) -> Mapping[str, tuple[str, ...]]:
    """The ceilings that keep effects out which are worth more than the budget of error, by effect."""
    found = {}
    for effect in effects:
        if error is None or effect.decision != "skipped" or effect.estimated_error_rel <= error:
            continue
        showing = [each for each in choices if shows_effect(effect.effect, each)]
        beyond = [each.exceeded(ceilings) for each in showing]
        if showing and all(beyond):
            found[effect.effect] = min(beyond, key=len)
    return MappingProxyType(found)


def shows_effect(name: str, choice: Choice) -> bool:
    """True if images of a choice have the effect."""
    setting = choice.setting
    if name == "all-frequency-light":
        return not is_low(setting)
    if name == "self-shadowing":
        return choice.has_shadows
    if name in ("glossy", "mesostructure") and not shows(setting.mode, name):
        return False
    if name == "interreflection" and not shows_bounces(setting, choice.skipped):
        return False
    return name not in choice.skipped


def _check_varied(scene: Scenery, force: frozenset[str], skip: frozenset[str]) -> None:
    """UsageError where effects that the model itself does not have are forced on parameters of it that vary."""
    if scene.varied is None or "spatially-varying-gloss" in skip:
        return
    absent = {"glossy": is_diffuse(scene.brdf), "anisotropy": scene.brdf.isotropic}
    for name in force & absent.keys():
        if absent[name]:
            raise UsageError(f"{name} cannot be forced on a reflectance that varies and does not have it")


def offer(choices: list[Choice], ceilings: Ceilings) -> list[Choice]:
    """Those below the ceilings; a ceiling that none keeps below is raised to `RAISED` times what it takes at least."""
    least = {name: min(getattr(each.cost, name) for each in choices) for name in ("bake_s", "frame_s")}
    room = {name: max(getattr(ceilings, name), RAISED * value) for name, value in least.items()}
    return [each for each in choices if not each.exceeded(replace(ceilings, **room))] or choices


def best(choices: list[Choice], error: float | None, time_s: float | None) -> tuple[Choice, bool]:
    """The first choice for a budget of error or of seconds a frame, and whether the budget is met."""
    if time_s is not None:
        within = [each for each in choices if each.cost.frame_s <= time_s]
        if within:
            return min(within, key=lambda each: (each.error, each.price)), True
        return min(choices, key=lambda each: (each.cost.frame_s, each.error)), False
    if error is None:
        return min(choices, key=lambda each: each.effort), False
    for each in sorted(choices, key=lambda each: each.rank):
        if each.meets(error):
            return each, True
    return _least_overrun(choices, error), False


def _least_overrun(choices: list[Choice], error: float) -> Choice:
    """The least price times mean overrun, which is at least 1: nothing is predicted of what costs more than that."""
    ranked = sorted(choices, key=lambda each: each.price)
    found, least = ranked[0], math.inf
    for each in ranked:
        if each.price >= least:
            break
        value = each.price * each.overrun(error)
        if value < least:
            found, least = each, value
    return found


def _beyond(choices: list[Choice], error: float, ceilings: Ceilings) -> Beyond | None:
    """The cheapest that meets a budget of error beyond some ceilings, of modes whose error is soon predicted first."""
    for each in sorted(choices, key=lambda each: (each.setting.mode in SLOW, each.rank)):
        if each.exceeded(ceilings) and each.meets(error):
            summary = (each.setting, depth_of(each.skipped), each.error, each.cost, each.exceeded(ceilings))
            return Beyond(*summary)
    return None


def _effect(
    name: str,
    estimate: Estimate,
    chosen: Choice,
    offers: Choices,
    force: frozenset[str],
    skip: frozenset[str],
) -> Effect:
    shown = shows_effect(name, chosen)
    if name in force:
        decision = "forced on"
    elif name in skip:
        decision = "forced off"
    else:
        decision = ("needed" if estimate.error_rel >= NOTHING else "included") if shown else "skipped"
    saves_s, saves_bytes = _savings(name, chosen, offers)
    return Effect(name, decision, _reason(estimate, decision, chosen), estimate.error_rel, saves_s, saves_bytes)


def _reason(estimate: Estimate, decision: str, chosen: Choice) -> str:
    if estimate.error_rel == 0.0 or decision.startswith("forced"):
        return estimate.text
    if estimate.effect == "all-frequency-light":
        return f"{estimate.text} The error of the whole plan is {percent(chosen.error)}."
    if decision == "skipped" and estimate.effect == "self-shadowing" and chosen.casts:
        return f"{estimate.text} The mode {chosen.setting.mode} shows it of lamps and suns alone."
    if decision == "skipped" and estimate.effect not in chosen.skipped:
        return f"{estimate.text} The mode {chosen.setting.mode} does not show it."
    return estimate.text


def _savings(name: str, chosen: Choice, offers: Choices) -> tuple[float, int]:
    """Seconds of the bake and bytes of the file that leaving the effect out saves, beside the chosen setting."""
    setting = chosen.setting
    if name == "all-frequency-light":
        if setting.mode not in transport.names():
            return 0.0, 0
        high = HIGH if is_low(setting) else setting
        without, with_it = offers.cost(LOW, chosen.skipped), offers.cost(high, chosen.skipped)
    elif name not in COSTING or setting.mode not in transport.names():
        return 0.0, 0
    elif name == "interreflection":
        if "interreflection" not in setting.parameters:
            setting = LOW
        without = offers.cost(setting.replace(interreflection=0), chosen.skipped | {name})
        with_it = offers.cost(setting.replace(interreflection=1), chosen.skipped - {name})
    else:
        asked = frozenset({name}) if offers.estimate(name) == 0.0 else frozenset()
        without = offers.cost(setting, chosen.skipped | {name})
        with_it = offers.cost(setting, chosen.skipped - {name}, asked)
    return max(0.0, with_it.bake_s - without.bake_s), max(0, with_it.size_bytes - without.size_bytes)


def brdf_of(chosen: EffectsPlan, brdf: Brdf) -> Brdf:
    """The BRDF that the plan draws: without what it leaves out, and as general as what is forced on needs."""
    if chosen.mean:
        if chosen.shows("spatially-varying-gloss"):
            return brdf
        brdf = with_parameters(brdf, dict(chosen.mean))
    diffuse = is_diffuse(brdf)
    if chosen.decision("glossy") == "forced on":
        return GlossyLambert(brdf.albedo) if is_diffuse(brdf) else brdf
    if not diffuse and not chosen.shows("glossy"):
        return lambertian(brdf)
    if diffuse:
        return brdf
    if chosen.decision("anisotropy") == "forced on" and brdf.isotropic:
        brdf = Brushed(brdf)
    elif not brdf.isotropic and not chosen.shows("anisotropy"):
        brdf = Unbrushed(brdf)
    if chosen.decision("fresnel") == "forced off":
        brdf = WithoutRise(brdf)
    if chosen.decision("retro-reflection") == "forced off":
        brdf = WithoutRetro(brdf)
    return brdf
