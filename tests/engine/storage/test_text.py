"""Text in UTF-16 (`engine.storage.text`) reads as the same text in UTF-8, in every format that is text."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from engine.brdf.readers.read import read_measurement
from engine.capture.lights.capture_file import read_capture_file
from engine.capture.lights.light_positions import read_light_positions
from engine.geometry.mesh import decode_mesh
from engine.geometry.read_scene import estimate_faces
from engine.storage.text import utf8

BOX = trimesh.creation.box()
ASCII_PLY = (
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
)
MESHES = {
    "a.obj": "# Würfel\r\nv 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n",
    "a.off": "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    "a.ply": ASCII_PLY,
    "a.stl": BOX.export(file_type="stl_ascii"),
    "a.gltf": BOX.export(file_type="gltf", embed_buffers=True)["model.gltf"].decode(),
}
CSV = "theta_i,phi_i,theta_o,phi_o,r,g,b\n" + "".join(
    f"{15 * one},0,{12 * other},{45 * turn},{0.1 + 0.01 * one},0.2,0.3\n"
    for one in range(5)
    for other in range(5)
    for turn in range(5)
)
ALTA = "#DIM 2 1\n#PARAM_IN COS_TH_TD\n#PARAM_OUT INV_STERADIAN\n" + "".join(
    f"{0.1 + 0.2 * one} {0.1 + 0.2 * other} {0.1 + 0.02 * one}\n" for one in range(5) for other in range(5)
)
CODINGS = [("utf-16-le", b"\xff\xfe"), ("utf-16-le", b""), ("utf-16-be", b"\xfe\xff"), ("utf-16-be", b"")]

every_coding = pytest.mark.parametrize(("coding", "mark"), CODINGS, ids=lambda value: str(value))


def different(one: object, other: object) -> bool:
    return not np.array_equal(np.asarray(one), np.asarray(other))


@every_coding
def test_text_in_utf_16_is_what_it_is_in_utf_8(coding: str, mark: bytes, tmp_path: Path) -> None:
    for name, text in MESHES.items():
        content = mark + text.encode(coding)
        found, wanted = decode_mesh(content, name), decode_mesh(text.encode(), name)
        assert not [key for key in ("positions", "normals", "uv", "faces") if different(found[key], wanted[key])], name
        assert estimate_faces(content, len(content), name[2:]) >= len(wanted["faces"])
    (tmp_path / "a.lp").write_bytes(mark + "1\nlamp_ä.png 0 0.6 0.8\n".encode(coding))
    assert read_light_positions(tmp_path / "a.lp").lights[0].name == "lamp_ä.png"
    (tmp_path / "capture.toml").write_bytes(mark + "lamp_distance = 2.5\n".encode(coding))
    assert read_capture_file(tmp_path / "capture.toml").lamp_distance == 2.5
    for name, text in (("a.csv", CSV), ("a.txt", ALTA)):
        (tmp_path / name).write_bytes(mark + text.encode(coding))
        (tmp_path / f"8{name}").write_text(text)
        samples, same = (read_measurement(tmp_path / each) for each in (name, f"8{name}"))
        assert len(samples.value) >= 5
        assert not [key for key in ("wi", "wo", "value") if different(getattr(samples, key), getattr(same, key))], name


def test_what_is_not_utf_16_stays_as_it_is() -> None:
    for content in (b"", b"\0", b"OFF", b"\xff", "ä".encode("latin-1"), bytes(84), b"solid" + bytes(79), b"\0\1" * 40):
        assert utf8(content) in (content, content.replace(b"\0", b""))
    assert utf8(bytes(range(256)) * 3) == bytes(range(256)) * 3
    assert utf8(np.arange(1000.0).tobytes()) == np.arange(1000.0).tobytes()
    assert utf8(b"\xff\xfea\0b") == "a\ufffd".encode(), "a letter that was cut in two"
