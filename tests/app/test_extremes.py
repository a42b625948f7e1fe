"""Extreme numbers for every parameter of every verb: done, or refused in a sentence, and never a warning of Python.

The parameters are walked: numbers of the verbs' own parsers, and the ranges that BRDFs and lamps declare. Texts
that hold several numbers are written with a place for each (`TEXTS`). Images and models hold extreme numbers as well.
"""

from __future__ import annotations

import json
import os
import random
import re
import signal
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from app import command_line
from app.arguments.common import thread_number
from app.arguments.quantities import Degrees, Units, share
from app.arguments.results import Input, Output
from app.arguments.usage import BAD_FILE, CANCELLED, DONE, WRONG_USAGE
from engine.brdf.brdf import MODELS
from engine.core import params
from engine.images.encode import encode_png, write_exr
from engine.light.lamps import LampSettings
from engine.light.near_lamps import NearLampSettings
from tests.app.arguments.test_results import arguments
from tests.app.scenarios import SCENARIOS, prepare

pytestmark = pytest.mark.skipif(os.name == "nt", reason="Windows has no timer that interrupts")

#: Seconds of the CPU after which a verb that accepted a number, and has much to do with it, is cancelled.
PATIENCE_S = 10.0

#: Cases of a round, half of them of BRDFs.
CASES = 2

EXTREMES = (
    *("0", "-0.0", "1", "-1", "0.5", "1e-30", "-1e-30", "1e30", "-1e30", "1e-300", "1e300", "-1e300", "5e-324", "1e39"),
    *("nan", "inf", "-inf", "2147483647", "2147483648", "-2147483649", "9223372036854775808", "1" + 30 * "0"),
    *("1" + 400 * "0", "255", "65536", "1e-7", "1e7"),
)

SMALL = "--width 8 --height 6 --samples 1"
RENDER = f"render {{inputs}}/mesh.obj -o {{folder}}/a.png {SMALL}"
BAKED = f"render {{inputs}}/baked.transport -o {{folder}}/a.png {SMALL}"
TINY_BAKE = "bake {inputs}/mesh.obj --brdf lambert --cube 16 --fine 1 -o {folder}/a.transport"

#: Small command lines by verb; each of its parameters is given an extreme number in turn.
LINES = {
    "simulate": ("simulate -o {folder}/capture --size 32 --elevations-deg 20,60,80 --calibration",),
    "import": ("import {inputs}/photographs -o {folder}/stack",),
    "watch": ("watch {inputs}/photographs -o {folder}/watched --until-idle 0.1",),
    "shade": ("shade {inputs}/stack -o {folder}/a.lightarc --slices 3",),
    "normals": ("normals {inputs}/stack -o {folder}/maps --no-errors",),
    "export": ("export {inputs}/a.lightarc --to auto -o {folder}/exported",),
    "render": (
        f"{RENDER} --renderer cpu",
        f"{RENDER} --mode reference --max-depth 2 --ground",
        f"{RENDER} --renderer cpu --material {{inputs}}/a.lightarc",
        f"{RENDER} --env {{inputs}}/sky.exr --renderer cpu --measure-error",
        f"{BAKED} --renderer cpu",
        f"{BAKED} --renderer cpu --env {{inputs}}/sky.exr",
    ),
    "compare": ("compare {inputs}/a.png {inputs}/b.png",),
    "brdf info": ("brdf info ggx",),
    "brdf eval": ("brdf eval ggx --wi-deg 10,20 --wo-deg 30,40",),
    "brdf fit": ("brdf fit ggx --model lambert --samples 300",),
    "factor": (
        "factor lambert --size 8 --samples 300 --terms 1 -o {folder}/factors",
        "factor ggx --size 8 --samples 300 --method homomorphic --terms 1 -o {folder}/factors",
    ),
    "bake": (
        f"{TINY_BAKE} --mode sh --order 3",
        f"{TINY_BAKE} --coefficients 40 --terms 2",
        "bake {inputs}/mesh.obj --brdf ggx --mode gaussian --views 6 --lobes 1 --samples 64 -o {folder}/a.transport",
    ),
    "plan": ("plan {inputs}/mesh.obj --brdf ggx --env {inputs}/sky.exr --width 16 --height 12",),
    "tradeoff": (
        "tradeoff {inputs}/mesh.obj --brdf lambert --env {inputs}/sky.exr --modes sh --budget-s 1 --width 8 --height 6 "
        "-o {folder}/sweep",
    ),
    "selftest": ("selftest --long --only M5 --cases 2",),
}

#: Options that hold several numbers, or a text with numbers in it, each with a place for an extreme one.
TEXTS = {
    "--brushing": ("{},1,0", "0,{},1:4", "y:{}"),
    "--bands": ("{}", "1,{},2"),
    "--calibrate": ("{}", "gains,{}"),
    "--elevations": ("{}",),
    "--azimuths": ("{}",),
    "--elevations-deg": ("{},40,60", "20,{},60"),
    "--azimuths-deg": ("{},90,180",),
    "--exposures": ("{},2", "1,{}"),
    "--angles-deg": ("{},50,80", "20,50,{}"),
    "--white-balance": ("{},1,1", "patch:{},0,4,4", "patch:0,0,{},4"),
    "--crop": ("{},0,8,8", "0,0,{},8"),
    "--corners": ("{},1,20,1,20,15,1,15", "1,1,20,{},20,15,1,15"),
    "--pair": ("{}",),
    "--scale": ("{}", "chart={}", "1,2,9,9={}", "{},2,9,9=25"),
    "--size": ("{}x12", "12x{}"),
    "--sphere": ("{},9,4", "9,9,{}"),
    "--second-sphere": ("{},9,4", "9,9,{}"),
    "--equalise": ("{},0,8,8", "0,0,{},8"),
    "--azimuth": ("{}", "90±{}"),
    "--lights": ("{}", "1-{}"),
    "--light-deg": ("{},30", "50,{}"),
    "--wi-deg": ("{},30", "50,{}"),
    "--wo-deg": ("{},30", "50,{}"),
    "--camera": (
        *("eye={},0,0", "eye=0,{},3", "eye=0,0,4 target={},0,0", "eye=0,0,4 up={},1,0", "fov_deg={}"),
        "eye={},{},{}",
    ),
    "--cluster": ("{}",),
    "--lamp": tuple(f"{parameter.name}={{}}" for parameter in params.parameters(LampSettings)),
    "--near-lamp": tuple(f"z=2,{parameter.name}={{}}" for parameter in params.parameters(NearLampSettings)),
    "--until-idle": ("{}", "{}min"),
    "--expect": ("{}",),
    "--limit": ("{}", "{}GB"),
    "--memory": ("{}", "{}kB"),
    "--memory-limit": ("{}", "{}MB"),
    "--vary": ("alpha={}:0.5:y", "alpha=0.1:{}:x"),
}

Case = tuple[str, ...]


def numbers_of(parameter: params.Parameter) -> tuple[str, ...]:
    """Extremes, and the ends of the range that is declared with what lies next to them."""
    ends = (parameter.low, parameter.high)
    beside = (np.nextafter(ends[0], -np.inf), np.nextafter(ends[0], np.inf), np.nextafter(ends[1], -np.inf))
    return (*EXTREMES, *(repr(float(number)) for number in (*ends, *beside)))


def walk() -> list[Case]:
    """Words of a command line for every numeric parameter of every verb."""
    cases: list[Case] = []
    for name, action, _ in arguments(command_line.build_parser()):
        verb, _, option = name.rpartition(" ")
        verb = verb.strip()
        if action.type in (None, str) or isinstance(action.type, Input | Output) or action.choices:
            places = TEXTS.get(option, ())
        else:
            places = TEXTS.get(option) or ("{}",)
        for line in LINES.get(verb, ()):
            for place in places:
                cases += [(line, f"{option}={place.replace('{}', number)}") for number in EXTREMES]
    return cases


def reflectances() -> list[Case]:
    """Every parameter of every analytic BRDF at its ends, and several at once."""
    cases: list[Case] = []
    uses = ("brdf info {brdf}", f"{RENDER} --renderer cpu --brdf {{brdf}}", "brdf fit {brdf} --samples 300 --model ggx")
    more = (
        "factor {brdf} --size 8 --samples 300 --terms 1 -o {folder}/factors",
        "bake {inputs}/mesh.obj --brdf {brdf} --mode sh --order 3 -o {folder}/a.transport",
        f"{RENDER} --mode reference --max-depth 2 --ground --brdf {{brdf}}",
    )
    for model, kind in MODELS.items():
        declared = params.parameters(kind)
        for parameter in declared:
            for use in (*uses, *more):
                texts = [f"{model}:{parameter.name}={number}" for number in numbers_of(parameter)]
                cases += [(use.replace("{brdf}", text),) for text in texts]
        for low in (True, False):
            every = ",".join(f"{p.name}={(p.low if low else p.high)!r}" for p in declared)
            cases += [(use.replace("{brdf}", f"{model}:{every}"),) for use in (*uses, *more)]
    return cases


#: Extreme values of images and models, in single precision.
HELD = (0.0, 1.0, 1e-45, 1e-38, 1e-20, 1e10, 1e19, 1e20, 1e30, 3e38, np.inf, -np.inf, np.nan, -1.0, -1e30, -3e38)

#: Command lines that read what a test has filled with extreme numbers.
READERS = (
    "import {folder}/photographs -o {folder}/stack",
    "import {folder}/photographs -o {folder}/stack --no-align",
    f"{RENDER} --renderer cpu --env {{folder}}/sky.exr --measure-error",
    f"{RENDER} --mode reference --env {{folder}}/sky.exr",
    f"{BAKED} --renderer cpu --env {{folder}}/sky.exr",
    "compare {folder}/sky.exr {inputs}/sky.exr --difference {folder}/d.png",
    "compare {inputs}/sky.exr {folder}/sky.exr",
    "plan {folder}/mesh.obj --brdf ggx",
    RENDER.replace("{inputs}/mesh", "{folder}/mesh") + " --renderer cpu",
    RENDER.replace("{inputs}/mesh", "{folder}/mesh") + " --mode reference",
    TINY_BAKE.replace("{inputs}/mesh", "{folder}/mesh") + " --mode sh --order 3",
)


def describe(draw: random.Random) -> str:
    """The text of a capture.toml; in every second one some numbers are extreme."""
    numbers = draw.choice((EXTREMES, ("1.0",)))
    lines = [f"lamp_distance = {draw.choice(numbers)}"] if draw.random() < 0.3 else []
    for angle in (20, 50, 80):
        lines += ["[[photographs]]", f'file = "a_{angle}deg.exr"', f"elevation_deg = {angle}"]
        lines += [f"exposure_s = {draw.choice(numbers)}"] if draw.random() < 0.7 else []
        lines += [f"azimuth_deg = {draw.choice(numbers)}"] if draw.random() < 0.1 else []
        lines += [f"control_points = [[1, 2, {draw.choice(numbers)}, 3]]"] if draw.random() < 0.2 else []
    return "\n".join([*lines, ""])


def fill(folder: Path, draw: random.Random) -> str:
    """Photographs, an environment and a model with a few extreme numbers; gives them in words."""
    held = draw.sample(HELD, draw.choice((1, 2, 3)))
    share = draw.choice((0.01, 0.3, 1.0))
    rng = np.random.default_rng(draw.randrange(2**32))

    def image(height: int, width: int) -> dict[str, np.ndarray]:
        radiance = rng.random((height, width, 3), np.float32)
        bad = rng.random(radiance.shape) < share
        radiance[bad] = rng.choice(np.array(held, np.float32), np.count_nonzero(bad))
        return {name: radiance[..., index] for index, name in enumerate("RGB")}

    (folder / "photographs").mkdir(parents=True)
    for angle in (20, 50, 80):
        write_exr(folder / "photographs" / f"a_{angle}deg.exr", image(40, 48), half=False)
    (folder / "photographs" / "capture.toml").write_text(describe(draw))
    write_exr(folder / "sky.exr", image(8, 16), half=False)
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], np.float64)
    corners.flat[rng.integers(12)] = draw.choice((*held, 1e100, 1e200, 1e300, 1e-300))
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in corners.tolist()]
    (folder / "mesh.obj").write_text("\n".join([*lines, "f 1 3 2", "f 1 2 4", "f 1 4 3", "f 2 3 4", ""]))
    return f"{share:g} of {held}, corners {corners.tolist()}"


@pytest.fixture(scope="module")
def inputs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("extremes")
    prepare(folder)
    sky = np.random.default_rng(1).random((8, 16, 3), np.float32)
    write_exr(folder / "sky.exr", {name: sky[..., index] for index, name in enumerate("RGB")})
    for name in ("a.png", "b.png"):
        (folder / name).write_bytes(encode_png(np.full((16, 16, 3), 90, np.uint8)))
    for scenario in ("shade", "bake"):
        assert command_line.main(SCENARIOS[scenario].line(folder, folder)) == DONE
    (folder / "a.transport").rename(folder / "baked.transport")
    return folder


#: A line of progress, as it stands where there is no terminal.
PROGRESS = re.compile(r"[ \d]{3} %  ")


@contextmanager
def interrupt_after(seconds: float) -> Iterator[None]:
    """Interrupt what has run for `seconds` of the CPU, however loaded the machine is; with 0, never."""

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGPROF, interrupt)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def run(words: list[str], patience_s: float) -> int | str | None:
    try:
        with interrupt_after(patience_s), warnings.catch_warnings():
            warnings.simplefilter("error")
            return command_line.main([*words, "--json"])
    except SystemExit as stop:
        return stop.code
    except KeyboardInterrupt:  # before the verb, and so before anybody heeds it
        return CANCELLED


def hold(
    case: str, words: list[str], capfd: pytest.CaptureFixture[str], patience_s: float = PATIENCE_S
) -> int | str | None:
    """Run a verb, and demand a result or a sentence, which may follow lines of progress; gives the exit code."""
    capfd.readouterr()
    try:
        code = run(words, patience_s)
    except Exception as error:
        raise AssertionError(case) from error
    out, err = capfd.readouterr()
    said = f"{case}: {code}\n{out}{err}"
    assert code in (DONE, WRONG_USAGE, BAD_FILE, CANCELLED), said
    assert "Warning" not in err, said
    assert "Traceback" not in err or code == CANCELLED, said  # an interrupt may fall into a destructor
    *before, last = err.splitlines() or [""]
    if code == DONE:
        json.loads(out)
    elif code != CANCELLED:
        assert last.endswith("."), said
        assert all(PROGRESS.match(line) for line in before), said
    return code


@pytest.mark.campaign(rounds=800)
def test_no_parameter_brings_a_warning(
    seed: int, inputs: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    draw = random.Random(seed)
    cases = [*draw.sample(walk(), CASES // 2), *draw.sample(reflectances(), CASES // 2)]
    for number, case in enumerate(cases):
        folder = tmp_path / str(number)
        folder.mkdir()
        line, *more = case
        hold(" ".join(case), [*line.format(inputs=inputs, folder=folder).split(), *more], capfd)


@pytest.mark.campaign(rounds=400)
def test_no_file_brings_a_warning(seed: int, inputs: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    draw = random.Random(seed)
    held, line = fill(tmp_path, draw), draw.choice(READERS)
    hold(f"{line} with {held}", line.format(inputs=inputs, folder=tmp_path).split(), capfd)


def test_every_verb_with_numbers_is_walked() -> None:
    """A new verb, or a new kind of text with numbers in it, cannot be forgotten."""
    for name, action, _ in arguments(command_line.build_parser()):
        verb, _, option = name.rpartition(" ")
        plain = action.type in (None, int, float, str, share, thread_number)
        plain |= isinstance(action.type, Input | Output | Units | Degrees)
        assert plain or option in TEXTS, name
        assert action.type not in (int, float) or verb.strip() in (*LINES, "bench"), name


@pytest.mark.parametrize(
    ("line", "code"),
    [
        (f"{RENDER} --renderer cpu --camera eye=1e300,0,0", WRONG_USAGE),
        (f"{RENDER} --renderer cpu --intensity 1e39", DONE),  # cut to what an image holds
        (f"{RENDER} --renderer cpu --intensity 1e101", WRONG_USAGE),
        (f"{RENDER} --mode reference --max-depth 2 --brdf lafortune:ks=5e-324", DONE),
        ("brdf info ggx --seed -1", WRONG_USAGE),
        ("brdf fit ggx --model lambert --seed -1", WRONG_USAGE),
        (f"{TINY_BAKE} --coefficients 1{400 * '0'}", WRONG_USAGE),
        ("import {folder}/photographs -o {folder}/stack --no-align", BAD_FILE),
        (f"{RENDER} --renderer cpu --env {{folder}}/sky.exr", BAD_FILE),
    ],
)
def test_what_once_brought_a_warning_or_a_traceback(
    line: str, code: int, inputs: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    radiance = np.full((40, 80, 3), 1e30, np.float32)
    radiance[::3, ::5] = 3e38, np.nan, 1.0
    channels = {name: radiance[..., index] for index, name in enumerate("RGB")}
    (tmp_path / "photographs").mkdir()
    for angle in (20, 50, 80):
        write_exr(tmp_path / "photographs" / f"a_{angle}deg.exr", channels, half=False)
    write_exr(tmp_path / "sky.exr", channels, half=False)
    assert hold(line, line.format(inputs=inputs, folder=tmp_path).split(), capfd, patience_s=0.0) == code
    assert not (tmp_path / "stack").exists()
