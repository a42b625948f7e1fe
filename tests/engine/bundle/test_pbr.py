"""PBR maps in bundles: every bit comes back, and what is not theirs is refused."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.bundle.bundle import extract_bundle, open_bundle, save_bundle, verify_bundle
from engine.bundle.manifest import MANIFEST, PBR, describe_bundle
from engine.core.errors import InputError, UsageError
from engine.core.steps import drain
from engine.exchange.export import subject_of
from engine.scene.material import Material, material_of_maps
from engine.storage.records import Manifest, read_manifest, write_manifest
from engine.surface.pbr_maps import MapErrors, ObservedSlopes, PbrMaps, SurfaceMaps, Uncertainty
from tests.engine.exchange.materials import measure_maps, woven_material

NAMES = ("base_colour", "normal", "roughness", "metallic", "f0", "height", "occlusion")


def uncertain_maps() -> PbrMaps:
    """Maps along an arc with an uncertainty of each, which is not known at one texel."""
    maps = measure_maps()
    rng = np.random.default_rng(8)
    sigma = {name: rng.uniform(0.0, 1.0, maps.size).astype(np.float32) for name in NAMES}
    sigma["base_colour"] = rng.uniform(0.0, 1.0, (*maps.size, 3)).astype(np.float32)
    sigma["height"][2, 3] = np.inf
    errors = MapErrors(in_sample=4.5, normal_sigma=0.02)
    return dataclasses.replace(
        maps, uncertainty=Uncertainty(**sigma), observed=ObservedSlopes("along the arc", 0.5), errors=errors
    )


def same(found: Any, wanted: Any) -> None:
    for name in NAMES:
        values = getattr(wanted, name)
        if values is None:
            assert getattr(found, name) is None
        else:
            np.testing.assert_array_equal(getattr(found, name), values)


@pytest.mark.parametrize("maps", [measure_maps(), uncertain_maps()], ids=["plain", "uncertain"])
@pytest.mark.parametrize("name", ["rock.lightarc", "rock"])
def test_every_bit_comes_back(maps: PbrMaps, name: str, tmp_path: Path) -> None:
    material = material_of_maps(maps, "rock")
    path = drain(save_bundle(tmp_path / name, material))
    found = open_bundle(path)
    assert found.pbr is not None
    same(found.pbr, maps)
    assert (found.brdf, found.name, found.size) == (material.brdf, "rock", maps.size)
    assert found.pbr.observed == maps.observed
    np.testing.assert_equal(dataclasses.asdict(found.pbr.errors), dataclasses.asdict(maps.errors))
    assert (found.pbr.uncertainty is None) == (maps.uncertainty is None)
    if maps.uncertainty is not None:
        same(found.pbr.uncertainty, maps.uncertainty)
    assert verify_bundle(path).problems == ()


def test_heights_of_other_regions_than_the_largest_are_unknown_in_a_bundle(tmp_path: Path) -> None:
    maps = uncertain_maps()
    region = np.zeros(maps.size, np.float32)
    region[:, :2] = 1.0
    material = material_of_maps(dataclasses.replace(maps, region=region), "rock")
    found = open_bundle(drain(save_bundle(tmp_path / "rock.lightarc", material))).pbr
    assert found is not None
    assert found.uncertainty is not None
    assert found.uncertainty.height is not None
    np.testing.assert_array_equal(np.isinf(found.uncertainty.height[:, :2]), True)
    assert maps.uncertainty is not None
    assert maps.uncertainty.height is not None
    np.testing.assert_array_equal(found.uncertainty.height[:, 2:], maps.uncertainty.height[:, 2:])


def test_maps_without_height_stay_without(tmp_path: Path) -> None:
    maps = dataclasses.replace(measure_maps(), height=None, occlusion=None)
    found = open_bundle(drain(save_bundle(tmp_path / "flat.lightarc", material_of_maps(maps, "flat")))).pbr
    assert found is not None
    same(found, maps)


def test_a_bundle_says_what_it_holds_and_comes_apart(tmp_path: Path) -> None:
    path = drain(save_bundle(tmp_path / "rock.lightarc", material_of_maps(measure_maps(), "rock")))
    said = describe_bundle(path)
    assert said["schema_version"] == 3
    assert said["pbr"]["maps"] == list(NAMES)
    files = extract_bundle(path, tmp_path / "apart")
    assert set(files) == {PBR, "brdf.json", "preview.png", MANIFEST}
    assert open_bundle(tmp_path / "apart").pbr is not None


def test_maps_of_a_surface_lie_beside_what_comes_from_photographs(tmp_path: Path) -> None:
    """The material is looked up as without them, and exports of the bundle take them with their white card."""
    plain = woven_material(*measure_maps().size)
    whole = dataclasses.replace(plain, surface=SurfaceMaps(measure_maps(), 1.25))
    path = drain(save_bundle(tmp_path / "both.lightarc", whole))
    assert verify_bundle(path).problems == ()
    assert describe_bundle(path)["schema_version"] == 4
    found = open_bundle(path)
    assert (found.pbr, found.size) == (None, plain.size)
    assert found.surface is not None
    assert found.surface.white == 1.25
    same(found.surface.maps, measure_maps())
    subject = drain(subject_of(found))
    assert subject.maps is found.surface.maps
    assert subject.white == 1.25


def test_photographs_beside_maps_are_refused(tmp_path: Path) -> None:
    both = dataclasses.replace(woven_material(12, 10), pbr=measure_maps())
    with pytest.raises(UsageError, match="replace what comes from photographs"):
        drain(save_bundle(tmp_path / "both.lightarc", both))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"maps": ["base_colour", "normal", "roughness", "metallic", "metallic"]}, "other maps"),
        ({"maps": ["base_colour", "normal", "roughness", "metallic", "f0", "gloss"]}, "other maps"),
        ({"maps": list(NAMES[:5])}, "other channels"),
        ({"height_px": 13}, "13 x 10"),
        ({"observed_slopes": "none", "observed_azimuth": 1.0}, "cannot be"),
    ],
)
def test_numbers_that_do_not_fit_the_pixels_are_refused(change: dict[str, Any], words: str, tmp_path: Path) -> None:
    folder = drain(save_bundle(tmp_path / "rock", material_of_maps(measure_maps(), "rock")))
    _change(folder, **change)
    with pytest.raises(InputError, match=words):
        open_bundle(folder)
    assert not verify_bundle(folder).ok


def test_a_schema_without_its_maps_is_refused(tmp_path: Path) -> None:
    folder = drain(save_bundle(tmp_path / "rock", material_of_maps(measure_maps(), "rock")))
    value = json.loads((folder / MANIFEST).read_text())
    with pytest.raises(ValueError, match="belong to schema 3"):
        Manifest.model_validate({**{k: v for k, v in value.items() if k != "manifest_sha256"}, "schema_version": 1})


def test_bundles_without_maps_are_as_they_were(tmp_path: Path) -> None:
    """Their manifest has no key that an older program does not know."""
    path = drain(save_bundle(tmp_path / "woven", woven_material()))
    value = json.loads((path / MANIFEST).read_text())
    assert value["schema_version"] == 1
    assert "pbr" not in value


def test_a_material_of_nothing_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="PBR maps"):
        drain(save_bundle(tmp_path / "none.lightarc", Material(None, None)))


def _change(folder: Path, **values: Any) -> None:
    """Write other numbers of the maps into the manifest, sealed anew."""
    manifest = read_manifest((folder / MANIFEST).read_bytes(), folder)
    assert manifest.pbr is not None
    record = manifest.pbr.model_copy(update=values)
    (folder / MANIFEST).write_bytes(write_manifest(manifest.model_copy(update={"pbr": record})))
