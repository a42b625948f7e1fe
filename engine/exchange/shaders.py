"""Shaders that evaluate the material itself: GLSL, HLSL and OSL without other texts, and the maps that they read.

These are exact: the look-up of the shading map, within a sum over lights, as this program draws it (Kautz2004 Eq. 2,
Kautz2004 Eq. 4). The GLSL is that of the bundle, the BRDF in HLSL and OSL is the same in other words
(`engine.exchange.dialects`). OSL leaves light to the renderer, so that its shader is told where a light stands; of the
PBR maps, which need no such look-up, the generator of MaterialX makes OSL.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from engine.bundle.directional import directional_members
from engine.bundle.maps import map_members
from engine.bundle.portable import shader, shader_from
from engine.core.errors import UsageError
from engine.core.steps import Step, Steps
from engine.exchange.dialects import hlsl_of, osl_of
from engine.exchange.loss import Shown, material_shown
from engine.exchange.subject import Contents, Files, Settings, Subject, fit_warnings
from engine.images.exr_strips import Planes, encode


def show(subject: Subject, _settings: Settings) -> Shown | None:
    """The planes, or the power law, which is what the head of the shader offers first; else the slices.

    A measured BRDF leaves as the model nearest to it, so that its error is part of the loss.
    """
    return subject.kept("power-law", lambda: material_shown(subject.portable, "power-law"))


def slices_shown(subject: Subject, _settings: Settings) -> Shown | None:
    """The slices, which GLSL and HLSL look up as well; None where there are none beside a power law."""
    if subject.material.power_law is None or subject.material.shading_map is None:
        return None
    return subject.kept("slices", lambda: material_shown(subject.portable))


def law_alone_shown(subject: Subject, _settings: Settings) -> Shown | None:
    """The power law in all tiles, as HLSL, OSL and pages show it; None where no tile keeps its slices."""
    law = subject.material.power_law
    if law is None or law.kept is None:
        return None
    alone = replace(subject.portable, power_law=replace(law, kept=None))
    return subject.kept("power law alone", lambda: material_shown(alone, "power-law"))


def contents(subject: Subject, _settings: Settings, loss: str) -> Steps[Contents]:
    """`NAME.glsl`, `NAME.hlsl`, `NAME.osl` and the maps as in a bundle."""
    material = subject.material
    if not material.has_map:
        raise UsageError("shaders look up a map, and this material has none")
    yield Step(0.0, "writing shaders")
    files: dict[str, bytes | Callable[[], bytes]] = {f"{subject.name}.glsl": shader(material, loss).encode()}
    kind = "lightarc" if material.directional is None else "directional"
    for language, translated in (("hlsl", hlsl_of), ("osl", osl_of)):
        text = shader_from(f"{kind}.{language}", material, translated, loss)
        files[f"{subject.name}.{language}"] = text.encode()
    warnings = []
    if material.power_law is not None and material.power_law.kept is not None:
        warnings.append("tiles that keep their slices are looked up by the GLSL alone, and shown by the power law else")
    if material.power_law is None and material.directional is None:
        warnings.append("the material has no power law, which the OSL looks up; GLSL and HLSL look its slices up")
    members = map_members(material)
    if material.directional is not None:
        members |= directional_members(material.directional)
    files |= {name: partial(_member, produce) for name, produce in members.items()}
    return Contents(Files(files), _bytes_per_texel(subject), (*fit_warnings(subject), *warnings))


def _member(produce: Callable[[], bytes | Planes]) -> bytes:
    return encode(produce())


def _bytes_per_texel(subject: Subject) -> float:
    """Bytes of a look-up: the planes, the pair, or two slices."""
    material = subject.material
    if material.directional is not None:
        return float(material.directional.bytes_per_texel)
    if material.power_law is not None:
        return material.power_law.size_bytes / subject.maps.roughness.size
    return 24.0
