"""No silent approximation: every file whose format has a place for words says what leaving costs."""

from __future__ import annotations

import dataclasses
import json
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.brdf.resample import resample
from engine.core.figure_text import percent
from engine.core.steps import drain
from engine.exchange import gltf, materialx, rti, shaders, textures, usd, web
from engine.exchange.loss import environment_lights, material_shown, sphere
from engine.exchange.subject import Settings, Subject
from engine.scene.material import compute_fit_error

from .materials import dome_material, dome_stack, woven_subject

LOSS = "An error of 12.3 %."


def words_of_png(content: bytes) -> dict[str, str]:
    """The tEXt chunks of a PNG (W3C, third edition, 11.3.3), their checksums checked."""
    found, at = {}, 8
    while at < len(content):
        length, kind = struct.unpack(">I4s", content[at : at + 8])
        body = content[at + 8 : at + 8 + length]
        assert zlib.crc32(kind + body) == struct.unpack(">I", content[at + 8 + length : at + 12 + length])[0]
        if kind == b"tEXt":
            name, _, text = body.partition(b"\0")
            found[name.decode("latin-1")] = text.decode("latin-1")
        at += 12 + length
    return found


@pytest.mark.parametrize("target", [textures, materialx, gltf, usd, shaders, web, rti])
def test_files_state_the_loss(target: object, tmp_path: Path) -> None:
    subject = woven_subject()
    if target is rti:
        subject = Subject(dome_material(), subject.maps, stack=dome_stack())
    files = drain(target.contents(subject, Settings(), LOSS)).files  # type: ignore[attr-defined]
    silent = (
        ".ptm",
        "embed.html",
        ".css",
        ".js",
        "_materialx.usda",
    )  # a script or style, a snippet, opinions over a package
    for name, content in files.items():
        if name.endswith(silent) or (name.endswith(".png") and target in (web, shaders)):
            continue
        if name.endswith(".png"):
            assert words_of_png(content)["Comment"] == LOSS, name
        elif name.endswith(".exr"):
            continue  # the maps of the material itself, bit for bit
        else:
            assert LOSS.encode() in content, name


def test_open_exr_textures_state_the_loss(tmp_path: Path) -> None:
    files = drain(textures.contents(woven_subject(), Settings(coding="exr"), LOSS)).files
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
        assert OpenEXR.File(str(tmp_path / name)).header()["comments"] == LOSS


def test_gltf_has_it_as_extras_of_the_material_and_the_asset() -> None:
    (content,) = drain(gltf.contents(woven_subject(), Settings(), LOSS)).files.values()
    length = struct.unpack("<I", content[12:16])[0]
    document = json.loads(content[20 : 20 + length])
    assert document["asset"]["extras"] == document["materials"][0]["extras"] == {"lightarc_loss": LOSS}


def test_a_file_of_textures_is_made_when_it_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """One file of a large material is in memory at a time."""
    made: list[object] = []
    real = textures.pack

    def note(*given: Any) -> Any:
        made.append(given[1])
        return real(*given)

    monkeypatch.setattr(textures, "pack", note)
    files = drain(textures.contents(woven_subject(), Settings(), LOSS)).files
    assert made == []
    assert len(files["A_cloth_woven_roughness.png"]) > 100
    assert made == [("roughness",)]


def test_a_measured_brdf_leaves_as_its_model_and_that_is_measured_and_said() -> None:
    """Shaders hold the model: what they show is that of the material without its measurement."""
    subject = woven_subject()
    measured = drain(resample(brdf_from_text("ggx:alpha=0.2,kd=0.3"), (12, 12, 24)))
    subject = dataclasses.replace(subject, material=dataclasses.replace(subject.material, measured=measured))
    shown = shaders.show(subject, Settings())
    assert shown is not None
    assert web.show(subject, Settings()) is shown
    view, lights = sphere(24, 20, 24), environment_lights("studio")
    model = material_shown(dataclasses.replace(subject.material, measured=None), "power-law")(view, lights)
    np.testing.assert_array_equal(shown(view, lights), model)
    assert np.abs(material_shown(subject.material, "power-law")(view, lights) - model).max() > 0.01
    error = compute_fit_error(subject.material)
    assert error is not None
    for target in (shaders, web):
        warnings = drain(target.contents(subject, Settings(), LOSS)).warnings
        assert any(f"a fit of the measured one, {percent(error, 3)} away" in words for words in warnings)
