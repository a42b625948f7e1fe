"""Every way to draw a scene: a setting together with the effects that it leaves out, its error and its cost.

The error is that of `engine.planning.predicted_error`, the cost the model's (`cost_model`). Effects are left out from
the least upwards.

The noise of the reference, estimated from an image of a few pixels: the samples that an error takes follow from it.

The error of a mean over n samples is that of one over √n. A thousand pixels of some samples know it to about a tenth
unless single paths carry most of the light, and an image framed by another camera may be noisier than this one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import product
from typing import TYPE_CHECKING, Any

from engine.core.cached import cached_property, remember
from engine.core.errors import UsageError
from engine.core.steps import drain
from engine.geometry.camera import Camera, frame
from engine.geometry.mesh import Mesh
from engine.planning.ceilings import Ceilings
from engine.planning.costs.cost_model import Cost, CostModel, Load
from engine.planning.costs.load import measure_closed_share, measure_coverage, shade
from engine.planning.costs.planned import planning_of
from engine.planning.costs.setting import Setting, parameters_of
from engine.planning.effects.estimates import LOW_ORDER, Estimate, Scenery
from engine.planning.effects.simplified import albedos
from engine.planning.predicted_error import PredictedErrors, depth_of, shows_bounces
from engine.planning.prior import SURE
from engine.planning.small_images import Measured
from engine.render.reference import reference
from engine.scene.mode import MODES, REFERENCE, is_traced
from engine.scene.scene import Scene
from engine.transport import method as transport
from engine.transport.sh.transfer import is_diffuse

if TYPE_CHECKING:
    from engine.brdf.brdf import Brdf

#: Side of the image, samples of each pixel, and what the noise that is found is raised by.
SIDE, SAMPLES, MARGIN = 32, 16, 1.1


@remember(8)
def probe(mesh: Mesh, brdf: Brdf, depth: int, **place: Any) -> float:
    """The relative error of a reference of one sample for each pixel, light touching up to `depth` points.

    `place` are fields of the `Scene`: its environment, ground, and so on. Remembered; some 0.1 s.
    """
    scene = Scene(mesh, frame(mesh.positions), brdf, **place)
    found = drain(reference(scene, (SIDE, SIDE), samples=SAMPLES, max_depth=depth))
    return MARGIN * (found.uncertainty_rmse_rel or 0.0) * math.sqrt(SAMPLES)


#: Frames over which a bake is spread, and over which a changed light is.
FRAMES, LIGHTS = 20_000, 50

#: Images up to which a reference is a mode as any other, and a frame may take as long as it does.
FEW_FRAMES = 1

#: Seconds of a frame that a byte which is held counts as: ten milliseconds for a gigabyte.
BYTE_S = 1e-11

#: Share of an error budget that all effects together that are left out may take.
SHARE = 0.5

#: Setting drawn if light of high frequency is left out, and the finest setting of the same kind.
LOW, HIGH = Setting("sh", {"order": LOW_ORDER}), Setting("sh", {"order": 15})

#: Numbers of directions that may be chosen, by steps of √2: each costs as much more as it has more.
DIRECTIONS = tuple(round(2.0 ** (0.5 * step)) for step in range(4, 17))

#: Pixels of an image where nobody says.
PIXELS = 720 * 760

#: Lights under which texels are drawn in baked light: those of an environment where nobody says, and faint ones.
TEXEL_LIGHTS = 64 + 12

#: Seconds of the tables of a BRDF that varies, beside the one that every bake makes.
VARIED_S = 2.0


@dataclass(frozen=True)
class Wishes:
    """Requirements on the ways to draw a scene; UsageError for fewer frames than one.

    Attributes
    ----------
    force, skip : effects that must be shown, and that must not. modes : all that may be chosen, None for any.
    pixels : of an image of `aspect`, width over height. frames : images that a bake is spread over.
    """

    force: frozenset[str] = frozenset()
    skip: frozenset[str] = frozenset()
    modes: Collection[str] | None = None
    pixels: int = PIXELS
    aspect: float = 1.0
    frames: int = FRAMES

    def __post_init__(self) -> None:
        if self.frames < 1:
            raise UsageError(f"{self.frames} frames are too few")


@dataclass(frozen=True)
class Choice:
    """A setting, what is left out, and what both come to; the error is found when it is first asked for.

    Where lights are summed, sharp ones cast shadows if `casts`; images have those of all lights that count if
    `has_shadows`.
    """

    setting: Setting
    skipped: frozenset[str]
    casts: bool
    has_shadows: bool
    predict: Callable[[], float]
    probability: Callable[[float], float]
    overrun: Callable[[float], float]
    sure: float
    cost: Cost
    frames: int

    @cached_property
    def error(self) -> float:
        return self.predict()

    def meets(self, budget: float) -> bool:
        """True if the error is within a budget, by the image of a camera almost surely."""
        return self.error <= budget and self.probability(budget) >= self.sure

    @property
    def price(self) -> float:
        """Seconds of a frame with its share of the bake and of a changed light, and what memory counts for."""
        cost = self.cost
        return cost.frame_s + cost.relight_s / LIGHTS + cost.bake_s / self.frames + BYTE_S * cost.memory_bytes

    @property
    def effort(self) -> float:
        """error² · price: half an error is worth four times the price, as it is of the reference."""
        return self.error**2 * self.price

    @property
    def rank(self) -> tuple[bool, float]:
        """Sort key of options within the budget of error, first choice first."""
        return is_traced(self.setting.mode) and self.frames > FEW_FRAMES, self.price

    def exceeded(self, ceilings: Ceilings) -> tuple[str, ...]:
        """The ceilings that it is beyond; a single image may take as long as it does."""
        found = ceilings.exceeded(self.cost)
        return found if self.frames > FEW_FRAMES else tuple(name for name in found if name != "frame_s")


@dataclass(frozen=True, eq=False)
class Choices:
    """Every way to draw a scene.

    Attributes
    ----------
    found : the estimate of each effect. noise : that of a reference of one sample, by the points of the surface that
        light may touch; without it there is no reference to choose. small : errors of small images.
    """

    scene: Scenery
    found: Mapping[str, Estimate]
    cost_model: CostModel
    wishes: Wishes
    noise: Callable[[int], float] | None
    small: Mapping[Setting, Measured] = field(default_factory=dict)

    @cached_property
    def errors(self) -> PredictedErrors:
        return PredictedErrors(self.scene, self.found, self.noise, self.small)

    @cached_property
    def _covered(self) -> float:
        return measure_coverage(self.scene.sample.of.caster, self._camera, self.wishes.aspect)

    @cached_property
    def _shaded(self) -> float:
        return shade(self.scene.sample.of.caster, self._camera, self.wishes.aspect)

    @cached_property
    def _camera(self) -> Camera:
        looked = self.scene.sample
        return frame(looked.surface.positions[: looked.model_vertices], self.wishes.aspect)

    @cached_property
    def _coloured(self) -> bool:
        colours = albedos(self.scene.brdf).mean
        return bool((abs(colours - colours[0]) > 1e-9).any())

    def all(self, error: float | None) -> Iterator[Choice]:
        for skipped in self._list_skipped_sets(error):
            for setting in self._settings(skipped):
                yield self.choice(setting, skipped)
            if self.noise is not None:
                for setting in self._references(skipped, error):
                    yield self.choice(setting, skipped)

    def choice(self, setting: Setting, skipped: frozenset[str]) -> Choice:
        predict = partial(self.errors.of, setting, skipped)
        probability = partial(self.errors.probability, setting, skipped)
        sure = SURE if self.errors.has_camera else 0.0
        overrun = partial(self.errors.overrun, setting, skipped)
        casts, has_shadows = self.errors.casts(setting, skipped), self.errors.shows_shadows(setting, skipped)
        cost = self.cost(setting, skipped)
        return Choice(
            setting, skipped, casts, has_shadows, predict, probability, overrun, sure, cost, self.wishes.frames
        )

    def cost(self, setting: Setting, skipped: frozenset[str], asked: frozenset[str] = frozenset()) -> Cost:
        """Cost of `setting`; with `asked`, effects that the scene may not have, but that are worked out."""
        load = self._load(skipped, asked | self.wishes.force)
        found = self.cost_model.predict(setting, self._vertices, self.wishes.pixels, load=load)
        if self.scene.varied is None or "spatially-varying-gloss" in skipped or setting.mode not in transport.names():
            return found
        return replace(found, bake_s=found.bake_s + VARIED_S)

    def estimate(self, effect: str) -> float:
        return self.found[effect].error_rel

    @property
    def _vertices(self) -> int:
        return len(self.scene.sample.surface.positions)

    def _list_skipped_sets(self, error: float | None) -> Iterator[frozenset[str]]:
        """Sets of effects to leave out, each with those before and the next larger one."""
        least = {name for name, each in self.found.items() if each.error_rel == 0.0}
        always = frozenset(((least | self.wishes.skip) - self.wishes.force) - {"all-frequency-light"})
        # what is left out for the user leaves no parameters that could vary
        if not any(self._varies(mode, always) for mode in transport.names()):
            always |= {"spatially-varying-gloss"} - self.wishes.force
        yield always
        rest = sorted(
            (each.error_rel, name) for name, each in self.found.items() if name not in always | self.wishes.force
        )
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
        """Settings that may be chosen if `skipped` is left out."""
        bounces = int("interreflection" not in skipped)
        for name in transport.names():
            sweeps = {parameter: each.sweep for parameter, each in parameters_of(name).items()}
            if "interreflection" in sweeps:
                sweeps["interreflection"] = (bounces,)
            turned = (dict(zip(sweeps, values, strict=True)) for values in product(*sweeps.values()))
            diffuse, planning = self._diffuse(skipped), planning_of(name)
            for setting in dict.fromkeys(planning.adapt(Setting(name, parameters), diffuse) for parameters in turned):
                yield from self._is_allowed(skipped, setting)
        for mode in MODES.values():
            if mode.spread is not None and not mode.traced and mode.shows_texels == ("mesostructure" not in skipped):
                for directions in DIRECTIONS:
                    yield from self._is_allowed(skipped, Setting(mode.name, {"directions": directions}))

    def _is_allowed(self, skipped: frozenset[str], setting: Setting) -> Iterator[Setting]:
        force, skip, modes = self.wishes.force, self.wishes.skip, self.wishes.modes
        low = is_low(setting)
        if not self._varies(setting.mode, skipped):
            return
        if modes is not None and setting.mode not in modes:
            return
        if ("all-frequency-light" in force and low) or ("all-frequency-light" in skip and not low):
            return
        unshaded = "self-shadowing" in skipped and self.estimate("self-shadowing") > 0.0
        if setting.mode in transport.names():
            if unshaded and "self-shadowing" in transport.method_of(setting.mode).always:
                return
            if not planning_of(setting.mode).suits(self, skipped):
                return
        if "self-shadowing" in force and not self.errors.shows_shadows(setting, skipped):
            return
        if "interreflection" in force and not shows_bounces(setting, skipped):
            return
        yield setting

    def _references(self, skipped: frozenset[str], error: float | None) -> Iterator[Setting]:
        """The reference with samples that bring its noise below what the budget leaves for it, or in steps."""
        parameter = parameters_of(REFERENCE.name)["samples"]
        unshaded = "self-shadowing" in skipped and self.estimate("self-shadowing") > 0.0
        if unshaded or not self._varies(REFERENCE.name, skipped):
            return
        if self.noise is None or (self.wishes.modes is not None and REFERENCE.name not in self.wishes.modes):
            return
        steps: tuple[int | float, ...] = parameter.sweep
        if error is not None:
            left = error - self.errors.left_out(Setting(REFERENCE.name), skipped)
            noise = self.errors.sure_noise * self.noise(depth_of(skipped))
            wanted = (noise / left) ** 2 if left > 0.0 else math.inf
            steps = (min(max(math.ceil(min(wanted * (1.0 + 1e-9), parameter.high)), parameter.low), parameter.high),)
        for samples in steps:
            yield Setting(REFERENCE.name, {"samples": samples})

    def _varies(self, mode: str, skipped: frozenset[str]) -> bool:
        """True if a mode shows the variation of the BRDF, or if there is none, or if `skipped` holds that effect.

        What vertices have of their own are parameters of a model: a mean, or a model that is cut, has none.
        """
        own = self.scene.varied
        if own is None or "spatially-varying-gloss" in skipped:
            return True
        left_out = {"glossy", "anisotropy"} & skipped | {"fresnel", "retro-reflection"} & self.wishes.skip
        if any(self.estimate(name) > 0.0 for name in left_out):
            return False
        return mode in transport.names() and len(own.variations) <= transport.method_of(mode).variations

    def _diffuse(self, skipped: frozenset[str]) -> bool:
        return is_diffuse(self.scene.brdf) or "glossy" in skipped

    def _load(self, skipped: frozenset[str], asked: frozenset[str]) -> Load:
        looked = self.scene.sample
        occluded = 1.0 if "self-shadowing" in asked else 1.0 - looked.unoccluded_fraction
        return Load(
            self._vertices,
            self.wishes.pixels,
            len(looked.surface.faces),
            0.0 if "self-shadowing" in skipped else occluded,
            self._diffuse(skipped) and "glossy" not in asked,
            (bool(self.scene.brdf.isotropic) and "anisotropy" not in asked) or "anisotropy" in skipped,
            self._coloured,
            closed=measure_closed_share(looked.of),
            covered=self._covered,
            shaded=self._shaded,
            lamps=len(looked.lamp_direction) if "sun-split" not in skipped else 0,
            texels=math.prod(looked.light.whole.radiance.shape[:2]),
            depth=depth_of(skipped),
            shadows=0 if "self-shadowing" in skipped else len(looked.lamp_direction),
            texel_lights=0 if "mesostructure" in skipped else TEXEL_LIGHTS,
            ground=self._vertices - looked.model_vertices,
        )


def is_low(setting: Setting) -> bool:
    """True for spherical harmonics of an order that is enough where light is of low frequency."""
    return setting.mode == LOW.mode and setting["order"] <= LOW["order"]
