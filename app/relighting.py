"""What light makes of a bake: the part of relighting that runs on the threads of jobs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from app.bake_work import Made, Method
from engine.brdf.brdf import Brdf
from engine.scene import Scene
from engine.steps import Step, Steps

if TYPE_CHECKING:
    from engine.lamps import Lamp
    from engine.transport.lit import Lit
    from engine.transport.sh import Window
    from engine.transport.sh_transfer import ShTransport


def same_light(one: Scene, other: Scene, method: Method) -> bool:
    """Whether two scenes have one light for bakes of a method, which for harmonics takes the reflectance in."""
    names = ["light", "irradiance", "environment", "environment_rotation", "lamps"] + ["brdf"] * (method == "sh")
    return all(getattr(one, name) == getattr(other, name) for name in names)


def relit(
    method: Method, made: Made, scene: Scene, tabled: tuple[Brdf, ShTransport] | None, window: Window
) -> Steps[Lit]:
    """The light of `scene` on what was baked; `tabled` is the transport of the reflectance before."""
    yield Step(0.0, "preparing kernels")
    from engine.transport.lit import LitHarmonics, LitWavelets

    if method == "wavelet":
        rows = _tuples(made, scene)
        return LitWavelets(made.transport, rows)
    if method == "gaussian":
        return _lobes_under(made, scene)
    from engine.transport.sh import windowed
    from engine.transport.sh_lighting import scene_coefficients
    from engine.transport.sh_transfer import transferred

    transport: ShTransport = made.transport
    if tabled is not None and tabled[0] == scene.brdf:
        transport = tabled[1]
    elif made.wanted.brdf != scene.brdf:
        transport = yield from _with_brdf(transport, scene.brdf)
    transport.mesh.tangents.flags.writeable = False  # drawing would otherwise wait for them
    coefficients = windowed(scene_coefficients(scene, transport.order), window)
    return LitHarmonics(transport, transferred(transport, coefficients))


def _lobes_under(made: Made, scene: Scene) -> Lit:
    """Lobes under the light of `scene`, with everything that drawing would otherwise wait for."""
    from engine.transport.lit import lit_gaussians

    lit = lit_gaussians(
        made.transport,
        scene.environment,
        rotation=scene.environment_rotation,
        factor=scene.irradiance,
        lamps=_lamps(scene),
    )
    lit.transport.texels.flags.writeable = False
    lit.light.atlas.texels.flags.writeable = False
    return lit


def _lamps(scene: Scene) -> tuple[Lamp, ...]:
    """All lamps, the one light among them where there is no environment."""
    from engine.lamps import Lamp

    if scene.environment is not None or scene.irradiance <= 0.0:
        return scene.lamps
    return (Lamp(scene.light, (scene.irradiance,) * 3), *scene.lamps)


def _with_brdf(transport: ShTransport, brdf: Brdf) -> Steps[ShTransport]:
    from engine.transport.sh_table import tabulate
    from engine.transport.sh_transfer import with_table

    return with_table(transport, (yield from tabulate(brdf, transport.order)))


def _tuples(made: Made, scene: Scene) -> Any:
    from engine.transport.wavelet_lighting import dark, lighting_of

    edge, lamps = made.transport.edge, _lamps(scene)
    if scene.environment is None:
        return made.relighter.tuples(dark(edge, lamps))
    turn, factor = scene.environment_rotation, scene.irradiance
    return made.relighter.tuples(lighting_of(scene.environment, edge, rotation=turn, factor=factor, lamps=lamps))
