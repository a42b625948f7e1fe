"""The plan of a scene: which effects it calls for, and the mode and knobs that show them within a budget.

Every way to draw the scene is a setting together with the effects that it leaves out. Its error is at most the sum of
the errors of what is left out (`estimates`) and of the method's own (`mode_error`), by the triangle inequality; its
cost is the model's (`cost_model`). Effects are left out from the least upwards, together at most half of an error
budget, so that a larger budget offers every choice of a smaller one and never ends in a costlier plan:

    budget of error   the cheapest within it, a bake being spread over `FRAMES` frames and a light over `LIGHTS`
    budget of time    the least error whose frame is within it

What does not fit into free memory is never offered. A bake of more than `LONG_S` is chosen only where nothing else
meets the budget of error, and the reference, whose samples follow from the noise of a tiny picture, where no other mode
does. Where more than `FEW_FRAMES` are wanted, nobody waits longer than `PATIENCE_S` for each of them: a reference that
takes longer is not the plan then, but named beside it as what would keep to the budget.

An effect whose estimate is 0 is always left out, one that the user forces never. Where nothing satisfies the budget,
the plan is the nearest to it and says so: of all whose error is hardly above the least, the cheapest.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache, partial
from types import MappingProxyType
from typing import Any

import psutil

from engine.camera import frame
from engine.effects.cost_model import Cost, CostModel, Load
from engine.effects.estimates import EFFECTS, LOW_ORDER, Estimate, Scenery, estimates, percent, scenery, seen_as
from engine.effects.load import covered, rays_of, shaded
from engine.effects.mode_error import ModeErrors, mode_errors
from engine.effects.noise import REFERENCE_DEPTH, probed
from engine.effects.setting import KNOBS, Setting
from engine.effects.simplified import Brushed, GlossyLambert, Unbrushed, WithoutRetro, WithoutRise, albedos, matt
from engine.environment import EnvironmentMap
from engine.ground import Ground
from engine.material import Material
from engine.mesh import Mesh
from engine.transport.sh_transfer import is_diffuse
from engine.transport.sh_varied import MOST_VARIATIONS
from engine.transport.variation import Variation, with_parameters

#: Frames over which a bake is spread, and over which a changed light is.
FRAMES, LIGHTS = 20_000, 50

#: Seconds of a bake that is long, and pictures up to which a reference is a mode as any other.
LONG_S, FEW_FRAMES = 1200.0, 1

#: Seconds that a person waits for one of many pictures.
PATIENCE_S = 10.0

#: Errors up to so many times the least are as near to a budget that nothing meets.
AS_NEAR = 1.05

#: Share of free memory that a setting may take.
MEMORY_SHARE = 0.75

#: Share of an error budget that all effects together that are left out may take.
SHARE = 0.5

#: Pixels of a picture where nobody says.
PIXELS = 720 * 760

#: The modes that are baked.
BAKED = ("sh", "wavelet", "gaussian")

#: What left out or not is seen in the cost of a setting.
COSTING = ("self-shadowing", "interreflection", "glossy", "anisotropy", "sun-split", "spatially-varying-gloss")

#: Seconds of the tables of a reflectance that varies, beside the one that every bake makes.
VARIED_S = 2.0


@dataclass(frozen=True)
class Effect:
    """A row of the plan.

    Attributes
    ----------
    decision : "needed", "skipped", "forced on" or "forced off".
    reason : in words, with its number.
    estimated_error_rel : relative error of a picture without the effect.
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
        return self.decision in ("needed", "forced on")


@dataclass(frozen=True)
class SlowReference:
    """A reference of so many `samples` that would meet a budget of error, in `frame_s` a picture."""

    samples: int
    max_depth: int
    error_rel: float
    frame_s: float


@dataclass(frozen=True, eq=False)
class EffectsPlan:
    """What a scene calls for, and the setting that shows it.

    `predicted_error_rel` holds what is left out too. `satisfied` tells whether the budget is met, and `reference` is
    then one that meets it, where there is one for which frames are too many. `free_share` of the vertices see their
    whole hemisphere: they need no rays and no visibility, whatever the others need. `mean` is what parameters that vary
    over the surface stand at where that is left out.
    """

    effects: tuple[Effect, ...]
    setting: Setting
    predicted_error_rel: float
    cost: Cost
    satisfied: bool
    free_share: float
    reference: SlowReference | None = None
    mean: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))

    @property
    def mode(self) -> str:
        return self.setting.mode

    @property
    def knobs(self) -> dict[str, int | float]:
        return dict(self.setting.knobs)

    @property
    def predicted_frame_s(self) -> float:
        return self.cost.frame_s

    @property
    def max_depth(self) -> int:
        """Points of the surface that light of the reference may touch."""
        return REFERENCE_DEPTH if self.shows("interreflection") else 1

    def shows(self, effect: str) -> bool:
        """Whether pictures of this plan have the effect."""
        return next(each.on for each in self.effects if each.effect == effect)

    def decision(self, effect: str) -> str:
        return next(each.decision for each in self.effects if each.effect == effect)


@dataclass(frozen=True)
class _Choice:
    """A setting, what is left out, and what both come to; the error is found when it is first asked for."""

    setting: Setting
    skipped: frozenset[str]
    told: Callable[[], float]
    cost: Cost
    frames: int

    @cached_property
    def error(self) -> float:
        return self.told()

    @property
    def is_slow(self) -> bool:
        """Whether it is a reference that nobody waits for, so many frames being wanted."""
        is_often = self.setting.mode == "reference" and self.frames > FEW_FRAMES
        return is_often and self.cost.frame_s > PATIENCE_S

    @property
    def price(self) -> float:
        return self.cost.frame_s + self.cost.relight_s / LIGHTS + self.cost.bake_s / self.frames

    @property
    def rank(self) -> tuple[int, float]:
        """What is chosen first, being within a budget of error."""
        last = self.setting.mode == "reference" and self.frames > FEW_FRAMES
        return 2 if last else int(self.cost.bake_s > LONG_S), self.price


def plan(
    mesh: Mesh,
    brdf: Any,
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
    memory_bytes: int | None = None,
) -> EffectsPlan:
    """The plan for a budget: `error` relative (0.01 where neither is given) or `time_ms` of a frame.

    `variations` move parameters of the reflectance over the mesh. `modes` narrows the choice. A bake is spread over
    `frames`, and `memory_bytes` may be taken, most of what is free where that is None. ValueError for both budgets,
    budgets that are not positive, and effects that are not known or both forced and skipped. Less than a second for
    50,000 vertices once mesh and reflectance are known.
    """
    check_effects(force, skip)
    if error is not None and time_ms is not None:
        raise ValueError("a plan has one budget: of error or of time")
    budget = 0.01 if error is None and time_ms is None else error
    for value, name in ((budget, "error"), (time_ms, "time")):
        if value is not None and not 0.0 < value < float("inf"):
            raise ValueError(f"a budget of {name} of {value} is not above 0")
    scene = scenery(mesh, brdf, environment, rotation=rotation, ground=ground, material=material, variations=variations)
    place = {"environment": environment, "environment_rotation": rotation, "ground": ground}

    def noise(depth: int) -> float:
        return probed(mesh, brdf, depth, **place)

    wishes = frozenset(force), frozenset(skip)
    return plan_of(scene, cost, budget, time_ms, *wishes, modes, pixels, frames, memory_bytes, noise, aspect)


def check_effects(force: Collection[str], skip: Collection[str]) -> None:
    """ValueError for names that are no effects, and for one that is in both."""
    for name in (*force, *skip):
        if name not in EFFECTS:
            raise ValueError(f"{name!r} is no effect; known are {', '.join(EFFECTS)}")
    both = sorted(set(force) & set(skip))
    if both:
        raise ValueError(f"{both[0]} cannot be forced and skipped at once")


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
    memory_bytes: int | None = None,
    noise: Callable[[int], float] | None = None,
    aspect: float = 1.0,
) -> EffectsPlan:
    """As `plan`, of a scene that has been looked at.

    `noise` tells that of a reference of one sample, by the points of the surface that light may touch; without it there
    is no reference to choose.
    """
    if frames < 1:
        raise ValueError(f"{frames} frames are too few")
    _check_varied(scene, force, skip)
    found = estimates(scene)
    room = int(MEMORY_SHARE * psutil.virtual_memory().available) if memory_bytes is None else memory_bytes
    offers = _Choices(scene, found, cost, force, skip, modes, pixels, frames, noise, aspect)
    choices = [each for each in offers.all(error) if each.cost.memory_bytes <= room]
    if not choices:
        raise ValueError(f"no mode is left to choose from in {room / 1e9:.2g} GB of memory")
    offered = [each for each in choices if not each.is_slow] or choices
    chosen, satisfied = _best(offered, error, None if time_ms is None else 1e-3 * time_ms)
    slow = None if satisfied or error is None else _slow_reference(choices, error)
    effects = tuple(_effect(name, found[name], chosen, offers, force, skip) for name in EFFECTS)
    told = (chosen.setting, chosen.error, chosen.cost, satisfied, scene.sample.free_share)
    return EffectsPlan(effects, *told, slow, scene.mean)


def _check_varied(scene: Scenery, force: frozenset[str], skip: frozenset[str]) -> None:
    """ValueError where effects that the model itself does not have are forced on parameters of it that vary."""
    if scene.varied is None or "spatially-varying-gloss" in skip:
        return
    absent = {"glossy": is_diffuse(scene.brdf), "anisotropy": scene.brdf.isotropic}
    for name in force & absent.keys():
        if absent[name]:
            raise ValueError(f"{name} cannot be forced on a reflectance that varies and does not have it")


def _best(choices: list[_Choice], error: float | None, time_s: float | None) -> tuple[_Choice, bool]:
    if time_s is not None:
        within = [each for each in choices if each.cost.frame_s <= time_s]
        if within:
            return min(within, key=lambda each: (each.error, each.price)), True
        return min(choices, key=lambda each: (each.cost.frame_s, each.error)), False
    for each in sorted(choices, key=lambda each: each.rank):
        if error is not None and each.error <= error:
            return each, True
    least = min(each.error for each in choices)
    return min((each for each in choices if each.error <= AS_NEAR * least), key=lambda each: each.rank), False


def _slow_reference(choices: list[_Choice], error: float) -> SlowReference | None:
    """The quickest of the references that nobody waits for, but that meet a budget of error."""
    meeting = [each for each in choices if each.is_slow and each.error <= error]
    if not meeting:
        return None
    best = min(meeting, key=lambda each: each.cost.frame_s)
    return SlowReference(best.setting["samples"], _depth(best.skipped), best.error, best.cost.frame_s)


class _Choices:
    """Every way to draw a scene."""

    def __init__(
        self,
        scene: Scenery,
        found: Mapping[str, Estimate],
        cost: CostModel,
        force: frozenset[str],
        skip: frozenset[str],
        modes: Collection[str] | None,
        pixels: int,
        frames: int,
        noise: Callable[[int], float] | None,
        aspect: float,
    ) -> None:
        self._scene, self._found, self._cost, self._pixels = scene, found, cost, pixels
        looked = scene.sample
        self._rays = rays_of(looked.of)
        camera = frame(looked.surface.positions[: looked.model_vertices], aspect)
        self._covered, self._shaded = (tell(looked.of.caster, camera, aspect) for tell in (covered, shaded))
        self._frames, self._noise = frames, noise
        self._force, self._skip, self._modes = force, skip, modes
        self._errors: dict[tuple[bool, bool], ModeErrors] = {}
        colours = albedos(scene.brdf).mean
        self._coloured = bool((abs(colours - colours[0]) > 1e-9).any())

    def all(self, error: float | None) -> Iterator[_Choice]:
        for skipped in self._skipped_sets(error):
            for setting in self._settings(skipped):
                yield self.choice(setting, skipped)
            if self._noise is not None:
                for setting in self._references(skipped, error):
                    yield self.choice(setting, skipped)

    def choice(self, setting: Setting, skipped: frozenset[str]) -> _Choice:
        told = partial(self._error, setting, skipped)
        return _Choice(setting, skipped, told, self.cost(setting, skipped), self._frames)

    def cost(self, setting: Setting, skipped: frozenset[str], asked: frozenset[str] = frozenset()) -> Cost:
        """What `setting` costs; with `asked`, effects that the scene may not have, but that are worked out."""
        load = self._load(skipped, asked | self._force)
        found = self._cost.predict(setting, self._vertices, self._pixels, load=load)
        if self._scene.varied is None or "spatially-varying-gloss" in skipped or setting.mode not in BAKED:
            return found
        return replace(found, bake_s=found.bake_s + VARIED_S)

    def estimated(self, effect: str) -> float:
        return self._found[effect].error_rel

    @property
    def _vertices(self) -> int:
        return len(self._scene.sample.surface.positions)

    def _skipped_sets(self, error: float | None) -> Iterator[frozenset[str]]:
        """Sets of effects to leave out, each with those before and the next larger one."""
        least = {name for name, each in self._found.items() if each.error_rel == 0.0}
        always = frozenset(((least | self._skip) - self._force) - {"all-frequency-light"})
        if not self._varies("gaussian", always):  # what is left out for the user leaves no parameters that could vary
            always |= {"spatially-varying-gloss"} - self._force
        yield always
        rest = sorted((each.error_rel, name) for name, each in self._found.items() if name not in always | self._force)
        total, skipped = 0.0, always
        for value, name in rest:
            if name == "all-frequency-light":
                continue
            total += value
            if error is not None and total > SHARE * error:
                return
            skipped = skipped | {name}
            yield skipped

    def _settings(self, skipped: frozenset[str]) -> Iterator[Setting]:
        """What may be chosen where `skipped` is left out."""
        bounces = int("interreflection" not in skipped)
        for order in KNOBS["sh"]["order"].ladder:
            yield from self._allowed(skipped, Setting("sh", {"order": order, "interreflection": bounces}))
        for terms in (1,) if self._diffuse(skipped) else KNOBS["wavelet"]["terms"].ladder:
            for kept in KNOBS["wavelet"]["coefficients"].ladder:
                for cube in KNOBS["wavelet"]["cube"].ladder:
                    knobs = {"terms": terms, "coefficients": min(kept, 6 * int(cube) ** 2), "cube": cube}
                    yield from self._allowed(skipped, Setting("wavelet", knobs))
        for lobes in KNOBS["gaussian"]["lobes"].ladder:
            yield from self._allowed(skipped, Setting("gaussian", {"lobes": lobes, "interreflection": bounces}))
        mode = "direct" if "mesostructure" in skipped else "shading-map"
        for directions in (4, 16, 64, 256):
            yield from self._allowed(skipped, Setting(mode, {"directions": directions}))

    def _allowed(self, skipped: frozenset[str], setting: Setting) -> Iterator[Setting]:
        low = setting.mode == "sh" and setting["order"] <= LOW_ORDER
        if not self._varies(setting.mode, skipped):
            return
        if self._modes is not None and setting.mode not in self._modes:
            return
        if ("all-frequency-light" in self._force and low) or ("all-frequency-light" in self._skip and not low):
            return
        unshaded = "self-shadowing" in skipped and self.estimated("self-shadowing") > 0.0
        if setting.mode == "wavelet" and (unshaded or not self._mode_errors(frozenset()).knows("wavelet")):
            return
        if setting.mode == "gaussian" and (unshaded or not self._is_for_gaussians(skipped)):
            return
        if setting.mode in ("direct", "shading-map") and {"self-shadowing", "interreflection"} & self._force:
            return
        if "interreflection" in self._force and not _bounces(setting, skipped):
            return
        yield setting

    def _references(self, skipped: frozenset[str], error: float | None) -> Iterator[Setting]:
        """The reference with samples that bring its noise below what the budget leaves for it, or in steps."""
        knob = KNOBS["reference"]["samples"]
        unshaded = "self-shadowing" in skipped and self.estimated("self-shadowing") > 0.0
        if unshaded or not self._varies("reference", skipped):
            return
        if self._noise is None or (self._modes is not None and "reference" not in self._modes):
            return
        steps: tuple[int | float, ...] = knob.ladder
        if error is not None:
            left = error - self._missing(Setting("reference"), skipped)
            wanted = (self._noise(_depth(skipped)) / left) ** 2 if left > 0.0 else math.inf
            steps = (min(max(math.ceil(min(wanted * (1.0 + 1e-9), knob.high)), knob.low), knob.high),)
        for samples in steps:
            yield Setting("reference", {"samples": samples})

    def _varies(self, mode: str, skipped: frozenset[str]) -> bool:
        """Whether a mode shows how the reflectance varies, where it does and `skipped` does not hold that.

        What vertices have of their own are parameters of a model: a mean, or a model that is cut, has none.
        """
        own = self._scene.varied
        if own is None or "spatially-varying-gloss" in skipped:
            return True
        left_out = {"glossy", "anisotropy"} & skipped | {"fresnel", "retro-reflection"} & self._skip
        if any(self.estimated(name) > 0.0 for name in left_out):
            return False
        return mode == "gaussian" or (mode == "sh" and len(own.variations) <= MOST_VARIATIONS)

    def _is_for_gaussians(self, skipped: frozenset[str]) -> bool:
        """Whether the reflectance that is left has a model's own parts, without which nothing is cut into lobes."""
        changed = skipped - {name for name in skipped if self.estimated(name) == 0.0}
        if changed & {"glossy", "anisotropy", "fresnel", "retro-reflection"}:
            return False
        if {"glossy", "anisotropy"} & self._force and (
            is_diffuse(self._scene.brdf) or ("anisotropy" in self._force and self._scene.brdf.isotropic)
        ):
            return False
        return self._mode_errors(frozenset()).knows("gaussian")

    def _diffuse(self, skipped: frozenset[str]) -> bool:
        return is_diffuse(self._scene.brdf) or "glossy" in skipped

    def _mode_errors(self, skipped: frozenset[str]) -> ModeErrors:
        """Of the scene, or of the matt one that is left without gloss."""
        flat = "glossy" in skipped and not is_diffuse(self._scene.brdf)
        even = self._scene.varied is not None and "spatially-varying-gloss" in skipped
        if (flat, even) not in self._errors:
            scene = self._scene
            if flat or even:
                scene = (scenery_without_gloss if flat else scenery_of_the_mean)(scene)
            self._errors[flat, even] = mode_errors(scene)
        return self._errors[flat, even]

    def _error(self, setting: Setting, skipped: frozenset[str]) -> float:
        missing = self._missing(setting, skipped)
        if setting.mode == "reference" and self._noise is not None:
            return self._noise(_depth(skipped)) / math.sqrt(setting["samples"]) + missing
        return self._mode_errors(skipped).of(setting) + missing

    def _missing(self, setting: Setting, skipped: frozenset[str]) -> float:
        """What the effects add that the setting does not show."""
        missing = {name: self._found[name].error_rel for name in skipped if name != "all-frequency-light"}
        if not _bounces(setting, skipped):
            missing["interreflection"] = self._found["interreflection"].error_rel
        if setting.mode in ("direct", "shading-map"):
            missing["self-shadowing"] = self._found["self-shadowing"].error_rel
            missing.pop("sun-split", None)
        if setting.mode != "shading-map":
            missing["mesostructure"] = self._found["mesostructure"].error_rel
        if setting.mode != "wavelet":
            missing.pop("sun-split", None)
        return sum(missing.values())

    def _load(self, skipped: frozenset[str], asked: frozenset[str]) -> Load:
        sample_ = self._scene.sample
        occluded = 1.0 if "self-shadowing" in asked else 1.0 - sample_.free_share
        return Load(
            self._vertices,
            self._pixels,
            len(sample_.surface.faces),
            0.0 if "self-shadowing" in skipped else occluded,
            self._diffuse(skipped) and "glossy" not in asked,
            (bool(self._scene.brdf.isotropic) and "anisotropy" not in asked) or "anisotropy" in skipped,
            self._coloured,
            closed=self._rays.closed,
            covered=self._covered,
            shaded=self._shaded,
            visibility=self._rays.visibility,
            ray_scale=self._cost.ray_scale(self._rays),
            lamps=len(sample_.lamp_direction) if "sun-split" not in skipped else 0,
            texels=math.prod(sample_.light.whole.radiance.shape[:2]),
            depth=_depth(skipped),
            ground=self._vertices - sample_.model_vertices,
        )


def _bounces(setting: Setting, skipped: frozenset[str]) -> bool:
    """Whether pictures have light from the model itself."""
    if setting.mode == "reference":
        return "interreflection" not in skipped
    return bool(setting.knobs.get("interreflection"))


def _depth(skipped: frozenset[str]) -> int:
    """Points of the surface that light of the reference may touch."""
    return 1 if "interreflection" in skipped else REFERENCE_DEPTH


@lru_cache(maxsize=8)
def scenery_without_gloss(scene: Scenery) -> Scenery:
    """The same with the matt reflectance of equal albedo."""
    return seen_as(matt(scene.brdf), scene.sample, scene.fine, scene.bounced, scene.material)


@lru_cache(maxsize=8)
def scenery_of_the_mean(scene: Scenery) -> Scenery:
    """The same with one reflectance for the whole surface."""
    return seen_as(scene.brdf, scene.sample, scene.fine, scene.bounced, scene.material)


def _effect(
    name: str,
    estimate: Estimate,
    chosen: _Choice,
    offers: _Choices,
    force: frozenset[str],
    skip: frozenset[str],
) -> Effect:
    shown = name not in chosen.skipped
    setting = chosen.setting
    if name == "all-frequency-light":
        shown = not (setting.mode == "sh" and setting["order"] <= LOW_ORDER)
    elif (name in ("self-shadowing", "interreflection") and setting.mode in ("direct", "shading-map")) or (
        name == "interreflection" and not _bounces(setting, chosen.skipped)
    ):
        shown = False
    elif name == "mesostructure":
        shown = setting.mode == "shading-map"
    if name in force:
        decision = "forced on"
    elif name in skip:
        decision = "forced off"
    else:
        decision = "needed" if shown else "skipped"
    saves_s, saves_bytes = _savings(name, chosen, offers)
    return Effect(name, decision, _reason(estimate, decision, chosen), estimate.error_rel, saves_s, saves_bytes)


def _reason(estimate: Estimate, decision: str, chosen: _Choice) -> str:
    if estimate.error_rel == 0.0 or decision.startswith("forced"):
        return estimate.text
    if estimate.effect == "all-frequency-light":
        return f"{estimate.text} The plan as a whole is off by {percent(chosen.error)}."
    if decision == "skipped" and estimate.effect not in chosen.skipped:
        return f"{estimate.text} The mode {chosen.setting.mode} does not show it."
    return estimate.text


def _savings(name: str, chosen: _Choice, offers: _Choices) -> tuple[float, int]:
    """Seconds of the bake and bytes of the file that leaving the effect out saves, beside the chosen setting."""
    setting = chosen.setting
    if name == "all-frequency-light":
        if setting.mode not in BAKED:
            return 0.0, 0
        low = Setting("sh", {"order": LOW_ORDER})
        high = Setting("sh", {"order": 15}) if setting.mode == "sh" and setting["order"] <= LOW_ORDER else setting
        without, with_it = offers.cost(low, chosen.skipped), offers.cost(high, chosen.skipped)
    elif name not in COSTING or setting.mode not in BAKED:
        return 0.0, 0
    elif name == "interreflection":
        if "interreflection" not in setting.knobs:
            setting = Setting("sh")
        without = offers.cost(setting.replaced(interreflection=0), chosen.skipped | {name})
        with_it = offers.cost(setting.replaced(interreflection=1), chosen.skipped - {name})
    else:
        asked = frozenset({name}) if offers.estimated(name) == 0.0 else frozenset()
        without = offers.cost(setting, chosen.skipped | {name})
        with_it = offers.cost(setting, chosen.skipped - {name}, asked)
    return max(0.0, with_it.bake_s - without.bake_s), max(0, with_it.size_bytes - without.size_bytes)


def brdf_of(chosen: EffectsPlan, brdf: Any) -> Any:
    """The reflectance that the plan draws: without what it leaves out, and as general as what is forced on needs."""
    if chosen.mean:
        if chosen.shows("spatially-varying-gloss"):
            return brdf
        brdf = with_parameters(brdf, dict(chosen.mean))
    diffuse = is_diffuse(brdf)
    if chosen.decision("glossy") == "forced on":
        return GlossyLambert(brdf.albedo) if diffuse else brdf
    if not diffuse and not chosen.shows("glossy"):
        return matt(brdf)
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
