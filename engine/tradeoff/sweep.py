"""Measures many settings on one scene against one reference, the quick ones first, within a number of seconds.

Settings that are one for the scene are measured once. First a rough reference; then what somebody asks for first, as
the choice of a plan, and the cheapest setting of every mode; then what is expected to lower the error most below the
best that is known at its price, for the seconds that it takes (`engine.tradeoff.expect`), or, where nothing is
expected, images without a bake and then bakes, coarse ones first; what is left of the time refines the reference, and
all errors are measured anew. What is under way when the time is over is left out: its error is extrapolated from those
that were measured, and of a mode of which none was, from a small image. Every step from the first image on carries the
`Tradeoff` so far.

The one reference that all settings are measured against, refined as far as there is time.

Its noise is taken off every error and stated as their uncertainty (`engine.accuracy.compare.error_against`). Only
pixels count that the model covers completely, in the reference and in an image drawn of it: silhouettes, which each
method places a little differently, do not.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.accuracy.compare import ErrorEstimate, comparison, error_against, error_against_parts, noise_of
from engine.core.cached import cached_property
from engine.core.errors import UsageError
from engine.core.figure_text import percent
from engine.core.steps import Step, Steps, drain, part
from engine.core.stopwatch import shortest
from engine.core.summary import Summary
from engine.geometry.backs import with_backs
from engine.planning.bake_group import (
    Bake,
    Factors,
    LeftOut,
    bake_alone,
    bake_group,
    relight_transport,
    too_long,
)
from engine.planning.costs.cost_model import CostModel
from engine.planning.costs.setting import Setting, parameters_of
from engine.planning.small_images import measure_small
from engine.render.path import check_scene
from engine.render.reference import BYTES_PER_PIXEL, ReferenceImage, reference
from engine.scene.mode import MODES, is_traced
from engine.scene.scene import Scene, Source
from engine.shading.directional.planes import DirectionalMap
from engine.shading.power_law import PowerLawMap
from engine.tradeoff.agenda import effort_of, in_order, quick_first, reduce
from engine.tradeoff.draw import LONG_ENOUGH_S, SAMPLES, Drawer, drawing, find_shown_vertices
from engine.tradeoff.expect import Expectations, Expected, measure_worth, price
from engine.tradeoff.front import break_even_frames, effort, front, rises
from engine.tradeoff.point import Point
from engine.tradeoff.predict import Predictions
from engine.transport import method as transport
from engine.transport.wavelet.bake import factors_for

#: Coverage from which a pixel is taken to be covered completely.
COVERED = 0.999

#: Passes from which the variance between them is believed, and where it is only a first glance.
PASSES, FEW_PASSES = 8, 3

#: Noise, relative to the image, below which the reference is not refined any further, and samples at most.
QUIET, MAX_SAMPLES = 0.002, 1 << 14


@dataclass(frozen=True, eq=False)
class NoisyReference:
    """A reference, the mask (height, width) of what is compared, and its noise as relative RMSE."""

    reference: ReferenceImage
    mask: NDArray[np.bool_]
    noise: float

    def error(self, image: NDArray[np.float32]) -> ErrorEstimate:
        parts = self.reference.parts
        if parts is not None:
            return error_against_parts(image, parts, self.mask)
        return error_against(image, self.reference.image, self._variance, self.mask)

    def flip(self, image: NDArray[np.float32]) -> Steps[float]:
        """Mean ꟻLIP of an image against it."""
        return (yield from comparison(image, self.reference.image, self.mask)).flip

    @property
    def _variance(self) -> NDArray[np.float64]:
        variance = self.reference.variance
        assert variance is not None
        return variance


class Refining:
    """A reference under way. `refine` goes on where it stopped; `close` ends it."""

    def __init__(self, scene: Scene, size: tuple[int, int], max_depth: int, seed: int) -> None:
        self._steps = reference(scene, size, samples=None, max_depth=max_depth, seed=seed)
        self.covered = np.ones((size[1], size[0]), np.bool_)
        self.found: ReferenceImage | None = None

    def refine(self, seconds: float, noise: float = QUIET, passes: int = PASSES) -> Steps[NoisyReference]:
        """Take samples for so many seconds, or until the noise is low; at least so many `passes`.

        UsageError where nothing is covered.
        """
        started = time.monotonic()
        while True:
            step = next(self._steps)
            if step.partial is not None:
                self.found = step.partial
                if self._is_known(self.found, passes) and self._is_enough(started, seconds, noise):
                    return self.current()
            passed = (time.monotonic() - started) / max(seconds, 1e-9)
            yield Step(min(1.0, passed), "refining the reference")

    def _is_known(self, found: ReferenceImage, passes: int) -> bool:
        return found.passes >= passes and found.variance is not None

    def _is_enough(self, started: float, seconds: float, noise: float) -> bool:
        assert self.found is not None
        late = time.monotonic() - started >= seconds
        return late or self.found.samples >= MAX_SAMPLES or self.current().noise <= noise

    def current(self) -> NoisyReference:
        """As far as it is now."""
        found = self.found
        assert found is not None
        assert found.variance is not None
        mask = self.covered & (found.image[..., 3] >= COVERED)
        if not mask.any():
            raise UsageError("no pixel is covered completely: the image is too small, or the model is out of sight")
        return NoisyReference(found, mask, noise_of(found.image, found.variance, mask))

    def close(self) -> None:
        self._steps.close()


#: Shares of the time that the first reference and the last refinement of it may take.
FIRST, LAST = 0.15, 0.2

#: Share of the time in which modes without a bake are measured after the first settings, where there are others.
AT_ONCE = 0.25

#: The reference may take so many seconds beforehand at most, and so many at the end.
FIRST_S, LAST_S = 20.0, 60.0

#: Seconds that any setting takes beside its bake and its image.
AT_LEAST_S = 0.5

#: Radians by which the light is rotated to see what relighting takes.
TURN = 0.1

#: Runs of the relighting that is timed.
RELIGHTS = 3

#: The reference that is measured as a setting draws other random numbers than the one that it is measured against.
OTHER_SEED = 7919


@dataclass(frozen=True, eq=False, repr=False)
class Tradeoff(Summary):
    """Result of a sweep.

    Attributes
    ----------
    points : in the order in which they were measured.
    left_out : settings that were not, with the reason.
    noise : of the reference, as relative RMSE; samples : of each of its pixels.
    device : what drew the images. size : (width, height). time_s : that it all took.
    baked : share of the vertices that were baked, those that the images show; times of bakes are stated for all.
    expected : errors and costs of settings that were left out, extrapolated.
    """

    points: tuple[Point, ...]
    left_out: tuple[LeftOut, ...]
    noise: float
    samples: int
    device: str
    size: tuple[int, int]
    time_s: float
    baked: float = 1.0
    expected: tuple[Expected, ...] = ()

    def break_even(self, point: Point) -> int | None:
        """Frames after which the bake of `point` has paid off; see `engine.tradeoff.front`."""
        return break_even_frames(point, effort(self.points))

    @property
    def break_even_frames(self) -> tuple[int, Point] | None:
        """The fewest frames after which a bake on the front of error against frame time has paid off, and which."""
        found = [(frames, point) for point in front(self.points) if (frames := self.break_even(point)) is not None]
        return min(found, key=lambda each: each[0], default=None)

    def not_monotone(self, mode: str, parameter: str) -> list[tuple[Point, Point]]:
        """Neighbours along the sweep of one parameter, all else equal, whose error rises where it should fall."""
        return [pair for points in self.sweeps(mode, parameter) for pair in rises(points)]

    def sweeps(self, mode: str, parameter: str) -> list[list[Point]]:
        """Points that differ in one parameter only, coarse first: as many sweeps as the others have values."""
        return sweeps_of(self.points, mode, parameter)

    def summary(self) -> dict[str, Any]:
        """Return what `repr` says."""
        width, height = self.size
        facts = {"points": len(self.points), "on_front": len(front(self.points)), "not_measured": len(self.left_out)}
        return {**facts, "size": f"{width} × {height} px", "time": f"{self.time_s:.3g} s", "device": self.device}


def sweeps_of(points: Sequence[Point], mode: str, parameter: str) -> list[list[Point]]:
    """Points of a mode that differ in one parameter only, each sweep in the order of its values, of at least two
    steps."""
    steps = parameters_of(mode)[parameter].sweep
    found: dict[tuple[object, ...], list[Point]] = {}
    for point in points:
        if point.mode == mode:
            others = tuple(value for name, value in point.parameters.items() if name != parameter)
            found.setdefault(others, []).append(point)
    coarse_first = steps[0] <= steps[-1]
    ordered = (
        sorted(some, key=lambda point: point.parameters[parameter], reverse=not coarse_first) for some in found.values()
    )
    return [some for some in ordered if len(some) > 1]


def sweep(
    scene: Scene,
    settings: Sequence[Setting],
    size: tuple[int, int] = (320, 240),
    *,
    seconds: float = 120.0,
    max_depth: int = 1,
    seed: int = 0,
    costs: CostModel | None = None,
    first: Sequence[Setting] = (),
) -> Steps[Tradeoff]:
    """Measure `settings` on `scene` in images of `size` (width, height), in about so many `seconds`, some `first`.

    `max_depth` is the number of points of the surface that light of the reference may touch. With `costs` every point
    has what they predict of it. ValueError where the scene has no reference, or shows nothing; UsageError for lights
    near the model, which not all modes show.
    """
    check_scene(scene)
    if scene.near_lamps:
        raise UsageError("a sweep compares modes of which some show no light near the model; leave near_lamps out")
    scene = dataclasses.replace(scene, mesh=with_backs(scene.mesh, scene.ground))
    with closing(Refining(scene, size, max_depth, seed)) as refining, drawing(size) as drawer:
        run = _Run(scene, size, refining, drawer, seconds, max_depth, seed, costs)
        yield from _without_images(run.measure(settings, first))
        return run.result()


def _without_images(steps: Steps[None]) -> Steps[None]:
    """The same steps, never going back, with no `partial` but a `Tradeoff`."""
    done = 0.0
    with closing(steps):
        for step in steps:
            done = max(done, step.done)
            yield Step(done, step.note, step.partial if isinstance(step.partial, Tradeoff) else None)


@dataclass(frozen=True, eq=False)
class _Measured:
    """A point with the image that its error is measured on anew."""

    point: Point
    image: NDArray[np.float32]


@dataclass(eq=False)
class _Run:
    """One sweep under way: what is asked for, and what was found so far."""

    scene: Scene
    size: tuple[int, int]
    refining: Refining
    drawer: Drawer
    seconds: float
    max_depth: int
    seed: int
    costs: CostModel | None
    started: float = field(default_factory=time.monotonic)
    found: list[_Measured] = field(default_factory=list)
    left_out: list[LeftOut] = field(default_factory=list)
    reference: NoisyReference | None = None
    has_bakes: bool = False
    factors: Factors = field(default_factory=dict)
    baked: float = 1.0
    measuring_s: float = 0.0
    at_once: float = AT_ONCE
    expected: list[Expected] = field(default_factory=list)

    @cached_property
    def shown(self) -> NDArray[np.int64]:
        """The vertices that images need."""
        found = find_shown_vertices(self.scene, self.size, SAMPLES)
        self.baked = len(found) / len(self.scene.surface.positions)
        return found

    @cached_property
    def predictions(self) -> Predictions | None:
        """Predictions of the cost model; None without one."""
        if self.costs is None:
            return None
        return Predictions(self.costs, self.scene, self.size, SAMPLES, self.max_depth)

    @cached_property
    def expectations(self) -> Expectations | None:
        """Expected errors of settings; None without costs, and of a scene that no plan is made of."""
        if self.costs is None or self.scene.environment is None or self.scene.irradiance != 1.0:
            return None
        return Expectations(self.scene, self.max_depth)

    def left_s(self, share: float = 1.0) -> float:
        """Seconds until `share` of the time has passed."""
        return share * self.seconds - (time.monotonic() - self.started)

    def result(self) -> Tradeoff:
        noisy = self.reference
        return Tradeoff(
            tuple(each.point for each in self.found),
            tuple(self.left_out),
            noisy.noise if noisy else 0.0,
            noisy.reference.samples if noisy else 0,
            self.drawer.device,
            self.size,
            time.monotonic() - self.started,
            self.baked,
            tuple(self.expected),
        )

    def measure(self, settings: Sequence[Setting], first: Sequence[Setting] = ()) -> Steps[None]:
        """Everything, quick settings first."""
        plain = dataclasses.replace(self.scene, material=None, relit=None, directions=4)
        covered = yield from part(self.drawer.draw(plain), 0.0, 0.01)
        self.started = time.monotonic()  # modules are imported and kernels are there
        self.refining.covered = covered.image[..., 3] >= 0.999
        first_s = min(FIRST * self.seconds, FIRST_S)
        self.reference = yield from part(self.refining.refine(first_s, 10.0 * QUIET, FEW_PASSES), 0.01, FIRST)
        asked = yield from self._distinct([*first, *settings])
        leaders = list(dict.fromkeys([*asked[: len(set(first))], *self._cheapest(asked)]))
        early, late = quick_first(leaders, self._bake_s), in_order([each for each in asked if each not in leaders])
        self.has_bakes = any(job[0].mode in transport.names() for job in (*early, *late))
        weights = [4 if job[0].mode in transport.names() else 1 for job in (*early, *late)]
        done, share = FIRST, (1.0 - FIRST - LAST) / max(sum(weights), 1)
        for number, weight in enumerate(weights):
            job = early[number] if number < len(early) else self._take_best(late)
            is_early = number < len(early)
            if is_early or not self.has_bakes:
                self.at_once = 1.0 - LAST
            elif number == len(early):
                self.at_once = min(1.0 - LAST, AT_ONCE + 1.0 - self.left_s() / self.seconds)
            yield from part(self._in_time(job, self._job(job)), done, done + weight * share)
            done += weight * share
        if self.found:
            yield from part(self._again(), 1.0 - LAST, 1.0)
            yield from self._extrapolate()

    def _take_best(self, jobs: list[list[Setting]]) -> list[Setting]:
        """The job that is worth most for its seconds, taken out of `jobs`; the first where nothing is expected."""
        if self.expectations is None or not self.found:
            return jobs.pop(0)
        return jobs.pop(max(range(len(jobs)), key=lambda number: self._measure_worth(jobs[number])))

    def _measure_worth(self, job: Sequence[Setting]) -> float:
        """Expected fall of errors for each second of a job; what takes longer than there is time for comes last."""
        assert self.expectations is not None
        points, total = [each.point for each in self.found], 0.0
        bake_s = max(self._bake_s(each) for each in job) * self.baked
        seconds = bake_s + sum(self._predict(each).get("frame_s", 0.0) for each in job) + AT_LEAST_S
        for each in job:
            error, cost = self.expectations.expect(each, points), self._predict(each)
            if error is not None:
                total += measure_worth(error, price(cost.get("frame_s", 0.0), cost.get("bake_s", 0.0)), points)
        return total / seconds - (seconds if seconds > self.left_s(1.0 - LAST) else 0.0)

    def _extrapolate(self) -> Steps[None]:
        """Errors of what was left out; a mode of which nothing was measured gets a small image of its cheapest."""
        if self.expectations is None:
            return
        points = [each.point for each in self.found]
        left_out = list(dict.fromkeys(each.setting for each in self.left_out if not is_traced(each.setting.mode)))
        without = {each.mode for each in left_out} - {each.mode for each in points}
        for mode in filter(self.expectations.can_draw, without):
            cheapest = self._cheapest([each for each in left_out if each.mode == mode])
            yield self._step(f"a small image of {cheapest[0]}")
            self.expectations.small.update(drain(measure_small(self.scene, cheapest, seed=self.seed)))
        for setting in left_out:
            error = self.expectations.expect(setting, points)
            if error is not None:
                self.expected.append(Expected(setting, error.median, error.interval, self._predict(setting)))
        yield self._step("measured")

    def _distinct(self, settings: Sequence[Setting]) -> Steps[list[Setting]]:
        """The settings, those that are one for this BRDF named by the least of their parameters, each once."""
        most = max((each["terms"] for each in settings if "terms" in each.parameters), default=1)
        if most > 1:
            if most not in self.factors:
                self.factors[most] = yield from factors_for(self.scene.brdf, most, signs="signed")
            most = self.factors[most].terms
        return list(dict.fromkeys(reduce(each, most) for each in settings))

    def _cheapest(self, settings: Sequence[Setting]) -> list[Setting]:
        """One setting of each mode: that which costs least, as far as it can be predicted."""

        def cost(setting: Setting) -> tuple[float, ...]:
            predicted = self._predict(setting)
            return predicted.get("bake_s", 0.0) + predicted.get("frame_s", 0.0), *setting.parameters.values()

        modes = dict.fromkeys(each.mode for each in settings)
        return [min((each for each in settings if each.mode == mode), key=cost) for mode in modes]

    def _job(self, job: Sequence[Setting]) -> Steps[None]:
        return self._group(job) if job[0].mode in transport.names() else self._find_unbaked(job[0])

    def _in_time(self, job: Sequence[Setting], steps: Steps[None]) -> Steps[None]:
        """The steps until the time for measuring is over; of the job, what is not measured by then is left out."""
        with closing(steps):
            for step in steps:
                yield step
                if self.found and self.left_s(1.0 - LAST) <= 0.0:
                    reported = {each.point.setting for each in self.found} | {each.setting for each in self.left_out}
                    self._too_late([each for each in job if each not in reported], 1.0 - LAST)
                    return

    def _step(self, note: str) -> Step:
        return Step(0.0, note, self.result())

    def _too_late(self, settings: Sequence[Setting], share: float, takes_s: float = 0.0) -> bool:
        """True if less than `takes_s` is left of a share of the time; the settings are then left out."""
        if self.left_s(share) > takes_s:
            return False
        self.left_out += [LeftOut(setting, self._why(setting, takes_s)) for setting in settings]
        return True

    def _why(self, setting: Setting, takes_s: float) -> str:
        """Why there was no time for a setting: seconds that it takes, as far as something is known of them."""
        predicted = self._predict(setting)
        if predicted.get("bake_s", 0.0) > 0.0:
            return too_long(predicted["bake_s"])
        takes_s = takes_s or predicted.get("frame_s", 0.0)
        return too_long(takes_s, "its image") if takes_s > 0.0 else "the time was over"

    def _find_unbaked(self, setting: Setting) -> Steps[None]:
        if self.found and self._too_late([setting], self.at_once, self._estimate_seconds(setting)):
            return
        if is_traced(setting.mode):
            yield from self._reference(setting)
            return
        scene = scene_of(setting, self.scene)
        rotated = dataclasses.replace(scene, environment_rotation=scene.environment_rotation + TURN)
        relight_s = shortest(lambda: dataclasses.replace(rotated).lights, RELIGHTS, LONG_ENOUGH_S)
        drawn = yield from self.drawer.draw(scene)
        held = scene.lights.direction.nbytes + scene.lights.irradiance.nbytes + _material_bytes(scene)
        yield from self._add(setting, drawn.image, drawn.frame_s, relight_s, 0.0, held, 0)

    def _estimate_seconds(self, setting: Setting) -> float:
        """Seconds that measuring a mode without a bake takes, from what less of it took."""
        before = [each.point for each in self.found if each.point.mode == setting.mode]
        frames = 1.0 if is_traced(setting.mode) else 2.5
        return frames * before[-1].frame_s * effort_of(setting) / effort_of(before[-1].setting) if before else 0.0

    def _reference(self, setting: Setting) -> Steps[None]:
        """An image of a few samples, by other random numbers than those of the reference."""
        started = time.perf_counter()
        options = {"samples": setting["samples"], "max_depth": self.max_depth, "seed": self.seed + OTHER_SEED}
        with closing(reference(self.scene, self.size, **options)) as steps:
            while True:
                try:
                    step = next(steps)
                except StopIteration as finished:
                    image = finished.value.image
                    break
                yield Step(step.done, step.note)
        frame_s = time.perf_counter() - started
        yield from self._add(setting, image, frame_s, 0.0, 0.0, self._pixel_bytes, 0)

    @property
    def _pixel_bytes(self) -> int:
        return self.size[0] * self.size[1] * BYTES_PER_PIXEL

    def _group(self, group: Sequence[Setting]) -> Steps[None]:
        if self._too_late(group, 1.0 - LAST):
            return
        left_s = self.left_s(1.0 - LAST)
        if transport.method_of(group[0].mode).shares_rays:
            making = bake_group(self.scene, group, left_s, self.shown, self.factors)
        else:
            making = bake_alone(self.scene, group[0], left_s, self.shown)
        bakes, left_out = yield from part(making, 0.0, 0.8)
        self.left_out += left_out
        for number, bake in enumerate(bakes):
            yield from part(self._bake(bake), 0.8 + 0.2 * number / len(bakes), 0.8 + 0.2 * (number + 1) / len(bakes))
        yield self._step(f"{len(self.found)} settings measured")

    def _bake(self, bake: Bake) -> Steps[None]:
        rotated = dataclasses.replace(self.scene, environment_rotation=self.scene.environment_rotation + TURN)
        yield Step(0.0, "relighting")
        relight_s = shortest(lambda: relight_transport(bake, rotated), RELIGHTS, LONG_ENOUGH_S)
        relit = relight_transport(bake, self.scene)
        scene = dataclasses.replace(self.scene, relit=relit)
        drawn = yield from self.drawer.draw(scene)
        held = bake.memory_bytes + relit.size_bytes + _material_bytes(scene)
        yield from self._add(
            bake.setting, drawn.image, drawn.frame_s, relight_s, bake.bake_s, held, bake.size_bytes, bake.another_s
        )

    def _add(
        self,
        setting: Setting,
        image: NDArray[np.float32],
        frame_s: float,
        relight_s: float,
        bake_s: float,
        memory_bytes: int,
        size_bytes: int,
        another_s: float | None = None,
    ) -> Steps[None]:
        assert self.reference is not None
        before = time.monotonic()
        flip = yield from self.reference.flip(image)
        error = self.reference.error(image)
        self.measuring_s = max(self.measuring_s, time.monotonic() - before)
        costs = (frame_s, relight_s, bake_s, int(memory_bytes), int(size_bytes))
        point = Point(setting, error.rmse_rel, flip, error.uncertainty, *costs, self._predict(setting), another_s)
        self.found.append(_Measured(point, image))
        yield self._step(f"{setting}: {percent(error.rmse_rel)}")

    def _predict(self, setting: Setting) -> dict[str, float]:
        return {} if self.predictions is None else self.predictions.of(setting)

    def _bake_s(self, setting: Setting) -> float:
        return self._predict(setting).get("bake_s", 0.0)

    def _again(self) -> Steps[None]:
        """Refine the reference until it is quiet beside the least error, and tell all errors by it."""
        assert self.reference is not None
        baked = [each.point.error_rmse_rel for each in self.found if not is_traced(each.point.mode)]
        noise = max(QUIET, 0.5 * min(baked, default=0.0))
        seconds = min(self.left_s() - len(self.found) * self.measuring_s, LAST_S)
        if self.reference.noise > noise and seconds > 0.0:
            self.reference = yield from part(self.refining.refine(seconds, noise), 0.0, 0.8)
            for number, each in enumerate(self.found):
                yield from part(self._measure_again(number, each), 0.8, 0.8 + 0.2 * (number + 1) / len(self.found))
        yield self._step("measured")

    def _measure_again(self, number: int, each: _Measured) -> Steps[None]:
        assert self.reference is not None
        error = self.reference.error(each.image)
        flip = yield from self.reference.flip(each.image)
        point = dataclasses.replace(
            each.point, error_rmse_rel=error.rmse_rel, error_uncertainty=error.uncertainty, error_flip=flip
        )
        self.found[number] = _Measured(point, each.image)


def scene_of(setting: Setting, scene: Scene) -> Scene:
    """The scene as a mode without a bake draws it."""
    drawn = dataclasses.replace(MODES[setting.mode].adapt(scene), directions=setting["directions"], relit=None)
    if "power_law" not in setting.parameters:
        return drawn
    source: Source = "power-law" if setting["power_law"] else "slices"
    return dataclasses.replace(drawn, source=source)


def _material_bytes(scene: Scene) -> int:
    shading = scene.shading
    if shading is None:
        return 0
    if isinstance(shading, DirectionalMap):
        return int(shading.planes.nbytes)
    return shading.size_bytes if isinstance(shading, PowerLawMap) else int(shading.slices.nbytes)
