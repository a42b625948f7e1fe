"""Shader programs from `resources/shaders`, with `#include` that nests, includes each file once and keeps lines.

`#include "brdf/phong.glsl"` names a file; `#include BRDF` the file that the definition BRDF gives. Each piece is
opened by `#line LINE NUMBER`, and the numbers are turned back into file names in the driver's messages.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import moderngl

from engine.core.interrupts import interrupts_held
from engine.core.shader_files import SHADERS, find

_INCLUDE = re.compile(r'\s*#\s*include\s+(?:"(?P<file>[^"]+)"|(?P<name>\w+))\s*$')

#: Line numbers in drivers' messages: Mesa `2:14(5): error`, NVIDIA `2(14) : error`, others `ERROR: 2:14:`.
_POSITIONS = (re.compile(r"\b(\d+):(\d+)(?=\(\d+\)|:)"), re.compile(r"\b(\d+)\((\d+)\)(?= ?:)"))


class ShaderError(RuntimeError):
    """A shader does not compile or link; the message is the driver's, with file names and lines."""


def expand(name: str, definitions: Mapping[str, str], folder: Path = SHADERS) -> tuple[str, list[str]]:
    """The text of shader file `name` with its includes and definitions, and the files by their `#line` number."""
    files: list[str] = []
    lines = _expand(name, definitions, folder, files)
    if not lines or not lines[0].startswith("#version"):
        raise ShaderError(f"{name}:1: the first line must be #version")
    defined = [f"#define {key} {value}" for key, value in definitions.items() if not value.endswith(".glsl")]
    return "\n".join([lines[0], *defined, "#line 2 0", *lines[1:]]) + "\n", files


def _expand(name: str, definitions: Mapping[str, str], folder: Path, files: list[str]) -> list[str]:
    number = len(files)
    files.append(name)
    result: list[str] = []
    for line_number, line in enumerate(find(name, folder).read_text(encoding="utf-8").splitlines(), start=1):
        include = _INCLUDE.match(line)
        if include is None:
            result.append(line)
            continue
        wanted = include["file"] or definitions.get(include["name"], "")
        if not find(wanted, folder).is_file():
            raise ShaderError(f"{name}:{line_number}: there is no shader file {wanted or include['name']!r}")
        if wanted not in files:
            result += [f"#line 1 {len(files)}", *_expand(wanted, definitions, folder, files)]
        result.append(f"#line {line_number + 1} {number}")
    return result


def load_program(
    context: moderngl.Context,
    vertex: str,
    fragment: str | None,
    definitions: Mapping[str, str] | None = None,
    *,
    folder: Path = SHADERS,
    varyings: Sequence[str] = (),
) -> moderngl.Program:
    """Compile and link the shader files `vertex` and `fragment` with `#define`s; ShaderError with the driver's log.

    `varyings` are what transform feedback writes.
    """
    definitions = definitions or {}
    vertex_text, vertex_files = expand(vertex, definitions, folder)
    fragment_text, fragment_files = expand(fragment, definitions, folder) if fragment else (None, [])
    try:
        with interrupts_held():
            return context.program(vertex_shader=vertex_text, fragment_shader=fragment_text, varyings=tuple(varyings))
    except moderngl.Error as error:
        message = str(error)
        files = fragment_files if "fragment_shader" in message else vertex_files
        raise ShaderError(_with_names(message, files)) from None


def _with_names(message: str, files: list[str]) -> str:
    def find_named(match: re.Match[str]) -> str:
        number = int(match[1])
        return f"{files[number]}:{match[2]}" if number < len(files) else match[0]

    spoken = next((position for position in _POSITIONS if position.search(message)), None)
    return spoken.sub(find_named, message) if spoken else message


def set_uniforms(program: moderngl.Program, values: Mapping[str, Any]) -> None:
    """Set those uniforms that the compiled program kept."""
    for name, value in values.items():
        if name in program:
            find_uniform(program, name).value = value


def find_uniform(program: moderngl.Program, name: str) -> moderngl.Uniform:
    """A uniform that the compiled program kept; KeyError where it did not."""
    uniform = program[name]
    assert isinstance(uniform, moderngl.Uniform), f"{name} is no uniform"
    return uniform
