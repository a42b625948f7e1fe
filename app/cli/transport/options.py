"""Light as the command line names it, and `--vary`, which lets parameters of a BRDF vary over a model."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from app.arguments.results import Input
from app.cli.transport import project_input
from app.document.variation import as_baked, find_varied_in
from engine.core.directions import world_direction
from engine.core.errors import UsageError
from engine.core.figure_text import number
from engine.geometry.brushing import Brushing, parse_brushing
from engine.light.environment_file import open_environment
from engine.light.lamps import Lamp, lamp_from_text
from engine.light.near_lamps import near_lamp_from_text
from engine.scene.settings import DEFAULTS
from engine.transport.baking.spatially_varying import variation_from_text
from engine.transport.relight import Light

if TYPE_CHECKING:
    from engine.brdf.brdf import Brdf
    from engine.light.environment import EnvironmentMap
    from engine.light.near_lamps import NearLamp
    from engine.transport.baking.spatially_varying import Variation

#: Most radiance: what was baked is multiplied in single precision, which ends at 3e38.
BRIGHTEST = 1e30


def brushing_argument(text: str) -> Brushing:
    """The direction that --brushing names; the parser's error otherwise."""
    return _argument(parse_brushing, text)


def lamp_argument(text: str) -> Lamp:
    """The lamp that --lamp names; the parser's error otherwise."""
    return _argument(lamp_from_text, text)


def near_lamp_argument(text: str) -> NearLamp:
    """The lamp that --near-lamp names; the parser's error otherwise."""
    return _argument(near_lamp_from_text, text)


Read = TypeVar("Read")


def _argument(read: Callable[[str], Read], text: str) -> Read:
    try:
        return read(text)
    except UsageError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def light_of(arguments: argparse.Namespace) -> Light:
    """The light of --env, --light-deg, --lamp, --near-lamp and --intensity; wrong usage where it cannot be."""
    lamps, near_lamps = tuple(arguments.lamp), tuple(arguments.near_lamp)
    _check(arguments)
    environment = open_environment(arguments.env) if arguments.env else None
    if environment is not None:
        _check_brightness(environment, arguments.intensity)
    if environment is None and (arguments.light_deg is not None or not (lamps or near_lamps)):
        x, y, z = world_direction(*map(math.radians, arguments.light_deg or DEFAULTS.light_deg))
        lamps = (Lamp((x, y, z), (arguments.intensity,) * 3), *lamps)
    turn = math.radians(arguments.env_rotation_deg)
    return Light(environment, turn, arguments.intensity, lamps, near_lamps)


def _check(arguments: argparse.Namespace) -> None:
    if not 0.0 <= arguments.intensity <= BRIGHTEST:
        raise UsageError(f"--intensity {arguments.intensity} is outside 0 … {BRIGHTEST:g}")
    if not math.isfinite(arguments.env_rotation_deg):
        raise UsageError(f"--env-rotation-deg {arguments.env_rotation_deg} is not finite")


def _check_brightness(environment: EnvironmentMap, factor: float) -> None:
    radiance = factor * float(environment.radiance.max())
    if radiance > BRIGHTEST:
        raise UsageError(
            f"{environment.name} is as bright as {number(radiance, 3)}, above the limit for baked transport "
            f"({BRIGHTEST:g}); choose a smaller --intensity"
        )


HELP = (
    "vary a parameter of an analytic BRDF from one value to another over the model, by x, y or z across its "
    "bounding box or by the luminance of an image at its texture coordinates: alpha=0.1:0.5:y"
)


def add_argument(parser: argparse.ArgumentParser | argparse._ArgumentGroup, beside: str = "") -> None:
    """The option, with what there is to say `beside` its usual help."""
    parser.add_argument(
        "--vary",
        type=Input(),
        action="append",
        default=[],
        metavar="PARAMETER=FROM:TO:SOURCE",
        help=f"{HELP}; {beside}" if beside else HELP,
    )


def variations_of(arguments: argparse.Namespace, brdf: Brdf) -> list[Variation]:
    """The variations that the arguments name, or those of a project whose BRDF is `brdf`.

    Wrong usage where one is invalid.
    """
    if project_input.is_given(arguments):
        return [*as_baked(find_varied_in(brdf, project_input.setup_of(arguments).project.variations))]
    return [variation_from_text(text) for text in arguments.vary]
