"""Shared by tests of the command line: the type of the fixture `lightarc`, and the record that a verb prints."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any

#: Runs the command line with these words; gives exit code, standard output and standard error.
Command = Callable[..., SimpleNamespace]


def result(command: SimpleNamespace) -> dict[str, Any]:
    """The JSON object of a verb that ended well."""
    assert command.code == 0, command.err
    found: dict[str, Any] = json.loads(command.out)
    return found


def replace_options(common: Sequence[Any], words: Sequence[Any]) -> tuple[Any, ...]:
    """The `common` options with one value each, or none, less those that `words` give: each may be given once."""
    given, kept = {str(word) for word in words if str(word).startswith("-")}, []
    for at, word in enumerate(common):
        option = word if str(word).startswith("-") else common[at - 1]
        if option not in given:
            kept.append(word)
    return tuple(kept)
