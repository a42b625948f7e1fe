"""Spectra to linear sRGB: the observer's published sums, and an oracle that shares no code with ours."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.brdf.spectrum import ILLUMINANTS, Illuminant, observer, srgb_from_spectra, srgb_weights
from engine.core.errors import UsageError

#: Patches of a colour chart, 380 to 730 nm at 10 nm, and their linear sRGB under D65 as the package colour-science
#: 0.4.7 computes it by direct integration at 5 nm with Bradford adaptation (end values repeated to 780 nm). It rounds
#: the matrix of sRGB to four places.
CHART = {
    "red": (
        "50 49 48 47 47 47 47 47 46 45 44 44 45 46 47 48 49 50 54 60 72 104 178 312 467 581 644 675 690 698 706 715 "
        "724 730 734 738",
        (0.429935611, 0.032313817, 0.040131649),
    ),
    "yellow": (
        "58 54 52 52 53 54 56 59 67 81 107 152 225 336 462 559 616 650 672 694 710 723 731 739 746 752 758 764 769 "
        "771 776 782 790 796 799 804",
        (0.856683343, 0.574745275, 0.008493207),
    ),
    "cyan": (
        "108 141 192 236 261 286 317 353 390 426 446 444 423 385 337 283 231 185 146 118 101 90 82 76 74 73 73 74 76 "
        "77 76 75 73 72 74 79",
        (-0.028064958, 0.248999448, 0.382803349),
    ),
}


def test_the_observer_has_the_sums_that_cie_15_prints() -> None:
    grid, functions, d65 = observer()
    assert (grid[0], grid[-1], len(grid)) == (380.0, 780.0, 81)
    np.testing.assert_allclose(functions.sum(axis=0), [21.3715, 21.3713, 21.3715], atol=5e-5)
    white = d65 @ functions
    np.testing.assert_allclose(white[:2] / white.sum(), [0.3127, 0.3290], atol=1e-4)


@pytest.mark.parametrize("name", CHART)
def test_chart_agrees_with_an_independent_computation(name: str) -> None:
    text, expected = CHART[name]
    rgb = srgb_from_spectra(np.arange(380, 731, 10), np.array(text.split(), float) / 1000.0)
    np.testing.assert_allclose(rgb, expected, atol=2e-4)


@pytest.mark.parametrize("illuminant", ILLUMINANTS)
@pytest.mark.parametrize(
    "wavelengths",
    [np.arange(400, 701, 10), [550.0], np.linspace(360, 1000, 195), np.arange(380, 781), [1.0, 550.0, 5000.0]],
)
def test_a_constant_spectrum_is_white(wavelengths: object, illuminant: Illuminant) -> None:
    nanometres = np.asarray(wavelengths, float)
    np.testing.assert_allclose(srgb_from_spectra(nanometres, np.ones(len(nanometres)), illuminant), 1.0, atol=4e-15)


def test_finer_sampling_of_the_same_curve_changes_nothing() -> None:
    coarse = np.arange(380.0, 781.0, 20.0)
    spectrum = np.random.default_rng(1).random(len(coarse))
    ten = np.arange(380.0, 781.0, 10.0)
    expected = srgb_from_spectra(coarse, spectrum)
    np.testing.assert_allclose(srgb_from_spectra(ten, np.interp(ten, coarse, spectrum)), expected, atol=1e-13)


def test_missing_ends_take_the_nearest_band_and_invisible_bands_are_not_seen() -> None:
    short, long = np.arange(400.0, 701.0, 10.0), np.arange(380.0, 781.0, 10.0)
    spectrum = np.random.default_rng(2).random(len(short))
    expected = srgb_from_spectra(short, spectrum)
    np.testing.assert_allclose(srgb_from_spectra(long, np.interp(long, short, spectrum)), expected, atol=1e-14)
    beyond = srgb_from_spectra([*long, 900.0, 1000.0], [*np.interp(long, short, spectrum), 7.0, 8.0])
    np.testing.assert_allclose(beyond, expected, atol=1e-14)


@given(st.lists(st.floats(300.0, 900.0), min_size=2, max_size=40, unique=True), st.sampled_from(ILLUMINANTS))
def test_any_wavelengths_keep_white_or_are_refused(wavelengths: list[float], illuminant: Illuminant) -> None:
    nanometres = np.sort(wavelengths)
    if not ((nanometres >= 400.0) & (nanometres <= 700.0)).any():
        with pytest.raises(UsageError, match="400 and 700"):
            srgb_weights(nanometres, illuminant)
        return
    np.testing.assert_allclose(srgb_weights(nanometres, illuminant).sum(axis=0), 1.0, atol=1e-12)


@pytest.mark.parametrize("wrong", [[], [500.0, 500.0], [600.0, 500.0], [np.nan], [[500.0]], [200.0, 300.0]])
def test_wrong_wavelengths_are_refused(wrong: list[float]) -> None:
    with pytest.raises(ValueError, match="wavelength"):
        srgb_weights(wrong)


def test_wrong_calls_are_refused() -> None:
    with pytest.raises(ValueError, match="bands"):
        srgb_from_spectra([500.0, 600.0], np.ones(3))
    with pytest.raises(ValueError, match="choose from D65, E"):
        srgb_weights([500.0], "A")  # type: ignore[arg-type]
