"""Arguments of the command line that name files: their `type` is `Input` for reading and `Output` for writing.

`app.command_line` hands every parsed command line to `check_results` before the verb runs, so that no verb can forget
it. An argument of free words that names no file has the type `str`; `tests/app/arguments/test_results.py` fails for one
without a type. Below are the kinds of results, and by what an earlier one is known, which may be replaced without being
asked for.
"""

from __future__ import annotations

import argparse
import os
import stat
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Literal

from engine.core.errors import InputError, OutputError
from engine.figures.papers.catalogue import FIGURES
from engine.storage.outputs import Kind, check_outputs, has_tag, look
from engine.storage.unpack import is_archive
from engine.storage.untrusted import read_head

#: Names longer than any path are text, which no file is looked for by.
_LONGEST_PATH = 4096


def refuse_empty(text: str) -> str:
    """`text`, a name; ArgumentTypeError for an empty one, which a path would take for the current folder."""
    if not text.strip():
        raise argparse.ArgumentTypeError("the name is empty, as that of a variable of the shell that is not set")
    return text


@dataclass(frozen=True)
class Input:
    """The type of an argument that names something to read, by itself or within a text (`alpha=0.1:0.5:map.png`).

    Attributes
    ----------
    make : what the verb gets: `str` or `Path`.
    reach : 'file' where a folder of that name is not read (models and skies have built-in names), 'path' for a file or
        a folder, 'beside' where the folder of a file is read as well.
    """

    make: Callable[[str], Any] = str
    reach: Literal["file", "path", "beside"] = "path"

    def __call__(self, text: str) -> Any:
        return self.make(refuse_empty(text))

    def paths(self, text: str) -> Iterator[str]:
        """Existing paths that `text` may mean."""
        for name in _candidates(text):
            found = look(name)
            if found is None or (self.reach == "file" and stat.S_ISDIR(found.st_mode)):
                continue
            yield name
            if self.reach == "beside" and stat.S_ISREG(found.st_mode) and not _is_archive(name):
                yield str(Path(name).parent)


@dataclass(frozen=True)
class Output:
    """The type of an argument that names something to write.

    Attributes
    ----------
    kind : what is written, or a function of the text and all options that lists paths with their kinds.
    make : what the verb gets: `str` or `Path`.
    """

    kind: Kind | Callable[[str, argparse.Namespace], list[tuple[str, Kind]]]
    make: Callable[[str], Any] = str

    def __call__(self, text: str) -> Any:
        return self.make(refuse_empty(text))

    def find_named(self, text: str, options: argparse.Namespace) -> list[tuple[str, Kind]]:
        return [(text, self.kind)] if isinstance(self.kind, Kind) else self.kind(text, options)


def check_results(parser: argparse.ArgumentParser, options: argparse.Namespace) -> list[tuple[str, Kind]]:
    """Check all outputs of a command line, see `check_outputs`, and give them; UsageError for a wrong ending."""
    inputs: list[str] = []
    outputs: list[tuple[str, Kind]] = []
    for action in {each.dest: each for each in _choose_actions(parser, options)}.values():
        for text in _texts(getattr(options, action.dest, None)):
            if isinstance(action.type, Input):
                inputs += action.type.paths(text)
            elif isinstance(action.type, Output):
                outputs += action.type.find_named(text, options)
    check_outputs(outputs, inputs, overwrite=options.overwrite, makes_folders=True)
    return outputs


def _choose_actions(parser: argparse.ArgumentParser, options: argparse.Namespace) -> Iterator[argparse.Action]:
    """The arguments of the verb that was chosen, and of its own actions."""
    for action in parser._actions:
        if not isinstance(action, argparse._SubParsersAction):
            yield action
        elif getattr(options, action.dest) is not None:
            yield from _choose_actions(action.choices[getattr(options, action.dest)], options)


def _texts(value: object) -> list[str]:
    if isinstance(value, list | tuple):
        return [text for each in value for text in _texts(each)]
    return [os.fspath(value)] if isinstance(value, str | os.PathLike) else []


def _candidates(text: str) -> Iterator[str]:
    """The text, what follows its colons and equals signs, and each of these up to a # (`abrdf.dat#17`)."""
    starts = [0, *(index + 1 for index, letter in enumerate(text) if letter in ":=")]
    for start in starts:
        for name in {text[start:], text[start:].strip(), text[start:].rpartition("#")[0].strip()}:
            if 0 < len(name) <= _LONGEST_PATH and "\0" not in name:
                yield name


def _is_archive(path: str) -> bool:
    return is_archive(Path(path))


#: Photographs of a simulated capture begin with the name of its sample.
_PHOTOGRAPHS = ("woven_*", "hammered_*", "leather_*", "plain_*")


def software(verb: str) -> str:
    """The software tag of images that a verb writes."""
    return f"Lightarc {verb}"


def image_by(verb: str, *endings: str) -> Kind:
    """An image that a verb writes, known by its software tag."""
    return Kind("an image", endings, is_earlier=partial(has_tag, software=software(verb)))


def _folder(noun: str, marker: str, *members: str) -> Kind:
    """A folder that is known by the file `marker` and holds nothing but that and `members`."""
    return Kind(noun, is_earlier=lambda folder: (folder / marker).is_file(), members=(marker, *members))


def _is_transport(path: Path) -> bool:
    from engine.transport.baking.file import holds_transport

    return holds_transport(path)


def _is_table(path: Path) -> bool:
    """A MERL file of ours is like any other, and so never known."""
    from engine.brdf.readers.table_file import looks_like_table

    try:
        return looks_like_table(*read_head(path, 1 << 12), path.name)
    except InputError:
        return False


def _holds(path: Path, words: bytes, max_bytes: int) -> bool:
    """True where the first bytes of a file have these words."""
    try:
        return words in read_head(path, max_bytes)[0]
    except InputError:
        return False


def _is_bundle(path: Path) -> bool:
    from engine.bundle.bundle import check_replaceable

    try:
        check_replaceable(path)
    except OutputError:
        return False
    return True


def material_at(path: str, options: argparse.Namespace) -> list[tuple[str, Kind]]:
    """A bundle is a file where it has the ending of one, and else a folder, as comparisons and bundles by arc are."""
    if getattr(options, "compare", False):
        return [(path, COMPARISON)]
    if getattr(options, "per_arc", False):
        return [(path, ARCS)]
    return [(path, BUNDLE if Path(path).suffix.lower() == ".lightarc" else BUNDLE_FOLDER)]


def figures_in(folder: str, options: argparse.Namespace) -> list[tuple[str, Kind]]:
    """A folder for each figure that is asked for, within one that they share."""
    names = FIGURES if "all" in options.names else dict.fromkeys(options.names)
    return [(folder, SHARED), *((str(Path(folder) / name), FIGURE) for name in names if name in FIGURES)]


def watch_result(path: str, _options: argparse.Namespace) -> list[tuple[str, Kind]]:
    """A project where the name has its ending, else a stack."""
    return [(path, PROJECT if Path(path).suffix.lower() == ".lap" else STACK)]


def project_result(path: str, options: argparse.Namespace) -> list[tuple[str, Kind]]:
    """A replay makes a folder, all else that is written of a project is one."""
    return [(path, REPLAY if options.action == "replay" else PROJECT)]


def sweep_in(folder: str, _options: argparse.Namespace) -> list[tuple[str, Kind]]:
    """The files of a sweep, each replaced by itself, within a folder that may hold others."""
    stems = ("tradeoff", "tradeoff-relight", "tradeoff-bake", "tradeoff-memory")
    names = ["tradeoff.csv", *(f"{stem}{ending}" for stem in stems for ending in (".png", ".svg")), "tradeoff.json"]
    return [(folder, SHARED), *((str(Path(folder) / name), SWEEP) for name in names)]


def _is_sweep(path: Path) -> bool:
    return _holds(path.with_name("tradeoff.json"), b'"reference_samples"', 1 << 24)


TRANSPORT = Kind("a transport file", (".transport",), is_earlier=_is_transport)
TABLE = Kind("a table", (".binary", ".exr"), is_earlier=_is_table)
FIT = Kind("a fit", (".json",), is_earlier=lambda path: _holds(path, b'"rmse_log', 1 << 20))
BUNDLE = Kind("a bundle", (".lightarc",), is_earlier=_is_bundle)
BUNDLE_FOLDER = Kind("a bundle", is_earlier=_is_bundle, members=("*",))  # whose reader knows all members
STACK = _folder("a stack", "stack.json", "codes.npy", "room.npy", "radiance.npy", "saturated.npy", "diffuse.npy")
CAPTURE = _folder(
    "a simulated capture",
    "truth/truth.json",
    *("capture.toml", "truth/height.exr", "truth/radiance_*.exr"),
    *(f"truth/{name}.exr" for name in ("normal", "albedo", "specular", "roughness")),
    *(f"{name}.{ending}" for name in (*_PHOTOGRAPHS, "dark", "flat") for ending in ("tif", "exr", "dng")),
)
DEMO = _folder(
    "a demo",
    "demo.json",
    *("contact_sheet.png", "cloth_*.png", "*.lightarc", "stack/*"),
    *(f"capture/{name}" for name in CAPTURE.members),
)
ARCS = _folder("materials of arcs", "arcs.json", "arc-*.lightarc")
COMPARISON = _folder("a comparison", "comparison.json", "comparison.png", "comparison.svg", "comparison-worst.png")
EXPORT = _folder("an export", "export.json", "proof.png", "proof.json", "*/*")
MAPS = _folder(
    "a folder of maps",
    "surface.json",
    *(
        f"{name}{sigma}.{ending}"
        for name in ("base_colour", "normal", "roughness", "metallic", "specular", "height", "occlusion")
        for sigma in ("", "_sigma")
        for ending in ("exr", "png")
    ),
)
FACTORS = _folder("a folder of factors", "factors.json", "term-*.exr", "terms-*.exr")
FIGURE = _folder("a figure", "figure.json", "*.png", "*.svg", "pictures.csv", "curves.csv", "radiance/*.exr")
FILM = Kind("a film", (".mp4", ".webp"))
FRAMES = _folder("frames of a film", "turntable.json", "frame-*.png")
CHART = Kind(
    "a file of a colour chart",
    (".chart", ".html"),
    is_earlier=lambda path: _holds(path, b'"lightarc_chart"', 1 << 8) or _holds(path, b"<title>Colour chart", 1 << 8),
)
LENS = Kind("a file of a lens", (".lens",), is_earlier=lambda path: _holds(path, b'"lightarc_lens"', 1 << 8))
LIGHTS = Kind(
    "a file of lights", (".lights", ".lp"), is_earlier=lambda path: _holds(path, b'"lightarc_lights"', 1 << 8)
)
PROJECT = Kind("a project", (".lap",))
REPLAY = _folder("a replay", "replay.json", "stack/*", "material.lightarc")
SELFTEST_CASES = Kind(
    "cases of the self-test", (".json",), is_earlier=lambda path: _holds(path, b'"lightarc-selftest-cases-1"', 1 << 8)
)
#: A log, whose first line begins with a time and the name of the program.
LOG = Kind("a log", (".log", ".txt"), is_earlier=lambda path: _holds(path, b"  lightarc ", 1 << 6))
MEASURED_PAGE = Kind(
    "a page of what was measured", (".md",), is_earlier=lambda path: _holds(path, b"# Speeds and errors of one run", 64)
)
SHARED = Kind("a folder", shared=True)
SOAK_LOG = _folder("a record of a soak", "soak.jsonl")
SWEEP = Kind("a file of a sweep", (".json", ".csv", ".png", ".svg"), is_earlier=_is_sweep)
