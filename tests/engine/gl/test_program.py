"""Shader files: includes, line numbers, names in messages; contexts that cannot be had."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import moderngl
import pytest

from engine.core.errors import MissingCapability
from engine.core.shader_files import SHADERS
from engine.gl import context as context_module
from engine.gl.program import ShaderError, _with_names, expand


def files(folder: Path, **texts: str) -> Path:
    for name, text in texts.items():
        (folder / f"{name}.glsl").write_text(text)
    return folder


def test_includes_nest_each_once_and_keep_line_numbers(tmp_path: Path) -> None:
    folder = files(
        tmp_path,
        a='#version 330 core\n#include "b.glsl"\nA\n#include CHOSEN\nZ',
        b='B\n#include "c.glsl"\nB3',
        c="C",
        d='#include "c.glsl"\nD2',
    )
    text, names = expand("a.glsl", {"CHOSEN": "d.glsl", "FAST": "1"}, folder)
    assert names == ["a.glsl", "b.glsl", "c.glsl", "d.glsl"]
    assert text.splitlines() == [
        *("#version 330 core", "#define FAST 1", "#line 2 0"),
        *("#line 1 1", "B", "#line 1 2", "C", "#line 3 1", "B3", "#line 3 0"),
        *("A", "#line 1 3", "#line 2 3", "D2", "#line 5 0", "Z"),
    ]


def test_a_file_that_includes_itself_ends(tmp_path: Path) -> None:
    text, _ = expand("a.glsl", {}, files(tmp_path, a='#version 330 core\n#include "a.glsl"\nA'))
    assert text.count("A") == 1


def test_a_missing_include_and_a_missing_version_are_named(tmp_path: Path) -> None:
    folder = files(tmp_path, a='#version 330 core\n\n#include "nowhere.glsl"\n', b="void main() {}\n")
    with pytest.raises(ShaderError, match=r"a\.glsl:3: .*nowhere"):
        expand("a.glsl", {}, folder)
    with pytest.raises(ShaderError, match=r"b\.glsl:1"):
        expand("b.glsl", {}, folder)


@pytest.mark.parametrize(
    "message", ["1:14(5): error: x", "1(14) : error C0000: x", "ERROR: 1:14: 'x' : undeclared identifier"]
)
def test_every_driver_s_position_becomes_a_file_name(message: str) -> None:
    assert "brdf.glsl:14" in _with_names(message, ["direct.frag", "brdf.glsl"])


def test_every_shader_file_opens_with_what_goes_in_and_out() -> None:
    for path in SHADERS.rglob("*.*"):
        head = path.read_text().split("\n\n")[0]
        assert head.startswith(("//", "#version 330 core\n//")), path.name


@pytest.mark.parametrize("error", [Exception("eglInitialize failed"), OSError("libEGL.so"), ImportError("glcontext")])
def test_GL5_no_opengl_is_a_missing_capability_with_a_remedy(monkeypatch: pytest.MonkeyPatch, error: Exception) -> None:
    def refuse(**_: Any) -> Any:
        raise error

    monkeypatch.setattr(moderngl, "create_context", refuse)
    with pytest.raises(MissingCapability, match=r"apt install .*--renderer cpu"):
        context_module.create_context()


def test_a_mistake_of_ours_is_not_taken_for_a_missing_capability(monkeypatch: pytest.MonkeyPatch) -> None:
    def mistake(**_: Any) -> Any:
        raise KeyError("require")

    monkeypatch.setattr(moderngl, "create_context", mistake)
    with pytest.raises(KeyError):
        context_module.create_context()


def test_context_has_opengl_3_3_and_limits(gl: Any) -> None:
    assert gl.version_code >= 330
    limits = context_module.limits(gl)
    assert limits.texture_size >= 1024
    assert limits.layers >= 256
    assert context_module.renderer_name(gl)
