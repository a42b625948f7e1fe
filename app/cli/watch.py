"""`lightarc watch`: a capture is followed while it is taken, then imported and written as a project."""

from __future__ import annotations

import argparse
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack, closing
from pathlib import Path
from typing import Any

from app.arguments.common import Line
from app.arguments.quantities import SECONDS
from app.arguments.results import Input, Output, watch_result
from app.cli import import_
from app.process import ending
from app.project.project_file import ENDING
from engine.capture.ahead import WrittenAhead
from engine.capture.arriving import Arrived, Capture, Wait, Watching, arrive, decoding_options
from engine.capture.decoded import Decoded
from engine.capture.import_plan import ImportSettings
from engine.capture.import_stack import import_stack
from engine.core.errors import InputError, UsageError
from engine.core.figure_text import percent, time_text
from engine.core.health import Verdict
from engine.core.steps import Step, drain
from engine.storage.atomic import make_folder
from engine.storage.notices import Notices

EXAMPLE = "lightarc watch photographs -o woven.lap --expect 64"

#: The most photographs that may be expected, and seconds in which an import that was asked for by Ctrl+C is done.
MAX_EXPECTED, IMPORTING_S = 100_000, 1e6

#: The shortest and the longest time without a photograph after which a capture may end, in seconds.
MIN_IDLE_S, MAX_IDLE_S = 0.1, 1e6

#: Words for verdicts.
VERDICTS = {Verdict.GOOD: "good", Verdict.NOTE: "good", Verdict.WARNING: "doubtful", Verdict.BAD: "not usable"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "photographs",
        nargs=1,
        type=Input(Path, "beside"),
        metavar="FOLDER",
        help="the folder in which a camera or the controller of a dome writes photographs; those that are there count",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Output(watch_result, Path),
        metavar="PROJECT.lap|STACK",
        help="the project with stack and material, or the folder of a stack as 'lightarc import' writes it (the name "
        "of the folder with .lap, here)",
    )
    parser.add_argument(
        "--expect",
        type=_count,
        metavar="N",
        help="end when so many photographs are there (as many as a list of lights in the folder or --angles-deg names)",
    )
    parser.add_argument(
        "--until-idle",
        type=SECONDS,
        metavar="TIME",
        help="end when no photograph has come for so long after the last one, as 30s or 5min",
    )
    parser.add_argument(
        "--camera",
        nargs="?",
        const="",
        type=str,
        metavar="PORT",
        help="also download what a camera on a cable takes from now on into the folder: the one that is found, or the "
        "one at a port of libgphoto2 (usb:001,004), or a memory card (disk:/media/card); needs the library gphoto2",
    )
    import_.add_choices(parser)
    parser.epilog = f"{parser.epilog}\n\n{MORE_HELP}"


MORE_HELP = """\
Each photograph is awaited until it is whole, decoded once, and judged: clipping, focus, motion against the first one,
light that is missing, and the mirror sphere where --sphere asks for one. Without --expect, --until-idle and a list of
lights it goes on until Ctrl+C, which ends the capture and keeps what is there; a second Ctrl+C ends the program. The
result is that of 'lightarc import FOLDER' with the same options.

JSON: that of 'lightarc import', and expected, photographs (name, verdict, elevation_deg, azimuth_deg, findings),
coverage (share of the hemisphere within 25° of a lamp, null on an arc), stopped (by Ctrl+C), and
seconds_after_last, from the end of the last photograph until the result was written."""


def run(arguments: argparse.Namespace, show: Callable[[Step], None]) -> dict[str, Any]:
    from app.document.import_choices import choices_of
    from app.watch.camera import Camera
    from app.watch.project import choose_path_ahead, write_project

    begun_s, (folder,) = time.perf_counter(), arguments.photographs
    settings, sphere = import_.choose_settings(arguments), import_.outline_of(arguments.sphere)
    target = arguments.output or Path(f"{folder.resolve().name}{ENDING}")
    is_project = target.suffix.lower() == ENDING
    choices = choices_of(settings, sphere) if is_project else None
    if arguments.camera is not None:
        make_folder(folder)
    if not folder.is_dir():
        raise InputError(folder, "is not a folder, in which photographs could appear", "Name that of the camera")
    if arguments.until_idle is not None and not MIN_IDLE_S <= arguments.until_idle <= MAX_IDLE_S:
        raise UsageError(f"--until-idle {arguments.until_idle:g} s is outside {MIN_IDLE_S:g} s … {MAX_IDLE_S:g} s")
    frames = tuple(import_.frames_of(arguments))
    wishes = Watching(folder, arguments.expect, arguments.until_idle, arguments.angles_deg, sphere, frames)
    with ExitStack() as held:
        decoded = held.enter_context(closing(Decoded(decoding_options(folder, settings))))
        beside = choose_path_ahead(target) if is_project else target
        ahead = held.enter_context(closing(WrittenAhead(beside, settings, decoded.options)))
        source: Camera | Notices = Notices(folder) if arguments.camera is None else Camera(folder, arguments.camera)
        with closing(source):
            name = source.name if isinstance(source, Camera) else str(folder)
            show(Step(0.0, f"waiting for photographs from {name}"))
            capture, stopped, last_s = _follow(decoded, ahead, wishes, settings, source.wait, show)
        sources = drain(import_.find_sources(arguments, [folder]), show)
        if choices is not None:
            stack = drain(write_project(target, sources, choices), show).stack
        else:
            stack = drain(import_stack(sources, settings, target), show)
        assert stack is not None
        after_s = time.perf_counter() - last_s
    found = import_.describe(stack)
    missing = (
        []
        if capture.expect is None or capture.count >= capture.expect
        else [f"{capture.count} of {capture.expect} photographs came"]
    )
    return {
        **found,
        "warnings": [*missing, *found["warnings"]],
        "output": str(target),
        "expected": capture.expect,
        "photographs": [_describe(one) for one in capture.photographs],
        "coverage": capture.coverage,
        "stopped": stopped,
        "seconds_after_last": after_s,
        "time_s": time.perf_counter() - begun_s,
    }


def report(result: dict[str, Any]) -> str:
    usable = sum(one["verdict"] != VERDICTS[Verdict.BAD] for one in result["photographs"])
    lines = [f"{usable} of {len(result['photographs'])} photographs are usable"]
    if result["coverage"] is not None:
        lines.append(f"lights cover {percent(result['coverage'])} of the dome")
    lines.append(f"{result['output']} was written {time_text(result['seconds_after_last'])} after the last photograph")
    return "\n".join([*lines, import_.report(result)])


def _follow(
    decoded: Decoded,
    ahead: WrittenAhead,
    wishes: Watching,
    settings: ImportSettings,
    wait: Wait,
    show: Callable[[Step], None],
) -> tuple[Capture, bool, float]:
    """The capture when it has ended, whether Ctrl+C ended it, and when its last photograph was there."""
    from app.watch.kernels import load_kernels_beside

    finish, last_s = threading.Event(), time.perf_counter()

    def tell(step: Step) -> None:
        nonlocal last_s
        capture = step.partial if isinstance(step.partial, Capture) else Capture()
        for one in (one for one in capture.photographs if one.path.name in capture.new):
            last_s = time.perf_counter()
            show(Step(step.done, step.note, Line(_line(capture, one))))
        show(Step(step.done, step.note))

    with ending.during(finish.set, IMPORTING_S):
        arriving = arrive(decoded, wishes, finish.is_set, wait, ahead)
        capture = drain(load_kernels_beside(arriving, settings), tell)
    if finish.is_set():
        ending.go_on()
    return capture, finish.is_set(), last_s


def _line(capture: Capture, new: Arrived) -> str:
    """A photograph and the verdict on it: `3 of 64  c.tif  elevation 30°, azimuth 120°  good  (dome: 12 %)`."""
    many = f"{capture.count} of {capture.expect}" if capture.expect else f"{capture.count}"
    covered = capture.coverage
    words = [many, new.path.name, _direction_text(new), VERDICTS[new.verdict]]
    words += ["; ".join(each.text for each in new.findings)]
    words += ["" if covered is None else f"(dome: {percent(covered)})"]
    return "  ".join(word for word in words if word)


def _direction_text(one: Arrived) -> str:
    from engine.capture.lights.light_angles import direction_text

    return "" if one.direction is None else direction_text(*one.direction)


def _describe(one: Arrived) -> dict[str, Any]:
    elevation, azimuth = one.direction or (None, None)
    return {
        "name": one.path.name,
        "verdict": VERDICTS[one.verdict],
        "elevation_deg": elevation,
        "azimuth_deg": azimuth,
        "findings": [each.text for each in one.findings],
    }


def _count(text: str) -> int:
    if not text.isdecimal() or len(text) > 6 or not 2 <= int(text) <= MAX_EXPECTED:
        raise argparse.ArgumentTypeError(f"{text[:40]!r} is not a number of photographs from 2 to {MAX_EXPECTED}")
    return int(text)
