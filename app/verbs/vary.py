"""`--vary`, by which verbs let parameters of a reflectance differ over a model."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from app.results import Input

if TYPE_CHECKING:
    from engine.transport.variation import Variation

HELP = (
    "let a parameter of an analytic reflectance go from one value to another over the model, by x, y or z across its "
    "bounding box or by the luminance of a picture at its texture coordinates: alpha=0.1:0.5:y"
)


def add_argument(parser: Any, beside: str = "") -> None:
    """The option, with what there is to say `beside` its usual help."""
    parser.add_argument(
        "--vary",
        type=Input(),
        action="append",
        default=[],
        metavar="PARAMETER=FROM:TO:SOURCE",
        help=f"{HELP}; {beside}" if beside else HELP,
    )


def variations_of(arguments: argparse.Namespace) -> list[Variation]:
    """What was asked for; wrong usage where it is none."""
    from app.cli import usage
    from engine.transport.variation import variation_from_text

    found: list[Variation] = usage(lambda: [variation_from_text(text) for text in arguments.vary])
    return found
