"""Options that are given twice."""

from __future__ import annotations

import pytest

from app.arguments.usage import WRONG_USAGE
from tests.app.command import Command


@pytest.mark.parametrize(
    ("words", "option"),
    [
        ("render sphere --brdf lambert --width 32 --width=64 -o {out}.png", "--width"),
        ("brdf eval lambert --wi-deg 30,0 --wi-deg -30,0 --wo-deg 30,180", "--wi-deg"),
        ("project info x.lap --json --json", "--json"),
        ("shade x --slices 2 --slices 3 -o {out}", "--slices"),
        ("compare a.png b.png -o c.png --mask m.png --mask n.png", "--mask"),
    ],
)
def test_an_option_given_twice_is_refused(words: str, option: str, lightarc: Command, tmp_path: object) -> None:
    ended = lightarc(*words.format(out=f"{tmp_path}/a").split())
    assert ended.code == WRONG_USAGE
    assert f"{option}: is given twice" in ended.err


def test_options_that_collect_values_may_repeat(lightarc: Command) -> None:
    words = "plan sphere --brdf lambert --skip shadows --skip interreflection --error nothing"
    assert "argument --error: 'nothing' is not a share" in lightarc(*words.split()).err
