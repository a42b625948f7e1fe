"""The material of a project as a bundle, with a preview that is drawn on the CPU: no viewport is needed."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Set
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from app.commands.bundle_view import view_of
from app.commands.surface import material_with_surface
from app.document.document import Look, Project
from app.document.exporting import PARTS
from engine.bundle.manifest import MAPS_PROCESS, describe_bundle
from engine.core.steps import Step, Steps, part
from engine.render.direct import radiance
from engine.render.display import Display, display_apart
from engine.scene.material import error_figures, material_of_maps

if TYPE_CHECKING:
    from engine.scene.scene import Scene

SIZE = (640, 480)

#: Most directions that stand for an environment. A preview takes about a second for each on two cores.
DIRECTIONS = 16


def draw(scene: Scene, look: Look) -> Steps[NDArray[np.uint8]]:
    """(480, 640, 4) uint8: `scene` with the exposure and tone mapping of `look`, sRGB-coded, and its opacity."""
    yield Step(0.0, "compiling (first use only)")
    scene = dataclasses.replace(scene, directions=min(scene.directions, DIRECTIONS))
    image = yield from radiance(scene, SIZE, samples=1)
    return display_apart(image, Display(look.exposure_ev, look.tone_map))


@dataclass(frozen=True)
class Exported:
    """A bundle that was written: what its verification found, and the bytes of its members."""

    path: Path
    problems: tuple[str, ...]
    members: dict[str, int]


def export(
    project: Project,
    path: Path,
    scene: Scene | None,
    include: Set[str] = frozenset(PARTS),
    origin: Mapping[str, Any] = MappingProxyType({}),
) -> Steps[Exported]:
    """Write the material of `project` with the parts in `include` as the bundle `path`, then verify it.

    The preview shows `scene`; `origin` and the view join the provenance. Raises OutputError where the bundle cannot be
    written.
    """
    yield Step(0.0, "preparing the bundle")
    from engine.bundle.bundle import check_replaceable, save_bundle, verify_bundle
    from engine.images.encode import encode_png

    whole, name = material_with_surface(project), path.name.removesuffix(".lightarc")
    material = dataclasses.replace(
        whole,
        shading_map=whole.shading_map if "slices" in include else None,
        power_law=whole.power_law if "power-law" in include else None,
        directional=whole.directional if "planes" in include else None,
        pbr=whole.pbr if "pbr" in include else None,
        surface=whole.surface if "pbr" in include else None,
        name=name,
    )
    if material.surface is not None and not material.has_map:
        material = material_of_maps(material.surface.maps, name)
    check_replaceable(path)
    preview = None
    if scene is not None:
        preview = encode_png((yield from part(draw(scene, project.look), 0.0, 0.2)))
    figures = error_figures(material)
    provenance = {**project.provenance, **origin, "view": view_of(project, path)}
    saving = save_bundle(path, material, provenance=provenance, figures=figures, preview=preview)
    yield from part(saving, 0.2, 0.85)
    yield Step(0.85, "verifying the bundle")
    problems = verify_bundle(path).problems
    members = describe_bundle(path, MAPS_PROCESS)["members"] if not problems else {}
    return Exported(path, problems, {name: member["size_bytes"] for name, member in members.items()})
