"""Fault 5 for scattered measurements: each damaged file gives samples that can be, or one sentence with its line.

Text has no checksum: a digit that changes is a value that changes. What passes is checked for what samples must be. A
table after ASTM says how many rows follow, so that one cut between two rows is noticed.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from engine.brdf.readers.alta import read_alta
from engine.brdf.readers.cornell import read_cornell
from engine.brdf.readers.csv_samples import read_csv_directions, read_csv_samples
from engine.brdf.readers.curet import read_curet
from engine.brdf.readers.read import read_measurement
from engine.brdf.samples import BrdfSamples
from tests.engine.brdf.fitted import fit_scattered_brdf
from tests.engine.brdf.readers.test_scattered_files import curet
from tests.engine.damage import COUNT, ROUNDS
from tests.engine.storage.test_damage import each_written

ROWS = np.random.default_rng(11).uniform(0.1, 1.2, (60, 11))
BANDS = [400, 450, 500, 550, 600, 650, 700]


def lines(separator: str, first: int = 0, last: int = 11) -> str:
    return "\n".join(separator.join(f"{number:.6f}" for number in row[first:last]) for row in ROWS) + "\n"


ASTM_HEADER = f"LAB_NAME somewhere\nNUM_POINTS {len(ROWS)}\nVARS theta_i,phi_i,theta_s,phi_s,"

#: A good file of each format, how long its header is, and its reader.
FILES: dict[str, tuple[str, int, Callable[[Path], BrdfSamples]]] = {
    "paint.brdf": (f"# paint\n7\n{' '.join(map(str, BANDS))}\n{lines(' ')}", 42, read_cornell),
    "paint.astm": (ASTM_HEADER + ",".join(f"{band}nm" for band in BANDS) + "\n" + lines(","), 130, read_cornell),
    "paint.dat": (
        f"#DIM 4 3\n#VS 0\n#PARAM_IN SPHERICAL_TL_PL_TV_PV\n#PARAM_OUT RGB_COLOR\n{lines(' ', 0, 7)}",
        68,
        read_alta,
    ),
    "paint.csv": ("theta_i,phi_i,theta_o,phi_o,R,G,B\n" + lines(",", 0, 7), 34, read_csv_samples),
}


def assert_possible(samples: BrdfSamples, what: str) -> None:
    assert len(samples.value) >= 1, what
    assert np.isfinite(samples.value).all(), what
    assert (samples.value >= 0.0).all() or samples.spectra is not None, what
    assert (samples.positive >= 0.0).all(), what
    assert (np.minimum(samples.wi[:, 2], samples.wo[:, 2]) > 0.0).all(), what


@pytest.mark.campaign(rounds=ROUNDS)
@pytest.mark.parametrize("name", FILES)
def test_fault_5_damaged_scattered_measurements(tmp_path: Path, name: str, seed: int) -> None:
    text, header, read = FILES[name]
    path = tmp_path / name
    path.write_text(text)
    passed = 0
    results = each_written(path, (0, header), lambda: read(path), seed=seed)
    for damage, samples in results:
        if samples is not None:
            passed += 1
            assert_possible(samples, str(damage)[:200])
            if path.suffix == ".astm" and damage.what == "cut":
                assert damage.first >= len(text) - 9, "a cut table is taken for a whole one"
    assert 1 / 40 < passed / len(results) < 9 / 10


@pytest.mark.campaign(rounds=ROUNDS)
def test_fault_5_damaged_curet_tables(tmp_path: Path, seed: int) -> None:
    path = curet(tmp_path, 1, "a")
    for damaged_file, count in ((path, COUNT), (tmp_path / "table.txt", COUNT // 2)):
        for damage, samples in each_written(damaged_file, (0, 200), lambda: read_curet(path), count, seed=seed):
            if samples is not None:
                assert_possible(samples, str(damage)[:200])


@pytest.mark.campaign(rounds=ROUNDS)
def test_fault_5_damaged_lists_of_directions(tmp_path: Path, seed: int) -> None:
    path = tmp_path / "directions.csv"
    path.write_text("theta_i,phi_i,theta_o,phi_o\n" + lines(",", 0, 4))
    for _, directions in each_written(path, (0, 28), lambda: read_csv_directions(path), seed=seed):
        if directions is not None:
            np.testing.assert_allclose(np.linalg.norm(directions, axis=-1), 1.0)


@pytest.mark.campaign(rounds=ROUNDS)
def test_fault_5_damaged_files_through_the_front_door(tmp_path: Path, seed: int) -> None:
    """Recognised as nothing, as another format, or read: never a traceback; and what is read can be made smooth."""
    files = smoothed = 0
    for name, (text, header, _) in FILES.items():
        path = tmp_path / name
        path.write_text(text)
        results = each_written(path, (0, header), partial(read_measurement, path), COUNT // 3, seed=seed)
        files += len(results)
        for damage, samples in results:
            if samples is not None:
                assert_possible(samples, str(damage)[:200])
                smoothed += 1
                if smoothed % 20 == 1:
                    values = fit_scattered_brdf(samples).f(samples.wi, samples.wo)
                    assert np.isfinite(values).all(), str(damage)[:200]
    assert smoothed > files / 27
