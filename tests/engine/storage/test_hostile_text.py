"""Text from outside that is made to be slow (safety S3): no reader searches backwards, and all refuse in one sentence.

How long they take is measured by `python -m benchmarks --only hostile-text`; here it follows from the patterns: where
every repetition is bounded, and their choices multiplied are few, so is the work at each place of a text.
"""

from __future__ import annotations

import ast
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import pytest

from benchmarks.hostile_text import FILLS, PLACES, refusal
from engine.capture.lights.capture_file import read_capture_file
from engine.core.errors import InputError
from engine.storage.records import read_manifest
from engine.storage.text import read_json
from tests.cases import few

PROJECT = Path(__file__).resolve().parents[3]

#: Modules whose patterns meet nothing but texts of our own, or names in a folder, which systems keep short.
OWN_TEXT = {
    "engine/capture/lights/folder.py",
    "engine/gl/program.py",
    "engine/bundle/page.py",
    "engine/bundle/portable.py",
    "engine/core/figure_text.py",
    "engine/exchange/shaders.py",
    "engine/figures/figure.py",
    "engine/storage/partial_names.py",
    "engine/storage/writer.py",
    "app/command_line.py",
}

#: Ways to match a text at one place, all of which a pattern that fails in the end may try.
MAX_WAYS = 1000

#: Rounds in which every place meets every fill; the first is in the ordinary suite.
ROUNDS = 8

#: Lengths at which every place and fill is read: longer than most buffers, and over in milliseconds.
LENGTH = 1 << 12


def patterns() -> Iterator[tuple[str, str | bytes]]:
    """The patterns of engine and app with their places in the sources; those put together from constants as well."""
    for path in sorted([*PROJECT.glob("engine/**/*.py"), *PROJECT.glob("app/**/*.py")]):
        module = path.relative_to(PROJECT).as_posix()
        text = path.read_text(encoding="utf-8")
        if "import re\n" not in text:
            continue
        tree = ast.parse(text)
        known = {
            node.targets[0].id: node.value.value
            for node in tree.body
            if isinstance(node, ast.Assign)
            and isinstance(node.targets[0], ast.Name)
            and isinstance(node.value, ast.Constant)
        }
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and find_uses_of_re(node.func) and module not in OWN_TEXT:
                yield f"{module}:{node.lineno}", eval(ast.unparse(node.args[0]), {}, known)


def find_uses_of_re(function: ast.expr) -> bool:
    return isinstance(function, ast.Attribute) and isinstance(function.value, ast.Name) and function.value.id == "re"


def ways(pattern: str | bytes) -> float:
    """The number of ways to match at one place; infinite for a repetition without a bound."""
    return _ways_of(cast(Any, re)._parser.parse(pattern))


def _ways_of(parsed: Any) -> float:
    return math.prod(_ways_of_one(str(kind), value) for kind, value in parsed)


def _ways_of_one(kind: str, value: Any) -> float:
    match kind, value:
        case ("MAX_REPEAT" | "MIN_REPEAT", (low, high, repeated)):
            one = _ways_of(repeated)
            return (
                math.inf
                if high == cast(Any, re)._parser.MAXREPEAT
                else sum(one**count for count in range(low, high + 1))
            )
        case "POSSESSIVE_REPEAT", (_, high, repeated):
            return math.inf if high == cast(Any, re)._parser.MAXREPEAT else _ways_of(repeated)
        case "BRANCH", (_, branches):
            return sum(map(_ways_of, branches))
        case "SUBPATTERN", (*_, inner):
            return _ways_of(inner)
        case "ATOMIC_GROUP", inner:
            return _ways_of(inner)
        case "ASSERT" | "ASSERT_NOT", (_, inner):
            return _ways_of(inner)
    return 1.0


def test_S3_no_pattern_repeats_without_a_bound() -> None:
    assert {place: pattern for place, pattern in patterns() if not ways(pattern) <= MAX_WAYS} == {}


def test_S3_what_was_slow_has_no_bound() -> None:
    assert ways(r"[_ (\[]*(deg|degrees?|°)[)\]]?$") == math.inf
    assert ways(rb"OFF(?:\s|#[^\n]*\n)+\d{1,12}") == math.inf
    assert ways(r"(\d{1,9}+(?:\.\d{1,9}+)?) {0,9}+nm") == 2.0
    assert ways(r"(ab|cd){0,3}") == 1 + 2 + 4 + 8


@pytest.mark.parametrize("name", PLACES)
@pytest.mark.campaign(rounds=ROUNDS)
def test_S3_hostile_text_is_read_or_refused_in_one_sentence(name: str, seed: int, tmp_path: Path) -> None:
    first = (list(PLACES).index(name) + seed) % ROUNDS
    for what, fill in list(FILLS.items())[first::ROUNDS]:
        said = refusal(PLACES[name], fill, LENGTH, tmp_path)
        assert said is None or (said and "\n" not in said and len(said) < 1000), f"{name} with {what}: {said}"


@pytest.mark.parametrize(
    "name",
    few(
        ["TOML number", "JSON number", "CSV number", ".lp numbers", "Cornell count", "OBJ face"],
        lambda name: name in ("JSON number", "OBJ face"),
    ),
)
def test_S3_numbers_of_a_million_digits(name: str, tmp_path: Path) -> None:
    refusal(PLACES[name], "7", 1_000_000, tmp_path)


def test_S3_keys_of_many_parts_are_refused_however_they_are_hidden(tmp_path: Path) -> None:
    path = tmp_path / "capture.toml"
    parts = ".a" * 2000
    for before in (
        "a",
        "'\\'",
        "'\"'",
        '"\\""',
        'x = {b = """""", a',
        'x = {b = """\n"""", a',
        "x = {b = '''\n''''', a",
    ):
        path.write_text(f"{before}{parts} = 1" + "}" * before.startswith("x"))
        with pytest.raises(InputError, match="a key of more than 32 parts"):
            read_capture_file(path)
    for notes in ('"' + "." * 99 + '"', "'" + "\\." * 99 + "'", f'"""\n"{parts}"""', f'"" # {parts}'):
        path.write_text(f"notes = {notes}")
        assert read_capture_file(path).notes.count(".") in (99, 2000, 0)


def test_S3_nested_manifests_are_refused_at_any_depth() -> None:
    for depth in (*range(400, 1100, 10), 100_000):
        nested = b"[" * depth + b"]" * depth
        with pytest.raises(InputError, match=r"nested too deeply|not as it was written"):
            read_manifest(b'{"format": "lightarc-bundle", "name": ' + nested + b"}", "a")
    with pytest.raises(InputError, match="too large"):
        read_json(b"1e400", "a", "b")
