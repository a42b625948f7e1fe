"""ARCHITECTURE.md: its diagram is drawn from the imports, and what it names exists."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[1]
PAGE = (PROJECT / "ARCHITECTURE.md").read_text(encoding="utf-8")


def test_the_diagram_shows_the_imports() -> None:
    spec = importlib.util.spec_from_file_location("draw", PROJECT / "packaging" / "draw_architecture.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    drawn = (PROJECT / "resources" / "architecture.svg").read_text(encoding="utf-8")
    assert module.draw() == drawn, "type: python packaging/draw_architecture.py"


@pytest.mark.parametrize("path", sorted(set(re.findall(r"`([a-z_.]+/[a-z0-9_./-]*)`", PAGE))))
def test_paths_of_the_page_exist(path: str) -> None:
    assert (PROJECT / path).exists()
