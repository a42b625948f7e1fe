"""A complete mode from outside the package: the model in matte grey, to judge its shape."""

from __future__ import annotations

from dataclasses import replace

from lightarc import Lambert, Mode, Scene


def of_clay(scene: Scene) -> Scene:
    """The scene without its material."""
    return replace(scene, brdf=Lambert((0.5, 0.5, 0.5)), material=None)


CLAY = Mode("clay", "Clay", "Clay", "The shape alone, in matte grey", of_clay, key="Y", shows=frozenset())
