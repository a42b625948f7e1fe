"""How many directions an environment needs: errors against the sum over the whole map, for a matt and a shiny BRDF."""

from __future__ import annotations

from dataclasses import dataclass

from engine.brdf.brdf import brdf_from_text
from engine.camera import frame
from engine.environment import EnvironmentMap
from engine.material import Material
from engine.render.environment_error import DirectionsError, error_ladder
from engine.scene import Scene
from engine.shapes import shape
from engine.steps import Steps, part

COUNTS = (8, 16, 32, 64, 128, 256, 512)
BRDFS = ("lambert", "phong:kd=0.2,ks=0.6,exponent=100")
SIZE = (160, 120)


@dataclass(frozen=True)
class Ladder:
    """The errors of one BRDF by rising number of directions; a curve of a plot."""

    brdf: str
    errors: tuple[DirectionsError, ...]


def directions_ladders(material: Material, environment: EnvironmentMap, *, pixels: int = 64) -> Steps[list[Ladder]]:
    """The ladders of `BRDFS` for `material` on the sphere; about 10 s each with 64 pixels."""
    mesh = shape("sphere")
    camera = frame(mesh.positions, SIZE[0] / SIZE[1])
    ladders = []
    for index, text in enumerate(BRDFS):
        scene = Scene(mesh, camera, brdf_from_text(text), material, environment=environment)
        steps = error_ladder(scene, SIZE, COUNTS, pixels=pixels)
        errors = yield from part(steps, index / len(BRDFS), (index + 1) / len(BRDFS))
        ladders.append(Ladder(text, tuple(errors)))
    return ladders
