"""Options of the command line made from declared parameters (`engine.core.params`); None is what was not given."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from typing import Any

from app.arguments.results import Input
from engine.core.cluster import check_cluster
from engine.core.errors import UsageError
from engine.core.params import Parameter, parameters


def option(parameter: Parameter, words: str = "") -> dict[str, Any]:
    """The keyword arguments of argparse's `add_argument`; its help are other `words` where some are given."""
    more: dict[str, Any] = {"metavar": parameter.metavar}
    if parameter.kind in ("whole", "number"):
        more["type"] = int if parameter.kind == "whole" else float
    elif parameter.kind == "flag":
        more = {"action": "store_const", "const": True}
    elif parameter.kind == "choice":
        more = {"choices": parameter.values}
    elif parameter.kind in ("text", "texts"):
        more |= {"type": Input()} | ({"action": "append"} if parameter.kind == "texts" else {})
    return {"help": words or words_of(parameter), "default": None, **more}


def words_of(parameter: Parameter) -> str:
    """The sentence of a parameter with its default."""
    is_shown = isinstance(parameter.default, int | float | str) and not isinstance(parameter.default, bool)
    default = f" ({parameter.default})" if is_shown and "(" not in parameter.doc[-40:] else ""
    return f"{parameter.doc}{default}"


def value_of(arguments: argparse.Namespace, flag: str) -> Any:
    """The value given for an option; None if it was not given."""
    return getattr(arguments, flag.removeprefix("--").replace("-", "_"), None)


def refuse_unused(arguments: argparse.Namespace, rules: Iterable[tuple[str, bool, str]]) -> None:
    """UsageError for an option that was given and is not used: each rule is its flag, whether it is, what it needs."""
    for flag, is_used, need in rules:
        if not is_used and value_of(arguments, flag) not in (None, False):
            raise UsageError(f"{flag} needs {need}")


def settings_from(arguments: argparse.Namespace, of: type[Any], without: Iterable[str] = ()) -> Any:
    """The dataclass `of` with what was given, `without` some parameters; UsageError for what cannot be."""
    values: dict[str, Any] = {}
    for parameter in parameters(of):
        given = value_of(arguments, parameter.flag)
        if given is not None and parameter.name not in without:
            value = tuple(given) if isinstance(given, list) else given
            parameter.check(value, parameter.flag)
            values[parameter.name] = value
    return of(**values)


def add_search(parser: argparse.ArgumentParser) -> None:
    """The folder of images and libraries that a document names."""
    parser.add_argument(
        "--search",
        type=Input(),
        metavar="FOLDER",
        help="a folder, with those below, in which images that a document names may lie (MaterialX, glTF, USD), and "
        "libraries of OBJ models; names lead there as from the document, or are looked for from FOLDER on",
    )


def add_cluster(parser: argparse.ArgumentParser, verb: str) -> None:
    """The address of a cluster on whose workers to do what `verb` says."""
    parser.add_argument(
        "--cluster",
        type=str,
        metavar="ADDRESS",
        help=f"{verb} on the workers of a Dask cluster that has this program: the address of its scheduler, for "
        "example tls://192.168.0.10:8786; use only a cluster of your own",
    )
    parser.add_argument(
        "--plain-cluster",
        action="store_true",
        help="take an address without TLS (tcp://) of another computer; anybody in that network can then run code on "
        "this one and on the workers",
    )


def refuse_plain_cluster(arguments: argparse.Namespace) -> None:
    """UsageError for an address of a cluster that is none, or that has no TLS and was not asked for."""
    if arguments.cluster is not None:
        check_cluster(arguments.cluster, allow_plain=arguments.plain_cluster)
    elif arguments.plain_cluster:
        raise UsageError("--plain-cluster needs --cluster")
