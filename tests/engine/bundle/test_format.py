"""docs/format.md: its reader runs without this program, its schema is that of the manifest, its members are all."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

from engine.bundle.bundle import extract_bundle, open_bundle, save_bundle, verify_bundle
from engine.bundle.manifest import MEMBERS, describe_bundle
from engine.core.errors import InputError, OutputError
from engine.core.steps import drain
from engine.scene.material import Material
from engine.storage.records import manifest_schema
from tests.engine.domes import dome_material
from tests.engine.exchange.materials import measure_maps, woven_law, woven_material

DOCS = Path(__file__).resolve().parents[3] / "docs"


@pytest.fixture
def bundle(tmp_path: Path) -> Path:
    return drain(save_bundle(tmp_path / "woven.lightarc", woven_material()))


def reader(number: int) -> str:
    """A program of the documentation: the first reads power laws, the second directional maps."""
    programs: list[str] = re.findall(
        r"```python\n(.*?)```", (DOCS / "format.md").read_text(encoding="utf-8"), re.DOTALL
    )
    return programs[number]


def test_the_reader_of_the_documentation_reads_a_bundle(bundle: Path, tmp_path: Path) -> None:
    """In an interpreter that knows no module of ours, about twenty lines give the radiance bit for bit but rounding."""
    source = reader(0)
    assert len([line for line in source.splitlines() if line.strip()]) <= 20
    assert "engine" not in source
    assert "lightarc" not in source
    (tmp_path / "reader.py").write_text(source)
    words = [sys.executable, "-I", "reader.py", str(bundle), "0.1", "radiance.npy"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == f"{bundle} is sound; A cloth, woven is in it as power_law"
    np.testing.assert_allclose(np.load(tmp_path / "radiance.npy"), woven_law().slice_image(0.1), rtol=1e-5)


def test_the_reader_says_that_pbr_maps_are_in_a_bundle(tmp_path: Path) -> None:
    bundle = drain(save_bundle(tmp_path / "rock.lightarc", Material(None, None, name="rock", pbr=measure_maps())))
    (tmp_path / "reader.py").write_text(reader(0))
    words = [sys.executable, "-I", "reader.py", str(bundle), "0.1", "radiance.npy"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stdout.strip()) == (0, f"{bundle} is sound; rock is in it as pbr"), done.stderr
    assert not (tmp_path / "radiance.npy").exists()


def test_the_reader_notices_damage(bundle: Path, tmp_path: Path) -> None:
    source = reader(0)
    (tmp_path / "reader.py").write_text(source)
    content = bytearray(bundle.read_bytes())
    content[len(content) // 3] ^= 1
    bundle.write_bytes(content)
    words = [sys.executable, "-I", "reader.py", str(bundle), "0.1", "radiance.npy"]
    assert subprocess.run(words, cwd=tmp_path, capture_output=True, timeout=120).returncode != 0


def test_the_readers_read_a_directional_map(tmp_path: Path) -> None:
    """The first finds it sound and says what it is; the second draws what we draw, lit from overhead."""
    material = dome_material()
    assert material.directional is not None
    bundle = drain(save_bundle(tmp_path / "dome.lightarc", material))
    for number, values in ((0, ["0.1"]), (1, ["0", "0"])):
        (tmp_path / "reader.py").write_text(reader(number))
        words = [sys.executable, "-I", "reader.py", str(bundle), *values, "radiance.npy"]
        done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stderr
        if number == 0:
            assert done.stdout.strip() == f"{bundle} is sound; {material.name} is in it as directional"
    wanted = material.directional.image(np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(np.load(tmp_path / "radiance.npy"), wanted, rtol=1e-3, atol=1e-6)


def test_the_schema_is_that_of_the_manifest() -> None:
    stated = json.loads((DOCS / "manifest.schema.json").read_text(encoding="utf-8"))
    assert stated == manifest_schema()


def test_the_schema_allows_every_value_of_a_written_manifest(bundle: Path) -> None:
    """Whoever validates manifest.json as it lies in the bundle is not told that a value of ours is foreign."""
    stated = json.loads((DOCS / "manifest.schema.json").read_text(encoding="utf-8"))
    with zipfile.ZipFile(bundle) as archive:
        written = json.loads(archive.read("manifest.json"))
    assert stated["additionalProperties"] is False
    assert set(stated["required"]) <= set(written) <= set(stated["properties"])
    assert re.fullmatch(stated["properties"]["manifest_sha256"]["pattern"], written["manifest_sha256"])


def test_the_schema_names_every_value_of_a_manifest(bundle: Path) -> None:
    stated = json.loads((DOCS / "manifest.schema.json").read_text(encoding="utf-8"))
    assert set(describe_bundle(bundle)) - {"warnings"} <= set(stated["properties"])


def test_every_member_is_described() -> None:
    text = (DOCS / "format.md").read_text(encoding="utf-8")
    for name in MEMBERS:
        plain = re.sub(r"directional_plane\d+\.png", "directional_plane*.png", name)
        stem = plain.replace("power_law_exponent.png", "power_law_exponent.exr")
        assert f"`{stem}`" in text, name


def test_an_extracted_bundle_is_a_bundle(bundle: Path, tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    names = extract_bundle(bundle, folder)
    assert names[-1] == "manifest.json"
    assert all((folder / name).is_file() for name in names)
    assert verify_bundle(folder).ok
    law = open_bundle(folder).power_law
    assert law is not None
    np.testing.assert_array_equal(law.scale, woven_law().scale)
    extract_bundle(bundle, folder)


def test_nothing_damaged_is_extracted_and_nothing_foreign_replaced(bundle: Path, tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("dear")
    with pytest.raises(OutputError):
        extract_bundle(bundle, tmp_path / "mine")
    content = bytearray(bundle.read_bytes())
    content[len(content) // 3] ^= 1
    bundle.write_bytes(content)
    with pytest.raises(InputError):
        extract_bundle(bundle, tmp_path / "folder")
    assert not (tmp_path / "folder").exists()
