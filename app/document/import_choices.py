"""The user's choices for an import as settings of the engine, and the one way in which they change."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar

import numpy as np

from app.document.document import ImportChoices, Pair, Project
from engine.capture.lights.azimuth_spread import about_azimuth
from engine.capture.lights.file_names import printable
from engine.capture.lights.mirror_sphere import Circle
from engine.capture.lights.sources import Sources
from engine.capture.object_outline import ObjectOutline
from engine.capture.photograph.exposures import Exposure
from engine.capture.scale import CameraDistance, ChartPitch, KnownLength, ScaleChoice
from engine.core.errors import InputError, UsageError

if TYPE_CHECKING:
    from app.document.open_document import Document
    from engine.capture.import_stack import ImportSettings
Each = TypeVar("Each")


def choose(document: Document, words: str, gesture: str = "", **parts: Any) -> None:
    """Change `parts` of the import choices as one undo step, or as part of a gesture; nothing where nothing differs."""
    choices = dataclasses.replace(document.project.import_choices, **parts)
    if choices != document.project.import_choices:
        document.change(words, gesture=gesture, import_choices=choices)


def settings_of(choices: ImportChoices) -> ImportSettings:
    """The settings of an import by `choices`."""
    from engine.capture.import_plan import CALIBRATED, ImportSettings
    from engine.capture.photograph.grey_patch import GreyPatch

    patch = GreyPatch(*choices.patch) if choices.patch is not None else None
    return ImportSettings(
        motion=choices.motion,
        white_balance=patch or choices.white_balance,
        transfer=choices.transfer,
        dark=choices.dark,
        flat=choices.flat,
        lamp_distance=choices.lamp_distance,
        second_sphere="auto" if choices.second_sphere else None,
        equalise="object" if choices.equalise == "object" else patch if choices.equalise == "patch" else None,
        framing=choices.framing,
        reference=choices.reference,
        control_points=choices.control_points,
        calibrate=tuple(term for term in CALIBRATED if term not in choices.without_estimates),
        lights_form=choices.lights_form,
        chart=None if choices.chart == "none" else choices.chart,
        pair_gain=choices.pair_gain,
        working_space=choices.working_space,
        scale=_scale_of(choices),
        lens=None if choices.lens == "none" else choices.lens,
        mask=_mask_of(choices),
        trust_angles=choices.trust_angles,
        strict=not choices.leave_out,
        use_all=choices.use_all,
    )


def choices_of(settings: ImportSettings, sphere: Circle | Literal["auto"] | None = None) -> ImportChoices:
    """The choices of a project by which an import has these `settings`, and the lights a mirror `sphere` shows.

    Raises UsageError for settings that a project does not keep.
    """
    from engine.capture.import_plan import CALIBRATED
    from engine.capture.photograph.grey_patch import GreyPatch

    balance, equalise, scale = settings.white_balance, settings.equalise, settings.scale
    patch = next((each for each in (balance, equalise) if isinstance(each, GreyPatch)), None)
    given = {"auto": CALIBRATED, "none": ()}
    calibrate = given[settings.calibrate] if isinstance(settings.calibrate, str) else settings.calibrate
    outline = (sphere.column, sphere.row, sphere.radius) if isinstance(sphere, Circle) else None
    choices = ImportChoices(
        motion=settings.motion,
        white_balance=balance if balance in ("camera", "none") else "camera",
        transfer=settings.transfer,
        dark=settings.dark,
        flat=settings.flat,
        lamp_distance=settings.lamp_distance,
        sphere=sphere is not None,
        outline=outline,
        second_sphere=settings.second_sphere is not None,
        equalise="object" if equalise == "object" else "patch" if equalise is not None else "",
        patch=None if patch is None else (patch.left, patch.top, patch.width, patch.height),
        framing=settings.framing,  # type: ignore[arg-type]
        without_estimates=tuple(term for term in CALIBRATED if term not in calibrate),
        lights_form=settings.lights_form,
        chart=settings.chart or "none",
        lens=settings.lens or "none",
        mask="none" if settings.mask is None or isinstance(settings.mask, ObjectOutline) else settings.mask,
        scale_mm=scale if isinstance(scale, float) else None,
        chart_pitch_mm=scale.pitch_mm if isinstance(scale, ChartPitch) else None,
        scale_by_camera=isinstance(scale, CameraDistance),
        camera_distance_mm=scale.distance_mm if isinstance(scale, CameraDistance) else None,
        known_length=(*scale.first, *scale.second, scale.length_mm) if isinstance(scale, KnownLength) else None,
        pair_gain=settings.pair_gain,
        trust_angles=settings.trust_angles,
        leave_out=not settings.strict,
        use_all=settings.use_all,
        working_space=settings.working_space,
    )
    kept, wanted = settings_of(choices), dataclasses.replace(settings, calibrate=calibrate)
    names = [field.name for field in dataclasses.fields(wanted)]
    lost = [name for name in names if getattr(kept, name) != getattr(wanted, name)]
    if lost:
        raise UsageError(f"a project does not keep this choice of an import: {', '.join(lost)}; write a stack instead")
    return choices


def _mask_of(choices: ImportChoices) -> Path | Literal["alpha"] | ObjectOutline | None:
    if choices.outline_px:
        return ObjectOutline(choices.outline_px)
    return None if choices.mask == "none" else choices.mask


def _scale_of(choices: ImportChoices) -> ScaleChoice | None:
    if choices.scale_by_camera:
        return CameraDistance(choices.camera_distance_mm)
    if choices.known_length is not None:
        x0, y0, x1, y1, length_mm = choices.known_length
        return KnownLength((x0, y0), (x1, y1), length_mm)
    if choices.chart_pitch_mm is not None and choices.chart != "none":
        return ChartPitch(choices.chart_pitch_mm)
    return choices.scale_mm


def choose_lights_of(sources: Sources, choices: ImportChoices) -> Sources:
    """`sources`, with the mirror sphere that their lights are to be measured on where `choices` ask for one."""
    if not choices.sphere:
        return sources
    from engine.capture.lights.sphere_lights import with_sphere

    outline = Circle(*choices.outline) if choices.outline is not None else sources.sphere or "auto"
    return with_sphere(sources, outline, choices.highlights)


def transfer_of(sources: Sources, choices: ImportChoices) -> Any:
    """The assumed transfer function of 8- and 16-bit files."""
    return choices.transfer if choices.transfer != "auto" else sources.transfer or "auto"


def with_angle(sources: Sources, place: int, angle_deg: float, azimuth_deg: float | None = None) -> Sources:
    """`sources` with another elevation and azimuth of photograph number `place`, in the order that follows.

    None keeps the azimuth. Where none is known, the first one is that of all photographs, which then lie on one arc.
    """
    elevation, azimuth = sources.elevation.copy(), sources.azimuth
    elevation[place] = math.radians(angle_deg)
    if azimuth_deg is not None:
        azimuth = np.full(elevation.shape, math.radians(azimuth_deg)) if azimuth is None else azimuth.copy()
        azimuth[place] = math.radians(azimuth_deg)
    order = np.argsort(elevation, kind="stable")
    outdated = about_azimuth(sources.azimuth)
    findings = [finding for finding in sources.findings if finding not in outdated]
    lit = dataclasses.replace(sources, elevation=elevation, azimuth=azimuth, angle_source="user")
    return dataclasses.replace(_keep(lit, order.tolist()), findings=(*findings, *about_azimuth(azimuth)))


def without(sources: Sources, places: Collection[int]) -> Sources:
    """`sources` without the photographs number `places`; raises InputError where fewer than two remain."""
    kept = [place for place in range(len(sources.photographs)) if place not in places]
    if len(kept) < 2:
        first = sources.photographs[min(places)]
        raise InputError(first, "cannot be taken out of so few photographs", "At least two under different lights stay")
    names = {printable(sources.photographs[place]) for place in places}
    findings = tuple(finding for finding in sources.findings if finding.source not in names)
    return dataclasses.replace(_keep(sources, kept), findings=findings)


def with_file(sources: Sources, place: int, path: Path) -> Sources:
    """`sources` with the file `path` as photograph number `place`, under the same light.

    What was known of the file that it replaces (exposure, points, reflection) goes with it. Raises InputError where
    another photograph has the name of `path`.
    """
    others = [each for at, each in enumerate(sources.photographs) if at != place]
    if printable(path) in map(printable, others):
        raise InputError(path, "has the name of another photograph of the capture", "Give it a name of its own")
    old = sources.photographs[place]
    points = {each: pairs for each, pairs in sources.control_points.items() if each != old}
    return dataclasses.replace(
        sources,
        photographs=_with(sources.photographs, place, path),
        exposure_s=_with(sources.exposure_s, place, None),
        exposures=_with(sources.exposures, place, (Exposure(path, None),)),
        highlights_px=_with(sources.highlights_px, place, None) if sources.highlights_px else (),
        control_points=points,
        crossed={path if each == old else each: other for each, other in sources.crossed.items()},
        reference=None if sources.reference == old else sources.reference,
        findings=tuple(finding for finding in sources.findings if finding.source != printable(old)),
    )


def _with(values: tuple[Each, ...], place: int, value: Each) -> tuple[Each, ...]:
    return (*values[:place], value, *values[place + 1 :])


def _keep(sources: Sources, places: Sequence[int]) -> Sources:
    """The photographs number `places` of `sources`, in that order, with what is known of each."""
    chosen = [sources.photographs[place] for place in places]
    return dataclasses.replace(
        sources,
        photographs=tuple(chosen),
        elevation=sources.elevation[list(places)],
        azimuth=None if sources.azimuth is None else sources.azimuth[list(places)],
        exposure_s=tuple(sources.exposure_s[place] for place in places),
        exposures=tuple(sources.exposures[place] for place in places),
        highlights_px=tuple(sources.highlights_px[place] for place in places) if sources.highlights_px else (),
        control_points={path: pairs for path, pairs in sources.control_points.items() if path in chosen},
        reference=sources.reference if sources.reference in chosen else None,
    )


def choices_without(choices: ImportChoices, names: Collection[str]) -> ImportChoices:
    """`choices` without what they say of the photographs `names`: points, reflections, and the reference."""
    return dataclasses.replace(
        choices,
        control_points={name: pairs for name, pairs in choices.control_points.items() if name not in names},
        highlights={name: place for name, place in choices.highlights.items() if name not in names},
        reference=None if choices.reference in names else choices.reference,
    )


def path_of(project: Project, name: str | None) -> Path | None:
    """The file of the photograph `name`, None where the stack was opened without its photographs."""
    paths = project.sources.photographs if project.sources is not None else ()
    return next((path for path in paths if printable(path) == name), None)


def read_stated_points(sources: Sources | None) -> dict[str, tuple[Pair, ...]]:
    """The control points that `capture.toml` gives, by file name."""
    if sources is None:
        return {}
    return {
        printable(path): tuple((float(x), float(y), float(u), float(v)) for x, y, u, v in pairs)
        for path, pairs in sources.control_points.items()
    }


def points_of(project: Project) -> dict[str, tuple[Pair, ...]]:
    """The control points that an import would follow, by file name."""
    stated = {**read_stated_points(project.sources), **project.import_choices.control_points}
    return {name: pairs for name, pairs in stated.items() if pairs}


def reference_of(project: Project) -> str | None:
    """The photograph that the others are aligned to: the chosen, the stated, that of the last import, or the middle."""
    sources, stack, chosen = project.sources, project.stack, project.import_choices.reference
    if sources is None:
        return None
    names = [printable(path) for path in sources.photographs]
    last = stack.provenance.get("aligned_to") if stack is not None else None
    stated = printable(sources.reference) if sources.reference is not None else None
    wishes = [name for name in (chosen, stated, last) if name in names]
    return str(wishes[0]) if wishes else names[len(names) // 2]
