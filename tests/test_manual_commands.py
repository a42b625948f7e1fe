"""Commands of the README and of the manual: verbs and options exist, and all that can be run by itself runs."""

from __future__ import annotations

import argparse
import re
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

import pytest

from app.command_line import VERBS, build_parser

PROJECT = Path(__file__).resolve().parents[1]


def load() -> Any:
    spec = spec_from_file_location("manual_commands", PROJECT / "packaging" / "manual_commands.py")
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    sys.modules["manual_commands"] = module
    spec.loader.exec_module(module)
    return module


manual_commands = load()
RUN = [PROJECT / "README.md", *manual_commands.tutorials()]


def options_of(words: list[str]) -> tuple[set[str], set[str]]:
    """The options that a command uses, and those that its verb declares."""
    (verbs,) = (each for each in build_parser(words[0])._actions if isinstance(each, argparse._SubParsersAction))
    parser: argparse.ArgumentParser = verbs.choices[words[0]]
    for word in words[1:2]:
        for action in parser._actions:
            if isinstance(action, argparse._SubParsersAction):
                parser = action.choices[word]
    used = {word.partition("=")[0] for word in words if word.startswith("-") and not word[1:2].isdigit()}
    return used, set(parser._option_string_actions)


def test_every_command_of_readme_and_manual_has_a_verb_and_options_that_exist() -> None:
    names = {name for name, _, _ in VERBS}
    found = [(page.name, words) for page in manual_commands.pages() for words in manual_commands.commands(page)]
    assert len(found) > 40
    assert [each for each in found if each[1][0] not in names] == []
    unknown = [(page, words[0], used - known) for page, words in found for used, known in [options_of(words)]]
    assert [each for each in unknown if each[2]] == []


def test_the_readme_stays_short() -> None:
    assert len((PROJECT / "README.md").read_text(encoding="utf-8").splitlines()) <= 150


def test_commands_are_found_in_blocks_of_all_kinds(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        "    lightarc one -o a\n\n1. step\n\n       lightarc two\n\n"
        "   ```console\n   $ lightarc three \\\n     --x 'a b'\n   written\n   ```\n\n"
        "```python\nimport lightarc\n```\n\nText of lightarc four.\n"
    )
    assert manual_commands.commands(page) == [["one", "-o", "a"], ["two"], ["three", "--x", "a b"]]
    assert "import lightarc\n" in [*manual_commands.steps(page)]


@pytest.mark.long
@pytest.mark.parametrize("page", RUN, ids=[page.stem for page in RUN])
def test_the_commands_of_a_page_run_one_after_another(page: Path, tmp_path: Path) -> None:
    manual_commands.run_commands(page, tmp_path)


def test_every_message_that_the_manual_explains_is_one_of_the_program() -> None:
    sources = [
        path.read_text(encoding="utf-8") for folder in ("app", "engine") for path in (PROJECT / folder).rglob("*.py")
    ]
    written = re.sub(r'"\s*\n\s*f?"', "", "\n".join(sources))
    page = (PROJECT / "docs" / "manual" / "messages.md").read_text(encoding="utf-8")
    messages = re.findall(r"^\| `([^`]*)` \|", page, re.MULTILINE)
    assert len(messages) > 15
    missing = [
        (message, part) for message in messages for part in message.split("…") if part.strip(" ,") not in written
    ]
    assert missing == []
