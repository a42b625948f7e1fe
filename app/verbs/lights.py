"""Light as the command line of `lightarc render` names it."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from engine.environment import EnvironmentMap
    from engine.lamps import Lamp
    from engine.transport.lit import Light
    from engine.transport.sh_near_light import NearLamp

#: Where the light is unless something else is said.
LIGHT_DEG = (50.0, 30.0)

#: Most radiance: what was baked is multiplied in single precision, which ends at 3e38.
BRIGHTEST = 1e30


def angles_argument(text: str) -> tuple[float, float]:
    """Two finite numbers, THETA,PHI in degrees; the parser's error otherwise."""
    try:
        theta, phi = (float(number) for number in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not THETA,PHI such as 50,30") from None
    if not (math.isfinite(theta) and math.isfinite(phi)):
        raise argparse.ArgumentTypeError(f"{text!r} is not finite")
    return theta, phi


def lamp_argument(text: str) -> Lamp:
    """What --lamp names; the parser's error otherwise."""
    from engine.lamps import lamp_from_text

    return _argument(lamp_from_text, text)


def near_lamp_argument(text: str) -> NearLamp:
    """What --near-lamp names; the parser's error otherwise."""
    from engine.transport.sh_near_light import near_lamp_from_text

    return _argument(near_lamp_from_text, text)


Read = TypeVar("Read")


def _argument(read: Callable[[str], Read], text: str) -> Read:
    try:
        return read(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def light_of(arguments: argparse.Namespace) -> Light:
    """The light of --env, --light-deg, --lamp, --near-lamp and --intensity; wrong usage where it cannot be."""
    from app.cli import usage
    from engine.directions import world_direction
    from engine.environment_file import open_environment
    from engine.lamps import Lamp
    from engine.transport.lit import Light

    lamps, near_lamps = tuple(arguments.lamp), tuple(arguments.near_lamp)
    usage(_check, arguments)
    environment = open_environment(arguments.env) if arguments.env else None
    if environment is not None:
        usage(_check_brightness, environment, arguments.intensity)
    if environment is None and (arguments.light_deg is not None or not (lamps or near_lamps)):
        x, y, z = world_direction(*map(math.radians, arguments.light_deg or LIGHT_DEG))
        lamps = (usage(Lamp, (x, y, z), (arguments.intensity,) * 3), *lamps)
    turn = math.radians(arguments.env_rotation_deg)
    return Light(environment, turn, arguments.intensity, lamps, near_lamps)


def _check(arguments: argparse.Namespace) -> None:
    if not 0.0 <= arguments.intensity <= BRIGHTEST:
        raise ValueError(f"--intensity {arguments.intensity} is outside 0 … {BRIGHTEST:g}")
    if not math.isfinite(arguments.env_rotation_deg):
        raise ValueError(f"--env-rotation-deg {arguments.env_rotation_deg} is not finite")


def _check_brightness(environment: EnvironmentMap, factor: float) -> None:
    radiance = factor * float(environment.radiance.max())
    if radiance > BRIGHTEST:
        raise ValueError(
            f"{environment.name} is as bright as {radiance:.3g}, which is more than baked transport can be lit with "
            f"({BRIGHTEST:g}); a smaller --intensity makes it darker"
        )
