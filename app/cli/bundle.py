"""`lightarc bundle`: check a bundle, or show what is in it."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

from app.arguments.results import Input
from app.arguments.usage import BAD_FILE, DONE
from engine.core.steps import Step

NAME = "bundle"
HELP = "Check a bundle (hashes, schema, bounds, pixels) or show its manifest."
EXAMPLE = "lightarc bundle verify woven.lightarc --json"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("action", choices=("verify", "show"), help="verify: check everything; show: print the manifest")
    parser.add_argument("path", type=Input(), metavar="BUNDLE", help="a .lightarc file or a bundle folder")


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    """`ok`, `members`, `problems`, `size_bytes`, `schema_version` of a bundle; exit code 3 where it is not sound."""
    from engine.bundle.bundle import describe_bundle, verify_bundle

    show(Step(0.0, "reading the bundle"))
    if arguments.action == "show":
        return describe_bundle(arguments.path)
    verification = verify_bundle(arguments.path)
    return {
        "ok": verification.ok,
        "members": list(verification.members),
        "problems": list(verification.problems),
        "size_bytes": verification.size_bytes,
        "schema_version": verification.schema_version,
        "exit_code": DONE if verification.ok else BAD_FILE,
    }


def report(result: dict[str, Any]) -> str:
    if "ok" not in result:
        return "\n".join(f"{name}: {value}" for name, value in result.items())
    if result["ok"]:
        return f"The bundle is sound: {len(result['members'])} members, {result['size_bytes']:,} bytes."
    return "\n".join(["The bundle is not sound:", *(f"- {problem}" for problem in result["problems"])])
