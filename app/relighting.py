"""What light makes of a bake: the part of relighting that runs on the threads of jobs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from app.bake_work import Made
from engine.scene import Scene
from engine.steps import Step, Steps
from engine.transport.method import Method

if TYPE_CHECKING:
    from engine.transport.lit import Lit


def same_light(one: Scene, other: Scene, method: Method) -> bool:
    """True where two scenes have one light for bakes of a method, of which the BRDF is part where it can be changed."""
    names = ["light", "irradiance", "environment", "environment_rotation", "lamps"] + ["brdf"] * method.takes_brdf
    return all(getattr(one, name) == getattr(other, name) for name in names)


def relit(made: Made, scene: Scene, asked: Any) -> Steps[Lit]:
    """The light of `scene` on what was baked, with the settings of the light that are `asked` for."""
    yield Step(0.0, "preparing kernels")
    from engine.transport.lit import light_of

    return (yield from made.relighter(light_of(scene), asked, scene.brdf))
