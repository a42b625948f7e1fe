"""Dropped files are recognised by content: a bundle and an archive of photographs differ under any name."""

import io
import tarfile
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.commands.recognise import Recognised, recognise
from engine.brdf.brdf import brdf_from_text
from engine.brdf.readers.table_file import write_table
from engine.brdf.resample import table_from
from engine.core.errors import InputError
from engine.images.encode import rgb_channels, write_exr


def zip_of(path: Path, *names: str) -> Path:
    with zipfile.ZipFile(path, "w") as archive:
        for name in names:
            archive.writestr(name, b"{}")
    return path


def tar_of(path: Path, *names: str) -> Path:
    with tarfile.open(path, "w:xz") as archive:
        for name in names:
            archive.addfile(tarfile.TarInfo(name), io.BytesIO())
    return path


@pytest.mark.parametrize(
    ("make", "name", "members", "kind"),
    [
        (zip_of, "weave.lightarc", ["manifest.json"], "bundle"),
        (zip_of, "sent by mail.zip", ["manifest.json", "slices/0.exr"], "bundle"),
        (zip_of, "suede.zip", ["suede/1.png"], "photographs"),
        (zip_of, "bricks.zip", ["b/Bricks_1K_Color.jpg", "b/Bricks_1K_NormalGL.jpg", "b/Bricks.usdc"], "material"),
        (zip_of, "rock.usdz", ["rock.usda", "textures/baseColor.png", "textures/roughness.png"], "material"),
        (zip_of, "no ending", ["suede/1.png", "suede/manifest.json"], "photographs"),
        (tar_of, "suede.tar.xz", ["suede/1.png"], "photographs"),
    ],
)
def test_archives(tmp_path: Path, make: Any, name: str, members: Any, kind: str) -> None:
    assert recognise([make(tmp_path / name, *members)]).kind == kind


def test_a_package_of_usd_without_textures_that_are_known_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="USD package"):
        recognise([zip_of(tmp_path / "rock.usdz", "rock.usda", "0/texture.png")])


@pytest.mark.parametrize(("name", "kind"), [("rock.mtlx", "material"), ("rock.gltf", "mesh")])
def test_a_folder_with_one_document_is_that_document(tmp_path: Path, name: str, kind: str) -> None:
    (tmp_path / "rock" / "textures").mkdir(parents=True)
    (tmp_path / "rock" / name).write_text("{}")
    found = recognise([tmp_path / "rock"])
    assert (found.kind, found.paths) == (kind, (tmp_path / "rock" / name,))
    (tmp_path / "rock" / "photograph.png").write_bytes(b"\x89PNG")
    assert recognise([tmp_path / "rock"]).kind == ("material" if kind == "material" else "photographs")


def test_an_archive_that_is_cut_says_so(tmp_path: Path) -> None:
    path = zip_of(tmp_path / "suede.zip", "suede/1.png")
    path.write_bytes(path.read_bytes()[:-5])
    with pytest.raises(InputError, match="cut short"):
        recognise([path])


def test_measured_brdfs_are_recognised_by_content_and_by_endings_that_nothing_else_has(tmp_path: Path) -> None:
    table = tmp_path / "felt.exr"
    write_table(table, table_from(brdf_from_text("lambert"), (6, 5, 6), "felt", np.float32))
    samples = tmp_path / "samples"
    samples.write_text("theta_i,phi_i,theta_o,phi_o,r,g,b\n30,0,30,180,1,1,1\n")
    broken = tmp_path / "broken.bsdf"
    broken.write_bytes(b"nothing")
    assert recognise([table], lighting=True).kind == "brdf"
    assert recognise([samples]).kind == "brdf"
    assert recognise([table, broken]) == Recognised("brdf", (table, broken))


def test_other_files_are_not_taken_for_brdfs(tmp_path: Path) -> None:
    picture = tmp_path / "picture.exr"
    write_exr(picture, rgb_channels(np.ones((4, 8, 3), np.float32)))
    mesh = tmp_path / "mesh.obj"
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert recognise([picture], lighting=True).kind == "environment"
    assert recognise([mesh]).kind == "mesh"
    notes = tmp_path / "notes.txt"
    notes.write_text("nothing of the kind")
    with pytest.raises(InputError, match="nothing that Lightarc can open"):
        recognise([notes])


def test_measurements_behind_pages_of_comments_are_recognised(tmp_path: Path) -> None:
    path = tmp_path / "paint.dat"
    path.write_text("# a long story\n" * 1000 + "#DIM 4 1\n#PARAM_IN SPHERICAL_TL_PL_TV_PV\n0.1 0.2 0.3 0.4 0.5\n")
    assert recognise([path]).kind == "brdf"


def test_materials_of_other_programs(tmp_path: Path) -> None:
    textures = tmp_path / "rock"
    textures.mkdir()
    for name in ("Rock_1K_Color.png", "Rock_1K_NormalGL.png", "notes.txt"):
        (textures / name).write_bytes(b"\x89PNG\r\n\x1a\n")
    alone = (textures / "Rock_1K_Color.png", textures / "Rock_1K_NormalGL.png")
    assert recognise(alone) == Recognised("material", alone), "their folder was not dropped with them"
    assert recognise((*alone, textures / "notes.txt")).kind == "photographs", "not all are maps"
    assert recognise(alone[:1]).kind == "photographs"
    document = tmp_path / "rock.mtlx"
    document.write_text('<?xml version="1.0"?><materialx version="1.39"/>')
    assert recognise([textures]) == Recognised("material", (textures,))
    assert recognise([document]) == Recognised("material", (document,))
    photographs = tmp_path / "capture"
    photographs.mkdir()
    for name in ("IMG_1.jpg", "IMG_2.jpg", "flat.jpg"):
        (photographs / name).write_bytes(b"\xff\xd8\xff")
    assert recognise([photographs]).kind == "photographs"
