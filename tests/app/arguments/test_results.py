"""Outputs of all verbs against their inputs, and against what must not be replaced (`app.arguments.results`)."""

from __future__ import annotations

import argparse
import os
import re
from collections.abc import Callable, Iterator
from hashlib import sha256
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from app.arguments.results import Input, Output
from app.command_line import build_parser
from engine.figures.papers.catalogue import FIGURES
from engine.images.encode import encode_png

#: Words of help by which an argument that names a file gives itself away.
FILES = re.compile(r"FILE|FOLDER|PATH|IMAGE|BUNDLE|STACK|MATERIAL|FACTORS|TRANSPORT|MESH|OUT|BRDF$|SOURCE")


def arguments(parser: argparse.ArgumentParser, verb: str = "") -> Iterator[tuple[str, argparse.Action, bool]]:
    """Every argument of every verb with its name, and True where its parser knows --overwrite."""
    can_overwrite = "--overwrite" in parser._option_string_actions
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, below in action.choices.items():
                yield from arguments(below, f"{verb} {name}")
        elif action.nargs != 0:
            yield f"{verb} {action.option_strings[0] if action.option_strings else action.dest}", action, can_overwrite


def test_every_argument_says_whether_it_is_a_file() -> None:
    """A new option cannot forget the check: without a type it could be a file, and with `str` it says that it is none.

    The dash of -o, and words such as FILE in its name for users, are not believed to be anything but files.
    """
    outputs = []
    for name, action, can_overwrite in arguments(build_parser()):
        free = not (action.choices or callable(action.type)) or action.type in (Path, str)
        if free:
            assert action.type is str, f"{name}: say Input, Output, or type=str for words that name no file"
            assert not FILES.search(str(action.metavar)), f"{name} is called {action.metavar}, and has the type str"
        if {"-o", "--output"} & set(action.option_strings):
            assert isinstance(action.type, Output), f"{name} is an output"
        if isinstance(action.type, Output):
            outputs.append(name)
            assert can_overwrite, name
        default = None if action.default == argparse.SUPPRESS else action.default
        assert not isinstance(default, str) or not isinstance(action.type, Input | Output), name
    assert len(outputs) >= 13, outputs


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with inputs whose content nobody gets to read, and other names for some of them."""
    for name in (
        *("m.obj", "sky.exr", "meas.exr", "meas.binary", "cols.csv", "a.png", "b.png", "mask.png", "old.transport"),
        *("fac/factors.json", "fac/term-01-view.exr", "fac/term-01-light.exr", "abrdf.dat", "dark.tif"),
        *("pack/factors.json", "pack/meas.csv", "stack/stack.json", "stack/radiance.npy", "stack/error.png"),
        *("mat/manifest.json", "mat/preview.png", "photos/x_10deg.png", "photos/x_20deg.png", "photos/capture.toml"),
        *("old/stack.json", "old/radiance.npy", "old/saturated.npy", "out/kautz-6/figure.json", "out/kautz-6/m.obj"),
        *("out/tradeoff.png", "deep/er/x.txt"),
    ):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(name)
    for name, target in (
        *(("soft.transport", "m.obj"), ("soft.binary", "abrdf.dat"), ("soft.png", "soft2.png"), ("soft2.png", "b.png")),
        *(("softfac", "fac"), ("softout", "out"), ("fac/term-02-view.exr", "../kept.exr"), ("here", ".")),
    ):
        (tmp_path / name).symlink_to(target)
    (tmp_path / "kept.exr").write_text("reached through a link in fac")
    for name, target in (
        *(
            ("hard.transport", "m.obj"),
            ("hard.png", "a.png"),
            ("hard.exr", "sky.exr"),
            ("hardfac.exr", "fac/term-01-view.exr"),
        ),
        *(("hardstack.png", "stack/error.png"), ("hardbaked.png", "old.transport"), ("alike.transport", "a.png")),
    ):
        os.link(tmp_path / target, tmp_path / name)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def contents(folder: Path) -> dict[str, str]:
    """The contents of every path below `folder`: the target of a link, or the fingerprint of a file."""
    found = {}
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if path.is_symlink():
            found[name] = f"-> {path.readlink()}"
        elif path.is_file():
            found[name] = sha256(path.read_bytes()).hexdigest()
    return found


BAKE = ("bake", "m.obj", "--brdf", "ggx")
SHADE = ("shade", "stack", "-o", "new.lightarc")
TRADEOFF = ("tradeoff", "sphere", "--brdf", "ggx")

#: Command lines of which an output is, holds or lies in what the command reads, by all kinds of names.
MEETINGS = (
    ("bake", "old.transport", "--brdf", "ggx", "-o", "old.transport"),
    (*BAKE, "-o", "soft.transport"),
    (*BAKE, "-o", "hard.transport"),
    (*BAKE, "-o", "here/deep/../hard.transport"),
    (*BAKE, "--albedo", "a.png", "-o", "alike.transport"),
    (*BAKE, "--vary", "alpha=0.1:0.5:a.png", "--mode", "sh", "-o", "alike.transport"),
    (*BAKE, "--blend", "ggx:alpha=0.1:a.png", "-o", "alike.transport"),
    (*BAKE, "--error-env", "a.png", "-o", "alike.transport"),
    (*BAKE, "--mode", "auto", "--env", "a.png", "-o", "alike.transport"),
    ("bake", "sphere", "--brdf", "a.png", "-o", "alike.transport"),
    ("render", "sphere", "--env", "sky.exr", "-o", "sky.exr"),
    ("render", "sphere", "--env", "sky.exr", "-o", "hard.exr"),
    ("render", "sphere", "--env", "sky.exr", "-o", "./deep/er/../../sky.exr"),
    ("render", "sphere", "--brdf", "meas.exr", "-o", "meas.exr"),
    ("render", "sphere", "--brdf", " meas.exr ", "-o", "meas.exr"),
    ("render", "sphere", "--brdf", "fac", "-o", "fac/term-01-view.exr"),
    ("render", "sphere", "--brdf", "softfac", "-o", "fac/new.png"),
    ("render", "sphere", "--brdf", "fac", "-o", "hardfac.exr"),
    ("render", "sphere", "--brdf", "fac", "-o", "kept.exr"),
    ("render", "sphere", "--material", "mat", "-o", "mat/preview.png"),
    ("render", "old.transport", "-o", "hardbaked.png"),
    ("render", "old.transport", "--albedo", "a.png", "-o", "hard.png"),
    ("render", "old.transport", "--weight", "a.png", "-o", "a.png"),
    ("compare", "a.png", "b.png", "--difference", "a.png"),
    ("compare", "a.png", "b.png", "--difference", "soft.png"),
    ("compare", "soft.png", "a.png", "--difference", "b.png"),
    ("compare", "a.png", "b.png", "--mask", "mask.png", "--difference", "here/mask.png"),
    ("brdf", "convert", "meas.exr", "-o", "meas.exr"),
    ("brdf", "convert", "meas.binary", "-o", "meas.binary"),
    ("brdf", "convert", "abrdf.dat#17", "-o", "soft.binary"),
    ("factor", "fac", "-o", "fac"),
    ("factor", "softfac", "-o", "fac"),
    ("factor", "pack/meas.csv", "-o", "pack"),
    ("factor", "meas.exr", "fac", "-o", "fac/sub"),
    ("factor", "ggx", "--method", "search", "--resume", "fac", "-o", "softfac"),
    (*SHADE[:3], "stack"),
    (*SHADE[:3], "stack/new.lightarc"),
    (*SHADE, "--error-map", "stack/error.png"),
    (*SHADE, "--error-map", "hardstack.png"),
    (*SHADE, "--brdf", "a.png", "--tileable", "--tile-preview", "hard.png"),
    ("import", "photos", "-o", "photos"),
    ("import", "photos", "-o", "photos/stack"),
    ("import", "photos/x_10deg.png", "photos/x_20deg.png", "-o", "photos/stack"),
    ("import", "photos", "-o", "."),
    ("import", "photos", "--dark", "old/radiance.npy", "-o", "old"),
    ("figures", "kautz-6", "--mesh", "out/kautz-6/m.obj", "-o", "out"),
    ("figures", "all", "--env", "out/kautz-6/m.obj", "-o", "softout"),
    (*TRADEOFF, "--env", "out/tradeoff.png", "-o", "out"),
    (*TRADEOFF, "--env", "softout/tradeoff.png", "-o", "out"),
)


@pytest.mark.parametrize("words", MEETINGS, ids=" ".join)
def test_no_output_meets_an_input(lightarc: Callable[..., SimpleNamespace], place: Path, words: str) -> None:
    before = contents(place)
    for consent in ((), ("--overwrite",)):
        done = lightarc(*words, *consent)
        assert done.code == 3, done.err
        assert len(done.err.splitlines()) == 1
        assert "is read" in done.err
    assert contents(place) == before


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        ((*BAKE, "-o", "m.obj"), 2, "must end in .transport"),
        ((*BAKE, "-o", "new"), 2, "must end in .transport"),
        (("bake", "sphere", "--brdf", "meas.csv", "-o", "keep.jpg"), 2, "must end in .transport"),
        (("bake", "sphere", "--brdf", "ggx", "-o", "alike.transport"), 3, "is not a transport file"),
        (("bake", "sphere", "--brdf", "ggx", "-o", "deep"), 2, "must end in .transport"),
        (("render", "sphere", "-o", "a.png"), 3, "is not an image that this command wrote"),
        (("render", "sphere", "-o", "a.png/"), 3, "names a folder"),
        (("render", "sphere", "-o", "a.png/."), 3, "names a folder"),
        (("render", "sphere", "-o", ".."), 2, "must end in"),
        (("render", "sphere", "-o", ""), 2, "is empty"),
        (("render", "sphere", "-o", "m.obj/nowhere/a.png"), 3, "m.obj is a file"),
        (("render", "sphere", "-o", "m.obj/a.png"), 3, "m.obj is a file"),
        (("render", "sphere", "-o", f"{'n' * 300}.png"), 3, "too long"),
        (("render", "sphere", "-o", "loop.png"), 3, "loop.png"),
        (("render", "sphere", "-o", "broken.png"), 3, "folder does not exist"),
        (("render", "sphere", "-o", "pipe.png"), 3, "not a regular file"),
        (("render", "sphere", "-o", "folder.png"), 3, "it is a folder"),
        (("render", "sphere", "-o", "m.obj/two\nlines/a.png"), 3, "two\\nlines"),
        (("render", "sphere", "-o", "/dev/null"), 2, "must end in"),
        (("demo", "-o", "/dev/null"), 3, "file of that name exists"),
        (("demo", "-o", "/dev/stdout"), 3, "/dev/stdout"),
        (("demo", "-o", "pipe.png"), 2, "is a folder"),
        (("demo", "-o", "deep"), 3, "is not a demo"),
        (("demo", "-o", "/"), 3, "is not a demo"),
        (("simulate", "-o", "old"), 3, "is not a simulated capture"),
        (("simulate", "-o", "m.obj"), 2, "is a folder"),
        (("factor", "ggx", "-o", "old"), 3, "is not a folder of factors"),
        (("factor", "ggx", "-o", "pack"), 3, "holds meas.csv"),
        (("import", "photos", "-o", "mat"), 3, "is not a stack"),
        (("brdf", "convert", "ggx", "-o", "meas.binary"), 3, "is not a table"),
        (("brdf", "convert", "ggx", "-o", "meas.exr"), 3, "is not a table"),
        (("brdf", "convert", "ggx", "-o", "x.png"), 2, ".binary or .exr"),
        ((*SHADE[:3], "a.png"), 2, "is a folder"),
        ((*SHADE[:3], "deep"), 3, "is not a bundle"),
        ((*SHADE, "--error-map", "x.jpg"), 2, "must end in .png"),
        ((*SHADE, "--error-map", "x.png", "--tile-preview", "here/x.png", "--tileable"), 3, "another output"),
        (("shade", "stack", "-o", "new", "--error-map", "new/x.png"), 3, "another output"),
        (("compare", "a.png", "b.png", "--difference", "mask.png"), 3, "add --overwrite"),
        (("figures", "kautz-6", "-o", "m.obj"), 3, "file of that name exists"),
        (("figures", "kautz-6", "-o", "m.obj/out"), 3, "m.obj is a file"),
        (("figures", "kautz-6", "-o", "out"), 3, "holds m.obj"),
        ((*TRADEOFF, "--env", "sky.exr", "-o", "out"), 3, "tradeoff.png: it exists"),
    ],
    ids=lambda value: " ".join(map(repr, value)) if isinstance(value, tuple) else None,
)
def test_outputs_that_cannot_be_are_refused_before_any_work(
    lightarc: Callable[..., SimpleNamespace],
    place: Path,
    monkeypatch: pytest.MonkeyPatch,
    words: Any,
    code: int,
    said: str,
) -> None:
    os.mkfifo("pipe.png")
    Path("folder.png").mkdir()
    Path("loop.png").symlink_to("loop.png")
    Path("broken.png").symlink_to("nowhere/at/all.png")
    before = contents(place)
    done = lightarc(*words)
    assert (done.code, len(done.err.splitlines())) == (code, 1), done.err
    assert said in done.err
    assert contents(place) == before


def test_a_verb_replaces_its_own_image_and_with_consent_that_of_others(
    lightarc: Callable[..., SimpleNamespace], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.png").write_bytes(encode_png(np.full((40, 40, 3), 90, np.uint8)))
    compare = ("compare", "a.png", "a.png", "--difference", "d.png")
    for _ in range(2):
        assert lightarc(*compare).code == 0
    Path("d.png").write_bytes(Path("a.png").read_bytes())
    assert lightarc(*compare).code == 3
    assert Path("d.png").read_bytes() == Path("a.png").read_bytes()
    assert lightarc(*compare, "--overwrite").code == 0
    render = ("render", "plane", "--width", "8", "--height", "8", "--renderer", "cpu", "-o")
    assert lightarc(*render, "d.png").code == 3
    for ending in ("png", "exr"):
        for _ in range(2):
            assert lightarc(*render, f"r.{ending}").code == 0


def test_built_in_names_are_no_folders_that_are_read(
    lightarc: Callable[..., SimpleNamespace], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A model named 'plane' beside a folder of that name."""
    monkeypatch.chdir(tmp_path)
    Path("plane").mkdir()
    words = ("--width", "8", "--height", "8", "--renderer", "cpu", "-o", "plane/x.png")
    assert lightarc("render", "plane", *words).code == 0


def test_figures_of_other_names_do_not_matter() -> None:
    options = argparse.Namespace(names=["wang-2"])
    from app.arguments.results import figures_in

    assert [Path(path).name for path, _ in figures_in("out", options)] == ["out", "wang-2"]
    options.names = ["all"]
    assert len(figures_in("out", options)) == 1 + len(FIGURES)
