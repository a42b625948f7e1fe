"""RTI files, read by parsers written here from the published formats: relit, they are the photographs."""

from __future__ import annotations

import dataclasses
import json
import struct
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from engine.capture.stack import ImageStack
from engine.core.errors import UsageError
from engine.core.figure_text import percent
from engine.core.steps import drain
from engine.exchange import rti
from engine.exchange.export import export
from engine.exchange.loss import material_shown, photograph_error
from engine.exchange.subject import Settings, Subject

from .materials import dome_material, dome_stack, woven_subject

Numbers = NDArray[np.float64]
Viewer = Callable[[float, float, float], Numbers]


def srgb(linear: Numbers) -> Numbers:
    """IEC 61966-2-1, written here anew, in codes of 255."""
    return 255.0 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def relief_stack() -> ImageStack:
    """Codes that are exactly quadratic in the direction of light, and a texel at the top right that is known by red."""
    stack = dome_stack(9, 7)
    assert stack.azimuth is not None
    x, y = np.cos(stack.elevation) * np.cos(stack.azimuth), np.cos(stack.elevation) * np.sin(stack.azimuth)
    tilt = (
        np.linspace(-0.5, 0.5, 7)[None, None, :] * x[:, None, None]
        + np.linspace(0.5, -0.5, 9)[None, :, None] * y[:, None, None]
    )
    codes = np.repeat((120.0 + 90.0 * tilt - 30.0 * (x * x + 0.5 * x * y)[:, None, None])[..., None], 3, axis=3)
    codes[:, 0, 6, 1:] *= 0.25
    share = codes / 255.0
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return dataclasses.replace(stack, radiance=linear.astype(np.float32))


@pytest.fixture(scope="module")
def stack() -> ImageStack:
    return relief_stack()


@pytest.fixture(scope="module")
def files(stack: ImageStack) -> dict[str, bytes]:
    subject = Subject(dome_material(9, 7), woven_subject().maps, stack=stack)
    return dict(drain(rti.contents(subject, Settings(), "")).files)


def read_ptm(content: bytes) -> Viewer:
    """PTM 1.2 (Malzbender, Gelb, Wolters, "Polynomial Texture Map file format"): RGB and LRGB, rows from below."""
    lines = content.split(b"\n", 6)
    assert lines[0] == b"PTM_1.2"
    width, height = int(lines[2]), int(lines[3])
    scale, bias = (np.array(line.split(), np.float64) for line in lines[4:6])
    body = np.frombuffer(lines[6], np.uint8)
    texels = width * height
    if lines[1] == b"PTM_FORMAT_RGB":
        assert len(body) == 18 * texels
        terms = scale * (body.reshape(3, height, width, 6).astype(np.float64) - bias)
        colour = None
    else:
        assert lines[1] == b"PTM_FORMAT_LRGB"
        assert len(body) == 9 * texels
        terms = scale * (body[: 6 * texels].reshape(1, height, width, 6).astype(np.float64) - bias)
        colour = body[6 * texels :].reshape(height, width, 3).astype(np.float64)

    def view(x: float, y: float, _z: float) -> Numbers:
        values = terms @ np.array([x * x, y * y, x * y, x, y, 1.0])
        image = np.moveaxis(values, 0, 2) if colour is None else colour * values[0][..., None] / 255.0
        return image[::-1]

    return view


def read_hsh(content: bytes) -> Viewer:
    """HSH 1.2 of RTIBuilder: rows from the top, values to 1."""
    head, body = b"", content
    lines = []
    for _ in range(4):
        head, _, body = body.partition(b"\r\n")
        lines.append(head)
    assert lines[:2] == [b"#HSH1.2", b"3"]
    width, height, channels = (int(word) for word in lines[2].split())
    count = int(lines[3].split()[0])
    scale = np.array(struct.unpack(f"<{count}f", body[: 4 * count]))
    bias = np.array(struct.unpack(f"<{count}f", body[4 * count : 8 * count]))
    codes = np.frombuffer(body[8 * count :], np.uint8).reshape(height, width, channels, count)
    terms = codes / 255.0 * scale + bias

    def view(x: float, y: float, z: float) -> Numbers:
        theta, phi = np.arccos(z), np.arctan2(y, x)
        root, once = np.sqrt(np.cos(theta) - np.cos(theta) ** 2), 2.0 * np.cos(theta) - 1.0
        weights = [
            1.0 / np.sqrt(2.0 * np.pi),
            np.sqrt(6.0 / np.pi) * np.cos(phi) * root,
            np.sqrt(3.0 / (2.0 * np.pi)) * once,
            np.sqrt(6.0 / np.pi) * np.sin(phi) * root,
            np.sqrt(30.0 / np.pi) * np.cos(2.0 * phi) * (np.cos(theta) ** 2 - np.cos(theta)),
            np.sqrt(30.0 / np.pi) * np.cos(phi) * once * root,
            np.sqrt(5.0 / (2.0 * np.pi)) * (1.0 - 6.0 * np.cos(theta) + 6.0 * np.cos(theta) ** 2),
            np.sqrt(30.0 / np.pi) * np.sin(phi) * once * root,
            np.sqrt(30.0 / np.pi) * np.sin(2.0 * phi) * (np.cos(theta) ** 2 - np.cos(theta)),
        ]
        return 255.0 * (terms @ np.array(weights))

    return view


def test_each_file_states_its_own_error(stack: ImageStack) -> None:
    """One colour for all light is the coarsest; quadratic codes are kept by quadratic terms to their rounding."""
    made = drain(rti.contents(Subject(dome_material(9, 7), woven_subject().maps, stack=stack), Settings(), ""))
    stated = made.record["rmse_rel_by_file"]
    name = "dome"
    viewers = {
        f"{name}.ptm": read_ptm(made.files[f"{name}.ptm"]),
        f"{name}_lrgb.ptm": read_ptm(made.files[f"{name}_lrgb.ptm"]),
        f"{name}.rti": read_hsh(made.files[f"{name}.rti"]),
    }
    assert stack.azimuth is not None
    for file, view in viewers.items():
        apart = 0.0
        for number, (elevation, azimuth) in enumerate(zip(stack.elevation, stack.azimuth, strict=True)):
            x, y, z = np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)
            share = np.clip(view(x, y, z), 0.0, 255.0) / 255.0
            linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
            apart += float(np.sum((linear - stack.radiance[number]) ** 2))
        assert stated[file] == pytest.approx(
            np.sqrt(apart / np.sum(np.asarray(stack.radiance, np.float64) ** 2)), rel=1e-3
        )
        assert f"{file} {percent(stated[file], 3)}" in made.files["loss.txt"].decode()
        assert any(f"{file} {percent(stated[file], 3)}" in words for words in made.warnings)
    assert stated["relight/info.json"] == pytest.approx(stated[f"{name}.ptm"], abs=0.01)


def read_relight(files: dict[str, bytes]) -> Viewer:
    """The JSON form of relight: value = scale (plane − bias), terms 1, x, y, xx, xy, yy."""
    info = json.loads(files["relight/info.json"])
    scale, bias = (np.array(info["materials"][0][name]).reshape(-1, 3) for name in ("scale", "bias"))
    planes = []
    for number in range(info["nplanes"] // 3):
        content = np.frombuffer(files[f"relight/plane_{number}.png"], np.uint8)
        pixels = cv2.imdecode(content, cv2.IMREAD_UNCHANGED)
        assert pixels is not None
        planes.append(scale[number] * (pixels[..., ::-1] / 255.0 - bias[number]))
    assert (info["type"], info["colorspace"]) == ("ptm", "rgb")

    def view(x: float, y: float, _z: float) -> Numbers:
        return 255.0 * np.einsum("t,thwc->hwc", [1.0, x, y, x * x, x * y, y * y], np.array(planes))

    return view


VIEWERS: dict[str, Callable[[dict[str, bytes]], Viewer]] = {
    "rgb": lambda files: read_ptm(files["dome.ptm"]),
    "lrgb": lambda files: read_ptm(files["dome_lrgb.ptm"]),
    "relight": read_relight,
}


@pytest.mark.parametrize("form", VIEWERS)
def test_relit_photographs_agree_to_the_quantisation(files: dict[str, bytes], stack: ImageStack, form: str) -> None:
    """Photographs that are quadratic come back to half a code of each of six terms, whose functions are at most 1."""
    view = VIEWERS[form](files)
    assert stack.azimuth is not None
    for number in range(len(stack.sources)):
        across = np.cos(stack.elevation[number])
        light = across * np.cos(stack.azimuth[number]), across * np.sin(stack.azimuth[number])
        found = view(*light, float(np.sin(stack.elevation[number])))
        assert np.abs(found - srgb(np.asarray(stack.radiance[number], np.float64))).max() < 3.0


def test_relit_harmonics_agree_with_their_own_fit(files: dict[str, bytes], stack: ImageStack) -> None:
    assert stack.azimuth is not None
    view = read_hsh(files["dome.rti"])
    across = np.cos(stack.elevation)
    lights = np.column_stack([across * np.cos(stack.azimuth), across * np.sin(stack.azimuth), np.sin(stack.elevation)])
    basis = rti.hsh_functions(lights)
    codes = srgb(np.asarray(stack.radiance, np.float64)).reshape(len(lights), -1)
    wanted = (basis @ np.linalg.lstsq(basis, codes, rcond=None)[0]).reshape(stack.radiance.shape)
    for number, light in enumerate(lights):
        assert np.abs(view(*light) - wanted[number]).max() < 4.0
    assert np.abs(wanted - codes.reshape(wanted.shape)).max() < 25.0


def test_noise_is_not_fitted(stack: ImageStack) -> None:
    """Harmonics of few noisy photographs come nearer to those without noise than least squares do."""
    assert stack.azimuth is not None
    few = np.linspace(0, len(stack.elevation) - 1, 10).round().astype(int)
    codes = srgb(np.asarray(stack.radiance, np.float64))
    noisy = codes[few] + np.random.default_rng(8).normal(0.0, 12.0, (len(few), 9, 7, 3))
    share = np.clip(noisy / 255.0, 0.0, 1.0)
    linear = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    seen = dataclasses.replace(
        stack,
        **{name: getattr(stack, name)[few] for name in ("elevation", "azimuth", "saturated", "mean_radiance")},
        radiance=linear.astype(np.float32),
        sources=tuple(stack.sources[each] for each in few),
    )
    terms = drain(rti.fit(Subject(dome_material(9, 7), woven_subject().maps, stack=seen), rti.hsh_functions))
    across = np.cos(stack.elevation)
    lights = np.column_stack([across * np.cos(stack.azimuth), across * np.sin(stack.azimuth), np.sin(stack.elevation)])
    basis = rti.hsh_functions(lights)
    plain = np.linalg.lstsq(basis[few], srgb(linear).reshape(len(few), -1), rcond=None)[0]
    errors = [
        float(np.sqrt(np.mean((shown - codes) ** 2)))
        for shown in (np.moveaxis(terms.coefficients @ basis.T, 3, 0), (basis @ plain).reshape(codes.shape))
    ]
    assert errors[0] < 0.95 * errors[1], len(codes)


def test_the_top_of_the_image_is_the_top(files: dict[str, bytes]) -> None:
    """The reddish texel lies in row 0, at the right, in every form."""
    for viewer in (*(make(files) for make in VIEWERS.values()), read_hsh(files["dome.rti"])):
        image = viewer(0.1, 0.1, float(np.sqrt(0.98)))
        redness = image[..., 0] - image[..., 2]
        assert np.unravel_index(redness.argmax(), redness.shape) == (0, 6)


def test_a_directional_map_leaves_without_its_photographs() -> None:
    subject = Subject(dome_material(), woven_subject().maps)
    view = read_ptm(drain(rti.contents(subject, Settings(), "")).files["dome.ptm"])
    found = view(0.3, -0.2, float(np.sqrt(1.0 - 0.13)))
    wanted = srgb(np.sqrt(1.0 - 0.13) * np.array((0.24, 0.18, 0.12)))
    np.testing.assert_allclose(found[2, 1], wanted, atol=6.0)


def test_the_error_is_that_of_the_files() -> None:
    """Against the photographs; the planes of the directional map beside it are nearer or as near."""
    subject = Subject(dome_material(9, 7), woven_subject().maps, stack=dome_stack(9, 7))
    shown = rti.show(subject, Settings())
    assert shown is not None
    assert drain(photograph_error(shown, dome_stack(9, 7))) < 0.06
    assert drain(photograph_error(material_shown(subject.material), dome_stack(9, 7))) < 0.06


def test_an_arc_is_refused_before_any_work(tmp_path: Path) -> None:
    refused = export(tmp_path / "out", woven_subject().material, ["textures", "rti"])
    with pytest.raises(UsageError, match="several sides"):
        next(refused)
    assert rti.show(woven_subject(), Settings()) is None


def test_photographs_of_other_texels_count_as_none() -> None:
    assert rti.has_sides(dome_material(), None)
    assert not rti.has_sides(woven_subject().material, dome_stack(9, 7))
