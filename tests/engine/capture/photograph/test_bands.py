"""Images of more bands than colours: which become grey or red, green and blue."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tifffile
from numpy.typing import NDArray

from engine.capture.import_plan import ImportSettings
from engine.capture.photograph.decode import Unreadable, read_photograph
from engine.core.errors import UsageError
from engine.images.encode import encode_png

#: Codes (H, W, S) of eight bands, of which none has a white level by chance.
CODES = np.random.default_rng(5).integers(1, 60000, (12, 16, 8), np.uint16)


def write(folder: Path, codes: NDArray[Any], name: str = "a.tif", **options: Any) -> Path:
    content = io.BytesIO()
    tifffile.imwrite(content, codes, **{"photometric": "minisblack", "planarconfig": "contig", **options})
    path = folder / name
    path.write_bytes(content.getvalue())
    return path


@pytest.mark.parametrize("planar", ["contig", "separate"])
@pytest.mark.parametrize("bands", [(4,), (8, 2, 2)])
def test_chosen_bands_are_the_colours(tmp_path: Path, bands: tuple[int, ...], planar: str) -> None:
    codes = CODES if planar == "contig" else np.moveaxis(CODES, -1, 0)
    photograph = read_photograph(write(tmp_path, codes, planarconfig=planar), transfer="linear", bands=bands)
    expected = CODES[..., [band - 1 for band in bands]] / 65535
    np.testing.assert_allclose(photograph.radiance, np.broadcast_to(expected, (12, 16, 3)), rtol=1e-6)
    assert photograph.warnings == ()
    assert photograph.largest_code == CODES[..., [band - 1 for band in bands]].max()


@pytest.mark.parametrize(
    ("photometric", "text"), [("minisblack", "the first is used"), ("rgb", "the first 3 are used")]
)
def test_bands_that_nobody_chose_are_counted(tmp_path: Path, photometric: str, text: str) -> None:
    photograph = read_photograph(write(tmp_path, CODES, photometric=photometric))
    assert photograph.warnings == (f"has 8 bands, of which {text}",)


def test_bands_of_a_negative_are_inverted(tmp_path: Path) -> None:
    photograph = read_photograph(write(tmp_path, CODES, photometric="miniswhite"), transfer="linear", bands=(3,))
    np.testing.assert_allclose(photograph.radiance[..., 0], (65535 - CODES[..., 2].astype(float)) / 65535, rtol=1e-6)


def test_a_colour_of_a_plain_image_is_a_band(tmp_path: Path) -> None:
    codes = (CODES[..., :3] >> 8).astype(np.uint8)
    (tmp_path / "a.png").write_bytes(encode_png(codes))
    photograph = read_photograph(tmp_path / "a.png", transfer="linear", bands=(1,))
    np.testing.assert_allclose(photograph.radiance[..., 2], codes[..., 0] / 255, rtol=1e-6)


def test_a_band_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(Unreadable, match=r"holds 8 bands, and no band 9\. Choose one or three of the bands 1 to 8"):
        read_photograph(write(tmp_path, CODES), bands=(1, 2, 9))


@pytest.mark.parametrize("bands", [(1, 2), (0,), (1, 2, -3), (1, 2, 3, 4)])
def test_bands_are_one_or_three(bands: tuple[int, ...]) -> None:
    with pytest.raises(UsageError, match="not one or three"):
        ImportSettings(bands=bands)
