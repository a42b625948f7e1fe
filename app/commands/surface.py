"""Maps of the surface behind the photographs: made of the stack, kept in the document, written to a folder.

The engine is the one of `lightarc normals`, which compiles kernels and is imported inside the jobs.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from app.arguments.results import MAPS, software
from app.commands.making import pixels_made
from app.document.document import Project
from engine.core.steps import Step, Steps, part
from engine.scene.credits import Credits, credits_of
from engine.scene.material import Material
from engine.shading.shading_map import include
from engine.storage.outputs import check_outputs
from engine.surface.lamps import shows_slopes
from engine.surface.pbr_maps import SurfaceMaps

if TYPE_CHECKING:
    from app.commands.workbench import Workbench
    from app.jobs.jobs import Job
    from engine.surface.recover import Surface


def make_maps(bench: Workbench) -> Job:
    """Find the maps of the photographs in use; one undo step when they are found."""
    project = bench.document.project
    job = bench.jobs.submit("Making surface maps", lambda: surface_of(project), lane="compute")
    job.succeeded.connect(lambda surface: take_maps(bench, project, surface))
    return job


def surface_of(project: Project) -> Steps[Surface]:
    """The maps of the photographs of `project` that are in use. Raises InputError where its lamps tell no slope."""
    yield Step(0.0, "compiling (first use only)")
    from engine.surface.recover import recover

    assert project.stack is not None
    yield from part(pixels_made(project.stack, project.sources, project.imported_with), 0.0, 0.3)
    return (yield from recover(project.stack, include(project.stack, project.excluded), white=project.white))


def is_current(project: Project) -> bool:
    """True where the maps of `project` are of the photographs that are in use."""
    return project.surface is not None and project.surface_from == project.surface_recipe


def material_with_surface(project: Project) -> Material:
    """The material of `project` as it leaves: with credits, and the maps of its surface where they are there and of its
    texels."""
    material = with_surface(project.material, project.surface) if is_current(project) else project.material
    return replace(material, credits=project.exporting.credits.over(credits_of_sources(project)))


def credits_of_sources(project: Project) -> Credits:
    """Credits that the material of `project` and its photographs state."""
    stated = project.stack.provenance.get("credits") if project.stack is not None else None
    return project.material.credits.over(credits_of(stated))


def with_surface(material: Material, surface: Surface | None) -> Material:
    """`material` with the maps of `surface`; as it is where it is PBR maps, or shows other texels."""
    is_beside = material.has_map and material.pbr is None
    if surface is None or not is_beside or surface.maps.size != material.size:
        return material
    return replace(material, surface=SurfaceMaps(surface.maps, surface.white))


def needs_surface(project: Project) -> bool:
    """True where the photographs of `project` tell its surface, which an export takes, and its maps are not there."""
    stack, material = project.stack, material_with_surface(project)
    if stack is None or not material.has_map or material.pbr is not None or material.surface is not None:
        return False
    return stack.radiance.shape[1:3] == material.size and shows_slopes(stack)


def set_white(bench: Workbench, white: float | None) -> None:
    """The radiance of a white card that faces a lamp, from which colours count; None to find it in the photographs."""
    if white != bench.document.project.white:
        bench.document.change("White reference", white=white)


def take_maps(bench: Workbench, project: Project, surface: Surface) -> None:
    """Put the maps that were made of `project` into the document, unless it is of other photographs by now."""
    if bench.document.project.stack is not project.stack:
        return  # undone, or another capture was opened in the meantime
    bench.document.change("Make surface maps", surface=surface, surface_from=project.surface_recipe)
    bench.said.emit("Surface maps made")


def save_maps(bench: Workbench, folder: Path) -> Job:
    """Write the maps of the document into `folder`, which is new or holds maps already."""
    project = bench.document.project
    job = bench.jobs.submit("Writing surface maps", lambda: save(project, folder), lane="save", resource=str(folder))
    job.succeeded.connect(lambda files: bench.said.emit(f"{len(files)} files written to {folder}"))
    return job


def save(project: Project, folder: Path) -> Steps[list[str]]:
    """Write maps, previews and record; names of the files. Raises OutputError where `folder` cannot become theirs."""
    yield Step(0.0, "writing maps")
    from engine.surface.write import write_surface

    assert project.surface is not None
    stack, excluded, *_ = project.surface_from or (None, frozenset())
    provenance = {} if stack is None else {**stack.provenance, "excluded_photographs": sorted(excluded)}
    check_outputs([(str(folder), MAPS)], ())
    return (yield from part(write_surface(folder, project.surface, provenance, software("normals")), 0.0, 1.0))
