"""Files that a Linux desktop reads."""

from __future__ import annotations

import configparser
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

from app.cli import desktop_install
from tests.app.command import Command, result

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="entries are of Linux desktops")


def test_a_desktop_gets_entry_kinds_icon_preview_and_man_page(
    lightarc: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(desktop_install, "renew_tables", lambda _folder: None)  # files of the desktop's own programs
    made = result(lightarc("desktop-install", "--folder", tmp_path, "--json"))
    assert {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*") if path.is_file()} == {*made["files"]}
    entry = configparser.ConfigParser(interpolation=None, strict=True)
    entry.read([tmp_path / "applications/lightarc.desktop", tmp_path / "thumbnailers/lightarc.thumbnailer"])
    kinds = {kind for kind, *_ in desktop_install.FILE_KINDS}
    assert {*filter(None, entry["Desktop Entry"]["MimeType"].split(";"))} == kinds
    assert entry["Desktop Entry"]["Exec"].endswith(" gui %F")
    tree = ElementTree.parse(tmp_path / "mime/packages/lightarc.xml")
    space = "{http://www.freedesktop.org/standards/shared-mime-info}"
    suffixes = {each.attrib["pattern"] for each in tree.iter(f"{space}glob")}
    assert suffixes == {"*.lightarc", "*.lap", "*.ptm", "*.rti"}
    ElementTree.parse(tmp_path / "icons/hicolor/scalable/apps/lightarc.svg")
    assert ".SH VERBS" in (tmp_path / "man/man1/lightarc.1").read_text()

    result(lightarc("desktop-install", "--folder", tmp_path, "--remove", "--json"))
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]


def test_a_program_whose_path_has_spaces_is_quoted() -> None:
    assert desktop_install._quote("/opt/my apps/100%/lightarc") == '"/opt/my apps/100%%/lightarc"'
