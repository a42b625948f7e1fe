"""Names that are not UTF-8: every verb that writes works with them, or refuses them in words."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np
import pytest

from app.project.project_file import data_folder, read
from engine.images.encode import encode_png
from lightarc import open_bundle, save_bundle
from tests.app.command import Command
from tests.app.project.hostile import base

pytestmark = pytest.mark.skipif(sys.platform in ("darwin", "win32"), reason="names are UTF-8 on this system")


def test_projects_and_bundles_of_any_name(lightarc: Command, tmp_path: Path) -> None:
    project = base(tmp_path / os.fsdecode(b"in\xff"))
    for action in ("collect", "recover"):
        target = tmp_path / os.fsdecode(b"\xfe" + action.encode() + b".lap")
        ended = lightarc("project", action, project, "-o", target)
        assert ended.code == 0, ended.err
        assert read(target).current.name == "Felt"
        assert data_folder(target).is_dir() == data_folder(project).is_dir()
        assert not [path for path in tmp_path.iterdir() if ".waiting-" in path.name]
    bundle = tmp_path / os.fsdecode(b"m\xff.lightarc")
    assert lightarc("bundle", "make", project, "-o", bundle).code == 0
    assert lightarc("bundle", "verify", bundle).code == 0
    material = open_bundle(bundle)
    assert material.name.isprintable()
    save_bundle(tmp_path / "again.lightarc", material)


def test_differences_and_photographs_of_any_name(lightarc: Command, tmp_path: Path) -> None:
    folder = tmp_path / os.fsdecode(b"photographs\xff")
    folder.mkdir()
    noise = np.random.default_rng(0).uniform(0.7, 1.3, (18, 24, 3))
    for angle in (20, 50, 80):
        codes = np.clip(2 * angle * noise, 0, 255).astype(np.uint8)
        (folder / os.fsdecode(f"cloth_{angle}deg_".encode() + b"\xff.png")).write_bytes(encode_png(codes))
    stack, bundle = tmp_path / os.fsdecode(b"s\xff"), tmp_path / os.fsdecode(b"b\xff.lightarc")
    assert lightarc("import", folder, "-o", stack, "--no-align").code == 0
    assert lightarc("shade", stack, "-o", bundle, "--slices", 3).code == 0
    assert lightarc("bundle", "verify", bundle).code == 0
    images = sorted(folder.iterdir())
    ended = lightarc("compare", images[0], images[1], "--difference", tmp_path / os.fsdecode(b"d\xff.png"))
    assert ended.code == 0, ended.err
