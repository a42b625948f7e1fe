"""The manual for a browser: it is built without a warning, and F1 finds the anchors of all headings in it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from app.help.anchors import anchor_of
from app.help.manual import PAGES, headings

PROJECT = Path(__file__).resolve().parents[1]

#: Of the offline copy in the wheel.
MAX_BYTES = 25_000_000


@pytest.mark.parametrize("theme", ["basic", pytest.param("furo", marks=pytest.mark.long)])
def test_the_manual_is_built_without_warnings_and_has_the_anchors_that_f1_opens(tmp_path: Path, theme: str) -> None:
    """The theme of the manual writes the tree of all pages into each, which takes half of the time."""
    build = [sys.executable, PROJECT / "packaging" / "manual.py", tmp_path, "--theme", theme, "--without-examples"]
    done = subprocess.run([*map(str, build)], cwd=PROJECT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-4000:]
    html = tmp_path / "html"
    assert sum(path.stat().st_size for path in html.rglob("*") if path.is_file()) < MAX_BYTES
    for page in PAGES.glob("*.md"):
        shown = (html / "reference" / "workspaces" / f"{page.stem}.html").read_text(encoding="utf-8")
        anchors = [anchor_of(page.stem, heading) for heading in ("", *headings(page.stem))]
        assert [anchor for anchor in anchors if f'id="{anchor}"' not in shown] == []


@pytest.mark.long
def test_the_manual_is_built_with_its_examples(tmp_path: Path) -> None:
    pytest.importorskip("sphinx_gallery")
    build = [sys.executable, PROJECT / "packaging" / "manual.py", tmp_path]
    done = subprocess.run([*map(str, build)], cwd=PROJECT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-4000:]
    assert len([*(tmp_path / "html" / "gallery").glob("plot_*.html")]) == 12
