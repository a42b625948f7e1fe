"""Failures of the disk and of memory in verbs and functions of the library, one at a time, by seed.

    python -m tests.app.injected_faults SEED COUNT

Failure N is drawn by a generator with the seed N: one of the works, and in it one operation of four kinds. The
operations of `engine.storage.atomic` (write, flush, rename, close and so on) and everything that Python tells of files
to `sys.addaudithook` (opening, listing, mapping, making and removing) fail with an error of the system; arrays of numpy
find no memory; decoder processes are not started, are ended, find no memory or answer nonsense
(`tests.app.failing_decoder`). All works run in one process, so that a failure costs tens of milliseconds.

The rule: a verb ends with a known exit code and one sentence, a function with a LightarcError; inputs stay as they
were; an output is complete or absent, and nothing half-written stays.
"""

from __future__ import annotations

import contextlib
import errno
import functools
import io
import json
import logging
import os
import random
import shutil
import sys
import tempfile
import traceback
import webbrowser
import zipfile
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal
from unittest import mock

import numpy as np

import lightarc
from app import command_line
from app.arguments.usage import ALL_FAILED, BAD_FILE, DONE, MISSING, OUT_OF_MEMORY
from app.batch.record import open_record, read_folder
from app.project.project_file import is_waiting
from app.project.report import describe
from engine.capture.chart.correction import fit_correction
from engine.capture.chart.file import as_json, read_chart, save_chart
from engine.capture.chart.reference import REFERENCE_RGB
from engine.capture.lights.light_file import read_lights
from engine.capture.photograph.lens import Lens, read_lens, save_lens
from engine.core.errors import LightarcError
from engine.factor.factor_file import read_factors
from engine.images.decode import read_image
from engine.storage import atomic
from engine.transport.baking.file import open_transport
from tests.app import scenarios
from tests.app.allocations import FailingAllocator
from tests.app.failing_decoder import BLAMES, WAYS, FailingDecoder
from tests.app.project.hostile import base, change
from tests.app.scenarios import SCENARIOS, FailAt

Kind = Literal["atomic", "system", "allocation", "decoder"]
KINDS: tuple[Kind, ...] = ("atomic", "system", "allocation", "decoder")

#: How often failures of each kind are drawn; after one of a decoder its process has to be started again.
WEIGHTS = {"atomic": 3, "system": 3, "allocation": 3, "decoder": 1}

CODES = (errno.ENOSPC, errno.EIO, errno.EACCES, errno.EMFILE, errno.EDQUOT, errno.EROFS)
ALLOWED = (DONE, BAD_FILE, MISSING, OUT_OF_MEMORY, ALL_FAILED)

#: What Python tells of files before it asks the system.
EVENTS = frozenset(
    {
        *("open", "os.listdir", "os.scandir", "os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.truncate"),
        *("os.link", "os.symlink", "os.chmod", "os.utime", "mmap.__new__", "tempfile.mkstemp", "tempfile.mkdtemp"),
        *("shutil.copyfile", "shutil.copymode", "shutil.copystat", "shutil.rmtree", "sqlite3.connect"),
    }
)

#: Operations that clean up: where one fails, what it was to remove stays for the next write.
CLEANING = ("list", "unlink", "rmdir", "os.remove", "os.rmdir", "os.listdir", "os.scandir", "shutil.rmtree")

#: An image that is there before memory fails.
IMAGE = np.full((16, 16, 4), 0.5, np.float32)


@dataclass(frozen=True)
class Work:
    """A verb as `words`, or a `function` of the library.

    Attributes
    ----------
    output : the name of what it writes, '' for nothing.
    read : raises for an output that is not whole.
    begin : makes in the folder of outputs what the work changes there.
    rare : True for a work of which a whole run takes seconds; its failures are drawn less often (`RARITY`).
    ends : the exit code where nothing fails.
    keeps_temporary : True where the result lies in a temporary folder.
    """

    name: str
    words: str = ""
    function: Callable[[Path, Path], Any] | None = None
    output: str = ""
    read: Callable[[Path], Any] | None = None
    begin: Callable[[Path, Path], None] | None = None
    rare: bool = False
    ends: int = DONE
    keeps_temporary: bool = False


def open_batch(folder: Path) -> None:
    """Read the record of a batch and the folder of each capture that is done."""
    with open_record(folder) as record:
        for row in record.rows():
            assert row.state != "done" or read_folder(folder / row.capture.name) is not None


def _verbs() -> Iterator[Work]:
    for name, one in SCENARIOS.items():
        begin = _interrupted if one.resumed else None
        yield Work(name, one.words, None, one.output, one.read, begin)
    yield Work("shade arcs", "shade {inputs}/dome --per-arc -o {output} --slices 2", None, "arcs")
    yield Work("shade compare", "shade {inputs}/dome --compare -o {output} --slices 2", None, "comparison", rare=True)
    yield Work("normals", "normals {inputs}/dome --no-errors -o {output}", None, "normals")
    yield Work("render bake", "render {inputs}/a.transport --width 24 --height 16 -o {output}", None, "a.exr")
    yield Work("render bundle", "render plane --material {inputs}/a.lightarc " + SMALL, None, "a.exr")
    for mode in ("wavelet", "gaussian"):
        words = f"bake {{inputs}}/mesh.obj {BAKES[mode]} -o {{output}}"
        yield Work(f"bake {mode}", words, None, "b.transport", open_transport)
        words = f"render {{inputs}}/{mode}.transport --env {{inputs}}/sky.png " + SMALL
        yield Work(f"render {mode}", words, None, "a.png", read_image)
    words = "bake {inputs}/mesh.obj --brdf phong --mode sh --order 3 --cube 16 --fine 1 --interreflection "
    words += "--vary exponent=1:20:{inputs}/a.png -o {output}"
    yield Work("bake varied", words, None, "b.transport", open_transport, rare=True)
    words = "bake {inputs}/mesh.obj --material {inputs}/maps --mode sh --order 3 --cube 16 --fine 1 -o {output}"
    yield Work("bake maps", words, None, "b.transport", open_transport, rare=True)
    words = "bake {inputs}/mesh.obj --brdf lambert --mode auto --env {inputs}/sky.png -o {output}"
    yield Work("bake auto", words, None, "b.transport", open_transport, rare=True)
    for name, words in (("layers", "--layers"), ("lamps", "--lamp theta_deg=40,phi_deg=20,radius_deg=5 --ground")):
        yield Work(
            f"render {name}", f"render {{inputs}}/mesh.obj --brdf ggx {words} " + SMALL, None, "a.exr", read_image
        )
    for ending in ("mp4", "webp"):
        words = "render plane --turntable 2 " + "--background transparent " * (ending == "webp") + SMALL
        yield Work(f"turntable {ending}", words, None, f"a.{ending}")
    words = "batch {inputs}/photographs -o {output} --to none --workers 1 --quiet"
    yield Work("batch", words, None, "batch", open_batch, rare=True)
    words = "watch {inputs}/photographs -o {output} --until-idle 0.1 --calibrate none --quiet"
    yield Work("watch", words, None, "watched", rare=True)
    yield Work("completion", "completion bash")
    yield Work("desktop", "desktop-install --folder {output}", None, "share")
    yield Work("plan", "plan {inputs}/mesh.obj --brdf lambert --env {inputs}/sky.png --width 24 --height 16", rare=True)
    yield Work("tradeoff", TRADEOFF, None, "tradeoff", rare=True)
    yield Work("figures", "figures wang-2 --quick -o {output}", None, "figures", rare=True)
    yield Work("brdf list", "brdf list")
    yield Work("brdf info", "brdf info {inputs}/paint.csv", rare=True)
    yield Work("brdf eval", "brdf eval {inputs}/paint.csv --wi-deg 30,0 --wo-deg 30,180")
    yield Work("brdf fit", "brdf fit {inputs}/paint.csv --model phong --samples 64 -o {output}", None, "fit.json")
    yield Work("brdf convert", "brdf convert lambert -o {output}", None, "l.binary", rare=True)
    yield Work("brdf convert exr", "brdf convert lambert -o {output}", None, "l.exr", rare=True)
    yield Work("compare", "compare {inputs}/a.png {inputs}/b.png --difference {output}", None, "d.png")
    words = "compare {inputs}/a.png {inputs}/b.png --mask {inputs}/mask.png"
    yield Work("compare masked", words)
    for method in ("homomorphic", "search"):
        words = f"factor {{inputs}}/paint.csv --method {method} --size 8 --terms 1 --samples 300 -o {{output}}"
        words += " --restarts 1 --together 1" * (method == "search")
        yield Work(f"factor {method}", words, None, "factors", read_factors, rare=True)
    words = "factor {inputs}/paint.csv --method search --resume {inputs}/searched --size 8 --terms 2 --samples 300 "
    yield Work(
        "factor resumed", words + "--restarts 1 --together 1 -o {output}", None, "factors", read_factors, rare=True
    )
    words = "factor {inputs}/paint.csv --table --samples 300 --size 8 --terms 1 --restarts 1 --together 1"
    yield Work("factor table", words, rare=True)
    yield Work("bundle view", "bundle view {inputs}/a.lightarc", keeps_temporary=True)
    yield Work("bundle make maps", "bundle make {inputs}/maps -o {output}", None, "m.lightarc", lightarc.open_bundle)
    yield Work("bundle verify", "bundle verify {inputs}/a.lightarc")
    yield Work("bundle show", "bundle show {inputs}/a.lightarc")
    yield Work(
        "bundle extract", "bundle extract {inputs}/a.lightarc -o {output}", None, "members", lightarc.open_bundle
    )
    for target in ("textures", "materialx", "gltf", "shaders", "usd", "blender", "web", "rti", "brdf"):
        source = "dome.lightarc --stack {inputs}/dome" if target == "rti" else "a.lightarc"
        words = "export {inputs}/" + source + " --to " + target + " -o {output}"
        yield Work(f"export {target}", words, None, "export", rare=target not in ("gltf", "web"))
    words = "export {inputs}/Felt.lap --to auto -o {output}"
    yield Work("export auto", words, None, "export", rare=True)
    words = "export {inputs}/maps --to textures --preset unreal --coding exr -o {output}"
    yield Work("export maps", words, None, "export", rare=True)
    yield Work("project info", "project info {inputs}/Felt.lap")
    yield Work("project verify", "project verify {inputs}/Felt.lap")
    yield Work("project collect", "project collect {inputs}/Felt.lap -o {output}", None, "c.lap", _sound)
    yield Work("project recover", "project recover {inputs}/Felt.lap -o {output}", None, "r.lap", _sound)
    words = "project recover {inputs}/unsound/Felt.lap -o {output}"
    yield Work("project recover damaged", words, None, "r.lap", _sound)
    words = "project collect {inputs}/elsewhere.lap --include-outside --without-derived -o {output}"
    yield Work("project collect outside", words, None, "c.lap", _sound)
    yield Work("project clean-up", "project clean-up {output}", None, "Felt.lap", _sound, _copy_project)
    find = "project find {output} --photographs {inputs}/moved"
    yield Work("project find", find, None, "Felt.lap", describe, _copy_moved_project)
    yield Work("project replay", "project replay {inputs}/Felt.lap -o {output}", None, "replayed", rare=True)
    yield Work("bundle make", "bundle make {inputs}/Felt.lap -o {output}", None, "f.lightarc", lightarc.open_bundle)
    yield Work("selftest", "selftest --long --cases 3 -o {output}.json", rare=True)
    yield Work("selftest repeat", "selftest --repeat {inputs}/cases.json", rare=True)
    yield Work("demo", "demo -o {output}", None, "demo", rare=True)
    yield Work("bench", "bench --only linearise --report {output}", None, "measured.md", rare=True)
    yield Work("gui", "gui {inputs}/a.png", ends=MISSING)
    words = "simulate --sample woven --size 16 --elevations-deg 30,60 --format dng --calibration --sphere -o {output}"
    yield Work("simulate dng", words, None, "capture", rare=True)
    yield Work(
        "import zip", "import {inputs}/photographs.zip -o {output} --no-align", None, "stack", lightarc.open_stack
    )
    words = "import {inputs}/lamps -o {output} --calibrate auto"
    yield Work("import calibrated", words, None, "stack", lightarc.open_stack, rare=True)
    words = "shade {inputs}/stack -o {output} --slices 3 --tileable --tile-preview {output}.tiles.png "
    yield Work("shade tiles", words + "--error-map {output}.png", None, "a.lightarc", lightarc.open_bundle, rare=True)
    lights = "import {inputs}/lamps -o {inputs}-stack --no-align --overwrite --write-lights {output}"
    yield Work("import lights", lights, None, "l.lights", read_lights)
    chart = "import {inputs}/photographs -o {inputs}-stack --no-align --overwrite --chart {inputs}/lamps.chart"
    lens = "import {inputs}/photographs -o {inputs}-stack --no-align --overwrite --lens {inputs}/a.lens"
    yield Work("import lens", lens + " --write-lens {output}", None, "l.lens", read_lens)
    yield Work("import chart", chart + " --write-chart {output}", None, "l.chart", read_chart)
    yield Work("simulate", "simulate --sample plain --size 16 --elevations-deg 30,60 -o {output}", None, "capture")


BAKES = {
    "wavelet": "--brdf lambert --mode wavelet --cube 16 --fine 1 --coefficients 40 --terms 1 --ground --ground-cells 4",
    "gaussian": "--brdf ggx:alpha=0.3 --mode gaussian --order 3 --cube 16 --fine 1 --samples 32 --compress",
}
SMALL = "--width 24 --height 16 -o {output}"
TRADEOFF = "tradeoff {inputs}/mesh.obj --brdf lambert --env {inputs}/sky.png --modes sh --budget-s 1 " + SMALL


def _interrupted(inputs: Path, outputs: Path) -> None:
    shutil.copytree(inputs / "interrupted", outputs, dirs_exist_ok=True)


def _copy_project(inputs: Path, outputs: Path) -> None:
    shutil.copy2(inputs / "Felt.lap", outputs)
    shutil.copytree(inputs / "Felt.lap-data", outputs / "Felt.lap-data")


def _copy_moved_project(inputs: Path, outputs: Path) -> None:
    _copy_project(inputs / "moving", outputs)


def _sound(path: Path) -> None:
    from app.project.report import problems_of
    from engine.core.steps import drain

    assert not drain(problems_of(path))


def _functions() -> Iterator[Work]:
    """Functions of `lightarc.__all__` that read or write files."""
    la = lightarc

    def reading(name: str, function: Callable[[Path], Any], *, rare: bool = False) -> Work:
        return Work(name, function=lambda inputs, _: function(inputs), rare=rare)

    def writing(
        name: str, output: str, function: Callable[[Path, Path], Any], read: Callable[[Path], Any] | None = None
    ) -> Work:
        return Work(name, function=function, output=output, read=read)

    yield writing(
        "simulate_capture",
        "capture",
        lambda _, target: la.simulate_capture(target, sample="plain", elevations_deg=(30, 60), size=16),
    )
    yield reading("open_capture", lambda inputs: la.open_capture(inputs / "photographs"))
    yield writing(
        "import_capture",
        "stack",
        lambda inputs, target: la.import_capture(inputs / "photographs", target, motion="none"),
        la.open_stack,
    )
    yield reading("open_stack", lambda inputs: la.open_stack(inputs / "stack"))
    yield writing("recover_normals", "maps", lambda inputs, target: la.recover_normals(inputs / "dome", target))
    yield reading("build_material", lambda inputs: la.build_material(la.open_stack(inputs / "stack"), slices=3))
    yield reading("compress_material", lambda inputs: la.compress_material(la.open_bundle(inputs / "a.lightarc")))
    yield writing(
        "save_bundle",
        "b.lightarc",
        lambda inputs, target: la.save_bundle(target, la.open_bundle(inputs / "a.lightarc")),
        la.open_bundle,
    )
    yield reading("open_bundle", lambda inputs: la.open_bundle(inputs / "a.lightarc"))
    yield reading("open_material", lambda inputs: la.open_material(inputs / "maps"))
    yield reading("open_material gltf", lambda inputs: la.open_material(inputs / "gltf"))
    yield reading("verify_bundle", lambda inputs: la.verify_bundle(inputs / "a.lightarc"))
    yield writing("export", "export", lambda inputs, target: la.export(inputs / "a.lightarc", target, to="gltf"))
    yield reading("open_brdf", lambda inputs: la.open_brdf(str(inputs / "paint.csv")))
    yield reading("evaluate_brdf", lambda inputs: la.evaluate_brdf(inputs / "factors", UP, UP))
    yield reading("sample_brdf", lambda inputs: la.sample_brdf(inputs / "factors", UP))
    yield reading("evaluate_pdf", lambda inputs: la.evaluate_pdf(inputs / "factors", UP, UP))
    yield reading(
        "factor_brdf", lambda inputs: la.factor_brdf(inputs / "paint.csv", method="svd", size=8, samples=300, terms=1)
    )
    yield reading("fit_brdf", lambda inputs: la.fit_brdf(inputs / "paint.csv", "phong", samples=64))
    yield writing(
        "save_factors",
        "f",
        lambda _, target: la.save_factors(target, la.factor_brdf("lambert", size=8, samples=300, terms=1)),
        lambda target: la.open_brdf(str(target)),
    )
    yield Work("save_brdf", function=lambda _, target: la.save_brdf(target, "lambert"), output="l.binary", rare=True)
    yield reading("make_scene", lambda inputs: la.make_scene(inputs / "mesh.obj", environment=inputs / "sky.png"))
    yield reading("render ", lambda inputs: la.render(str(inputs / "mesh.obj"), brdf="lambert", size=(24, 16)))
    yield writing("save_image", "a.exr", lambda _, target: la.save_image(target, IMAGE))
    yield reading("compare ", lambda inputs: la.compare(inputs / "a.png", inputs / "b.png"))
    yield writing(
        "bake ",
        "b.transport",
        lambda inputs, target: la.bake(inputs / "mesh.obj", "lambert", target, method="sh", order=3),
    )
    for method, settings in (("wavelet", {"terms": 1}), ("gaussian", {"samples": 32})):

        def baking(inputs: Path, target: Path, method: str = method, settings: dict[str, Any] = settings) -> Any:
            return la.bake(inputs / "mesh.obj", "ggx:alpha=0.3", target, method=method, cube=16, fine=1, **settings)

        yield writing(f"bake {method} function", "b.transport", baking, open_transport)
    yield reading("relight", lambda inputs: la.relight(inputs / "a.transport", size=(24, 16), samples=1))
    yield reading("plan ", lambda inputs: la.plan(inputs / "mesh.obj", "lambert", size=(24, 16)), rare=True)
    yield reading("tradeoff ", lambda inputs: _tradeoff(inputs), rare=True)

    def running(inputs: Path, target: Path) -> Any:
        return la.run_batch(inputs / "photographs", target, to=(), workers=1)

    yield Work("run_batch", function=running, output="batch", read=open_batch, rare=True)
    yield Work(
        "draw_figures",
        function=lambda _, target: la.draw_figures("wang-2", target, quick=True),
        output="figures",
        rare=True,
    )


UP = np.array([0.0, 0.0, 1.0])


def _tradeoff(inputs: Path) -> Any:
    return lightarc.tradeoff(inputs / "mesh.obj", "lambert", modes=("sh",), seconds=1.0, size=(24, 16))


WORKS = (*_verbs(), *_functions())

#: How many frequent works there are to one rare one.
RARITY = 50


def choose(number: int) -> Work:
    """The work of a failure; the rare ones share every `RARITY`-th number."""
    rare = [work for work in WORKS if work.rare]
    if rare and number % RARITY == RARITY - 1:
        return rare[number // RARITY % len(rare)]
    frequent = [work for work in WORKS if not work.rare]
    return frequent[(number - number // RARITY) % len(frequent)]


#: Works of which a whole run takes milliseconds, and whose inputs are soon made.
QUICK = ("project info", "project recover", "project collect", "save_image")


def prepare(inputs: Path, *, all_works: bool = True) -> None:
    """The inputs of all works, or of `QUICK` alone."""
    from engine.images.encode import encode_png
    from tests.engine.brdf.readers.test_damaged_samples import FILES

    base(inputs)
    for name, value in (("a.png", 100), ("b.png", 110)):
        (inputs / name).write_bytes(encode_png(np.full((16, 16, 3), value, np.uint8)))
    if not all_works:
        return
    correction = fit_correction(0.5 * REFERENCE_RGB, np.indices((4, 6)).reshape(2, 24).T.astype(np.float64))
    assert correction is not None
    slight = Lens(24, 18, (24.0, 24.0, 12.0, 9.0), (-0.01, 0.0, 0.0, 0.0, 0.0), 0.1, 6)
    save_lens(inputs / "a.lens", slight.as_json())
    save_chart(inputs / "lamps.chart", as_json(correction, "chart.tif"))
    (inputs / "sky.png").write_bytes(encode_png(np.full((16, 32, 3), 100, np.uint8)))
    scenarios.prepare(inputs)
    for name in ("shade", "bake", "factor"):
        assert _end(SCENARIOS[name].line(inputs, inputs))[0] == DONE
    (inputs / "paint.csv").write_text(FILES["paint.csv"][0])
    mask = np.zeros((16, 16, 3), np.uint8)
    mask[4:12] = 255
    (inputs / "mask.png").write_bytes(encode_png(mask))
    with zipfile.ZipFile(inputs / "photographs.zip", "w") as archive:
        for path in sorted((inputs / "photographs").iterdir()):
            archive.write(path, path.name)
    for mode, words in BAKES.items():
        line = f"bake {inputs / 'mesh.obj'} {words} -o {inputs / mode}.transport"
        ended = _end(line.split())
        assert ended[0] == DONE, ended[1]
    searched = f"factor {inputs / 'paint.csv'} --method search --size 8 --terms 1 --samples 300 --restarts 1 "
    assert _end(f"{searched} --together 1 -o {inputs / 'searched'}".split())[0] == DONE
    _damage(base(inputs / "unsound"))
    _keep_cases(inputs / "cases.json")
    shutil.copy2(inputs / "Felt.lap", inputs / "elsewhere.lap")
    base(inputs / "moving")
    (inputs / "moving" / "pictures").rename(inputs / "moved")
    dome = "simulate --sample plain --size 16 --elevations-deg 20,40,60 --azimuths-deg 0,90,180,270 -o {}"
    for words in (
        dome.format(inputs / "lamps"),
        f"import {inputs / 'lamps'} -o {inputs / 'dome'} --no-align",
        f"shade {inputs / 'dome'} -o {inputs / 'dome.lightarc'}",
        f"export {inputs / 'a.lightarc'} --to textures gltf -o {inputs / 'exported'}",
    ):
        assert _end(words.split())[0] == DONE, words
    for name in ("textures", "gltf"):
        (inputs / "exported" / name).rename(inputs / name)
    (inputs / "textures").rename(inputs / "maps")


def _damage(path: Path) -> None:
    """The mesh of a project is gone, and a page of its file is another."""
    with change(path) as connection:
        connection.execute("DELETE FROM value WHERE text LIKE '%Mesh%'")


def _keep_cases(path: Path) -> None:
    """A file of self-test cases: the smallest of a law of images, and of one of files, which decoders read."""
    from hypothesis import find

    from engine.selftest.generated import files, images
    from engine.selftest.generated.search import Broken, ask, write_broken

    found = [(law, find(law.cases, lambda _: True)) for law in (images.LAWS[0], files.LAWS[0])]
    write_broken([Broken(law.id, values, 0, ask(law, values)) for law, values in found], path)


@contextlib.contextmanager
def reduced() -> Iterator[None]:
    """Images, beams and lights of previews and errors are few within the block: they only repeat what may fail."""
    from app.batch import run
    from app.commands import export_bundle
    from engine.brdf import analysis
    from engine.exchange import loss
    from engine.figures import demo
    from engine.simulate.arc import LightArc

    small = functools.partial(LightArc, elevation=(0.3, 0.8, 1.3), size=16, interreflection=False)
    with contextlib.ExitStack() as stack:
        for where, name, value in (
            (run, "MAKE", "tests.app.batch.fast:make"),
            (loss, "LIGHTS", 4),
            (loss, "DIAMETER", 24),
            (export_bundle, "SIZE", (32, 24)),
            (analysis.maximum_albedo, "__kwdefaults__", {"angles": 2, "count": 64}),
            (demo, "LightArc", small),
            (demo, "IMAGE_SIZE", (32, 20)),
            (webbrowser, "open", lambda _: True),
        ):
            stack.enter_context(mock.patch.object(where, name, value))
        stack.enter_context(mock.patch.dict(os.environ, dict.fromkeys(("DISPLAY", "WAYLAND_DISPLAY"), "")))
        yield


_hook: Callable[[str, tuple[Any, ...]], None] | None = None


def _audited(event: str, arguments: tuple[Any, ...]) -> None:
    if _hook is not None and event in EVENTS:
        _hook(event, arguments)


class FailingSystem:
    """Counts what the process asks of files below `folder`, and fails the one numbered `at` (from 0) with `code`."""

    _added = False

    def __init__(self, folder: Path, at: int = -1, code: int = 0) -> None:
        self.folder, self.at, self.code, self.operations = os.fspath(folder), at, code, list[str]()

    def _told(self, event: str, arguments: tuple[Any, ...]) -> None:
        place = arguments[0] if arguments else ""
        place = os.fsdecode(place) if isinstance(place, (str, bytes, os.PathLike)) else ""
        if event != "mmap.__new__" and not place.startswith(self.folder):
            return
        self.operations.append(event)
        if len(self.operations) == self.at + 1:
            raise OSError(self.code, os.strerror(self.code), place or None)

    def __enter__(self) -> FailingSystem:
        global _hook
        if not FailingSystem._added:
            sys.addaudithook(_audited)
            FailingSystem._added = True
        _hook = self._told
        return self

    def __exit__(self, *_: object) -> None:
        global _hook
        _hook = None


def _end(words: list[str]) -> tuple[int, str]:
    """Exit code and standard error of a verb."""
    out, err = (io.TextIOWrapper(io.BytesIO(), "utf-8", write_through=True) for _ in range(2))  # verify prints problems
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = command_line.main(words)
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else 1
    said, printed = (stream.buffer.getvalue().decode() for stream in (err, out))
    return code, said or (f"{printed.rstrip().rstrip('.')}." if code != DONE and printed else "")


def _run(work: Work, inputs: Path, folder: Path) -> tuple[int, str]:
    """Exit code and what was said; of a function DONE, or BAD_FILE with the sentence of its error."""
    target = folder / (work.output or "nothing")
    if work.function is None:
        return _end([word.format(inputs=inputs, output=target) for word in work.words.split()])
    try:
        work.function(inputs, target)
    except LightarcError as error:
        return BAD_FILE, f"{error}\n"
    return DONE, ""


def _marks(folder: Path) -> dict[str, tuple[int, int]]:
    return {
        os.fspath(path): (status.st_size, status.st_mtime_ns)
        for path in folder.rglob("*")
        if (status := path.lstat()) and path.is_file()
    }


class Faults:
    """Works with their inputs, in a folder of their own, and how many operations of each kind a work has."""

    def __init__(self, folder: Path, *, all_works: bool = True) -> None:
        self.folder, self.inputs = folder, folder / "inputs"
        prepare(self.inputs, all_works=all_works)
        self.outputs, self.temporary = folder / "outputs", folder / "temporary"
        self._counts: dict[tuple[str, Kind], int] = {}
        self.marks = _marks(self.inputs)
        self.outcomes = Counter[str]()

    def count(self, work: Work, kind: Kind) -> int:
        """The number of operations of a kind in a work that succeeds."""
        if (work.name, kind) not in self._counts:
            for _ in range(2):  # the first fills caches
                self._begin(work)
                with FailAt() as operations, FailingSystem(self.folder) as system, FailingDecoder() as decoder:
                    allocator = FailingAllocator()
                    ended = allocator.run(lambda: _run(work, self.inputs, self.outputs))
                assert ended[0] == work.ends, f"{work.name}: {ended[1]}"
            self._counts[work.name, "atomic"] = len(operations.operations)
            self._counts[work.name, "system"] = len(system.operations)
            self._counts[work.name, "allocation"] = allocator.count
            self._counts[work.name, "decoder"] = len(decoder.operations)
            self.marks = _marks(self.inputs)
        return self._counts[work.name, kind]

    def _begin(self, work: Work) -> None:
        for place in (self.outputs, self.temporary):
            if place.exists():
                shutil.rmtree(place)
            place.mkdir()
        if work.begin is not None:
            work.begin(self.inputs, self.outputs)

    def inject(self, number: int) -> str:
        """Inject the failure of a number; a sentence on the rule that it breaks, '' where none."""
        with mock.patch.object(tempfile, "tempdir", os.fspath(self.temporary)):
            return self._inject(choose(number), number)

    def _inject(self, work: Work, number: int) -> str:
        rng = random.Random(number)
        kinds = [kind for kind in KINDS if self.count(work, kind)]
        if not kinds:
            return ""
        kind = rng.choices(kinds, [WEIGHTS[kind] for kind in kinds])[0]
        at, code = rng.randrange(self.count(work, kind)), rng.choice(CODES)
        self._begin(work)
        begun = _marks(self.outputs)
        operation = ""
        what = f"{work.name}, {kind} {at} of {self.count(work, kind)}"
        try:
            if kind == "allocation":
                failing = FailingAllocator(at)
                ended = failing.run(lambda: _run(work, self.inputs, self.outputs))
                reached = failing.count > at
            elif kind == "decoder":
                way = rng.choice(WAYS)
                what += f" {way}"
                with FailingDecoder(at, way, number) as decoder:
                    ended = _run(work, self.inputs, self.outputs)
                reached = len(decoder.operations) > at
                operation = way
            else:
                what += f" with {errno.errorcode[code]}"
                with FailAt(at, code) if kind == "atomic" else FailingSystem(self.folder, at, code) as operations:
                    ended = _run(work, self.inputs, self.outputs)
                reached = len(operations.operations) > at
                operation = operations.operations[at] if reached else ""
                what += f" ({operation})"
        except BaseException as error:  # counted, and told with its number
            if isinstance(error, KeyboardInterrupt):
                raise
            where = traceback.extract_tb(error.__traceback__)[-1]
            place = f"{Path(where.filename).name}:{where.lineno}"
            self.outcomes["FAULT"] += 1
            return f"{what}: {type(error).__name__}: {str(error)[:150]} ({place})"
        self.outcomes["not reached" if not reached else "done" if ended[0] == DONE else "refused"] += 1
        broken = self._broken(work, ended, kind, operation, begun)
        if broken:
            self.outcomes["FAULT"] += 1
        return f"{what}: {broken}" if broken else ""

    def _broken(
        self, work: Work, ended: tuple[int, str], kind: Kind, operation: str, begun: dict[str, tuple[int, int]]
    ) -> str:
        code, said = ended
        if code not in ALLOWED:
            return f"exit code {code}: {said[-200:]!r}"
        if "Traceback" in said or ".partial-" in said:
            return f"no sentence: {said[-300:]!r}"
        if code != DONE and (not said.strip() or (work.words and not said.rstrip().endswith("."))):
            return f"no sentence: {said[-200:]!r}"
        if kind == "allocation" and code == BAD_FILE and "memory" not in said:
            return f"blames the file: {said[-200:]!r}"
        if kind != "allocation" and operation not in BLAMES and "damaged" in said:
            return f"calls a file damaged: {said[-300:]!r}"
        left = {entry.name for entry in self.outputs.iterdir()}
        if code != DONE and work.output.endswith(".transport"):
            left.discard(f".{work.output}.unfinished")  # a bake goes on where it ended
        left -= {Path(name).relative_to(self.outputs).parts[0] for name in begun}
        if (self.outputs / work.output).exists():  # data that wait are put in their place when the project is opened
            left -= {work.output, f"{work.output}-data", *filter(is_waiting, left)}
        left = {name for name in left if not name.startswith(f"{work.output}.")}  # a second output of the work
        left |= (
            {entry.name for entry in self.temporary.iterdir()} if not work.keeps_temporary or code != DONE else set()
        )
        if left and operation not in CLEANING:
            return f"left {sorted(left)[:3]}"
        if _marks(self.inputs) != self.marks:
            changed = {*_marks(self.inputs).items()} ^ {*self.marks.items()}
            self.marks = _marks(self.inputs)
            return f"inputs have changed: {sorted(changed)[:2]}"
        target = self.outputs / work.output
        if work.output and work.read is not None and target.exists():
            try:
                work.read(target)
            except (LightarcError, AssertionError) as error:
                return f"the output is not whole: {str(error)[:150]}"
        if work.output and code == DONE and not target.exists():
            return "ended well without its output"
        return ""


def main(seed: int, count: int) -> None:
    logging.disable(logging.WARNING)
    os.fsync = lambda fd: None
    shared = "/dev/shm"
    folder = Path(tempfile.mkdtemp(prefix="faults-", dir=shared if os.path.isdir(shared) else None))  # noqa: PTH112
    os.environ |= {f"XDG_{kind}_HOME": str(folder / kind) for kind in ("CONFIG", "DATA")}
    try:
        with reduced():
            run(Faults(folder), seed, count)
    finally:
        atomic.fault = None
        shutil.rmtree(folder, ignore_errors=True)


def run(faults: Faults, seed: int, count: int) -> None:
    """Inject the failures from `seed` on, and print what breaks the rule and how many there were of each outcome."""
    for number in range(seed, seed + count):
        if broken := faults.inject(number):
            print(f"fault {number}: {broken}", flush=True)
        if (number + 1 - seed) % 100 == 0 or number + 1 == seed + count:
            print(f"seeds {seed} to {number}: {json.dumps(faults.outcomes)}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]))
