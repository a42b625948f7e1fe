"""Bundles and pages of an object before a transparent background."""

from __future__ import annotations

import base64
import dataclasses
import json
import re
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from engine.bundle.bundle import open_bundle, save_bundle, swatch, verify_bundle
from engine.bundle.manifest import MANIFEST, describe_bundle
from engine.bundle.page import viewer
from engine.core.steps import drain
from engine.scene.material import Material
from tests.chromium import Page, chromium
from tests.engine.bundle.materials import make_material
from tests.engine.domes import dome_material

MASK = np.zeros((8, 8), np.bool_)
MASK[:, 4:] = True


def masked() -> Material:
    return dataclasses.replace(make_material(brdf="lambert", sigma=2.0), mask=MASK)


def test_a_bundle_keeps_the_mask(tmp_path: Path) -> None:
    path = drain(save_bundle(tmp_path / "object.lightarc", masked()))
    found = verify_bundle(path)
    assert (found.ok, found.schema_version) == (True, 6)
    assert describe_bundle(path)["mask"] == {"height_px": 8, "width_px": 8}
    opened = open_bundle(path)
    assert opened.mask is not None
    np.testing.assert_array_equal(opened.mask, MASK)
    again = drain(save_bundle(tmp_path / "again.lightarc", opened))
    assert again.read_bytes() == path.read_bytes()
    plain = drain(save_bundle(tmp_path / "plain.lightarc", make_material()))
    assert verify_bundle(plain).schema_version == 1
    assert b'"mask"' not in zipfile.ZipFile(plain).read(MANIFEST)


def test_the_small_image_is_transparent_around_the_object() -> None:
    image: Any = cv2.imdecode(np.frombuffer(swatch(masked()), np.uint8), cv2.IMREAD_UNCHANGED)
    np.testing.assert_array_equal(image[..., 3], np.where(MASK, 255, 0))


def data_of(page: str) -> dict[str, Any]:
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', page, re.DOTALL)
    assert found
    value: dict[str, Any] = json.loads(found[1])
    return value


def test_the_page_holds_what_is_transparent() -> None:
    data = data_of(viewer(masked()))
    (name,) = data["cover"]["layers"]
    image: Any = cv2.imdecode(np.frombuffer(base64.b64decode(data["pictures"][name]), np.uint8), cv2.IMREAD_UNCHANGED)
    np.testing.assert_array_equal(image[..., 0], np.where(MASK, 255, 0))
    assert "cover" not in data_of(viewer(make_material()))


@pytest.fixture(scope="module")
def browser() -> Iterator[Page]:
    with chromium() as page:
        yield page


@pytest.mark.parametrize("kind", ["power law", "planes"])
def test_a_browser_shows_the_background_of_the_page_around_the_object(browser: Page, tmp_path: Path, kind: str) -> None:
    material = masked()
    if kind == "planes":
        plain = dome_material()
        height, width = plain.size
        material = dataclasses.replace(plain, mask=np.broadcast_to(np.arange(width) >= width / 2, (height, width)))
    (tmp_path / "index.html").write_text(viewer(material), encoding="utf-8")
    browser.open(f"{(tmp_path / 'index.html').as_uri()}#neutral=0&elevation=90", (900, 600))
    browser.drawn()
    assert browser.errors == []
    image = browser.image()
    assert image[300, 150].tolist() == [24, 24, 24]
    assert image[300, 470].max() > 40
