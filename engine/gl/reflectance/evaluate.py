"""The far side of `engine.brdf.written`: a GLSL reflectance evaluated for many pairs of directions.

It runs in a decoder process (`engine.storage.untrusted`), which gives up files, network and programs before it sees
the first source, and which the parent kills when a source takes too long. Where Mesa is the driver it is asked for
its software renderer, so that no source reaches a graphics card that the desktop needs too. Directions come as a
texture of 32-bit floats and values leave as one, in tiles between which the clock is looked at.

Mesa's software renderer ends all loops of a pixel after 65,535 iterations, without a word, and the values are then
wrong. Each loop of a source therefore counts its iterations (`count_loops`), and a source that needs more than
`MAX_ITERATIONS` for one pair is refused.

Cost on two cores: 0.5 s for the start, 10 ms to compile Disney's BRDF of 2012, then 15 ns a pair.
"""

from __future__ import annotations

import os
import re
import time
from collections.abc import Iterator, Sequence
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from engine.core.errors import InputError, MissingCapability
from engine.gl.context import Owned, create_context
from engine.gl.program import find_uniform

#: Pairs in a row of the textures, and rows in a tile: few, so that a slow source is noticed soon.
WIDTH, TILE_ROWS = 1024, 64

#: Line that ours begin at in the driver's messages; those of a source are below, where they stand in its file.
OURS = 1_000_000

#: Iterations of all loops together for one pair of directions; fewer than those after which Mesa ends a loop.
MAX_ITERATIONS = 60_000

#: Counts an iteration; false once there were too many.
_COUNTER = f"int lightarc_count = 0; bool lightarc_next() {{ return ++lightarc_count <= {MAX_ITERATIONS}; }}"

#: Comments; a text has no more than 65,536 bytes (`engine.brdf.written`).
_COMMENT = r"//[^\n]{0,65536}+|/\*[^*]{0,65536}+(?:\*(?!/)[^*]{0,65536}+){0,65536}+\*/"

#: Comments, which hold no loops, and the beginnings of loops; comments and spaces; comments, brackets and semicolons.
_LOOP = re.compile(rf"{_COMMENT}|\b(?P<kind>for|while)\s{{0,999}}+\(")
_NOTHING = re.compile(rf"{_COMMENT}|\s")
_STOP = re.compile(rf"{_COMMENT}|[();]")

#: A condition that declares a variable, which can be no operand.
_DECLARATION = re.compile(
    r"\s{0,999}+(?:const\s{1,999}+)?+[A-Za-z_]\w{0,999}+\s{1,999}+[A-Za-z_]\w{0,999}+\s{0,999}+=[^=]"
)

#: A triangle over the whole image.
_VERTEX = """#version 330
void main() { gl_Position = vec4(4.0 * vec2(gl_VertexID & 1, gl_VertexID >> 1) - 1.0, 0.0, 1.0); }
"""

_MAIN = f"""
#line {OURS}
uniform sampler2D lightarc_light;
uniform sampler2D lightarc_viewer;
out vec4 lightarc_value;
void main() {{
    ivec2 place = ivec2(gl_FragCoord.xy);
    vec3 light = texelFetch(lightarc_light, place, 0).xyz;
    vec3 viewer = texelFetch(lightarc_viewer, place, 0).xyz;
    vec3 value = BRDF(light, viewer, vec3(0.0, 0.0, 1.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0));
    lightarc_value = vec4(value, lightarc_count <= {MAX_ITERATIONS} ? 1.0 : 0.0);
}}
"""

#: Types of uniforms by what a source calls its parameters.
TYPES = {"float": "float", "bool": "bool", "color": "vec3"}

_state: dict[str, Any] = {}


def prepare() -> None:
    """Make the OpenGL context and draw once, before the process is confined and can load no driver any more."""
    os.environ |= {"LIBGL_ALWAYS_SOFTWARE": "1", "MESA_SHADER_CACHE_DISABLE": "true"}
    try:
        _state["context"] = create_context()
    except MissingCapability as error:
        _state["missing"] = [error.capability, error.remedy]
        return
    up = np.array([[0.0, 0.0, 1.0]], np.float32)
    _draw(_program("vec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y) { return pow(L, V); }"), up, up, 1.0, "")


def evaluate(
    content: bytes, name: str, shader: str, first_line: int, parameters: Sequence[Sequence[Any]], limit_s: float
) -> dict[str, Any]:
    """The decoder: `values` (N, 3) float32 as the source gives them and `cpu_s`, the time that they took; or `log`, the
    driver's message where it refuses.

    Parameters
    ----------
    content : 2 N unit directions as float32, first those towards the light, then those towards the viewer.
    shader, first_line : GLSL with the function BRDF, and the line of its file in which it begins.
    parameters : (type, name, line, value) of each.
    """
    if "missing" in _state:
        return {"missing": _state["missing"]}
    wi, wo = np.frombuffer(content, np.float32).reshape(2, -1, 3)
    declared = "\n".join(f"#line {line}\nuniform {TYPES[kind]} {word};" for kind, word, line, _ in parameters)
    try:
        program = _program(f"{declared}\n#line {first_line}\n{count_loops(shader, name)}")
    except moderngl.Error as error:
        return {"log": str(error)}
    for _, word, _, value in parameters:
        if word in program:
            find_uniform(program, word).value = tuple(value) if isinstance(value, list) else value
    begun_s = time.process_time()
    return {"values": _draw(program, wi, wo, limit_s, name), "cpu_s": time.process_time() - begun_s}


def count_loops(shader: str, name: str) -> str:
    """Let each loop of a shader count its iterations and end after `MAX_ITERATIONS` of all loops; no line moves.

    The condition of a loop becomes `lightarc_next() && (condition)`. InputError for a loop whose condition declares a
    variable.

    Examples
    --------
    >>> count_loops("for (int i = 0; i < 3; i++) x += 1.0;", "a.brdf")
    'for (int i = 0;lightarc_next() && ( i < 3); i++) x += 1.0;'
    """
    edits: list[tuple[int, str]] = []
    for loop in _LOOP.finditer(shader):
        if loop["kind"] is None:
            continue
        stops = list(_stops(shader, loop.end()))
        first, last = (stops[0], stops[1]) if loop["kind"] == "for" and len(stops) > 2 else (loop.end() - 1, stops[-1])
        condition = shader[first + 1 : last]
        if _DECLARATION.match(condition):
            raise InputError(name, "has a loop whose condition declares a variable", "Declare it before the loop")
        is_empty = not _NOTHING.sub("", condition)
        edits += [(first + 1, "lightarc_next()" if is_empty else "lightarc_next() && (")]
        edits += [] if is_empty else [(last, ")")]
    for place, text in sorted(edits, reverse=True):
        shader = shader[:place] + text + shader[place:]
    return shader


def _stops(shader: str, start: int) -> Iterator[int]:
    """Positions of the semicolons between the brackets of a loop that opened before `start`, and of the closing one."""
    depth = 1
    for found in _STOP.finditer(shader, start):
        depth += {"(": 1, ")": -1}.get(found[0], 0)
        if depth == 0 or (depth == 1 and found[0] == ";"):
            yield found.start()
        if depth == 0:
            return
    yield len(shader)


def _program(source: str) -> moderngl.Program:
    """The program of a source, which is kept for the next request: mostly the same with other values."""
    if _state.get("source") != source:
        if (old := _state.pop("program", None)) is not None:
            old.release()
        _state["source"] = None
        text = f"#version 330\n{_COUNTER}\n{source}\n{_MAIN}"
        _state["program"] = _state["context"].program(vertex_shader=_VERTEX, fragment_shader=text)
        _state["source"] = source
    return _state["program"]


def _draw(
    program: moderngl.Program, wi: NDArray[np.float32], wo: NDArray[np.float32], limit_s: float, name: str
) -> NDArray[np.float32]:
    context, count, end = _state["context"], len(wi), time.monotonic() + limit_s
    for unit, word in enumerate(("lightarc_light", "lightarc_viewer")):
        if word in program:
            find_uniform(program, word).value = unit
    values = np.empty((count, 3), np.float32)
    triangle = context.vertex_array(program, [])
    pairs = WIDTH * TILE_ROWS
    for first in range(0, count, pairs):
        if time.monotonic() > end:
            raise InputError(name, f"takes more than {limit_s:g} s to evaluate", "Shorten its loops")
        part = slice(first, min(first + pairs, count))
        with _Target(context, part.stop - first) as target:
            textures = {0: target.directions(wi[part]), 1: target.directions(wo[part])}
            for unit, texture in textures.items():
                texture.use(unit)
            target.framebuffer.use()
            triangle.render(moderngl.TRIANGLES, vertices=3)
            drawn = np.frombuffer(target.framebuffer.read(components=4, dtype="f4"), np.float32).reshape(-1, 4)
            if not drawn[: part.stop - first, 3].all():
                problem = f"needs more than {MAX_ITERATIONS:,} iterations of its loops for one pair of directions"
                raise InputError(name, problem, "Shorten its loops")
            values[part] = drawn[: part.stop - first, :3]
    triangle.release()
    return values


class _Target:
    """Textures and framebuffer of one tile, released at its end."""

    def __init__(self, context: moderngl.Context, count: int) -> None:
        self.context, self.count = context, count
        self.size = (WIDTH, -(-count // WIDTH))
        self._owned = [context.texture(self.size, 4, dtype="f4")]
        self.framebuffer = context.framebuffer(self._owned[:1])

    def directions(self, vectors: NDArray[np.float32]) -> moderngl.Texture:
        texels = np.zeros((self.size[0] * self.size[1], 3), np.float32)
        texels[: self.count] = vectors
        self._owned.append(self.context.texture(self.size, 3, texels, dtype="f4"))
        self._owned[-1].filter = (self.context.NEAREST, self.context.NEAREST)
        return self._owned[-1]

    def __enter__(self) -> _Target:
        return self

    def __exit__(self, *_what: object) -> None:
        owned: tuple[Owned, ...] = (self.framebuffer, *self._owned)
        for each in owned:
            each.release()
