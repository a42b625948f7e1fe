"""The machine profile: measured once, kept in the user's cache folder, measured again if it is missing.

Bakes correct it, and frames that were timed as a whole: those of `render`, of transport files too, of a tradeoff, and
of the window's measurement of costs. Frames of the viewport do not: they are drawn in pieces between gestures, beside
jobs that take what they like of the CPU; nor do films by OpenGL, whose frames are read back and coded in between.
Nor does anything beside which other programs worked: it would have been faster alone.
"""

from __future__ import annotations

import logging
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.session.settings import cache_folder
from engine.core.errors import OutputError
from engine.core.figure_text import percent
from engine.core.steps import Steps, relay
from engine.core.stopwatch import DISTURBED, background_load, had_company, read_clock
from engine.geometry.camera import frame
from engine.planning.costs.cost_model import load_model, save
from engine.planning.costs.planned import planning_of
from engine.planning.costs.setting import Setting, parameters_of
from engine.planning.effects.sample import sample_surface
from engine.scene.mode import is_traced
from engine.scene.scene import Scene
from engine.tradeoff.predict import Predictions, predict_frame_s

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from engine.core.stopwatch import Spent
    from engine.geometry.camera import Camera
    from engine.planning.costs.cost_model import CostModel
    from engine.tradeoff.point import Point
    from engine.transport.method import Method, Subject
    from engine.transport.relight import RelightTransport

log = logging.getLogger(__name__)

NAME = "cost-model.json"


def cost_path() -> Path | None:
    """The file of the machine profile; None if the system names no usable folder."""
    folder = cache_folder()
    return folder / NAME if folder is not None else None


def cost_model(*, anew: bool = False) -> Steps[CostModel]:
    """The kept profile of this machine, or one that is measured now and kept if possible.

    That takes a second or two (`quick_profile`); with `anew` each rate is measured, in some ten seconds. What was
    measured beside other programs is not kept.
    """
    from engine.planning.costs.machine_profile import calibrate, quick_profile

    path = cost_path()
    kept = load_model(path) if path is not None else None
    if kept is not None and not anew and not kept.is_expired(time.time()):
        return kept
    if anew:
        budget = "some 10 s while nothing else runs"
        whole, load = yield from relay(calibrate(), lambda step: replace(step, note=f"{step.note}: {budget}"))
        if whole.calibrated:
            _keep_in(path, whole)
            return whole
        log.warning(
            "Other programs used %s of the CPUs during this measurement, so it is not kept. "
            "Measure it again when the machine is idle, with: lightarc plan … --calibrate",
            percent(load),
        )
        if kept is not None and not kept.is_expired(time.time()):
            return kept
    model = yield from quick_profile()
    _keep_in(path, model)
    return model


def _keep_in(path: Path | None, model: CostModel) -> None:
    if path is not None:
        _keep(model, path)


def learn(method: str, predicted_s: float, bake_s: float, since: Spent) -> None:
    """Tell the kept profile what a bake of `method` really took, from its start at `since` without a pause."""
    if not _was_disturbed(since):
        _learn_bake(method, predicted_s, bake_s)


def _learn_bake(method: str, predicted_s: float, bake_s: float) -> None:
    path = cost_path()
    kept = load_model(path) if path is not None else None
    if path is not None and kept is not None:
        found = kept.learn(method, predicted_s, bake_s)
        if found is not kept:
            _keep(found, path)


def learn_bake(subject: Subject, method: Method, settings: Any, bake_s: float, since: Spent) -> None:
    """Tell the kept profile what a bake of these settings took from `since` on; nothing of one that plans do not know.

    Plans know one BRDF for the whole model, and settings whose parameters alone differ from the usual.
    """
    chosen = {name: getattr(settings, name) for name in parameters_of(method.name)}
    if subject.variations or subject.parts or settings != replace(method.settings(), **chosen) or _was_disturbed(since):
        return
    parameters = {name: int(value) if isinstance(value, bool) else value for name, value in chosen.items()}
    parameters = {name: value for name, value in parameters.items() if value is not None}
    scene = Scene(subject.mesh, frame(subject.mesh.positions), subject.brdf, ground=subject.ground)
    predicted = _predict(scene, Setting(method.name, parameters), (1, 1), 1, 1)
    _learn_bake(method.name, predicted.get("bake_s", 0.0), bake_s)


def _was_disturbed(since: Spent) -> bool:
    """True if other programs or jobs took the CPUs from then on, so that times teach nothing of an idle machine."""
    if had_company():
        log.info("The machine profile learns nothing: another computation ran at the same time.")
        return True
    load = background_load(since, read_clock())
    if load > DISTURBED:
        log.info("The machine profile learns nothing: other programs used %s of the CPUs.", percent(load))
    return load > DISTURBED


def learn_frame(
    scene: Scene,
    setting: Setting,
    size: tuple[int, int],
    frame_s: float,
    since: Spent,
    *,
    samples: int,
    depth: int,
    device: str,
) -> None:
    """Tell the kept profile what a frame of `setting` took from `since` on, by `device`, which it has measured."""
    kept = _find_kept_for(device, setting.mode)
    if kept is None or scene.environment is None or _was_disturbed(since):
        return
    if is_traced(setting.mode):
        predicted_s = _predict(scene, setting, size, samples, depth).get("frame_s", 0.0)
    else:
        surface, shadows = sample_surface(scene.mesh, scene.ground), len(scene.casting)
        predicted_s = predict_frame_s(kept, surface, setting, scene.camera, size, samples, shadows=shadows)
    _learn_frame(kept, setting.mode, predicted_s, frame_s)


def learn_relit(
    relit: RelightTransport,
    camera: Camera,
    size: tuple[int, int],
    frame_s: float,
    since: Spent,
    *,
    samples: int,
    device: str,
) -> None:
    """Tell the kept profile what a frame of a bake took from `since` on; nothing of one that no plan would choose."""
    kept = _find_kept_for(device, relit.method)
    if kept is None or _was_disturbed(since):
        return
    try:
        setting = planning_of(relit.method).setting_of(relit)
    except ValueError:
        return
    diffuse = relit.flat_vertex == 0
    predicted_s = predict_frame_s(kept, relit.mesh, setting, camera, size, samples, diffuse=diffuse)
    _learn_frame(kept, relit.method, predicted_s, frame_s)


def _find_kept_for(device: str, mode: str) -> CostModel | None:
    """The kept profile, if frames of `mode` by `device` are those that it has measured."""
    path = cost_path()
    kept = load_model(path) if path is not None else None
    return kept if kept is not None and (is_traced(mode) or kept.renderer == device) else None


def _learn_frame(kept: CostModel, mode: str, predicted_s: float, frame_s: float) -> None:
    path, found = cost_path(), kept.learn_frame(mode, predicted_s, frame_s)
    if path is not None and found is not kept:
        _keep(found, path)


def _predict(scene: Scene, setting: Setting, size: tuple[int, int], samples: int, depth: int) -> dict[str, float]:
    """Seconds by the kept profile, in a process that has baked nothing yet; nothing without a profile."""
    path = cost_path()
    kept = load_model(path) if path is not None else None
    if kept is None:
        return {}
    return Predictions(kept, scene, size, samples, depth, tables_made=False).of(setting)


def learn_from(points: Sequence[Point], since: Spent) -> None:
    """Tell the kept profile what bakes and frames of a tradeoff took from `since` on: of each mode the middle one."""
    path = cost_path()
    kept = load_model(path) if path is not None else None
    if path is None or kept is None or _was_disturbed(since):
        return
    found = kept
    for mode, predicted_s, bake_s in _middle(points, "bake_s"):
        found = found.learn(mode, predicted_s, bake_s)
    for mode, predicted_s, frame_s in _middle(points, "frame_s"):
        found = found.learn_frame(mode, predicted_s, frame_s)
    if found is not kept:
        _keep(found, path)


def _middle(points: Sequence[Point], figure: str) -> Iterator[tuple[str, float, float]]:
    """Mode, predicted and measured seconds of the point of each mode whose ratio is in the middle."""
    ratios: dict[str, list[tuple[float, float, float]]] = {}
    for point in points:
        predicted_s, seconds = point.predicted.get(figure, 0.0), getattr(point, figure)
        if predicted_s > 0.0:
            ratios.setdefault(point.mode, []).append((seconds / predicted_s, predicted_s, seconds))
    for mode, found in ratios.items():
        _, predicted_s, seconds = sorted(found)[len(found) // 2]
        yield mode, predicted_s, seconds


def _keep(model: CostModel, path: Path) -> None:
    try:
        save(model, path)
    except OutputError as error:
        log.warning("The machine profile cannot be saved: %s", error)
