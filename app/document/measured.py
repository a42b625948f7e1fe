"""Measured accuracy and time, as the project keeps them, and the settings that the window can take."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from app.document.bake_request import BakeChoices, setting_for
from app.document.document import Look
from app.document.modes import mode_named
from engine.core.figure_text import number, percent_within, size_text, time_text
from engine.core.steps import Step, Steps, part
from engine.core.stopwatch import read_clock
from engine.planning.costs.setting import Setting, parameters_of
from engine.scene.scene import Scene
from engine.tradeoff.agenda import settings_of
from engine.tradeoff.front import break_even_frames, effort
from engine.tradeoff.point import Point

if TYPE_CHECKING:
    from engine.tradeoff.sweep import Tradeoff

#: Labels of the axis of each cost, and the factors to their units.
AXES = {
    "frame": ("Frame / ms", 1e3),
    "relight": ("Relighting / ms", 1e3),
    "bake": ("Bake / s", 1.0),
    "memory": ("Memory / MB", 1e-6),
}

#: Pixels of the images that are measured, at most: ꟻLIP of more would take longer than the images.
MAX_PIXELS = 120_000

#: Parameters that are on or off, as they are called where they are on.
FLAGS = {"interreflection": "interreflection", "power_law": "power law"}


@dataclass(frozen=True, eq=False)
class Accuracy:
    """Measured points and their scene: `of` is its `scene_key`. `unmeasured` lists the settings left out, in words."""

    points: tuple[Point, ...]
    of: tuple[Any, ...]
    size: tuple[int, int]
    samples: int
    device: str
    unmeasured: tuple[str, ...] = ()

    def break_even(self, point: Point) -> int | None:
        """Frames after which the bake of `point` has paid off against the reference at equal error."""
        return break_even_frames(point, effort(self.points))

    def with_before(self, before: Accuracy | None) -> Accuracy:
        """These points, and those of an earlier sweep over other settings of the same scene and size."""
        if before is None or not same_key(before.of, self.of) or before.size != self.size:
            return self
        own = {point.setting for point in self.points}
        kept = tuple(point for point in before.points if point.setting not in own)
        return Accuracy((*kept, *self.points), self.of, self.size, self.samples, self.device, self.unmeasured)


def scene_key(scene: Scene, bounces: int) -> tuple[Any, ...]:
    """The parts of a scene that errors and times depend on, beside the setting.

    The camera is not among them, nor are lamps near the model, which `measured` leaves out.
    """
    light = (scene.environment, scene.environment_rotation, scene.irradiance, scene.lamps)
    one = () if scene.environment is not None else (scene.light,)
    tiling = (scene.repeats, scene.tiling_mode) if scene.has_texels else ()
    return (scene.mesh, scene.ground, scene.brdf, scene.material, scene.lookup, *tiling, *light, *one, bounces)


def same_key(one: tuple[Any, ...], other: tuple[Any, ...]) -> bool:
    """Values are compared; models, maps and materials have to be the same objects."""
    return len(one) == len(other) and all(a is b or a == b for a, b in zip(one, other, strict=True))


def accuracy_of(found: Tradeoff, of: tuple[Any, ...]) -> Accuracy:
    """The points that a sweep has measured so far, as the project keeps them."""
    words = tuple(f"{each.setting}: {each.reason}" for each in found.left_out)
    return Accuracy(found.points, of, found.size, found.samples, found.device, words)


def setting_of(mode: str, look: Look, choices: BakeChoices | None) -> Setting:
    """The setting that the window shows: `choices` of its bake (`app.view.baking.Baking.chosen`), None without one."""
    if choices is not None:
        return setting_for(choices)
    own = {"directions": look.directions, "power_law": int(look.source == "power-law")}
    return Setting(mode, {name: value for name, value in own.items() if name in parameters_of(mode)})


def look_with(setting: Setting, look: Look) -> dict[str, Any]:
    """The parts of a look that a setting turns, its mode among them."""
    against = look.mode if setting.mode == look.against else look.against
    parts: dict[str, Any] = {"mode": setting.mode, "against": against}
    if "directions" in setting.parameters:
        parts["directions"] = setting["directions"]
    if "power_law" in setting.parameters:
        parts["source"] = "power-law" if setting["power_law"] else "slices"
    return parts


def choices_with(setting: Setting, choices: BakeChoices) -> BakeChoices:
    """`choices` for a bake with the parameters of a setting."""
    return choices.with_values(setting.parameters)


def size_of(screen: tuple[int, int]) -> tuple[int, int]:
    """Width and height of the images that are measured for a screen of so many pixels, as nearly of its shape."""
    width, height = max(1, screen[0]), max(1, screen[1])
    most = height * min(1.0, (MAX_PIXELS / (width * height)) ** 0.5)
    rows = range(max(1, round(0.9 * most)), max(1, round(most)) + 1)
    best = min(reversed(rows), key=lambda count: abs(round(count * width / height) * height / (count * width) - 1.0))
    return max(32, round(best * width / height)), max(32, best)


def measure(
    scene: Scene,
    modes: Sequence[str],
    bases: Sequence[Setting],
    size: tuple[int, int],
    seconds: float,
    bounces: int,
) -> Steps[Tradeoff]:
    """The sweep of all sweeps of some modes, without lamps near the model, which not all of them show.

    Slow modules are imported on the thread that asks for it.
    """
    yield Step(0.0, "compiling (first use only)")
    from app.session.machine_profile import cost_model, learn_from
    from engine.tradeoff.sweep import sweep

    scene = replace(scene, near_lamps=())
    settings = settings_of(scene, modes, bases, bounces=bounces > 0)
    costs = yield from part(cost_model(), 0.0, 0.05)
    steps = sweep(scene, settings, size, seconds=seconds, max_depth=bounces + 1, costs=costs)
    since = read_clock()
    found = yield from part(steps, 0.05, 1.0)
    learn_from(found.points, since)
    return found


def setting_text(setting: Setting) -> str:
    """'SH, order 15, interreflection'."""
    parameters = [FLAGS.get(name, f"{name} {value}") for name, value in setting.parameters.items() if value]
    return ", ".join((mode_named(setting.mode).label, *parameters))


def _describe_prediction(point: Point) -> str:
    """The seconds that the cost model predicted: 'frame 8.2 ms, bake 4.1 s'."""
    words = {"frame_s": "frame", "relight_s": "relighting", "bake_s": "bake"}
    return ", ".join(f"{words[name]} {time_text(said)}" for name, said in point.predicted.items() if name in words)


def describe(point: Point, accuracy: Accuracy | None = None) -> str:
    """A point in a few lines: its setting, its error and its costs."""
    error = f"error {percent_within(point.error_rmse_rel, point.error_uncertainty)}"
    lines = [
        setting_text(point.setting),
        f"{error}, FLIP {number(point.error_flip, 3)}",
        f"frame {time_text(point.frame_s, 3)}, relighting {time_text(point.relight_s, 3)}",
        f"bake {time_text(point.bake_s, 3)}, memory {size_text(point.memory_bytes)}",
    ]
    if point.predicted:
        lines.append(f"predicted: {_describe_prediction(point)}")
    frames = accuracy.break_even(point) if accuracy is not None else None
    if frames is not None:
        lines.append(f"pays off after {frames} frame{'s' if frames != 1 else ''} against the reference")
    return "\n".join(lines)
