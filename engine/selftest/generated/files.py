"""Laws of files of strangers: text in any coding, and damaged models, images and measurements."""

from __future__ import annotations

import base64
from functools import cache
from typing import Any

import numpy as np
from hypothesis import strategies as st

from engine.core.errors import InputError
from engine.geometry.mesh_weld import without_gaps
from engine.images.encode import encode_exr, encode_png, rgb_channels
from engine.selftest.case import Found
from engine.selftest.generated.law import SEED, SHARE, Law, Values, decades, draw, many
from engine.selftest.light import sphere
from engine.storage.text import utf8
from engine.storage.untrusted import decode_content

_MESH = "engine.geometry.mesh:decode_mesh"
_IMAGE = "engine.images.decode:decode"


#: Kinds of files that are damaged.
FILES = ("model.obj", "model.off", "model.stl", "picture.png", "picture.exr", "picture.hdr")


@cache
def _good() -> dict[str, tuple[str, bytes]]:
    """Small good files: the decoder of each, and its content."""
    image = np.random.default_rng(0).random((9, 7, 3)).astype(np.float32)
    model = sphere(3)
    corners = "".join(f"v {x:.6g} {y:.6g} {z:.6g}\n" for x, y, z in model.positions)
    faces = "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in model.faces)
    off = f"OFF\n{len(model.positions)} {len(model.faces)} 0\n" + corners.replace("v ", "")
    off += "".join(f"3 {a} {b} {c}\n" for a, b, c in model.faces)
    triangles = model.positions[model.faces].astype("<f4")
    rows = np.zeros(len(triangles), np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")]))
    rows["corners"] = triangles
    radiance = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 5\n" + bytes(range(64, 144))
    return {
        "model.obj": (_MESH, (corners + faces).encode()),
        "model.off": (_MESH, off.encode()),
        "model.stl": (_MESH, bytes(80) + np.uint32(len(rows)).tobytes() + rows.tobytes()),
        "picture.png": (_IMAGE, encode_png((255.0 * image).astype(np.uint8))),
        "picture.exr": (_IMAGE, encode_exr(rgb_channels(image))),
        "picture.hdr": (_IMAGE, radiance),
    }


def find_damaged(case: Values) -> bytes:
    """The content of the case's file with its damage: bytes that are others, and an end that is missing."""
    content = bytearray(_good()[case["file"]][1])
    for share, byte in case["others"]:
        content[min(int(share * len(content)), len(content) - 1)] = int(byte) % 256
    return bytes(content[: max(1, round(case["rest"] * len(content)))])


def _decode(name: str, content: bytes) -> dict[str, Any]:
    options: dict[str, Any] = {"beside": {}} if name.startswith("model") else {}
    return decode_content(_good()[name][0], name, content, **options)


def _damage(case: Values) -> Found:
    """That a damaged file is refused is an answer, also by a decoder that a damage ends."""
    try:
        reply = _decode(case["file"], find_damaged(case))
    except InputError:
        return 0.0, 0.0
    arrays = [each for each in reply.values() if isinstance(each, np.ndarray) and each.dtype.kind == "f"]
    return float(sum(np.count_nonzero(~np.isfinite(each)) for each in arrays)), 0.0


def _any_bytes(case: Values) -> Found:
    for name in FILES:
        try:
            _decode(name, base64.b64decode(case["base64"]))
        except InputError:
            continue
    return 0.0, 0.0


def _codings(case: Values) -> Found:
    text = case["text"] * 20
    content = [utf8(text.encode(code)) for code in ("utf-8", "utf-16", "utf-16-le", "utf-16-be")]
    return float(sum(each != text.encode() for each in content)), 0.0


def _gaps(case: Values) -> Found:
    """A closed model whose triangles have corners of their own, off by up to 1e-7 of its size, of any size."""
    model = sphere(6)
    corners = (case["scale"] * model.positions[model.faces].reshape(-1, 3)).astype(np.float64)
    moved = corners + case["scale"] * np.random.default_rng(case["seed"]).uniform(-1e-7, 1e-7, corners.shape)
    closed, _ = without_gaps(moved, np.arange(len(moved)).reshape(-1, 3))
    return float(len(np.unique(closed, axis=0)) - len(model.positions)), 0.0


_TEXT = st.text(st.characters(min_codepoint=9, max_codepoint=126, exclude_categories=["Cc"]), min_size=1, max_size=40)

LAWS = (
    Law(
        "D2",
        "damaged files that give numbers that are none, or another answer than a refusal",
        draw(
            file=st.sampled_from(FILES),
            others=many(st.tuples(SHARE, st.integers(0, 255)).map(list), 0, 8),
            rest=st.one_of(st.just(1.0), SHARE),
        ),
        _damage,
    ),
    Law(
        "D3",
        "contents that no decoder can refuse",
        draw(base64=st.binary(min_size=1, max_size=200).map(lambda each: base64.b64encode(each).decode())),
        _any_bytes,
    ),
    Law("N4", "texts in UTF-16 that are not read", draw(text=_TEXT), _codings),
    Law("N3", "points too many in a model whose corners differ", draw(scale=decades(-20, 14), seed=SEED), _gaps),
)
