"""Doubts about what a verb was given: sentences for the `warnings` of its result, which every verb has."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from engine.core.figure_text import number, percent
from engine.core.steps import Step, drain

if TYPE_CHECKING:
    from engine.brdf.brdf import Brdf
    from engine.light.environment import EnvironmentMap
    from engine.scene.material import Material
    from engine.scene.scene import Scene


def doubts_of_brdf(brdf: Brdf) -> list[str]:
    """Sentences about a measured BRDF; none about a model."""
    return list(brdf.health.warnings) if hasattr(brdf, "health") else []


def doubts_of_light(environment: EnvironmentMap | None) -> list[str]:
    """Sentences about an environment, each with its name."""
    if environment is None:
        return []
    return [f"{environment.name}: {text}" for text in environment.health.warnings]


def doubts_of_scene(scene: Scene) -> list[str]:
    """Sentences about the model of a scene, its environment, its measured BRDF and its materials, each once."""
    found = [*scene.mesh.health.warnings, *doubts_of_light(scene.environment), *doubts_of_brdf(scene.brdf)]
    if scene.material is not None:
        own = [each for each in scene.material.parts if each.name in scene.mesh.part_names]
        found += [f"{each.name}: {text}" for each in own or [scene.material] for text in each.health.warnings]
    if scene.mesh.colours is not None and scene.colours is None:
        found.append("the colours of the vertices are not drawn: they belong to materials of PBR maps")
    return list(dict.fromkeys(found))


def means_of_parts(materials: Sequence[Material], done: str = "drawn") -> list[str]:
    """A sentence about materials of parts whose maps are taken at their mean; none where there are no such parts."""
    textured = [each for each in materials if each.pbr is not None and each.pbr.size != (1, 1)]
    if not textured:
        return []
    names = ", ".join(repr(each.name) for each in textured[:4])
    return [f"the maps of {names}{' and others' if len(textured) > 4 else ''} are {done} at their mean"]


def mean_in_place_of_maps(material: Material, show: Callable[[Step], None], done: str = "shown") -> dict[str, Any]:
    """`material`, the BRDF at the mean of PBR maps with its error in their place, and `warnings`, the same in words."""
    from engine.exchange.loss import mean_brdf_loss

    error = drain(mean_brdf_loss(material), show)
    words = (
        f"the maps of {material.name} are {done} as the BRDF at their mean, {material.brdf}: on a ball under "
        f"{', '.join(error.rmse_rel)} an error of {percent(error.mean_rmse_rel)}, FLIP {number(error.mean_flip)}"
    )
    mean = {"brdf": material.brdf, "rmse_rel": error.mean_rmse_rel, "flip": error.mean_flip}
    return {"material": mean, "warnings": [words, *material.health.warnings]}
