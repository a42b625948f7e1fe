"""Names of BRDFs as a user writes them, and files of all formats recognised by content."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from engine.brdf.models.microfacet import Ggx
from engine.brdf.readers.read import open_brdf, read_brdf
from engine.core.errors import InputError
from engine.exchange.readers.read import open_material


def test_a_text_names_a_model() -> None:
    assert open_brdf(" ggx:alpha=0.2 ") == Ggx(alpha=0.2)


def test_a_word_that_is_neither_file_nor_model_is_offered_both() -> None:
    with pytest.raises(
        ValueError,
        match=r"'gggx:alpha=0.2' is neither a file nor a BRDF model \(did you mean ggx\?\); models are lambert, ",
    ):
        open_brdf("gggx:alpha=0.2")


@pytest.mark.parametrize("text", ["absent.bsdf", "folder/absent", "a" * 5000 + ".x", "nul\0.binary"])
def test_a_path_to_nothing_is_a_bad_input(text: str) -> None:
    with pytest.raises(InputError, match=r"does not exist\. Name a file, or a model: lambert, "):
        open_brdf(text)


def test_a_wrong_parameter_of_a_model_is_named() -> None:
    with pytest.raises(ValueError, match="alpha"):
        open_brdf("ggx:alpha=7")


def test_a_file_wins_over_a_model_of_that_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "phong").write_bytes(b"nothing that is known")
    with pytest.raises(InputError, match=r"phong: is not a measured BRDF of a known format\. These are read:"):
        open_brdf("phong")


def test_a_folder_and_an_empty_file_are_refused(tmp_path: Path) -> None:
    (tmp_path / "empty.binary").write_bytes(b"")
    with pytest.raises(InputError, match="is empty"):
        read_brdf(tmp_path / "empty.binary")
    with pytest.raises(InputError, match="is a folder"):
        open_brdf(str(tmp_path))


def test_fault_7_a_pointer_of_git_lfs_is_named(shared_data: Callable[[str], Path]) -> None:
    with pytest.raises(InputError, match=r"is a git-lfs pointer, not the data. Fetch the data with `git lfs pull`\.$"):
        read_brdf(shared_data("brdf/merl_lfs_pointers/gold-metallic-paint.binary"))


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("a.xml", b'<?xml version="1.0"?>\n<WindowElement xmlns="http://windows.lbl.gov">', "window system"),
        ("a.bsdf", b"#BSDF\nSource  Measured\nSymmetry  PlaneSymmetrical\nScatterType  BRDF\n", "Zemax"),
        ("a.axf", b"\x89HDF\r\n\x1a\n" + bytes(64), "AxF"),
        ("a.btf", b"BTFF" + bytes(64), "bidirectional texture function"),
    ],
)
def test_measurements_of_other_kinds_are_refused_by_name(tmp_path: Path, name: str, content: bytes, words: str) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    for read in (read_brdf, open_material):
        with pytest.raises(InputError, match=words):
            read(path)
