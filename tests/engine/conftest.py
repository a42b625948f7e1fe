"""An OpenGL context for tests that draw, watched for errors."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from engine.core.errors import MissingCapability
from engine.core.shader_files import SHADERS
from engine.gl.context import create_context


@pytest.fixture
def gl() -> Iterator[Any]:
    """A fresh standalone context; the test fails if it leaves a GL error behind."""
    try:
        context = create_context()
    except MissingCapability as missing:
        pytest.skip(str(missing))
    with context:
        assert context.error == "GL_NO_ERROR"
        yield context
        assert context.error == "GL_NO_ERROR"
    context.release()


@pytest.fixture
def shader(tmp_path: Path) -> Callable[[str, str], Path]:
    """Put a shader file beside a copy of the program's own; returns the folder."""

    def put(name: str, text: str) -> Path:
        folder = tmp_path / "shaders"
        if not folder.exists():
            shutil.copytree(SHADERS, folder)
        (folder / name).write_text(text)
        return folder

    return put
