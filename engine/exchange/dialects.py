"""The GLSL of resources/shaders in HLSL and in OSL.

Its shaders keep to a part of the language that translates word by word; tests compile every model in each language.
OSL has no vectors of two, so that they become vectors whose third number is 0, which no product or length notices; it
has no constants outside functions, so that these become words of its preprocessor, and arrays become functions.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

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
