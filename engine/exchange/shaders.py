"""Shaders that evaluate the material itself: GLSL, HLSL and OSL without other texts, and the maps that they read.

These are exact: the look-up of the shading map, within a sum over lights, as this program draws it (Kautz2004 Eq. 2,
Kautz2004 Eq. 4). The GLSL is that of the bundle, the BRDF in HLSL and OSL is the same in other words
(`engine.exchange.shaders`). OSL leaves light to the renderer, so that its shader is told where a light stands; of the
PBR maps, which need no such look-up, the generator of MaterialX makes OSL.

The GLSL of resources/shaders in HLSL and in OSL.

Its shaders keep to a part of the language that translates word by word; tests compile every model in each language.
OSL has no vectors of two, so that they become vectors whose third number is 0, which no product or length notices; it
has no constants outside functions, so that these become words of its preprocessor, and arrays become functions.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial

from engine.bundle.directional import directional_members
from engine.bundle.maps import map_members
from engine.bundle.portable import shader, shader_from
from engine.core.errors import UsageError
from engine.core.steps import Step, Steps
from engine.exchange.loss import Shown, material_shown
from engine.exchange.subject import Contents, Files, Settings, Subject, fit_warnings
from engine.images.exr_strips import Planes, encode

#: Words of GLSL and what HLSL calls them; `end` and the like are words of neither.
_HLSL = {
    **{f"vec{n}": f"float{n}" for n in (2, 3, 4)},
    **{f"ivec{n}": f"int{n}" for n in (2, 3, 4)},
    **{f"mat{n}": f"float{n}x{n}" for n in (2, 3, 4)},
    "mix": "lerp",
    "fract": "frac",
    "inversesqrt": "rsqrt",
    "atan": "atan2",
}

#: The same of OSL; names of variables that are words of OSL get another.
_OSL = {
    **{f"vec{n}": "vector" for n in (2, 3)},
    "bool": "int",
    "atan": "atan2",
    "out": "output",
    "normal": "facing_groove",
    "diffuse": "matte",
}

#: Numbers of a vector by their names.
_PLACES = {"x": 0, "y": 1, "z": 2, "r": 0, "g": 1, "b": 2}

_HLSL_WORD = re.compile(r"\b(" + "|".join(_HLSL) + r")\b")
_OSL_WORD = re.compile(r"\b(" + "|".join(_OSL) + r")\b")

_CONSTANT = re.compile(r"^const ", re.MULTILINE)
_ARRAY = re.compile(r"= float\[\d+\]\(([^;]*)\);")
_VECTOR = re.compile(r"\bvec([234])\(")

_OSL_ARRAY = re.compile(r"^const float (\w+)\[(\d+)\] = float\[\d+\]\(([^;]*)\);", re.MULTILINE)
_OSL_CONSTANT = re.compile(r"^const \w+ (\w+) = ([^;]*);", re.MULTILINE)
_OSL_CONST = re.compile(r"\bconst (?=float|vec)")
_INDEXED = re.compile(r"\b([A-Za-z_]\w*)\[(\w+)\]")
_PAIR = re.compile(r"\b([A-Za-z_]\w*)\.([xyz])([xyz])\b")
_PLACE = re.compile(r"\b([A-Za-z_]\w*)\.([xyzrgb])\b")


def hlsl_of(glsl: str) -> str:
    """The text of a shader of resources/shaders in HLSL.

    A constructor with one scalar becomes a cast, constants become static, arrays take braces, and words their others.
    """
    text = _ARRAY.sub(r"= {\1};", _CONSTANT.sub("static const ", glsl))
    return _HLSL_WORD.sub(lambda word: _HLSL[word[1]], "".join(_constructors(text, _cast)))


def osl_of(glsl: str) -> str:
    """The text of a shader of resources/shaders in OSL, whose triples are vectors."""
    arrays = [found[1] for found in _OSL_ARRAY.finditer(glsl)]
    text = _OSL_ARRAY.sub(r"float \1(int k)\n{\n    float numbers[\2] = {\3};\n    return numbers[k];\n}", glsl)
    text = _INDEXED.sub(lambda found: f"{found[1]}({found[2]})" if found[1] in arrays else found[0], text)
    text = _OSL_CONST.sub("", _OSL_CONSTANT.sub(r"#define \1 \2", text))
    text = _PAIR.sub(lambda pair: f"vec2({pair[1]}[{_PLACES[pair[2]]}], {pair[1]}[{_PLACES[pair[3]]}])", text)
    text = _PLACE.sub(lambda place: f"{place[1]}[{_PLACES[place[2]]}]", text)
    return _OSL_WORD.sub(lambda word: _OSL[word[1]], "".join(_constructors(text, _triple)))


def _cast(width: str, inside: str, commas: int) -> str:
    return f"((float{width})({inside}))" if commas == 0 else f"float{width}({inside})"


def _triple(width: str, inside: str, commas: int) -> str:
    """A vector of OSL: of one number all are it, but for the third of two."""
    if width == "3":
        return f"vector({inside})"
    return f"vector({inside}, {inside}, 0.0)" if commas == 0 else f"vector({inside}, 0.0)"


def _constructors(text: str, made: Callable[[str, str, int], str]) -> Iterator[str]:
    """`text` with `made(N, arguments, commas between them)` in place of each `vecN(arguments)`, also within others."""
    place = 0
    for found in _VECTOR.finditer(text):
        if found.start() < place:
            continue
        end, commas = _closing(text, found.end())
        yield text[place : found.start()]
        yield made(found[1], "".join(_constructors(text[found.end() : end], made)), commas)
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


def show(subject: Subject, _settings: Settings) -> Shown | None:
    """The planes, or the power law, which is what the head of the shader offers first; else the slices.

    A measured BRDF leaves as the model nearest to it, so that its error is part of the loss.
    """
    return subject.remember("power-law", lambda: material_shown(subject.portable, "power-law"))


def slices_shown(subject: Subject, _settings: Settings) -> Shown | None:
    """The slices, which GLSL and HLSL look up as well; None where there are none beside a power law."""
    if subject.material.power_law is None or subject.material.shading_map is None:
        return None
    return subject.remember("slices", lambda: material_shown(subject.portable))


def law_alone_shown(subject: Subject, _settings: Settings) -> Shown | None:
    """The power law in all tiles, as HLSL, OSL and pages show it; None where no tile keeps its slices."""
    law = subject.material.power_law
    if law is None or law.kept is None:
        return None
    alone = replace(subject.portable, power_law=replace(law, kept=None))
    return subject.remember("power law alone", lambda: material_shown(alone, "power-law"))


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
        warnings.append("tiles that keep their slices are sampled by the GLSL alone, and shown by the power law else")
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
