"""Captures that come as an archive: imported as their folder would be, and recorded with archive and members."""

import gc
import io
import tarfile
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.capture.import_stack import ImportSettings, import_stack
from engine.capture.lights.sources import find, find_packed
from engine.core.errors import InputError
from engine.core.steps import drain
from engine.images.encode import encode_png

SETTINGS = ImportSettings(motion="none")


def png(seed: int) -> bytes:
    return encode_png(np.random.default_rng(seed).integers(0, 256, (40, 50, 3)).astype(np.uint8))


def toml(*names: str) -> bytes:
    return "".join(
        f'[[photographs]]\nfile = "{name}"\nelevation_deg = {20 * n + 10}\n' for n, name in enumerate(names)
    ).encode()


CAPTURE = {
    "suede/capture.toml": b'notes = "suede"\nflat = "white.png"\n' + toml("a.png", "b.png", "c.png"),
    "suede/a.png": png(1),
    "suede/b.png": png(2),
    "suede/c.png": png(3),
    "suede/white.png": png(4),
    "suede/notes.txt": b"taken on Tuesday",
    "suede/truth/x.png": png(5),
    "__MACOSX/suede/._a.png": b"resources",
    ".DS_Store": b"x",
}


def zip_of(path: Path, members: Any) -> Path:
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return path


def tar_of(path: Path, members: Any) -> Path:
    with tarfile.open(path, "w:gz") as archive:
        for name, content in members.items():
            info = tarfile.TarInfo(f"./{name}")
            info.size = len(content)
            archive.addfile(info, io.BytesIO(content))
    return path


def look_for_packed(*paths: Any, **options: Any) -> Any:
    return drain(find_packed(list(paths), **options))


@pytest.mark.parametrize(("pack", "name"), [(zip_of, "suede.zip"), (tar_of, "suede.tar.gz")])
def test_an_archive_imports_as_its_folder_does(tmp_path: Path, pack: Any, name: str) -> None:
    archive, folder, scratch = pack(tmp_path / name, CAPTURE), tmp_path / "folder", tmp_path / "scratch"
    for place in (folder, scratch):
        place.mkdir()
    for member in ("a.png", "b.png", "c.png", "white.png", "capture.toml"):
        (folder / member).write_bytes(CAPTURE[f"suede/{member}"])
    sources = look_for_packed(archive, scratch=scratch)
    packed = drain(import_stack(sources, SETTINGS, tmp_path / "packed"))
    plain = drain(import_stack(find([folder]), SETTINGS, tmp_path / "plain"))
    np.testing.assert_array_equal(packed.radiance, plain.radiance)
    assert (sources.name, sources.angle_source, sources.notes) == ("suede", "capture.toml", "suede")
    assert packed.provenance["archive"] == name
    assert [one["member"] for one in packed.provenance["photographs"]] == [f"suede/{n}.png" for n in "abc"]
    assert packed.provenance["photographs"][0]["exposures"][0]["member"] == "suede/a.png"
    assert plain.provenance["archive"] is None
    assert any("excluded: suede/truth" in finding.text for finding in sources.findings)


def test_the_unpacked_photographs_vanish_with_their_sources(tmp_path: Path) -> None:
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    sources = look_for_packed(zip_of(tmp_path / "suede.zip", CAPTURE), scratch=scratch)
    assert sorted(path.name for path in scratch.rglob("*.png")) == ["a.png", "b.png", "c.png", "white.png"]
    del sources
    gc.collect()
    assert list(scratch.iterdir()) == []


def test_fault_8_what_is_no_capture_is_refused_and_nothing_is_left(tmp_path: Path) -> None:
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    cases: list[tuple[Any, str]] = [
        ({"a.txt": b"x"}, "holds no photographs"),
        ({}, "holds no photographs"),
        ({"a/x.png": png(1), "b/x.png": png(2)}, "several folders: a, b"),
        ({"x.png": png(1), "more.tar.gz": b"x"}, "holds another archive (more.tar.gz)"),
        ({"manifest.json": b"{}", "slices/x.png": png(1)}, "is a bundle"),
        ({"x.png": png(1)}, "one photograph only"),
    ]
    for number, (members, words) in enumerate(cases):
        with pytest.raises(InputError) as refusal:
            look_for_packed(zip_of(tmp_path / f"{number}.zip", members), scratch=scratch)
        assert words in str(refusal.value)
        del refusal
    gc.collect()  # once for all, as it takes seconds
    assert list(scratch.iterdir()) == []


def test_an_archive_comes_alone(tmp_path: Path) -> None:
    (tmp_path / "x.png").write_bytes(png(1))
    with pytest.raises(InputError, match="among other files"):
        look_for_packed(zip_of(tmp_path / "a.zip", CAPTURE), tmp_path / "x.png")


def test_folders_and_files_are_found_as_ever(tmp_path: Path) -> None:
    for n in range(2):
        (tmp_path / f"x_{30 * n + 10}deg.png").write_bytes(png(n))
    assert look_for_packed(tmp_path).photographs == find([tmp_path]).photographs
    assert look_for_packed(tmp_path).unpacked is None
    assert look_for_packed(tmp_path).name == tmp_path.name


def test_a_refusal_names_the_archive_and_the_member(tmp_path: Path) -> None:
    """A damaged photograph and a sphere that is nowhere: no temporary path is said."""
    broken = zip_of(tmp_path / "broken.zip", {**CAPTURE, "suede/b.png": png(2)[:300]})
    settings = ImportSettings(motion="none", strict=True)
    with pytest.raises(InputError) as refused:
        drain(import_stack(drain(find_packed([broken])), settings, tmp_path / "s"))
    assert refused.value.path == str(broken / "suede" / "b.png")
    archive = zip_of(tmp_path / "a.zip", CAPTURE)
    with pytest.raises(InputError, match="no sphere was found") as refused:
        drain(import_stack(drain(find_packed([archive], sphere="auto")), SETTINGS, tmp_path / "s"))
    assert refused.value.path == str(archive)
