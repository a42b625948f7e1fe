"""Files are recognised by content, and sorted into groups that open in places of their own."""

import io
import tarfile
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from app.commands.recognise import Kind, Opening, Recognised, recognise
from engine.brdf.brdf import brdf_from_text
from engine.brdf.readers.table_file import write_table
from engine.brdf.resample import table_from
from engine.geometry import usd
from engine.geometry.usd import has_library
from engine.images.encode import rgb_channels, write_exr


def one(*paths: Path) -> Recognised:
    """The one group that `paths` are."""
    found = recognise(paths)
    assert found.excluded == ()
    (group,) = found.groups
    return group


def kinds(found: Opening) -> list[tuple[Kind, int]]:
    return [(group.kind, len(group.paths)) for group in found.groups]


def exclude(found: Opening) -> list[tuple[str, str]]:
    return [(Path(error.path).name, error.problem) for error in found.excluded]


def radiance(path: Path, width: int, height: int) -> Path:
    write_exr(path, rgb_channels(np.ones((height, width, 3), np.float32)))
    return path


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


#: A package of USD is a model where the library reads it, otherwise its textures.
USD_PACKAGE = "mesh" if has_library() else "material"


@pytest.mark.parametrize(
    ("make", "name", "members", "kind"),
    [
        (zip_of, "weave.lightarc", ["manifest.json"], "bundle"),
        (zip_of, "sent by mail.zip", ["manifest.json", "slices/0.exr"], "bundle"),
        (zip_of, "suede.zip", ["suede/1.png"], "photographs"),
        (zip_of, "bricks.zip", ["b/Bricks_1K_Color.jpg", "b/Bricks_1K_NormalGL.jpg", "b/Bricks.usdc"], "material"),
        (zip_of, "rock.usdz", ["rock.usda", "textures/baseColor.png", "textures/roughness.png"], USD_PACKAGE),
        (zip_of, "no ending", ["suede/1.png", "suede/manifest.json"], "photographs"),
        (tar_of, "suede.tar.xz", ["suede/1.png"], "photographs"),
    ],
)
def test_archives(tmp_path: Path, make: Any, name: str, members: Any, kind: str) -> None:
    assert one(make(tmp_path / name, *members)).kind == kind


def test_a_package_of_usd_without_textures_that_are_known_is_refused_without_its_library(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(usd, "has_library", lambda: False)
    found = recognise([zip_of(tmp_path / "rock.usdz", "rock.usda", "0/texture.png")])
    assert found.groups == ()
    assert "USD package" in found.excluded[0].problem


@pytest.mark.parametrize(("name", "kind"), [("rock.mtlx", "material"), ("rock.gltf", "mesh")])
def test_a_folder_with_one_document_is_that_document(tmp_path: Path, name: str, kind: str) -> None:
    (tmp_path / "rock" / "textures").mkdir(parents=True)
    (tmp_path / "rock" / name).write_text("{}")
    found = one(tmp_path / "rock")
    assert (found.kind, found.paths) == (kind, (tmp_path / "rock" / name,))
    (tmp_path / "rock" / "photograph.png").write_bytes(b"\x89PNG")
    assert one(tmp_path / "rock").kind == ("material" if kind == "material" else "photographs")


def test_an_archive_that_is_cut_says_so(tmp_path: Path) -> None:
    path = zip_of(tmp_path / "suede.zip", "suede/1.png")
    path.write_bytes(path.read_bytes()[:-5])
    assert "cut short" in recognise([path]).excluded[0].problem


def test_measured_brdfs_are_recognised_by_content_and_by_endings_that_nothing_else_has(tmp_path: Path) -> None:
    table = tmp_path / "felt.exr"
    write_table(table, table_from(brdf_from_text("lambert"), (6, 5, 6), "felt", np.float32))
    samples = tmp_path / "samples"
    samples.write_text("theta_i,phi_i,theta_o,phi_o,r,g,b\n30,0,30,180,1,1,1\n")
    broken = tmp_path / "broken.bsdf"
    broken.write_bytes(b"nothing")
    assert one(table).kind == "brdf"
    assert one(samples).kind == "brdf"
    assert one(table, broken) == Recognised("brdf", (table, broken))


def test_other_files_are_not_taken_for_brdfs(tmp_path: Path) -> None:
    image = radiance(tmp_path / "picture.exr", 8, 4)
    mesh = tmp_path / "mesh.obj"
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert one(image).kind == "environment"
    assert one(mesh).kind == "mesh"
    notes = tmp_path / "notes.txt"
    notes.write_text("nothing of the kind")
    found = recognise([notes, tmp_path / "gone"])
    assert found.groups == ()
    assert exclude(found) == [("notes.txt", "is not a kind of file that Lightarc opens"), ("gone", "does not exist")]


def test_files_of_all_kinds_open_together(tmp_path: Path) -> None:
    """A model, an environment, two BRDFs and a folder of photographs, among them what does not open, in any order."""
    mesh, second, notes = tmp_path / "spot.obj", tmp_path / "cup.ply", tmp_path / "notes.txt"
    mesh.write_text("mtllib spot.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (tmp_path / "spot.mtl").write_text("newmtl spot\nmap_Kd spot.png\n")
    (tmp_path / "spot.png").write_bytes(b"\x89PNG")
    second.write_bytes(b"ply\n")
    notes.write_text("nothing of the kind")
    brdfs = [tmp_path / "a.bsdf", tmp_path / "b.bsdf"]
    for each in brdfs:
        each.write_bytes(b"nothing")
    sky = radiance(tmp_path / "sky.exr", 8, 4)
    photographs = tmp_path / "capture"
    photographs.mkdir()
    for name in ("IMG_1.jpg", "IMG_2.jpg"):
        (photographs / name).write_bytes(b"\xff\xd8\xff")
    given = [mesh, notes, sky, second, brdfs[0], photographs, brdfs[1], tmp_path / "spot.mtl", tmp_path / "spot.png"]
    for paths in (given, given[::-1]):
        found = recognise(paths)
        assert kinds(found) == [("brdf", 2), ("environment", 1), ("mesh", 1), ("photographs", 1)]
        first = mesh if paths is given else second
        assert found.groups[2].paths == (first,)
        left = {"notes.txt": "is not a kind of file that Lightarc opens"}
        left |= {(second if first is mesh else mesh).name: "is a second model"}
        assert dict(exclude(found)) == left
    assert kinds(recognise([tmp_path / "capture", sky])) == [("environment", 1), ("photographs", 1)]


def test_hdr_images_are_photographs_where_their_lights_are_stated(tmp_path: Path) -> None:
    angles = [radiance(tmp_path / f"felt_{angle}deg.exr", 8, 4) for angle in (10, 50, 90)]
    assert one(*angles).kind == "photographs"
    others = [radiance(tmp_path / f"{name}.exr", 8, 4) for name in ("harbour", "studio", "forest")]
    assert kinds(recognise(others)) == [("environment", 1)]
    assert [problem for _, problem in exclude(recognise(others))] == ["is a second environment"] * 2
    square = [radiance(tmp_path / f"{at}.exr", 4, 4) for at in range(3)]
    assert one(*square).kind == "photographs"
    assert kinds(recognise([*square, others[0]])) == [("environment", 1), ("photographs", 3)]
    described = tmp_path / "lights.lp"
    described.write_text("3\nharbour.exr 1 0 0\nstudio.exr 0 1 0\nforest.exr 0 0 1\n")
    assert one(*others, described) == Recognised("photographs", (*others, described))
    assert exclude(recognise([described])) == [("lights.lp", "is not a photograph that Lightarc reads")]


def test_a_folder_without_a_capture_stands_for_its_files(tmp_path: Path) -> None:
    radiance(tmp_path / "sky.exr", 8, 4)
    (tmp_path / "spot.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (tmp_path / "licence.txt").write_text("free")
    assert kinds(recognise([tmp_path])) == [("environment", 1), ("mesh", 1)]
    assert exclude(recognise([tmp_path])) == []


def test_measurements_behind_pages_of_comments_are_recognised(tmp_path: Path) -> None:
    path = tmp_path / "paint.dat"
    path.write_text("# a long story\n" * 1000 + "#DIM 4 1\n#PARAM_IN SPHERICAL_TL_PL_TV_PV\n0.1 0.2 0.3 0.4 0.5\n")
    assert one(path).kind == "brdf"


def test_materials_of_other_programs(tmp_path: Path) -> None:
    textures = tmp_path / "rock"
    textures.mkdir()
    for name in ("Rock_1K_Color.png", "Rock_1K_NormalGL.png", "notes.txt"):
        (textures / name).write_bytes(b"\x89PNG\r\n\x1a\n")
    alone = (textures / "Rock_1K_Color.png", textures / "Rock_1K_NormalGL.png")
    assert one(*alone) == Recognised("material", alone), "their folder was not dropped with them"
    assert recognise((*alone, tmp_path / "gone")).groups == (Recognised("material", alone),)
    assert one(*alone, textures / "notes.txt").kind == "photographs", "not all are maps"
    assert one(alone[0]).kind == "photographs"
    document = tmp_path / "rock.mtlx"
    document.write_text('<?xml version="1.0"?><materialx version="1.39"/>')
    assert one(textures) == Recognised("material", (textures,))
    assert one(document) == Recognised("material", (document,))
    photographs = tmp_path / "capture"
    photographs.mkdir()
    for name in ("IMG_1.jpg", "IMG_2.jpg", "flat.jpg"):
        (photographs / name).write_bytes(b"\xff\xd8\xff")
    assert one(photographs).kind == "photographs"


def test_relightable_images_are_materials_and_other_measurements_are_named(tmp_path: Path) -> None:
    """PTM and HSH by their endings, a tree by its numbers; what is not read says what it is."""
    (tmp_path / "coin.ptm").write_bytes(b"PTM_1.2\nPTM_FORMAT_RGB\n")
    tree = tmp_path / "coin"
    tree.mkdir()
    (tree / "info.json").write_text('{"type": "ptm", "nplanes": 18}')
    (tree / "plane_0.jpg").write_bytes(b"\xff\xd8\xff")
    for path in (tmp_path / "coin.ptm", tree, tree / "info.json"):
        assert one(path) == Recognised("material", (path,))
    for name, content, words in (
        ("sheer.xml", b"<WindowElement>", "window system"),
        ("scan.axf", b"\x89HDF\r\n\x1a\n", "AxF"),
    ):
        (tmp_path / name).write_bytes(content)
        ((_, problem),) = exclude(recognise([tmp_path / name]))
        assert words in problem
