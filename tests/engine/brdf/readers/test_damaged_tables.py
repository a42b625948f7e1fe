"""Fault 5 for tables of BRDFs: each damaged file gives a table that can be, or one sentence.

MERL has 12 bytes of header and UTIA none, and neither a checksum: what keeps the size and the header may pass, with
finite values that are not negative. Such files are all alike, so that a few of them are read to the end. Our own
files carry a fingerprint: what passes is the table that was written.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.brdf.readers.merl import SHAPE, SIZE_BYTES, read_merl
from engine.brdf.readers.read import read_brdf
from engine.brdf.readers.table_file import encode_table, read_table
from engine.brdf.readers.utia import SIZE_BYTES as UTIA_BYTES
from engine.brdf.readers.utia import read_utia
from engine.core.errors import InputError
from tests.engine.brdf.readers.test_table_file import make_holed_table
from tests.engine.brdf.readers.test_utia import model_planes
from tests.engine.brdf.test_table import direction_table, random_table
from tests.engine.damage import COUNT, ROUNDS, Damage, find_damaged
from tests.engine.storage.test_damage import assert_refused_in_words, each_written

#: Files that keep size and header, of which all are alike, that are read to the end.
READ_TO_THE_END = 8


def assert_possible(table: Any, damage: Damage) -> None:
    assert np.isfinite(table.values).all(), damage
    assert table.values.min() >= 0.0, damage
    assert table.missing.shape == table.values.shape[:-1], damage


@pytest.mark.campaign(rounds=ROUNDS)
def test_fault_5_damaged_merl_files(tmp_path: Path, seed: int) -> None:
    """The damaged start of a file, and the rest of it as a hole on the disk that nobody has to write."""
    start = np.array(SHAPE, "<i4").tobytes() + np.linspace(1.0, 2.0, 9).astype("<f8").tobytes()
    path = tmp_path / "paint.binary"
    refused = read = 0
    damages = list(find_damaged(start, (0, 12), seed=seed))
    for damage in damages:
        size_bytes = len(damage.content) if damage.what == "cut" else SIZE_BYTES + len(damage.content) - len(start)
        whole = size_bytes == SIZE_BYTES and damage.content[:12] == start[:12]
        if whole and read == READ_TO_THE_END:
            continue
        with path.open("wb") as file:
            file.write(damage.content)
            file.truncate(size_bytes)
        try:
            table = read_merl(path)
        except InputError as error:
            assert_refused_in_words(error, str(damage))
            refused += 1
        else:
            assert whole, damage
            assert_possible(table, damage)
        read += whole
    assert read == READ_TO_THE_END
    assert refused > len(damages) // 2


@pytest.mark.campaign(rounds=ROUNDS)
def test_fault_5_damaged_utia_files(tmp_path: Path, seed: int) -> None:
    start = model_planes().astype("<f8").tobytes()[:2048]
    path = tmp_path / "cloth.bin"
    refused = read = 0
    damages = list(find_damaged(start, (0, len(start)), seed=seed))
    for damage in damages:
        size_bytes = len(damage.content) if damage.what == "cut" else UTIA_BYTES + len(damage.content) - len(start)
        whole = size_bytes == UTIA_BYTES
        if whole and read == READ_TO_THE_END:
            continue
        with path.open("wb") as file:
            file.write(damage.content)
            file.truncate(size_bytes)
        try:
            table = read_utia(path)
        except InputError as error:
            assert_refused_in_words(error, str(damage))
            refused += 1
        else:
            assert whole, damage
            assert_possible(table, damage)
        read += whole
    assert refused > len(damages) // 5


@pytest.mark.campaign(rounds=ROUNDS)
@pytest.mark.parametrize("layout", ["half-difference", "directions"])
def test_fault_5_damaged_tables_of_our_own_are_refused_or_whole(tmp_path: Path, layout: str, seed: int) -> None:
    table = make_holed_table() if layout == "half-difference" else direction_table(columns=3)
    content, stored = encode_table(table)
    path = tmp_path / "table.exr"
    path.write_bytes(content)
    header = (0, content.index(b"lineOrder"))
    refused = 0
    results = each_written(path, header, lambda: read_table(path), COUNT // 2, seed=seed)
    for damage, found in results:
        if found is None:
            refused += 1
            continue
        assert type(found) is type(stored), damage
        assert np.array_equal(found.values, stored.values), damage
        assert np.array_equal(found.missing, stored.missing), damage
        assert (found.name, found.kind, found.health) == (stored.name, stored.kind, stored.health), damage
    assert refused > len(results) // 2


def test_fault_5_a_file_that_grows_or_shrinks_between_two_looks_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import engine.brdf.readers.merl as merl

    path = tmp_path / "paint.binary"
    with path.open("wb") as file:
        file.write(np.array(SHAPE, "<i4").tobytes())
        file.truncate(SIZE_BYTES)
    monkeypatch.setattr(merl, "read_bytes", lambda *_: path.read_bytes()[:-8])
    with pytest.raises(InputError, match="34,992,004 bytes where"):
        read_brdf(path)


def test_a_table_of_one_bin_is_a_table() -> None:
    table = random_table((1, 1, 1))
    assert table.at(0.3, 0.4, 0.5) == pytest.approx(table.values[0, 0, 0])
