"""Captures under parallel and crossed polarisers become stacks with a diffuse part, and maps that are true."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

import lightarc
from app.project.pixels import are_there, keep_pixels, unpack_pixels
from engine.capture.import_stack import ImportSettings, import_stack
from engine.capture.lights.sources import find, find_packed
from engine.capture.stack import DIFFUSE, open_stack
from engine.core.colour import LUMINANCE
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.surface.recover import recover
from tests.engine.capture.calibration.polarised import Pairs, photograph, save
from tests.engine.surface.photographs import angle_deg


@pytest.mark.parametrize(
    ("pairs", "names", "lights"),
    [
        (Pairs(leak=0.01, gain=(0.5, 0.43, 0.38), spread=0.15, noise=0.005), "names", "both"),
        (Pairs(size=48, seed=2, roughness=0.6, lamps=16, shift=(1.3, -0.8), room=0.1), "folders", "parallel"),
    ],
)
def test_base_colour_and_roughness_are_those_of_the_material(
    tmp_path: Path, pairs: Pairs, names: str, lights: str
) -> None:
    truth = photograph(pairs)
    folder = save(truth, tmp_path / "capture", names, lights)
    stack = drain(import_stack(find([folder]), ImportSettings(), tmp_path / "stack"))
    assert stack.diffuse is not None
    assert stack.health.warnings == []
    record = stack.provenance["polarisation"]
    np.testing.assert_allclose(record["gain"], pairs.gain, rtol=0.005)
    np.testing.assert_allclose(np.mean(record["shifts_px"], axis=0), pairs.shift, atol=0.1)
    assert sorted(record["crossed"]) == sorted(stack.sources)
    left, top, width, height = stack.provenance["crop_px"]
    part = np.s_[top : top + height, left : left + width]
    maps = drain(recover(stack, np.arange(pairs.lamps), white=1.0, left_out=False)).maps
    colour, roughness = maps.base_colour - truth.base_colour[part], maps.roughness - truth.roughness[part]
    assert np.median(np.abs(colour) / truth.base_colour[part]) < 0.01
    assert np.median(np.abs(roughness)) < 0.03
    assert np.quantile(np.abs(roughness), 0.95) < 0.06
    assert np.median(angle_deg(maps.normal, truth.normals[part])) < (0.1 if pairs.shift == (0.0, 0.0) else 1.0)
    assert maps.uncertainty is not None
    assert (np.abs(colour) < 2.0 * maps.uncertainty.base_colour).mean() > 0.9
    assert (np.abs(roughness) < 2.0 * maps.uncertainty.roughness).mean() > 0.9


def test_the_diffuse_part_is_checked_and_packed_with_the_pixels(tmp_path: Path) -> None:
    folder = save(photograph(Pairs(size=32, lamps=9)), tmp_path / "capture")
    drain(import_stack(find([folder]), ImportSettings(motion="none", pair_gain=0.43), tmp_path / "stack"))
    stack = open_stack(tmp_path / "stack")
    assert stack.provenance["polarisation"]["stated"]
    assert stack.diffuse is not None
    before = stack.diffuse[:]
    assert drain(keep_pixels(stack))
    for name in stack.pixels:
        (tmp_path / "stack" / name).unlink()
    assert not are_there(stack)
    drain(unpack_pixels(stack))
    np.testing.assert_array_equal(np.asarray(open_stack(tmp_path / "stack").pixels[DIFFUSE][:]), before)
    with (tmp_path / "stack" / DIFFUSE).open("r+b") as file:
        file.seek(1000)
        file.write(b"\x01\x02")
    with pytest.raises(InputError, match=r"diffuse.npy: is damaged"):
        open_stack(tmp_path / "stack")


def test_a_gain_is_stated_for_pairs_alone(tmp_path: Path) -> None:
    found = photograph(Pairs(size=32, lamps=6))
    folder = save(found, tmp_path / "capture", "folders", "parallel")
    with pytest.raises(InputError, match="holds no pairs under polarisers"):
        drain(
            import_stack(
                find([folder, folder / "parallel"], pair="none"), ImportSettings(pair_gain=0.5), tmp_path / "stack"
            )
        )


def test_shading_maps_show_the_diffuse_part_alone(tmp_path: Path) -> None:
    """Highlights of the photographs would be beside those of the BRDF."""
    folder = save(photograph(Pairs(size=48, lamps=9)), tmp_path / "capture")
    drain(import_stack(find([folder]), ImportSettings(motion="none", pair_gain=0.43), tmp_path / "stack"))
    stack = open_stack(tmp_path / "stack")
    assert stack.diffuse is not None
    means = {"diffuse": stack.diffuse[:], "whole": stack.radiance[:]}
    for part, said in (("diffuse", "Made of the diffuse part of the pairs"), ("whole", "Made of the whole light")):
        made = lightarc.build_material(stack, representation="shading-map", slices=4, part=part)  # type: ignore[arg-type]
        assert made.shading_map is not None
        brightest = (means[part].mean(axis=(1, 2), dtype=np.float64) @ LUMINANCE).max()
        assert made.shading_map.r_max == pytest.approx(brightest, rel=1e-5)
        assert sum(said in finding.text for finding in made.health.findings) == 1
    assert means["whole"].max() > 1.2 * means["diffuse"].max()


def test_archives_hold_pairs_in_one_folder(tmp_path: Path) -> None:
    found = photograph(Pairs(size=32, lamps=6))
    for names in ("names", "folders"):
        folder = save(found, tmp_path / names, names, "both" if names == "names" else "parallel")
        shutil.make_archive(str(tmp_path / names), "zip", folder)
    assert len(drain(find_packed([tmp_path / "names.zip"])).crossed) == 6
    with pytest.raises(InputError, match=r"holds pairs under polarisers in two folders: crossed, parallel\. Unpack it"):
        drain(find_packed([tmp_path / "folders.zip"]))
