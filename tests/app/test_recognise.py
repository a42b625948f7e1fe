"""What is dropped is told by its content: a bundle from an archive of photographs, whatever they are called."""

import io
import tarfile
import zipfile

import pytest

from app.recognise import recognise
from engine.errors import InputError


def zip_of(path, *names):
    with zipfile.ZipFile(path, "w") as archive:
        for name in names:
            archive.writestr(name, b"{}")
    return path


def tar_of(path, *names):
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
        (zip_of, "no ending", ["suede/1.png", "suede/manifest.json"], "photographs"),
        (tar_of, "suede.tar.xz", ["suede/1.png"], "photographs"),
    ],
)
def test_archives(tmp_path, make, name, members, kind):
    assert recognise([make(tmp_path / name, *members)]).kind == kind


def test_an_archive_that_is_cut_says_so(tmp_path):
    path = zip_of(tmp_path / "suede.zip", "suede/1.png")
    path.write_bytes(path.read_bytes()[:-5])
    with pytest.raises(InputError, match="cut short"):
        recognise([path])
