"""Base colours beyond Rec.709: kept in the working space, clipped and said where there is room for Rec.709 alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from engine.bundle.bundle import open_bundle, save_bundle
from engine.capture.stack import ImageStack
from engine.core.colour import ACESCG, REC_709, REC_2020, WorkingSpace, working_space
from engine.core.steps import drain
from engine.exchange.export import export
from engine.exchange.readers.read import open_material
from engine.exchange.subject import Settings
from engine.images.decode import read_image
from engine.scene.material import material_of_maps
from engine.surface.pbr_maps import PbrMaps
from engine.surface.recover import Surface, recover
from engine.surface.write import write_surface
from tests.engine.surface.photographs import bump, lambertian, lights

#: Reflectance in linear Rec.2020: a green beyond Rec.709, whose red is negative there, and a grey.
GREEN, GREY = (0.05, 0.6, 0.08), (0.4, 0.4, 0.4)


def _photographs(space: WorkingSpace) -> tuple[ImageStack, np.ndarray]:
    """Photographs of a bump, green on the left and grey on the right, and its reflectance in Rec.2020."""
    _, normal = bump()
    angles = lights((25.0, 45.0, 70.0), (0.0, 60.0, 120.0, 180.0, 240.0, 300.0))
    plain = lambertian(normal, (1.0, 1.0, 1.0), *angles)
    colour = np.empty(normal.shape, np.float32)
    colour[:], colour[:, normal.shape[1] // 2 :] = GREEN, GREY
    radiance = (np.asarray(plain.radiance) * colour) @ REC_2020.to_rec709.T.astype(np.float32)
    return replace(plain, radiance=radiance.astype(np.float32)).with_working_space(space), colour


def _surface(space: WorkingSpace) -> tuple[Surface, np.ndarray]:
    photographs, colour = _photographs(space)
    return drain(recover(photographs, np.arange(18), left_out=False)), colour


@pytest.fixture(scope="module")
def wide() -> tuple[PbrMaps, np.ndarray]:
    surface, colour = _surface(REC_2020)
    return surface.maps, colour


def _off(found: np.ndarray, truth: np.ndarray) -> float:
    """Median over texels of the largest error of a component, as a share of the largest component."""
    return float(np.median(np.abs(found - truth).max(axis=2) / truth.max(axis=2)))


@pytest.mark.parametrize("space", [REC_2020, ACESCG])
def test_colours_beyond_rec709_are_kept(space: WorkingSpace) -> None:
    surface, colour = _surface(space)
    maps = surface.maps
    assert maps.wide is not None
    green = np.s_[:, : colour.shape[1] // 2 - 1]
    truth = colour @ (space.from_rec709 @ REC_2020.to_rec709).T
    assert _off(maps.wide.base_colour[green], truth[green]) < 0.01
    clipped = np.clip(truth @ space.to_rec709.T, 0.0, 1.0)
    assert _off(maps.base_colour[green], clipped[green]) < 0.02
    assert maps.wide.clipped[0] == pytest.approx(0.5, abs=0.03)
    assert maps.wide.clipped[1] > 0.2
    assert any("beyond Rec.709" in finding.text for finding in surface.health.findings)


def test_rec709_has_no_wide_colours_and_grey_stays() -> None:
    surface, colour = _surface(REC_709)
    grey = np.s_[:, colour.shape[1] // 2 + 1 :]
    assert surface.maps.wide is None
    assert _off(surface.maps.base_colour[grey], colour[grey]) < 0.01


def test_maps_are_written_in_their_space(tmp_path: Path) -> None:
    surface, colour = _surface(REC_2020)
    drain(write_surface(tmp_path / "maps", surface, {}, "test"))
    back = read_image(tmp_path / "maps" / "base_colour.exr")
    assert back.profile == "linear Rec.2020"
    green = np.s_[:, : colour.shape[1] // 2 - 1]
    assert _off((back.pixels @ REC_2020.from_rec709.T)[green], colour[green]) < 0.01
    assert '"working_space": "linear Rec.2020"' in (tmp_path / "maps" / "surface.json").read_text()


def test_a_bundle_holds_them(wide: tuple[PbrMaps, np.ndarray], tmp_path: Path) -> None:
    material = material_of_maps(wide[0], "green")
    drain(save_bundle(tmp_path / "green.lightarc", material))
    maps = open_bundle(tmp_path / "green.lightarc").pbr
    assert maps is not None
    assert maps.wide is not None
    assert wide[0].wide is not None
    assert (maps.wide.space, maps.wide.clipped) == ("rec2020", wide[0].wide.clipped)
    np.testing.assert_array_equal(maps.wide.base_colour, wide[0].wide.base_colour)


def test_exports_hold_them_or_say_so(wide: tuple[PbrMaps, np.ndarray], tmp_path: Path) -> None:
    maps, colour = wide
    material = material_of_maps(maps, "green")
    settings = Settings(coding="exr")
    record = drain(export(tmp_path / "out", material, ["textures", "materialx", "gltf", "usd"], settings=settings))
    said = {made["target"]: " ".join(made["warnings"]) for made in record["targets"]}
    green = np.s_[:, : colour.shape[1] // 2 - 1]
    for target, label in (("textures", "linear Rec.2020"), ("materialx", "ACEScg")):
        (file,) = (tmp_path / "out" / target).rglob("*base_color.exr")
        back = read_image(file)
        assert back.profile == label
        assert _off((back.pixels @ REC_2020.from_rec709.T)[green], colour[green]) < 0.01
        assert "clipped" not in said[target]
        held = (back.pixels @ working_space(label).from_rec709.T).min()
        assert held > -1e-3
        (source,) = (tmp_path / "out" / target).glob("*.mtlx" if target == "materialx" else "*base_color.exr")
        read = open_material(source if target == "materialx" else source.parent).pbr
        assert read is not None
        assert read.wide is not None
        assert _off(read.wide.base_colour[green], colour[green]) < 0.01
    document = (tmp_path / "out" / "materialx" / "green.mtlx").read_text()
    assert 'base_color.exr" colorspace="acescg"' in document
    for target in ("gltf", "usd"):
        assert "lie beyond Rec.709 and are clipped by up to" in said[target]
