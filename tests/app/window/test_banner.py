"""Paths in the sentences of banners: on one line, short, and with the name of the file."""

from __future__ import annotations

from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from app.window.banner import MAX_LETTERS, MAX_OF_NAME, short_path
from engine.core.escape import escape_controls

NAMES = st.text(st.characters(codec="utf-8", exclude_characters="/\0"), min_size=1, max_size=200)


def test_folders_in_the_middle_are_left_out_whole() -> None:
    path = Path("/disks/third/A folder with a rather long name for photographs/Shelf 2/Felt.lap")
    assert str(short_path(path)) == "/disks/…/Shelf 2/Felt.lap"
    assert short_path(Path("/disks/third/Felt.lap")) == "/disks/third/Felt.lap"
    assert short_path(Path("/a") / f"{'x' * 100}.lap") == f"/a/{'x' * 20}…{'x' * 16}.lap"


@given(st.lists(NAMES.filter(lambda name: name not in (".", "..")), min_size=1, max_size=8))
def test_a_path_is_short_whatever_its_names(names: list[str]) -> None:
    shown = short_path(Path("/", *names))
    assert escape_controls(shown) == shown
    assert len(shown) <= max(MAX_LETTERS, 2 * MAX_OF_NAME + len("/…/…/…"))
    end = escape_controls(names[-1])
    assert shown.endswith(end[-MAX_OF_NAME // 2 :])
