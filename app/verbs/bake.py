"""`lightarc bake`: precompute what light does to a model, so that light and view can then change at once.

The arguments that all modes share are here; each mode has a module of its own with the rest.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any

from app.verbs import bake_auto, bake_gaussian, bake_sh, bake_wavelet, vary
from app.verbs.baked import words_of_time
from app.verbs.brdf import BRDF_HELP
from engine.steps import Step

HELP = "Precompute light transport for a model and a reflectance, for 'lightarc render' and the window."
EXAMPLE = "lightarc bake sphere --brdf ggx:alpha=0.3 --mode wavelet --ground -o sphere.transport"

#: For each mode the module with its options (`add_arguments`), its bake (`run`) and its lines of the report (`lines`).
MODES: dict[str, Any] = {"wavelet": bake_wavelet, "sh": bake_sh, "gaussian": bake_gaussian, "auto": bake_auto}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("mesh", metavar="MESH", help="a file, or a built-in: sphere, plane, torus-knot, cloth, blob")
    parser.add_argument("--brdf", required=True, metavar="TEXT", help=BRDF_HELP)
    parser.add_argument("-o", "--output", required=True, metavar="TRANSPORT", help="file to write, say bunny.transport")
    parser.add_argument(
        "--mode",
        default="wavelet",
        choices=tuple(MODES),
        help="wavelet: sharp shadows; sh: soft light; gaussian: sharp highlights; auto: what 'lightarc plan' finds "
        "(wavelet)",
    )
    parser.add_argument(
        "--ground",
        nargs="?",
        type=float,
        const=0.5,
        metavar="ALBEDO",
        help="let the model stand on a matt ground that receives its shadow (of albedo 0.5)",
    )
    parser.add_argument("--ground-cells", type=int, default=64, metavar="N", help="squares along its side (64)")
    parser.add_argument(
        "--cube",
        type=int,
        metavar="N",
        help="edge of the cube map that visibility is counted over: for wavelets, and their light, 16, 32 or 64, "
        "or fewer for a quick look (64); for sh and gaussian 4 to 256 (32, above order 8 64)",
    )
    parser.add_argument(
        "--fine",
        type=int,
        default=4,
        metavar="N",
        help="N × N rays for each texel of the cube map at the edges of shadows (4)",
    )
    parser.add_argument(
        "--order",
        type=int,
        default=5,
        metavar="N",
        help="harmonics of N bands, 3 to 15: of everything with sh, of the matt part with gaussian (5)",
    )
    vary.add_argument(parser, "for sh, twice at most, gaussian and auto")
    parser.add_argument(
        "--error-env",
        metavar="FILE",
        help="measure the error under this environment at 400 vertices, seen from 20 directions (half a minute)",
    )
    parser.add_argument(
        "--restart",
        action="store_true",
        help="use nothing of an earlier bake that was cancelled, and leave nothing where this one is",
    )
    parser.add_argument(
        "--cluster",
        metavar="ADDRESS",
        help="bake on the workers of a Dask cluster that has this program: the address of its scheduler, say "
        "tcp://192.168.0.10:8786; use only a cluster of your own",
    )
    for name, module in MODES.items():
        module.add_arguments(parser.add_argument_group(f"--mode {name}"))


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    from app.cli import usage

    usage(_check, arguments)
    result: dict[str, Any] = MODES[arguments.mode].run(arguments, show)
    return result


def report(result: dict[str, Any]) -> str:
    if result["cancelled"]:
        return _cancelled(result)
    size = f"{result['size_bytes'] / 1e6:.1f} MB"
    share = 100.0 * result["visibility_s"] / result["bake_s"] if result["bake_s"] > 0.0 else 0.0
    lines = [
        f"{result['output']}: {result['vertices']:,} vertices, {size}, {words_of_time(result['bake_s'])}, "
        f"{share:.0f} % of it for visibility",
        *MODES[result["knobs"]["mode"]].lines(result),
    ]
    if result["chunks_resumed"]:
        lines.append(f"{result['chunks_resumed']} of {result['chunks']} chunks were there from before")
    return "\n".join([*lines, *result["skipped"], *result["warnings"]])


def _cancelled(result: dict[str, Any]) -> str:
    if result["unfinished"] is None:
        return "Cancelled; nothing was written."
    left, size = result["unfinished"], f"{result['unfinished_bytes'] / 1e6:.1f} MB"
    return f"Cancelled; the same command goes on from here, with {left} ({size}), which --restart discards."


def _check(arguments: argparse.Namespace) -> None:
    """ValueError where an option is given that belongs to another mode, or an address is none."""
    if arguments.order != 5 and arguments.mode == "wavelet":
        raise ValueError("--order needs --mode sh or gaussian")
    if arguments.vary and arguments.mode == "wavelet":
        raise ValueError("--vary is not for --mode wavelet, which is baked for one reflectance")
    from engine.transport.chunks import check_cluster

    if arguments.cluster is not None:
        check_cluster(arguments.cluster)
    for name, module in MODES.items():
        options = argparse.ArgumentParser(add_help=False)
        module.add_arguments(options)
        for action in options._actions if name != arguments.mode else ():
            if getattr(arguments, action.dest) != action.default:
                raise ValueError(f"{action.option_strings[0]} needs --mode {name}")
