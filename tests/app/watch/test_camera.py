"""A camera on a cable: that of libgphoto2 which is a folder (`disk:`), where the library is installed."""

from __future__ import annotations

import importlib.util
import time
from contextlib import closing
from pathlib import Path

import pytest

from app.watch.camera import Camera
from engine.core.errors import InputError, MissingCapability

HAS_LIBRARY = importlib.util.find_spec("gphoto2") is not None


@pytest.mark.skipif(HAS_LIBRARY, reason="gphoto2 is installed")
def test_what_is_missing_is_named(tmp_path: Path) -> None:
    with pytest.raises(MissingCapability, match=r"gphoto2.*pip install 'lightarc\[camera\]'"):
        Camera(tmp_path)


@pytest.mark.skipif(not HAS_LIBRARY, reason="gphoto2 is not installed")
def test_photographs_are_copied_as_they_are_taken(tmp_path: Path) -> None:
    card, folder = tmp_path / "card", tmp_path / "taken"
    for place in (card / "DCIM", folder):
        place.mkdir(parents=True)
    (card / "DCIM" / "old.jpg").write_bytes(b"taken before")
    (folder / "two.jpg").write_bytes(b"of another camera")
    with closing(Camera(folder, f"disk:{card}")) as camera:
        assert camera.name == "Directory Browse"
        contents = {"one.jpg": bytes(range(256)) * 900, "two.jpg": b"2" * 70_000, "notes.txt": b"none", ".x.jpg": b"3"}
        for name, content in contents.items():
            (card / "DCIM" / name).write_bytes(content)
        found, until_s = list[Path](), time.monotonic() + 60.0
        while len(found) < 2 and time.monotonic() < until_s:
            found += camera.wait(0.2)
    assert {path.name for path in found} == {"one.jpg", "two-2.jpg"}
    assert (folder / "one.jpg").read_bytes() == contents["one.jpg"]
    assert (folder / "two-2.jpg").read_bytes() == contents["two.jpg"]
    assert (folder / "two.jpg").read_bytes() == b"of another camera"
    assert not (folder / "old.jpg").exists()


@pytest.mark.skipif(not HAS_LIBRARY, reason="gphoto2 is not installed")
def test_a_camera_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="switched on"):
        Camera(tmp_path)
