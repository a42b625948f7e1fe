"""Settings that a sweep measures, in order: sweeps of parameters, settings that are one, bakes that are made
together."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from engine.planning.bake_group import groups, is_apart
from engine.planning.costs.setting import Setting, parameters_of, sweep
from engine.scene.mode import MODES
from engine.scene.scene import Scene
from engine.transport import method as transport
from engine.transport.wavelet.haar import FACES


def modes_of(scene: Scene) -> tuple[str, ...]:
    """The modes that draw a scene, with a material those that look it up as well; 'direct' leaves its texels out."""
    unbaked = (
        mode.name for mode in MODES.values() if mode.spread is not None and (scene.has_texels or not mode.needs_map)
    )
    return (*transport.names(), *unbaked)


def _dear(mode: str) -> str:
    """The parameter of a mode that costs most, about whose cheapest value all others are turned as well."""
    return (MODES[mode] if mode in MODES else transport.method_of(mode)).dear


def settings_of(
    scene: Scene, modes: Sequence[str], bases: Sequence[Setting] = (), *, bounces: bool = False
) -> list[Setting]:
    """The sweeps of all parameters of some modes about `bases` (about the defaults where a mode has none), each once.

    They are climbed about the coarsest cube map and the fewest directions as well: on a large model there may be time
    for no other.
    Parameters that change nothing of this scene stay where they are: directions without an environment, light from the
    model itself without `bounces` in the reference, a power law that the material does not have.
    """
    found: dict[Setting, None] = {}
    for mode in modes:
        base = next((base for base in bases if base.mode == mode), Setting(mode))
        if bounces and "interreflection" in parameters_of(mode):
            base = base.replace(interreflection=1)
        dear = _dear(mode)
        coarse = (
            [base.replace(**{dear: parameters_of(mode)[dear].sweep[0]})]
            if dear and _matters(scene, dear, bounces)
            else []
        )
        for start in (base, *coarse):
            found |= dict.fromkeys([start])
            for parameter in parameters_of(mode):
                if _matters(scene, parameter, bounces):
                    found |= dict.fromkeys(sweep(mode, parameter, start))
    return list(found)


def _matters(scene: Scene, parameter: str, bounces: bool) -> bool:
    if parameter == "directions":
        return scene.environment is not None
    if parameter == "power_law":
        material = scene.material
        return material is not None and None not in (material.shading_map, material.power_law)
    return bounces if parameter == "interreflection" else True


def in_order(settings: Sequence[Setting]) -> list[list[Setting]]:
    """Settings that are measured together: images without a bake one by one, quick ones first, and then bakes."""
    at_once = sorted((setting for setting in settings if setting.mode in MODES), key=effort_of)
    return [[setting] for setting in at_once] + _jobs(settings)


def quick_first(settings: Sequence[Setting], bake_s: Callable[[Setting], float]) -> list[list[Setting]]:
    """The same, bakes by the time that is predicted of them.

    What a plan chose, and bakes in seconds, is not left out for the one setting of a mode that takes a minute.
    """
    return sorted(in_order(settings), key=lambda job: sum(bake_s(each) for each in job))


def reduce(setting: Setting, terms: int) -> Setting:
    """The least setting that is the same where a BRDF has so many terms, and maps as many coefficients as they have."""
    if "terms" not in setting.parameters:
        return setting
    kept = min(setting["coefficients"], FACES * setting["cube"] ** 2)
    return setting.replace(terms=min(setting["terms"], terms), coefficients=kept)


def _jobs(settings: Sequence[Setting]) -> list[list[Setting]]:
    """Bakes that are made together, cheap ones first: one lobe is cheaper than high orders, several are dearer."""
    shared = groups(settings)
    together = {setting for group in shared for setting in group}
    alone = [each for each in dict.fromkeys(settings) if each.mode in transport.names() and each not in together]
    low = [group for group in shared if not is_apart(group[0])]
    high = [group for group in shared if is_apart(group[0])]
    cheap = [[setting] for setting in alone if _is_cheapest(setting)]
    return low + cheap + high + [[setting] for setting in alone if not _is_cheapest(setting)]


def _is_cheapest(setting: Setting) -> bool:
    """True for the first step of the sweep of the first parameter."""
    name, parameter = next(iter(parameters_of(setting.mode).items()))
    return setting.parameters[name] == parameter.sweep[0]


def effort_of(setting: Setting) -> int:
    """The parameter that the time of a frame without a bake grows with."""
    return setting[next(iter(parameters_of(setting.mode)))]
