"""Files of a sweep: JSON, CSV, and a plot for each cost as PNG and SVG."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from engine.core.steps import Step, Steps
from engine.figures.plot import Dot, save, scatter_front
from engine.planning.costs.setting import Setting, modes, parameters_of
from engine.scene.mode import MODES
from engine.storage.atomic import make_folder, write_bytes, write_json
from engine.tradeoff.draw import ON_CPU
from engine.tradeoff.expect import Expected
from engine.tradeoff.front import front
from engine.tradeoff.point import COSTS, check
from engine.tradeoff.sweep import Tradeoff
from engine.transport import method as transport

#: Label under the axis of a cost, and the number of its units in a second or a byte.
AXES = {
    "frame": ("Time of a frame / ms", 1e3),
    "relight": ("Time to relight / ms", 1e3),
    "bake": ("Time to bake / s", 1.0),
    "memory": ("Memory / MB", 1e-6),
}


def names() -> dict[str, str]:
    """Modes as users read them, in the order in which plots colour them."""
    methods = {method.name: method.title for method in transport.METHODS}
    return methods | {mode.name: mode.title for mode in MODES.values()}


#: Values of parameters in labels on plots; other parameters are named in full.
_SHORT = {
    "samples": "paths {}",
    "directions": "lights {}",
    "terms": "terms {}",
    "coefficients": "kept {}",
    "cube": "{}²",
}


def record_of(found: Tradeoff, **scene: Any) -> dict[str, Any]:
    """A sweep as JSON; `scene` are further entries that say of what it is. Units are in the keys."""
    on_front = {id(point) for point in front(found.points)}
    paid_off = found.break_even_frames
    expected = {each.setting: each.as_json() for each in found.expected}
    return {
        **scene,
        "width_px": found.size[0],
        "height_px": found.size[1],
        "gl_renderer": found.device,
        "points": [
            {**point.as_json(), "on_front": id(point) in on_front, "break_even_frames": found.break_even(point)}
            for point in found.points
        ],
        "break_even_frames": paid_off[0] if paid_off else None,
        "break_even_setting": paid_off[1].setting.as_json() if paid_off else None,
        "ladders": sweeps(found),
        "predictions": check(found.points),
        "baked_share": found.baked,
        "left_out": [
            {**each.setting.as_json(), "reason": each.reason, **expected.get(each.setting, {})}
            for each in found.left_out
        ],
        "reference_samples": found.samples,
        "reference_noise_rel": found.noise,
        "time_s": found.time_s,
    }


def sweeps(found: Tradeoff) -> list[dict[str, Any]]:
    """For each parameter that was turned, whether the error fell along it (1 % slack), and where it did not."""
    trends = []
    for mode in modes():
        for parameter in parameters_of(mode):
            steps = found.sweeps(mode, parameter)
            if not steps:
                continue
            rising = found.not_monotone(mode, parameter)
            at = [[low.parameters[parameter], high.parameters[parameter]] for low, high in rising]
            trends.append({"mode": mode, "knob": parameter, "monotone": not rising, "rises": at})
    return trends


def table_of(found: Tradeoff) -> str:
    """A sweep as CSV, a line for each point, with the columns of the JSON and one for each parameter."""
    parameters = list(dict.fromkeys(name for point in found.points for name in point.parameters))
    rows = record_of(found)["points"]
    figures = [name for name in (rows[0] if rows else {}) if name not in ("mode", "knobs")]
    stream = io.StringIO()
    lines = csv.writer(stream, lineterminator="\n")
    lines.writerow(["mode", *parameters, *figures])
    for row in rows:
        values = [row["knobs"].get(name, "") for name in parameters]
        lines.writerow([row["mode"], *values, *("" if row[name] is None else row[name] for name in figures)])
    return stream.getvalue()


def plot_of(found: Tradeoff, axis: str, title: str = "", current: Setting | None = None) -> Figure | None:
    """Error against a cost, both logarithmic, the front joined; None where no point has that cost."""
    titles = names()
    words, factor = AXES[axis]
    shown = [point for point in found.points if point.cost(axis) > 0.0]
    if not shown:
        return None
    best = {id(point) for point in front(shown, axis)}
    order = sorted(shown, key=lambda point: list(titles).index(point.mode))
    dots = [
        Dot(
            factor * point.cost(axis),
            100.0 * point.error_rmse_rel,
            titles[point.mode],
            label_of(point.setting, [each.setting for each in found.points]),
            100.0 * point.error_uncertainty,
            id(point) in best,
            point.setting == current,
        )
        for point in order
    ]
    guessed = [each for each in _promising(found, axis) if each.predicted.get(COSTS[axis][0], 0.0) > 0.0]
    dots += [
        Dot(
            factor * each.predicted[COSTS[axis][0]],
            100.0 * each.error_rel,
            titles[each.setting.mode],
            f"{label_of(each.setting, [*(point.setting for point in found.points), each.setting])} (extrapolated)",
            (100.0 * (each.error_rel - each.interval[0]), 100.0 * (each.interval[1] - each.error_rel)),
        )
        for each in guessed
    ]
    drawn = "on the CPU" if found.device == ON_CPU else f"by {found.device}"
    note = f"Bars: 95 %. Errors against {found.samples} paths for each pixel; frames drawn {drawn}."
    free = len(found.points) - len(shown)
    note += f" {free} settings have no such cost." if free else ""
    note += f"\n{len(guessed)} settings were not measured but extrapolated." if guessed else ""
    note += _describe_break_even(found)
    return scatter_front(dots, words, "Error, relative RMSE / %", title=title, note=note)


def _promising(found: Tradeoff, axis: str) -> list[Expected]:
    """Settings that were not measured and may lie on the front: none measured is as exact and costs less."""
    name = COSTS[axis][0]
    return [
        each
        for each in found.expected
        if not any(
            point.error_rmse_rel <= each.error_rel and point.cost(axis) <= each.predicted.get(name, 0.0)
            for point in found.points
        )
    ]


def _describe_break_even(found: Tradeoff) -> str:
    """A line that says which bake pays off first, and when; nothing where none does."""
    paid_off = found.break_even_frames
    if paid_off is None:
        return ""
    frames, point = paid_off
    times = "1 frame" if frames == 1 else f"{frames} frames"
    label = label_of(point.setting, [each.setting for each in found.points])
    name = f"{transport.method_of(point.mode).noun} ({label})"
    return f"\nBreak-even: with their bake, {name} take less time than the reference at equal error after {times}."


def label_of(setting: Setting, settings: Sequence[Setting]) -> str:
    """The parameters in which settings of a mode differ: 'terms 4, kept 96, 32²'."""
    alike = [other for other in settings if other.mode == setting.mode]
    varied = [name for name in setting.parameters if len({other.parameters[name] for other in alike}) > 1] or [
        *setting.parameters
    ][:1]
    return ", ".join(_SHORT.get(name, f"{name} {{}}").format(setting.parameters[name]) for name in varied)


def write(found: Tradeoff, folder: Path, title: str = "", **scene: Any) -> Steps[dict[str, Any]]:
    """Write `tradeoff.json`, `tradeoff.csv`, and plots, `tradeoff.png` that of frames; the JSON's record.

    OutputError where that is not possible.
    """
    make_folder(folder)
    record = record_of(found, **scene)
    files: list[str] = []
    for number, axis in enumerate(COSTS):
        yield Step(number / len(COSTS), "drawing plots")
        figure = plot_of(found, axis, title)
        if figure is not None:
            stem = "tradeoff" if axis == "frame" else f"tradeoff-{axis}"
            files += [path.name for path in save(figure, folder / f"{stem}.png")]
    write_bytes(folder / "tradeoff.csv", table_of(found).encode())
    record["files"] = ["tradeoff.json", "tradeoff.csv", *files]
    write_json(folder / "tradeoff.json", record)
    return record
