"""Options of the command line for the settings of transport methods, made from their declarations.

An option that several methods have stands once, with what each says of it. None is what was not given.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable
from typing import Any

from app.arguments.results import Input
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
    """Add the options of all methods, `without` those that the parser has already."""
    groups: dict[str, Any] = {}
    for flag, owners in options(which).items():
        if flag in without:
            continue
        title = f"--mode {' and '.join(method.name for method, _ in owners)}"
        if title not in groups:
            groups[title] = parser.add_argument_group(title)
        groups[title].add_argument(flag, **_option(owners))


def _option(owners: list[tuple[Method, Parameter]]) -> dict[str, Any]:
    docs = list(dict.fromkeys(_words(parameter) for _, parameter in owners))
    if len(docs) > 1:
        docs = [f"{method.name}: {_words(parameter)}" for method, parameter in owners]
    parameter = owners[0][1]
    more: dict[str, Any] = {"metavar": parameter.metavar}
    if parameter.kind == "whole":
        more["type"] = int
    elif parameter.kind == "flag":
        more = {"action": "store_const", "const": True}
    elif parameter.kind == "choice":
        more = {"choices": parameter.values}
    elif parameter.kind in ("text", "texts"):
        more |= {"type": Input()} | ({"action": "append"} if parameter.kind == "texts" else {})
    return {"help": "; ".join(docs), "default": None, **more}


def _words(parameter: Parameter) -> str:
    is_shown = isinstance(parameter.default, int | str) and not isinstance(parameter.default, bool)
    default = f" ({parameter.default})" if is_shown and "(" not in parameter.doc[-40:] else ""
    return f"{parameter.doc}{default}"


def value_of(arguments: argparse.Namespace, flag: str) -> Any:
    """The value given for an option; None if it was not given."""
    return getattr(arguments, flag.removeprefix("--").replace("-", "_"), None)


def settings_from(arguments: argparse.Namespace, of: type[Any]) -> Any:
    """The dataclass `of` with what was given; UsageError for what cannot be."""
    values: dict[str, Any] = {}
    for parameter in parameters(of):
        given = value_of(arguments, parameter.flag)
        if given is not None:
            value = tuple(given) if isinstance(given, list) else given
            parameter.check(value, parameter.flag)
            values[parameter.name] = value
    return of(**values)


def strange_options(arguments: argparse.Namespace, which: Which, mode: str | None) -> list[tuple[str, str]]:
    """Options that were given and are not those of `mode`, each with the modes that it is for: 'sh or gaussian'."""
    return [
        (flag, " or ".join(method.name for method, _ in owners))
        for flag, owners in options(which).items()
        if value_of(arguments, flag) is not None and all(method.name != mode for method, _ in owners)
    ]
