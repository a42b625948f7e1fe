"""Files of reflectance transformation imaging against decoders written here from their formats."""

from __future__ import annotations

import contextlib
import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.special import factorial, lpmv

from engine.bundle.bundle import open_bundle, save_bundle
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.exchange import rti as writer
from engine.exchange.readers import rti
from engine.exchange.readers.read import holds_material, open_material
from engine.exchange.subject import Settings, Subject
from tests.engine.exchange.materials import dome_material, woven_subject
from tests.engine.exchange.test_rti import Viewer, read_hsh, read_ptm, read_relight, relief_stack, srgb

Codes = NDArray[np.uint8]
Numbers = NDArray[np.float64]

HEIGHT, WIDTH = 24, 40

#: Factors and constants of the six terms of the PTM files made here.
SCALE, BIAS = np.array((1.2, 1.0, 0.9, 1.4, 1.3, 1.6)), np.array((140, 150, 120, 128, 118, 0))

LIGHTS = [(0.0, 0.0, 1.0), (0.5, -0.3, 0.812), (-0.6, 0.55, 0.581), (0.1, 0.93, 0.354), (-0.97, -0.2, 0.138)]


def smooth(count: int, seed: int = 3) -> Codes:
    """(count, HEIGHT, WIDTH) codes that JPEG keeps well, away from 0 and 255."""
    coarse = np.random.default_rng(seed).uniform(90.0, 165.0, (count, 3, 5))
    return np.stack([cv2.resize(each, (WIDTH, HEIGHT), interpolation=cv2.INTER_CUBIC) for each in coarse]).astype(
        np.uint8
    )


def ptm_terms(x: float, y: float, _z: float) -> Numbers:
    return np.array([x * x, y * y, x * y, x, y, 1.0])


def head(version: str, form: str, more: str = "") -> bytes:
    scale, bias = " ".join(map(str, SCALE)), " ".join(map(str, BIAS))
    return f"{version}\n{form}\n{WIDTH}\n{HEIGHT}\n{scale} \n{bias} \n{more}".encode()


def ptm_viewer(planes: NDArray[np.generic], is_tinted: bool) -> Viewer:
    """Relight planes (9 or 18, H, W) whose first row is the lowest."""

    def view(x: float, y: float, z: float) -> Numbers:
        weights = ptm_terms(x, y, z) * SCALE
        shifted = (
            planes[: 6 if is_tinted else 18].astype(np.float64).reshape(-1, 6, HEIGHT, WIDTH) - BIAS[:, None, None]
        )
        seen = np.einsum("k,ckhw->hwc", weights, shifted)
        return (seen * np.moveaxis(planes[6:].astype(np.float64), 0, 2) / 255.0 if is_tinted else seen)[::-1]

    return view


def jpeg_ptm(is_tinted: bool) -> tuple[bytes, Viewer]:
    """Planes as JPEG: the second predicted from the first, the third from it turned over, one texel corrected."""
    count = 9 if is_tinted else 18
    planes = smooth(count)
    references, transforms = np.full(count, -1), np.zeros(count, int)
    references[1:3], transforms[2] = 0, 1
    order = [*range(count)]
    order[:3] = [0, 2, 1]
    streams, decoded = [], np.zeros((count, HEIGHT, WIDTH), np.int64)
    for number in range(count):
        wanted = planes[number].astype(np.int64)
        if references[number] >= 0:
            other = decoded[0] if not transforms[number] else 255 - decoded[0]
            wanted = wanted - other + 128
        stream = cv2.imencode(".jpg", wanted.clip(0, 255).astype(np.uint8), [cv2.IMWRITE_JPEG_QUALITY, 92])[1].tobytes()
        streams.append(stream)
        found = cv2.imdecode(np.frombuffer(stream, np.uint8), cv2.IMREAD_GRAYSCALE)
        assert found is not None
        decoded[number] = found if references[number] < 0 else (found.astype(np.int64) + other - 128) % 256
    decoded[2].flat[77] = 250
    side = struct.pack(">IB", 77, 250)
    rows: list[Any] = [
        transforms,
        np.zeros(count, int),
        np.zeros(count, int),
        order,
        references,
        [len(each) for each in streams],
    ]
    sides = np.zeros(count, int)
    sides[2] = len(side)
    said = "92\n" + "".join(" ".join(map(str, row)) + "\n" for row in (*rows, sides))
    body = b"".join(stream + (side if number == 2 else b"") for number, stream in enumerate(streams))
    form = "PTM_FORMAT_JPEG_LRGB" if is_tinted else "PTM_FORMAT_JPEG_RGB"
    return head("PTM_1.2", form, said) + body, ptm_viewer(decoded, is_tinted)


def first_lrgb() -> tuple[bytes, Viewer]:
    """PTM 1.1: nine bytes of each texel together."""
    planes = smooth(9)
    return head("PTM_1.1", "PTM_FORMAT_LRGB") + np.moveaxis(planes, 0, 2).tobytes(), ptm_viewer(planes, True)


def harmonics(terms: int) -> Callable[[float, float, float], Numbers]:
    """Gautron2004: associated Legendre polynomials of 2 cos θ − 1, without the sign (−1)^m that scipy gives them.

    Files have the other sign where m is 2.
    """

    def values(x: float, y: float, z: float) -> Numbers:
        phi, found = np.arctan2(y, x), []
        for order in range(4):
            for m in [*range(order, -1, -1), *range(-1, -order - 1, -1)]:
                size = abs(m)
                norm = np.sqrt((2 * order + 1) * factorial(order - size) / (2.0 * np.pi * factorial(order + size)))
                turned = 1.0 if m == 0 else np.sqrt(2.0) * (np.cos(size * phi) if m > 0 else np.sin(size * phi))
                sign = -1.0 if size == 2 else (-1.0) ** size
                found.append(sign * norm * turned * lpmv(size, order, 2.0 * z - 1.0))
        return np.array(found[:terms])

    return values


def hsh_file(terms: int, ending: str = "\n") -> tuple[bytes, Viewer]:
    codes = smooth(3 * terms, seed=terms).reshape(3, terms, HEIGHT, WIDTH)
    scale = np.linspace(0.5, 0.2, terms).astype("<f4")
    bias = np.linspace(0.9, -0.15, terms).astype("<f4")
    lines = ["#HSH1.2", "3", f"{WIDTH} {HEIGHT} 3", f"{terms} 2 1", ""]
    texels = np.moveaxis(codes, (0, 1), (2, 3))
    content = ending.join(lines).encode() + scale.tobytes() + bias.tobytes() + texels.tobytes()
    basis = harmonics(terms)
    return content, lambda x, y, z: 255.0 * ((texels / 255.0 * scale + bias) @ basis(x, y, z))


def tree(folder: Path, planes: Codes, jpeg: bool, **info: object) -> Codes:
    """Write a relight tree; planes (P, H, W) as their images give them back."""
    folder.mkdir()
    stored = []
    for number in range(len(planes) // 3):
        image = np.moveaxis(planes[3 * number : 3 * number + 3], 0, 2)[..., ::-1]
        path = folder / f"plane_{number}.{'jpg' if jpeg else 'png'}"
        cv2.imwrite(str(path), np.ascontiguousarray(image))
        read = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        assert read is not None
        stored += [read[..., channel] for channel in (2, 1, 0)]
    said = {"width": WIDTH, "height": HEIGHT, "nplanes": len(planes), "format": "jpg", **info}
    (folder / "info.json").write_text(json.dumps(said))
    return np.stack(stored)


def tinted_tree(folder: Path) -> Viewer:
    scale, bias = [1.0] * 3 + [0.9] * 6, [0.1] * 3 + [0.5] * 5 + [0.0]
    values = (
        tree(folder, smooth(9), True, type="ptm", colorspace="lrgb", materials=[{"scale": scale, "bias": bias}]) / 255.0
    )
    values = np.array(scale)[:, None, None] * (values - np.array(bias)[:, None, None])

    def view(x: float, y: float, _z: float) -> Numbers:
        light = np.einsum("k,khw->hw", [1.0, x, y, x * x, x * y, y * y], values[3:])
        return 255.0 * light[..., None] * np.moveaxis(values[:3], 0, 2)

    return view


def photographs_tree(folder: Path, kind: str) -> Viewer:
    """Planes as principal components of photographs, between which is interpolated."""
    rng, side = np.random.default_rng(5), 5
    count = side * side if kind == "bilinear" else 12
    lights = rng.normal(size=(12, 3)) * (1.0, 1.0, 0.6)
    lights[:, 2] = np.abs(lights[:, 2]) + 0.1
    lights /= np.linalg.norm(lights, axis=1, keepdims=True)
    basis = np.concatenate([rng.integers(100, 160, (1, count, 3)), rng.integers(90, 165, (6, count, 3))])
    spread, scale, bias = np.full(6, 240.0), np.linspace(1.4, 0.7, 6), np.full(6, 0.5)
    told = {"scale": scale.tolist(), "bias": bias.tolist(), "range": spread.tolist()}
    more = {"resolution": side} if kind == "bilinear" else {"lights": lights.ravel().tolist(), "sigma": 0.4}
    stored = tree(
        folder, smooth(6), False, type=kind, colorspace="mrgb", materials=[told], basis=basis.ravel().tolist(), **more
    )
    values = scale[:, None, None] * (stored / 255.0 - bias[:, None, None])
    mean, shares = basis[0] / 255.0, (basis[1:] - 127.0) / spread[:, None, None]

    def weights(light: Numbers) -> Numbers:
        if kind == "rbf":
            found = np.exp(-np.sum((lights - light) ** 2, axis=1) / 0.4**2)
            found = np.where(found / found.sum() > 0.001, found, 0.0)
            return np.asarray(found / found.sum())
        x, y, _ = light / np.abs(light).sum()
        found = np.zeros((side, side))
        across, down = (0.5 * (x + y) + 0.5) * (side - 1), (0.5 * (y - x) + 0.5) * (side - 1)
        for row in range(side):
            for column in range(side):
                found[row, column] = max(0.0, 1.0 - abs(across - column)) * max(0.0, 1.0 - abs(down - row))
        return found.ravel()

    def view(x: float, y: float, z: float) -> Numbers:
        shown = weights(np.array((x, y, z)) / np.sqrt(x * x + y * y + z * z))
        pixel = shown @ mean + np.einsum("phw,pc->hwc", values, np.einsum("n,pnc->pc", shown, shares))
        return 255.0 * pixel

    return view


def differ(path: Path, view: Viewer) -> float:
    """The largest difference in 8-bit levels over lights, texels and channels."""
    found = open_material(path).directional
    assert found is not None
    apart = 0.0
    for light in LIGHTS:
        unit = np.array(light) / np.linalg.norm(light)
        shown = srgb(np.clip(np.asarray(found.image(unit), np.float64), 0.0, 1.0))
        apart = max(apart, float(np.abs(shown - np.clip(view(*unit), 0.0, 255.0)).max()))
    return apart


FILES: dict[str, Callable[[], tuple[bytes, Viewer]]] = {
    "jpeg_rgb.ptm": lambda: jpeg_ptm(False),
    "jpeg_lrgb.ptm": lambda: jpeg_ptm(True),
    "lrgb_1_1.ptm": first_lrgb,
    "four.rti": lambda: hsh_file(4),
    "nine.rti": lambda: hsh_file(9, "\r\n"),
    "sixteen.rti": lambda: hsh_file(16),
}


@pytest.mark.parametrize("name", FILES)
def test_a_file_relights_as_its_format_says(tmp_path: Path, name: str) -> None:
    content, view = FILES[name]()
    (tmp_path / name).write_bytes(content)
    assert differ(tmp_path / name, view) < 0.05
    assert view(*LIGHTS[1]).std() > 2.0  # else anything would agree


@pytest.mark.parametrize("kind", ["lrgb", "rbf", "bilinear"])
def test_a_tree_relights_as_its_numbers_say(tmp_path: Path, kind: str) -> None:
    folder = tmp_path / "coin"
    view = tinted_tree(folder) if kind == "lrgb" else photographs_tree(folder, kind)
    assert differ(folder, view) < 0.05
    assert open_material(folder / "info.json").name == "coin"


def test_what_is_exported_comes_back(tmp_path: Path) -> None:
    """Each form, read by the decoders of the exporter's tests; and a bundle of it is the same bit for bit."""
    files = drain(
        writer.contents(Subject(dome_material(9, 7), woven_subject().maps, stack=relief_stack()), Settings(), "a loss")
    ).files
    for name, content in files.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(content)
    views = {name: read_ptm(files[name]) for name in ("dome.ptm", "dome_lrgb.ptm")}
    views |= {"dome.rti": read_hsh(_without_comment(files["dome.rti"])), "relight": read_relight(dict(files))}
    for name, view in views.items():
        assert differ(tmp_path / name, view) < 0.05, name
    made = open_material(tmp_path / "dome_lrgb.ptm")
    drain(save_bundle(tmp_path / "made.lightarc", made))
    kept = open_bundle(tmp_path / "made.lightarc").directional
    assert kept is not None
    assert made.directional is not None
    assert np.array_equal(kept.image(np.array((0.6, 0.0, 0.8))), made.directional.image(np.array((0.6, 0.0, 0.8))))
    assert kept.r_max == pytest.approx(made.directional.r_max)
    assert np.isnan(kept.leave_one_out)


def _without_comment(content: bytes) -> bytes:
    first, comment, rest = content.split(b"\r\n", 2)
    assert comment.startswith(b"#")
    return first + b"\r\n" + rest


@pytest.mark.parametrize("name", FILES)
def test_damage_is_refused_in_one_sentence(name: str) -> None:
    """Cut off anywhere, or with a number of the header changed, a file is refused or read, and never ends otherwise."""
    content, _ = FILES[name]()
    decode = rti.decode_hsh if name.endswith(".rti") else rti.decode_ptm
    for size in np.linspace(8, len(content) - 1, 9).astype(int):
        with pytest.raises(InputError) as refused:
            decode(content[:size], name)
        assert "\n" not in str(refused.value)
    rng = np.random.default_rng(9)
    for _ in range(40):
        changed = bytearray(content)
        for place in rng.integers(8, 200, 2):
            changed[place] = rng.choice([*b"0123456789 -.e\n#\xff"])
        with contextlib.suppress(InputError):
            decode(bytes(changed), name)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"PTM_1.2\nPTM_FORMAT_RGB\n60000\n60000\n1 1 1 1 1 1\n0 0 0 0 0 0\n", "megapixels"),
        (b"PTM_1.2\nPTM_FORMAT_RGB\n9000\n9000\n1 1 1 1 1 1\n0 0 0 0 0 0\n", "cannot hold"),
        (b"PTM_1.2\nPTM_FORMAT_LUM\n4\n4\n1 1 1 1 1 1\n0 0 0 0 0 0\n", "PTM_FORMAT_LUM"),
        (b"PTM_1.0\nPTM_FORMAT_RGB\n4\n4\n", "PTM_1.0"),
        (b"PTM_1.2\nPTM_FORMAT_RGB\n4\n4\n1 1 1 nan 1 1\n0 0 0 0 0 0\n", "not finite"),
        (b"#HSH1.2\n2\n4 4 3\n9 2 1\n", "SH"),
        (b"#HSH1.2\n3\n4 4 3\n25 2 1\n", "25 terms"),
    ],
)
def test_others_are_refused_by_name(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "x.ptm"
    path.write_bytes(content)
    with pytest.raises(InputError, match=words):
        open_material(path)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"colorspace": "mycc"}, "mycc"),
        ({"type": "neural"}, "neural"),
        ({"nplanes": 12}, "plane_3.jpg"),
        ({"nplanes": 10**40}, "whole number"),
        ({"width": 41}, "says 41"),
        ({"materials": [{"scale": [1], "bias": [1]}]}, "9 numbers as its scale"),
    ],
)
def test_faults_of_a_tree_are_named(tmp_path: Path, changes: dict[str, object], words: str) -> None:
    tinted_tree(tmp_path / "coin")
    path = tmp_path / "coin" / "info.json"
    said = json.loads(path.read_text()) | changes
    if "nplanes" in changes and "materials" not in changes:
        said["materials"] = [{"scale": [1.0] * 12, "bias": [0.0] * 12}]
    path.write_text(json.dumps(said))
    with pytest.raises(InputError, match=words):
        open_material(path)


def test_a_name_alone_makes_no_archive(tmp_path: Path) -> None:
    (tmp_path / "info.json").write_text("{}")
    (tmp_path / "x.rti").write_text("nothing")
    assert not holds_material(tmp_path / "info.json")
    with pytest.raises(InputError, match="not a PTM or HSH"):
        open_material(tmp_path / "x.rti")
