"""Doubts about what a verb was given: sentences for the `warnings` of its result, which every verb has."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from engine.light.environment import EnvironmentMap
    from engine.scene.scene import Scene


def doubts_of_brdf(brdf: Any) -> list[str]:
    """Sentences about a measured BRDF; none about a model."""
    return list(brdf.health.warnings) if hasattr(brdf, "health") else []


def doubts_of_light(environment: EnvironmentMap | None) -> list[str]:
    """Sentences about an environment, each with its name."""
    if environment is None:
        return []
    return [f"{environment.name}: {text}" for text in environment.health.warnings]


def doubts_of_scene(scene: Scene) -> list[str]:
    """Sentences about the model of a scene, its environment, its measured BRDF and its material, each once."""
    found = [*scene.mesh.health.warnings, *doubts_of_light(scene.environment), *doubts_of_brdf(scene.brdf)]
    if scene.material is not None:
        found += [f"{scene.material.name}: {text}" for text in scene.material.health.warnings]
    return list(dict.fromkeys(found))
