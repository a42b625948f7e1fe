"""The export: a folder in which each target has a folder of its own, and a record of the error of each.

`TARGETS` lists them once; the command line, the window and the record read it. A target is a function from subject and
settings to a representation, whose errors are measured here, alike for all (`engine.exchange.loss`), and one to files,
which state those errors wherever their format has a place for words.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import engine
from engine.brdf.models.multiple_scattering import SMOOTHEST
from engine.capture.scale import mm_per_texel
from engine.core.errors import UsageError
from engine.core.figure_text import number, percent
from engine.core.steps import Step, Steps, part, without_partials
from engine.exchange import blender, brdf, gltf, materialx, rti, shaders, textures, usd, web
from engine.exchange.loss import (
    ENVIRONMENTS,
    Floats,
    Shown,
    away,
    display_sphere,
    loss,
    material_shown,
    meaning,
    photograph_error,
    references,
    statement,
)
from engine.exchange.pbr_from_material import cavity, nearest_maps
from engine.exchange.subject import WIDTHS_MM, Contents, Settings, Subject
from engine.exchange.targets import EXPORTERS
from engine.scene.material import Material, compute_fit_error
from engine.storage.atomic import atomic_folder, make_folder, write_bytes
from engine.surface.lamps import shows_slopes
from engine.surface.pbr_maps import PbrMaps
from engine.surface.recover import recover

if TYPE_CHECKING:
    from engine.capture.stack import ImageStack

#: The record of an export, by which its folder is known.
RECORD = "export.json"

#: Errors of a representation in its entry of the record.
ERRORS = ("rmse_rel", "rmse_rel_reference", "flip", "by_environment")


@dataclass(frozen=True)
class Target:
    """A form in which a material leaves.

    Attributes
    ----------
    words : a sentence for users.
    shown : the representation as its files hold it, rounding included; None where it shows no image of the surface.
    contents : the files, from subject, settings and the sentence that states the errors.
    others : further look-ups that the same files hold, by the names under which the record states their errors; each
        is None where a material has none.
    averages_normals : whether programs that read the files average normals without widening highlights by their spread.
    """

    name: str
    words: str
    shown: Callable[[Subject, Settings], Shown | None]
    contents: Callable[[Subject, Settings, str], Steps[Contents]]
    others: tuple[tuple[str, Callable[[Subject, Settings], Shown | None]], ...] = ()
    averages_normals: bool = False


def as_gltf(subject: Subject, _settings: Settings) -> Shown:
    """The PBR maps in images of 8 bits, under what glTF has of their layers."""
    return subject.decode_as("png8", layers=gltf.read_back(subject.maps), omits_flat=True)


def with_one_f0(subject: Subject, _settings: Settings) -> Shown:
    """The same with the mean f0, of formats that hold no map of it."""
    return subject.decode_as("png8", subject.mean_f0, omits_flat=True)


TARGETS: tuple[Target, ...] = (
    Target(
        "textures",
        "PBR textures, named and packed for a program",
        textures.show,
        textures.contents,
        averages_normals=True,
    ),
    Target(
        "materialx",
        "MaterialX: OpenPBR and glTF PBR surfaces",
        with_one_f0,
        materialx.contents,
        averages_normals=True,
    ),
    Target("gltf", "glTF: a preview sphere with the material, as .glb", as_gltf, gltf.contents, averages_normals=True),
    Target(
        "usd",
        "USD: a preview sphere with UsdPreviewSurface, as .usdz",
        with_one_f0,
        usd.contents,
        averages_normals=True,
    ),
    Target(
        "blender",
        "Blender: a .blend where Blender's module is installed, else a .glb and a script",
        blender.show,
        blender.contents,
        (("power_law", blender.power_law_shown),),
        averages_normals=True,
    ),
    Target(
        "shaders",
        "GLSL, HLSL and OSL that evaluate the material itself",
        shaders.show,
        shaders.contents,
        (("slices", shaders.slices_shown), ("power_law_alone", shaders.law_alone_shown)),
    ),
    Target("web", "A page for any browser, and one for strict sites", web.show, web.contents),
    Target("rti", "RTI: .ptm, .rti and a tree for web viewers", rti.show, rti.contents),
    Target("brdf", "BRDF tables (CSV, ALTA, MERL, RGL) and the nearest model", brdf.show, brdf.contents),
)

#: Ratio of the peaks of highlights from which averaged normals are remarked on.
MUCH_LOWER = 2.0

NAMES = tuple(target.name for target in TARGETS)

#: The name that stands for a choice among the targets that show the surface.
AUTO = "auto"


def targets() -> tuple[Target, ...]:
    """All targets: those of the package, and those that others registered."""
    others = (each for each in EXPORTERS.values() if each.shown is not None and each.contents is not None)
    return (*TARGETS, *(Target(each.name, each.hint, each.shown, each.contents) for each in others))  # type: ignore[arg-type]


def candidates() -> tuple[str, ...]:
    """The names of the targets among which `AUTO` chooses."""
    return tuple(name for name, each in EXPORTERS.items() if each.shows_surface)


def subject_of(material: Material, stack: ImageStack | None = None) -> Steps[Subject]:
    """The material with PBR maps, and its photographs where they are at hand.

    The maps are those of its surface where it has them. Otherwise they are measured where the photographs show the
    slopes of the surface, and else those nearest to the material.
    PBR maps stay as they are; the white card that they are relative to is ideal, and shows 1/π under unit irradiance.
    """
    if material.pbr is not None:
        return Subject(material, material.pbr, 1.0 / np.pi)
    if material.surface is not None and material.surface.maps.size == material.size:
        return Subject(material, material.surface.maps, material.surface.white, cavity(material), stack)
    if stack is not None and shows_slopes(stack) and stack.radiance.shape[1:3] == material.size:
        surface = yield from recover(stack, np.arange(len(stack.sources)), left_out=False)
        return Subject(material, surface.maps, surface.white, cavity(material), stack)
    maps, white = yield from nearest_maps(material)
    return Subject(material, maps, white, cavity(material), stack)


@dataclass(frozen=True, eq=False)
class Departure:
    """A material about to leave: what targets are made of, and what their errors are measured by.

    Attributes
    ----------
    wanted : radiance of the ball of the material itself under each environment (`engine.exchange.loss.references`);
        empty until something is compared with it.
    stack : its photographs, None where they are not at hand or show other texels; `remark` then says so.
    own : errors before leaving, as `material` of the record.
    measured : errors of representations that were measured already, and their image of the ball.
    """

    subject: Subject
    wanted: dict[str, Floats]
    stack: ImageStack | None
    remark: tuple[str, ...]
    own: dict[str, Any]
    measured: dict[Shown | None, Measured] = field(default_factory=dict, repr=False)

    def sphere(self, values: Floats | None = None) -> NDArray[np.uint8]:
        """(H, W, 4) codes of an image of the ball under the first environment, by default of the material itself."""
        own = self.wanted[ENVIRONMENTS[0]]
        return display_sphere(own if values is None else values, own, self.subject.maps.size)


#: Errors of a representation, and the radiance of its ball, None where it shows no image.
Measured = tuple[dict[str, Any], "Floats | None"]


@dataclass(frozen=True, eq=False)
class Offer:
    """A target as it would be written: its entry in the record, which has no files yet, and an image of its ball.

    `why_not` is a sentence where this material cannot be written to it; then there is neither.
    """

    target: str
    entry: dict[str, Any]
    sphere: NDArray[np.uint8] | None
    why_not: str = ""


def departure(
    material: Material, stack: ImageStack | None = None, own: Mapping[str, Any] | None = None
) -> Steps[Departure]:
    """`material` made ready to leave.

    `stack` holds its photographs, where they are at hand. `own` are the errors before leaving, where they were measured
    before; only then nothing is drawn until it is needed.
    """
    subject = yield from part(subject_of(material, stack), 0.0, 0.6)
    usable, remark = _usable_stack(subject)
    leaving = Departure(subject, {}, usable, remark, dict(own or {}))
    if own is None:
        yield from part(_reference_images(leaving), 0.6, 0.8)
        leaving.own.update((yield from part(_own_errors(subject, leaving.wanted, usable), 0.8, 1.0)))
    return leaving


def _reference_images(leaving: Departure) -> Steps[dict[str, Floats]]:
    """The images of the material itself, drawn when they are first needed."""
    if not leaving.wanted:
        leaving.wanted.update((yield from references(leaving.subject.material)))
    return leaving.wanted


def offers(leaving: Departure, settings: Settings, names: Sequence[str] | None = None) -> Steps[list[Offer]]:
    """The targets `names`, or all, with their errors and sizes; nothing is written.

    Each is the `partial` of a step once.
    """
    chosen = [target for target in targets() if names is None or target.name in names]
    found = []
    for index, target in enumerate(chosen):
        start, stop = index / len(chosen), (index + 1) / len(chosen)
        found.append((yield from part(without_partials(_offer(leaving, target, settings)), start, stop)))
        yield Step(stop, target.words, found[-1])
    return found


def _offer(leaving: Departure, target: Target, settings: Settings) -> Steps[Offer]:
    try:
        contents, entry, values = yield from _make(leaving, target, settings)
    except UsageError as error:
        return Offer(target.name, {}, None, f"{str(error)[:1].upper()}{str(error)[1:]}.")
    yield Step(0.95, f"packing {target.name}")
    entry["bytes"] = sum(len(contents.content(name)) for name in contents.paths)
    return Offer(target.name, entry, None if values is None else leaving.sphere(values))


def export(
    folder: str | os.PathLike[str],
    material: Material,
    names: Sequence[str],
    *,
    settings: Settings | None = None,
    stack: ImageStack | None = None,
    error: float = 0.05,
    known: Mapping[str, Mapping[str, Any]] = MappingProxyType({}),
    own: Mapping[str, Any] | None = None,
) -> Steps[dict[str, Any]]:
    """Write `material` to the targets `names` in `folder`, and return the record, the content of `RECORD`.

    `AUTO` alone writes the one of fewest bytes among `candidates` whose `rmse_rel_reference` is at most `error`; `auto`
    of the record then holds all of them.

    `targets` of the record lists for each target its `files`, `bytes`, errors and warnings: `rmse_rel` against the
    photographs (None without a stack of the same size), `rmse_rel_reference` and `flip` over three environments, and
    the same by environment; `errors_are` says so in words, and why one is None. An earlier export is replaced.
    `known` and `own` are errors that were measured before, as `written` and `departure` take them.
    UsageError for unknown targets and, before any work, for one that `cannot_hold` the material; OutputError for the
    folder.
    """
    check_names(names)
    for name in names:
        if why_not := cannot_hold(name, material, stack):
            raise UsageError(why_not)  # before the work of making the material ready
    if not (error >= 0.0 and np.isfinite(error)):
        raise UsageError(f"an error of {error} is not a number from 0 upwards")
    leaving = yield from part(departure(material, stack, own), 0.0, 0.4)
    return (yield from part(write(folder, leaving, names, settings or Settings(), error, known), 0.4, 1.0))


def check_names(names: Sequence[str]) -> None:
    """Raise UsageError unless `names` are of targets, or `AUTO` alone."""
    unknown = [name for name in names if name not in (*EXPORTERS, AUTO)]
    if AUTO in names and len(names) > 1 and not unknown:
        raise UsageError(f"{AUTO} chooses the target: give {AUTO} alone, or targets by name")
    if unknown or not names:
        raise UsageError(f"unknown target {' '.join(unknown)!r}; choose from {', '.join(EXPORTERS)}, or {AUTO} alone")


def cannot_hold(name: str, material: Material, stack: ImageStack | None) -> str:
    """Why the target `name` cannot hold the material with these photographs, and what to do; "" where it can."""
    if material.pbr is not None and EXPORTERS[name].of_a_lookup:
        return f"{name} holds a material from photographs; PBR maps leave as the other targets"
    if name == "rti" and not rti.has_sides(material, stack):
        return "an RTI file needs light from several sides: give the stack of a dome"
    return ""


def write(
    folder: str | os.PathLike[str],
    leaving: Departure,
    names: Sequence[str],
    settings: Settings,
    error: float = 0.05,
    known: Mapping[str, Mapping[str, Any]] = MappingProxyType({}),
) -> Steps[dict[str, Any]]:
    """Write a material that is ready, as `export` does; one file at a time is in memory.

    `known` are entries of targets whose errors were measured before for the same material and settings, by name. The
    offer of each other target is the `partial` of a step once.
    """
    record: dict[str, Any] = {
        "lightarc_export": 1,
        "software": {"lightarc": engine.__version__},
        "material": leaving.own,
        "credits": settings.credits.over(leaving.subject.material.credits).entries,
        "targets": [],
    }
    start = 0.0
    if AUTO in names:
        record["auto"] = yield from part(smallest(leaving, settings, error), 0.0, 0.6)
        start, names = 0.6, [record["auto"]["chosen"]]
    chosen = [target for target in targets() if target.name in names]
    with atomic_folder(folder, RECORD) as place:
        for index, target in enumerate(chosen):
            ends = (start + (1.0 - start) * number / len(chosen) for number in (index, index + 1))
            putting = _put(place, leaving, target, settings, known.get(target.name))
            entry = yield from part(putting, *ends)
            record["targets"].append(entry)
        if "auto" in record and not record["auto"]["within"]:
            words = f"no representation keeps an error of {percent(error)}; this one has the least"
            record["targets"][0]["warnings"].append(words)
        write_bytes(place / RECORD, (json.dumps(record, indent=2, allow_nan=False) + "\n").encode())
    return {**record, "folder": str(Path(folder))}


def _put(
    place: Path, leaving: Departure, target: Target, settings: Settings, known: Mapping[str, Any] | None
) -> Steps[dict[str, Any]]:
    """Write the files of a target, one after the other, and return its entry."""
    making = _make(leaving, target, settings, known)
    contents, entry, values = yield from part(without_partials(making), 0.0, 0.5)
    for index, name in enumerate(contents.paths):
        path, content = place / target.name / name, contents.content(name)
        make_folder(path.parent)
        write_bytes(path, content)
        entry["bytes"] += len(content)
        yield Step(0.5 + 0.5 * (index + 1) / len(contents.paths), f"writing {name}")
    if known is None:
        offer = Offer(target.name, dict(entry), None if values is None else leaving.sphere(values))
        yield Step(1.0, target.words, offer)
    return entry


def _make(
    leaving: Departure, target: Target, settings: Settings, known: Mapping[str, Any] | None = None
) -> Steps[tuple[Contents, dict[str, Any], Any]]:
    """The contents of a target, its entry with no bytes yet, and its image of the ball, None where it is `known`.

    Equal representations are measured once. UsageError where the target cannot hold the material.
    """
    subject = leaving.subject
    settings = with_known_width(settings, subject)
    if why_not := cannot_hold(target.name, subject.material, subject.stack):
        raise UsageError(why_not)
    others: dict[str, Any] = {}
    values = None
    if known is not None:
        errors = {name: known[name] for name in ERRORS}
        others = {name: known[name] for name, _ in target.others if name in known}
    else:
        errors, values = yield from part(_measure(target.shown(subject, settings), leaving), 0.0, 0.4)
        for name, shown_else in target.others:
            if (other := shown_else(subject, settings)) is not None:
                others[name] = (yield from part(_measure(other, leaving), 0.4, 0.5))[0]
    settings = replace(settings, credits=settings.credits.over(subject.material.credits))
    loss = statement(errors) + (f" {settings.credits.ascii_line}." if settings.credits else "")
    contents = yield from part(target.contents(subject, settings, loss), 0.5, 1.0)
    entry = {
        "target": target.name,
        "files": [f"{target.name}/{name}" for name in contents.paths],
        "bytes": 0,
        "white_radiance": subject.white,
        "width_mm": settings.width_mm,
        "bytes_per_texel": contents.bytes_per_texel,
        **errors,
        "errors_are": meaning(errors),
        **others,
        "warnings": [
            *away(errors, others),
            *(warn_of_averaged_normals(subject.maps) if target.averages_normals else ()),
            *contents.warnings,
            *leaving.remark,
        ],
        **contents.record,
    }
    return contents, entry, values


def warn_of_averaged_normals(maps: PbrMaps) -> list[str]:
    """A sentence on highlights of maps whose texels are smaller than pixels, where normals are averaged; else none.

    The peak of GGX over normals whose slopes have the covariance S is lower by √|1 + 2 S / α²| (Olano2010).
    """
    slope = maps.normal[..., :2].reshape(-1, 2) / np.maximum(maps.normal[..., 2:].reshape(-1, 1), 0.2)
    alpha2 = float(np.mean(np.maximum(maps.roughness, SMOOTHEST).astype(np.float64) ** 2)) ** 2
    spread = np.cov(slope.T.astype(np.float64), bias=True)  # of one texel too
    lower = float(np.sqrt(np.linalg.det(np.eye(2) + 2.0 * spread / alpha2)))
    if lower < MUCH_LOWER:
        return []
    return [
        f"where a pixel covers many texels, other programs show highlights up to {number(lower, 2)} times too bright: "
        "they average normals, and these files cannot hold how far they differ; there, take maps of fewer texels and "
        "more roughness"
    ]


def with_known_width(settings: Settings, subject: Subject) -> Settings:
    """`settings` with the width of the sample that its photographs know, unless a user states one."""
    size = mm_per_texel(subject.stack.provenance) if subject.stack is not None else None
    if settings.width_mm is not None or size is None:
        return settings
    width = size * subject.maps.size[1]
    return replace(settings, width_mm=width) if WIDTHS_MM[0] <= width <= WIDTHS_MM[1] else settings


def _measure(shown: Shown | None, leaving: Departure) -> Steps[Measured]:
    if shown not in leaving.measured:
        leaving.measured[shown] = yield from _errors(shown, leaving)
    return leaving.measured[shown]


def smallest(leaving: Departure, settings: Settings, error: float) -> Steps[dict[str, Any]]:
    """The candidate of fewest bytes whose error is at most `error`, or that of least error; `auto` of the record."""
    found = yield from offers(leaving, settings, candidates())
    return choice([offer for offer in found if not offer.why_not], error)


def choice(found: Sequence[Offer], error: float) -> dict[str, Any]:
    """`chosen` of `found`, the smallest whose error is at most `error` (`within`) or the one of least error.

    Slices in the files of a target count as what they show: shaders look either up.
    """
    keys = ("rmse_rel_reference", "flip")
    rows = []
    for each in found:
        errors = each.entry.get("slices", each.entry)
        row = {**{key: each.entry[key] for key in ("target", "bytes")}, **{key: errors[key] for key in keys}}
        rows.append(row | ({"by": "slices"} if errors is not each.entry else {}))

    def error_of(row: dict[str, Any]) -> float:
        return inf if row["rmse_rel_reference"] is None else float(row["rmse_rel_reference"])

    within = [row for row in rows if error_of(row) <= error]
    nearest = min(rows, key=error_of)
    best = min(within or [nearest], key=lambda row: int(row["bytes"]))
    return {"error": error, "chosen": best["target"], "within": bool(within), "candidates": rows}


def _usable_stack(subject: Subject) -> tuple[ImageStack | None, tuple[str, ...]]:
    """The photographs, where they show the texels of the material, and a sentence where they do not."""
    stack = subject.stack
    if stack is None:
        return None, ()
    if stack.radiance.shape[1:3] != subject.maps.size:
        return None, ("the material was cut to a tile, so that it is not compared with the photographs",)
    return stack, ()


def _own_errors(subject: Subject, wanted: dict[str, Floats], stack: ImageStack | None) -> Steps[dict[str, Any]]:
    """Errors of the material before it leaves: of its photographs, and of its power law against its slices."""
    material = subject.material
    found: dict[str, Any] = {"name": subject.material.name, "brdf": subject.material.brdf}
    found["brdf_fit_rmse_rel"] = compute_fit_error(material)
    figures: dict[str, Any] = {"rmse_rel": None, "rmse_rel_power_law": None}
    if stack is not None:
        comparing = photograph_error(material_shown(material), stack, material.mask)
        figures["rmse_rel"] = yield from part(comparing, 0.0, 0.5)
    if material.power_law is not None and material.shading_map is not None:
        comparing_law = loss(material_shown(material, "power-law"), wanted, subject.maps.size, material.mask)
        measured = yield from part(comparing_law, 0.5, 1.0)
        figures["rmse_rel_power_law"] = measured.figures["rmse_rel_reference"]
    return {**found, **figures}


def _errors(shown: Shown | None, leaving: Departure) -> Steps[Measured]:
    """The errors of a representation, None for what does not apply, and its image of the ball."""
    figures: dict[str, Any] = {**dict.fromkeys(ERRORS), "by_environment": {}}
    if shown is None:
        return figures, None
    yield Step(0.0, "measuring the error")
    mask = leaving.subject.material.mask
    if leaving.stack is not None:
        figures["rmse_rel"] = yield from part(photograph_error(shown, leaving.stack, mask), 0.0, 0.4)
    wanted = yield from part(_reference_images(leaving), 0.4, 0.6)
    measured = yield from part(loss(shown, wanted, leaving.subject.maps.size, mask), 0.6, 1.0)
    return {**figures, **measured.figures}, measured.first
