"""Options of the command line for the settings of transport methods, made from their declarations.

An option that several methods have stands once, with what each says of it. None is what was not given.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable
from typing import Any

from app.arguments.options import option, value_of, words_of
from engine.core.params import Parameter, parameters
from engine.transport import method as transport
from engine.transport.method import Method

#: The dataclass of a method whose settings are asked for: of its bake, or of the light on it.
Which = Callable[[Method], type[Any]]


def options(which: Which) -> dict[str, list[tuple[Method, Parameter]]]:
    """The methods and parameters of every option, by its flag."""
    found: dict[str, list[tuple[Method, Parameter]]] = {}
    for method in transport.METHODS:
        for parameter in parameters(which(method)):
            found.setdefault(parameter.flag, []).append((method, parameter))
    return found


def add_options(parser: argparse.ArgumentParser, which: Which, without: Iterable[str] = ()) -> None:
    """Add the options of all methods, `without` those that the parser has already, in a group for each method.

    Options of several methods are in a last group, and each of these methods names them.
    """
    found = {flag: owners for flag, owners in options(which).items() if flag not in without}
    for method in transport.METHODS:
        of_method = [flag for flag, owners in found.items() if method in (each for each, _ in owners)]
        own = [flag for flag in of_method if len(found[flag]) == 1]
        also = ", ".join(flag for flag in of_method if flag not in own)
        if own:
            group = parser.add_argument_group(f"--mode {method.name}", f"also {also}, see below" if also else None)
            for flag in own:
                group.add_argument(flag, **_option(found[flag]))
    shared = {flag: owners for flag, owners in found.items() if len(owners) > 1}
    last = parser.add_argument_group("several modes")
    for flag, owners in shared.items():
        last.add_argument(flag, **_option(owners))


def _option(owners: list[tuple[Method, Parameter]]) -> dict[str, Any]:
    docs = list(dict.fromkeys(words_of(parameter) for _, parameter in owners))
    if len(owners) > 1 and len(docs) == 1:
        docs = [f"{', '.join(method.name for method, _ in owners)}: {docs[0]}"]
    elif len(docs) > 1:
        docs = [f"{method.name}: {words_of(parameter)}" for method, parameter in owners]
    return option(owners[0][1], "; ".join(docs))


def strange_options(arguments: argparse.Namespace, which: Which, mode: str | None) -> list[tuple[str, str]]:
    """Options that were given and are not those of `mode`, each with the modes that it is for: 'sh or gaussian'."""
    return [
        (flag, " or ".join(method.name for method, _ in owners))
        for flag, owners in options(which).items()
        if value_of(arguments, flag) is not None and all(method.name != mode for method, _ in owners)
    ]
