"""Damaged files of every format in bulk: a sample of records and archives in each suite, a million files with `--long`.

The ordinary sample of images, meshes and lists is in `test_damage.py`, which also knows what each may give.
"""

from __future__ import annotations

import warnings

import pytest

from engine.core.errors import InputError
from tests.engine.storage import damaged_files

#: Files of a round of the campaign, of which there are 25.
FILES = 40_000


@pytest.mark.campaign(rounds=26)
def test_damaged_files_are_refused_in_words(seed: int, capsys: pytest.CaptureFixture[str]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        if seed:
            tally = damaged_files.run(FILES * seed, FILES)
        else:
            tally = damaged_files.run(0, len(damaged_files.FORMATS), in_child=False)
    said = capsys.readouterr().out
    assert "FAULT" not in tally.outcomes, said
    assert said == ""
    assert tally.outcomes["refused"] > tally.count // 2
    assert seed == 0 or tally.outcomes["read"] > tally.count // 10


def test_a_fault_is_told_with_the_number_of_its_file(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def read(_path: object) -> None:
        raise KeyError("width")

    one = damaged_files.Format("a.lp", lambda: b"5 lights", read=read)
    monkeypatch.setattr(damaged_files, "FORMATS", (one,))
    damaged_files._good.cache_clear()
    tally = damaged_files.run(7, 1)
    damaged_files._good.cache_clear()
    assert tally.outcomes == {"FAULT": 1}
    assert "file 7 (a.lp): KeyError: 'width'" in capsys.readouterr().out


def test_files_that_cannot_be_told_from_good_ones_do_not_exist() -> None:
    """Each damage changes its file, at least half of the time where a damage meets bytes that nothing changes."""
    for index, one in enumerate(damaged_files.FORMATS):
        if one.name in ("a.lp", "capture.toml", "a.dome"):
            good = one.good()
            others = [damaged_files.find_damaged(one, good, number) for number in range(index, index + 40)]
            assert sum(other != good for other in others) > 30


def test_records_under_a_right_seal_are_read_to_their_values() -> None:
    """A changed value gets the seal that it needs, so that what reads values meets it."""
    place = next(at for at, one in enumerate(damaged_files.FORMATS) if one.name == "manifest.json")
    one = damaged_files.FORMATS[place]
    from engine.storage.records import read_manifest

    said = set[str]()
    for number in range(40):
        try:
            read_manifest(damaged_files.find_damaged(one, damaged_files._good(place), number), "a")
        except InputError as error:
            said.add(error.problem)
    assert sum("not as it was written" in each for each in said) <= 1
    assert len(said) > 10
