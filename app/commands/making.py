"""Stack and material of a project, made of its photographs by its settings, or found where it had them before."""

from __future__ import annotations

import dataclasses
import logging
import secrets
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import engine
from app.document.document import ImportChoices, Project
from app.document.import_choices import choose_lights_of, settings_of
from app.project.made import find_built_before, key_of, note
from app.project.photographs import Mark, keep, take_marks
from app.project.pixels import are_packed, are_there, open_kept, take_again, take_in, unpack_pixels
from app.project.project_file import path_of
from app.session import cache
from engine.capture.diffuse_part import take_part
from engine.capture.evenness import even_out
from engine.capture.lights.sources import Sources
from engine.capture.object_part import take_object
from engine.capture.stack import CODES, RECORD, ImageStack
from engine.core.errors import FileError, InputError
from engine.core.health import Health
from engine.core.steps import Step, Steps, part
from engine.scene.material import Material
from engine.shading.mixed import keep_tiles
from engine.shading.power_law import PowerLawMap, fit
from engine.shading.quantise import quantise
from engine.shading.representation import choose
from engine.shading.shading_map import ShadingMap, include
from engine.shading.tile import make_tile, tile_health, tile_planes
from engine.storage.writer import writer

log = logging.getLogger(__name__)


def keep_stack(
    sources: Sources,
    choices: ImportChoices,
    marks: Mapping[Path, Mark],
    folders: Sequence[Path],
    now: ImageStack | None = None,
) -> Steps[ImageStack]:
    """The stack of the photographs, which `marks` tell apart: the one that lies in `folders`, or a new one in the last.

    Its name is the hash of the photographs' contents, of the choices, and of the version that imports them. Where it
    is the one that is open `now`, it stays the same object, so that its material is up to date.
    """
    yield Step(0.0, "looking for the stack")
    contents = {path: mark.hash for path, mark in marks.items()}
    name = f"stack-{key_of(engine.__version__, sources, choices, contents=contents)}"
    for folder in folders:
        if (folder / name / RECORD).is_file():
            try:
                found = open_kept(folder / name, verify=True)
                yield from part(pixels_made(found, sources, choices), 0.1, 1.0)
            except FileError as error:
                log.warning("%s", error)
                continue
            return now if now is not None and now.folder == found.folder else found
    return (yield from new_stack_of(sources, choices, folders[-1] / name))


def new_stack_of(sources: Sources, choices: ImportChoices, target: Path) -> Steps[ImageStack]:
    """Import the photographs as the stack `target` of a project, its pixels into the cache of the user where it has one
    (`app.project.pixels`)."""
    made = _importing()
    if made is None:
        return (yield from stack_of(sources, choices, target))
    began = time.perf_counter()
    yield from _import(sources, choices, made)
    stack = take_in(made, target, path_of(target.parent), sources.photographs)
    note(target, "stack", time.perf_counter() - began)
    return stack


def pixels_made(stack: ImageStack, sources: Sources | None, choices: ImportChoices | None) -> Steps[None]:
    """Make the pixels of a stack again where they are gone, bit for bit: of the compressed ones in the project, or of
    the photographs, by the `choices` that it was imported with.

    Raises InputError where the photographs are gone, or give other pixels than they did.
    """
    if are_there(stack) or stack.folder is None:
        return
    if are_packed(stack.folder):
        try:
            yield from unpack_pixels(stack)
            return
        except InputError as error:
            log.warning("%s", error)
    if sources is None or choices is None:
        raise InputError(stack.folder, "has lost its pixels", "Open the photographs that it was made of")
    yield Step(0.0, "reading the photographs again")
    made = _importing() or stack.folder.with_name(f"again-{writer()}-{secrets.token_hex(4)}")
    yield from _import(sources, choices, made, as_codes=CODES in stack.pixels)
    take_again(made, stack, path_of(stack.folder.parent), sources.photographs)


def can_be_read(project: Project) -> bool:
    """True if the pixels of the stack are there, or compressed in the project."""
    stack = project.stack
    return stack is not None and (are_there(stack) or (stack.folder is not None and are_packed(stack.folder)))


def readable_stack(project: Project) -> Steps[ImageStack | None]:
    """The stack of `project` with its pixels, made again where they are gone; None where that cannot be."""
    if project.stack is None:
        return None
    try:
        yield from pixels_made(project.stack, project.sources, project.imported_with)
    except FileError as error:
        log.warning("%s", error)
        return None
    return project.stack


def _importing() -> Path | None:
    """A free folder in the cache; None where there is none."""
    return cache.entry(f"importing-{writer()}-{secrets.token_hex(4)}")


def mark_stack(
    sources: Sources,
    choices: ImportChoices,
    folders: tuple[Path, Path],
    files: tuple[Path, ...],
    now: ImageStack | None,
) -> Steps[ImageStack]:
    """As `keep_stack`; the project keeps the marks of `files`, by which they are known again."""
    marks = yield from part(take_marks(files), 0.0, 0.1)
    stack = yield from part(keep_stack(sources, choices, marks, folders, now), 0.1, 1.0)
    keep_marks(folders[-1], marks)
    return stack


def keep_marks(folder: Path, marks: Mapping[Path, Mark]) -> None:
    """Let the project whose data lie in `folder` know these photographs again; where it cannot, the log says so."""
    try:
        keep(path_of(folder), marks)
    except FileError as error:
        log.info("photographs could not be marked: %s", error)


def stack_of(sources: Sources, choices: ImportChoices, target: Path) -> Steps[ImageStack]:
    """Import the photographs into the folder `target`, with their pixels."""
    began = time.perf_counter()
    stack = yield from _import(sources, choices, target)
    note(target, "stack", time.perf_counter() - began)
    return stack


def _import(sources: Sources, choices: ImportChoices, target: Path, *, as_codes: bool = True) -> Steps[ImageStack]:
    yield Step(0.0, "preparing the import")
    from engine.capture.import_stack import import_stack

    chosen = choose_lights_of(sources, choices)
    return (yield from import_stack(chosen, settings_of(choices), target, as_codes=as_codes))


def keep_material(project: Project, folder: Path, own: Path) -> Steps[Material]:
    """As `material_of`; the one that the project had by the same settings before, where its data `folder` has it.

    `own` is the folder of a stack that the project file does not know of.
    """
    yield Step(0.0, "looking for the material")
    try:
        found = find_built_before(path_of(folder), project.recipe, own)
    except FileError as error:
        log.info("%s", error)
        found = None
    if found is not None:
        return prepare_to_draw(dataclasses.replace(found, name=project.name))
    return prepare_to_draw((yield from material_of(project)))


def prepare_to_draw(material: Material) -> Material:
    """`material`, with the smaller sizes of its planes computed: a viewport would compute them on the window's thread,
    in 0.5 s the first time."""
    if material.directional is not None:
        material.directional.smaller  # noqa: B018 - kept by the map once it was asked for
    return material


def material_of(project: Project) -> Steps[Material]:
    """The stack of `project` as slices and their compression, or as planes, by its settings."""
    yield Step(0.0, "compiling (first use only)")
    if project.stack is not None:
        yield from part(pixels_made(project.stack, project.sources, project.imported_with), 0.0, 0.5)

    assert project.stack is not None
    excluded, evenness = project.excluded, Health()
    stack, light = yield from part(take_part(project.stack, project.part_of_light), 0.0, 0.02)
    stack, mask, masked = yield from part(take_object(stack, to_tile=project.tileable), 0.02, 0.04)
    if project.tileable and project.evened:
        stack, evenness = yield from part(even_out(stack), 0.02, 0.1)
    chosen = yield from part(choose(stack, project.slices, excluded=excluded, wanted=project.representation), 0.1, 0.3)
    elevation_deg = tuple(float(angle) for angle in stack.elevation_deg[include(stack, excluded)])
    health = stack.health.without(excluded).merge(chosen.health).merge(light).merge(masked)
    if not isinstance(chosen.map, ShadingMap):
        planes, health = chosen.map, health.merge(evenness)
        if project.tileable:
            sample = planes.planes.shape[1], planes.planes.shape[2]
            planes, tile = yield from part(tile_planes(planes, name=stack.folder or "the stack"), 0.3, 1.0)
            health = health.merge(tile_health(tile, sample))
        material = Material(None, None, elevation_deg=elevation_deg, name=project.name, health=health, mask=mask)
        return dataclasses.replace(material, directional=planes)
    shading_map = chosen.map
    if project.tileable:
        shading_map = (yield from part(make_tile(stack, shading_map, excluded=excluded), 0.3, 0.6)).shading_map
        shading_map = dataclasses.replace(shading_map, health=shading_map.health.merge(evenness))
    power_law = yield from part(_compress(project, shading_map), 0.6, 1.0)
    return Material(
        shading_map=shading_map,
        power_law=power_law,
        elevation_deg=elevation_deg,
        name=project.name,
        health=health.merge(shading_map.health).merge(power_law.health),
        mask=mask,
    )


def _compress(project: Project, shading_map: ShadingMap) -> Steps[PowerLawMap]:
    """The power law of `shading_map`, rounded and with kept slices as the project says."""
    power_law = yield from part(fit(shading_map, project.scale), 0.0, 0.6)
    if project.exponent_bits != 32:
        power_law = yield from part(quantise(power_law, shading_map, project.exponent_bits), 0.6, 0.8)
    if project.mixed:
        bound = project.error_bound_percent / 100.0 * shading_map.r_max
        power_law = yield from part(keep_tiles(power_law, shading_map, bound), 0.8, 1.0)
    return power_law


def with_material(project: Project, stack: ImageStack, material: Material) -> Project:
    """`project` with the material that was built of its stack, shown flat where lamps stood all around."""
    kept = {name: getattr(project.material, name) for name in ("brdf", "measured", "sigma")}
    provenance = {**stack.provenance, "excluded_photographs": sorted(project.excluded)}
    provenance["power_law_scale"] = project.scale
    built = dataclasses.replace(material, **kept)
    made = dataclasses.replace(project, material=built, built_from=project.recipe, provenance=provenance)
    is_flat = material.directional is not None and project.mesh is None
    return dataclasses.replace(made, **made.lay_flat(built)) if is_flat else made
