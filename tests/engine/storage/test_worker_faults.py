"""Fault 18: a decoder process that answers nonsense, of whatever kind, costs one file and is replaced."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from engine.core.errors import InputError, UnreadableError
from engine.storage import untrusted
from engine.storage.untrusted import decode_in_child
from tests.app.failing_decoder import FailingDecoder, Way

#: A decoder that writes on the pipe of replies, whatever its number, before its own answer.
DECODER = """
import os

def say(content, name, first=""):
    for descriptor in range(3, 30):
        try:
            os.write(descriptor, first.encode("latin-1"))
        except OSError:
            pass
    return {"pid": os.getpid()}
"""


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    (tmp_path / "decoder_that_lies.py").write_text(DECODER)
    monkeypatch.syspath_prepend(tmp_path)
    untrusted.stop_children()
    yield tmp_path / "decoder_that_lies.py"
    untrusted.stop_children()


@pytest.mark.parametrize(
    "answer",
    [
        "5\n",
        "[1]\n",
        "null\n",
        "{}\n",
        "\xff\xfe\n",
        "[" * 50_000 + "\n",
        '{"arrays": [["a", "<f4", [1e400]]]}\n',
        '{"arrays": [["a", "O", [2]]]}\n',
        '{"arrays": [["a", "<f4", [-2]]], "offsets": null}\n',
        '{"arrays": [["a", "<f4", [2]]], "offsets": {}}\n',
        '{"arrays": [["a", "<f4", [2]]], "offsets": {"a": -4096}}\n',
        '{"arrays": [["a", "<f4", [2]]], "offsets": {"a": 1e30}}\n',
        '{"arrays": [], "protection": 5}\n',
        '{"arrays": [], "problem": 5, "remedy": []}\n',
        '{"arrays": [], "problem": "is bad"}\n',
    ],
    ids=lambda answer: ascii(answer)[:40],
)
def test_fault18_nonsense_costs_one_file(file: Path, answer: str) -> None:
    decoder = "decoder_that_lies:say"
    good = decode_in_child(decoder, file)["pid"]
    with pytest.raises(InputError, match="invalid response"):
        decode_in_child(decoder, file, first=answer)
    assert decode_in_child(decoder, file)["pid"] != good


def test_a_result_that_a_decoder_owes_is_an_error_of_its_file(file: Path) -> None:
    reply = decode_in_child("decoder_that_lies:say", file)
    with pytest.raises(InputError, match="invalid response"):
        reply["radiance"]


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
@pytest.mark.parametrize(
    ("way", "said"),
    [
        ("unreadable", "cannot be read: Bad file descriptor"),
        ("killed", "the system ended the decoder process"),
        ("crashed", "is damaged: its decoder crashed"),
        ("halted", "could not be decoded within"),
    ],
)
def test_what_the_system_does_to_a_decoder_is_not_blamed_on_the_file(file: Path, way: Way, said: str) -> None:
    decode_in_child("decoder_that_lies:say", file)
    with FailingDecoder(0, way), pytest.raises(InputError, match=said) as raised:
        decode_in_child("decoder_that_lies:say", file)
    assert isinstance(raised.value, UnreadableError) == (way == "unreadable")
    assert decode_in_child("decoder_that_lies:say", file)["pid"]
