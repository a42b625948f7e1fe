"""Text meshes that are cut, that hold what is no number, or that are older than UTF-8."""

from __future__ import annotations

from pathlib import Path

import pytest
import trimesh

from engine.core.errors import InputError
from engine.geometry.mesh import read_mesh

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def read(folder: Path, name: str, content: bytes) -> int:
    """Number of faces in a file of this content."""
    path = folder / name
    path.write_bytes(content)
    return len(read_mesh(path).faces)


@pytest.mark.parametrize("comment", ["# Würfel", "o Würfel"])
def test_names_in_latin_1_do_not_matter(tmp_path: Path, comment: str) -> None:
    assert read(tmp_path, "a.obj", f"{comment}\n{TRIANGLE}".encode("latin-1")) == 1


@pytest.mark.parametrize("kind", ["off", "ply"])
def test_fault5_a_mesh_that_lost_its_last_lines_is_refused(tmp_path: Path, kind: str) -> None:
    options = {"encoding": "ascii"} if kind == "ply" else {}
    exported = trimesh.creation.box().export(file_type=kind, **options)
    content = exported if isinstance(exported, bytes) else exported.encode()
    assert read(tmp_path, f"a.{kind}", content) == 12
    cut = b"\n".join(content.strip().split(b"\n")[:-3])
    with pytest.raises(InputError, match=r"of 20 lines that it announces, 17 follow"):
        read(tmp_path, f"a.{kind}", cut)


def test_fault5_an_stl_with_a_broken_number_is_refused(tmp_path: Path) -> None:
    content = trimesh.creation.box().export(file_type="stl_ascii").encode()
    vertices = content.split(b"vertex ")
    broken = b"vertex ".join([*vertices[:19], b"?" + vertices[19][1:], *vertices[20:]])
    with pytest.raises(InputError, match="damaged"):
        read(tmp_path, "a.stl", broken)
