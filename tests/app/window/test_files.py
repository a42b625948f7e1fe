"""Files that come from outside the window."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest
from PySide6.QtCore import QUrl

from app.window.files import local_path


@pytest.mark.skipif(sys.platform in ("darwin", "win32"), reason="names are UTF-8 on this system")
def test_a_dropped_file_may_have_a_name_in_any_encoding() -> None:
    assert os.fsencode(local_path(QUrl.fromEncoded(b"file:///a/m%FF.lap"))) == b"/a/m\xff.lap"


@pytest.mark.parametrize("name", ["/a b%20/ä#?.png", "/plain.lap"])
def test_other_names_stay(name: str) -> None:
    assert local_path(QUrl.fromLocalFile(name)) == Path(name)
