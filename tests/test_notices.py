"""Third-party notices and the bill of materials follow the lock file, and hold what licences ask for."""

from __future__ import annotations

import json
import re
import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

PROJECT = Path(__file__).resolve().parents[1]


def load_notices() -> Any:
    spec = spec_from_file_location("notices", PROJECT / "packaging" / "notices.py")
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    sys.modules["notices"] = module
    spec.loader.exec_module(module)
    return module


notices = load_notices()
LOCKED = {(each.name, each.version) for each in notices.read_lock()}


def test_notices_name_each_package_of_the_lock() -> None:
    text = notices.NOTICES.read_text(encoding="utf-8")
    named = re.findall(r"^={100}\n(\S+) (\S+)$", text, re.MULTILINE)
    assert len(LOCKED) > 30
    assert set(named) == LOCKED, "run packaging/notices.py"
    assert "see the text below" not in text


def test_each_package_has_a_text_or_a_remark() -> None:
    text = notices.NOTICES.read_text(encoding="utf-8")
    for part in re.split(rf"^{'=' * 100}\n", text, flags=re.MULTILINE)[1:]:
        name = part.split(" ", 1)[0]
        assert "\n--- " in part or name in notices.REMARKS or "other systems" in part, name


def test_licences_of_qt_and_libraw_are_told() -> None:
    text = notices.NOTICES.read_text(encoding="utf-8")
    assert "replace" in notices.REMARKS["pyside6-essentials"]
    assert notices.REMARKS["pyside6-essentials"] in text
    assert notices.REMARKS["rawpy"] in text
    for name in ("LGPL-3.0.txt", "GPL-3.0.txt"):
        assert "Version 3, 29 June 2007" in (notices.FOLDER / name).read_text(encoding="utf-8")


def test_bill_of_materials_holds_the_lock_with_its_hashes() -> None:
    said = json.loads(notices.SBOM.read_text(encoding="utf-8"))
    assert (said["bomFormat"], said["specVersion"]) == ("CycloneDX", "1.6")
    found = {(each["name"], each["version"]): each for each in said["components"]}
    assert found.keys() == LOCKED, "run packaging/notices.py"
    for locked in notices.read_lock():
        properties = found[locked.name, locked.version]["properties"]
        assert tuple(each["value"] for each in properties) == locked.hashes
    references = [each["bom-ref"] for each in said["components"]]
    assert len(set(references)) == len(references)
    assert "libraw" in json.dumps(found["rawpy", next(v for n, v in LOCKED if n == "rawpy")]).lower()
