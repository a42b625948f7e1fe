"""Shaders that evaluate the material itself: GLSL and HLSL functions without other files, and the maps that they read.

These are exact: the look-up of the shading map, within a sum over lights, as this program draws it (Kautz2004 Eq. 2,
Kautz2004 Eq. 4). The GLSL is that of the bundle. The HLSL of the BRDF is the GLSL in other words: the shaders of
resources/shaders keep to a part of the language that translates word by word, and tests compile every model. OSL has no
place for a look-up by the direction of light; of the PBR maps the generator of MaterialX makes it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from functools import partial

from engine.bundle.directional import directional_members
from engine.bundle.maps import map_members
from engine.bundle.portable import brdf_source, shader, shader_from
from engine.core.errors import UsageError
from engine.core.steps import Step, Steps
from engine.exchange.loss import Shown, material_shown
from engine.exchange.subject import Contents, Files, Settings, Subject, fit_warnings
from engine.images.exr_strips import Planes, encoded

#: Words of GLSL and what HLSL calls them; `end` and the like are words of neither.
_WORDS = {
    **{f"vec{n}": f"float{n}" for n in (2, 3, 4)},
    **{f"ivec{n}": f"int{n}" for n in (2, 3, 4)},
    **{f"mat{n}": f"float{n}x{n}" for n in (2, 3, 4)},
    "mix": "lerp",
    "fract": "frac",
    "inversesqrt": "rsqrt",
    "atan": "atan2",
}
_WORD = re.compile(r"\b(" + "|".join(_WORDS) + r")\b")
_CONSTANT = re.compile(r"^const ", re.MULTILINE)
_ARRAY = re.compile(r"= float\[\d+\]\(([^;]*)\);")
_VECTOR = re.compile(r"\bvec([234])\(")


def shown(subject: Subject, _settings: Settings) -> Shown | None:
    """The planes, or the power law, which is what the head of the shader offers first; else the slices.

    A measured BRDF leaves as the model nearest to it, so that its error is part of the loss.
    """
    return subject.kept("power-law", lambda: material_shown(subject.portable, "power-law"))


def contents(subject: Subject, _settings: Settings, loss: str) -> Steps[Contents]:
    """`NAME.glsl`, `NAME.hlsl` and the maps as in a bundle."""
    material = subject.material
    if not material.has_map:
        raise UsageError("shaders look up a map, and this material has none")
    yield Step(0.0, "writing shaders")
    files: dict[str, bytes | Callable[[], bytes]] = {f"{subject.name}.glsl": shader(material, loss).encode()}
    warnings = []
    if material.directional is None:
        source = hlsl_of(brdf_source(material))
        files[f"{subject.name}.hlsl"] = shader_from("lightarc.hlsl", material, source, loss).encode()
    else:
        warnings.append("a directional map has a shader in GLSL alone")
    members = map_members(material)
    if material.directional is not None:
        members |= directional_members(material.directional)
    files |= {name: partial(_member, produce) for name, produce in members.items()}
    return Contents(Files(files), _bytes_per_texel(subject), (*fit_warnings(subject), *warnings))


def _member(produce: Callable[[], bytes | Planes]) -> bytes:
    return encoded(produce())


def _bytes_per_texel(subject: Subject) -> float:
    """Bytes of a look-up: the planes, the pair, or two slices."""
    material = subject.material
    if material.directional is not None:
        return float(material.directional.bytes_per_texel)
    if material.power_law is not None:
        return material.power_law.size_bytes / subject.maps.roughness.size
    return 24.0


def hlsl_of(glsl: str) -> str:
    """The text of a shader of resources/shaders in HLSL.

    A constructor with one scalar becomes a cast, constants become static, arrays take braces, and words their others.
    """
    text = _ARRAY.sub(r"= {\1};", _CONSTANT.sub("static const ", glsl))
    return _WORD.sub(lambda word: _WORDS[word[1]], "".join(_casts(text)))


def _casts(text: str) -> Iterator[str]:
    """`text` with `((floatN)(x))` in place of `vecN(x)`, where x is one argument; what is inside is treated alike."""
    place = 0
    for found in _VECTOR.finditer(text):
        if found.start() < place:
            continue
        end, commas = _closing(text, found.end())
        inside = "".join(_casts(text[found.end() : end]))
        yield text[place : found.start()]
        yield f"((float{found[1]})({inside}))" if commas == 0 else f"vec{found[1]}({inside})"
        place = end + 1
    yield text[place:]


def _closing(text: str, start: int) -> tuple[int, int]:
    """Place of the parenthesis that closes the one before `start`, and the commas between that belong to it."""
    depth, commas = 1, 0
    for place in range(start, len(text)):
        letter = text[place]
        depth += (letter == "(") - (letter == ")")
        commas += letter == "," and depth == 1
        if depth == 0:
            return place, commas
    raise ValueError("a parenthesis is not closed")
