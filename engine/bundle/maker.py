"""Fingerprint of the state of this program that wrote the page, the shader and brdf.json of a bundle: their maker.

Two states of one version may write different pages, and a page of another state cannot be told from one that somebody
changed. The manifest keeps the fingerprint, and `check_made_anew` says what follows.
"""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Callable

import numpy as np

import engine
from engine.brdf.brdf import MODELS
from engine.bundle.directional import directional_problems
from engine.bundle.manifest import BRDF, SHADER, VIEWER
from engine.bundle.members import SMALL_LIMIT_BYTES
from engine.bundle.page import OneFile, make_page, viewer
from engine.bundle.portable import RESOURCES, brdf_json, is_same_text, shader
from engine.core.errors import UsageError
from engine.scene.material import Material
from engine.shading.power_law import PowerLawMap
from engine.storage.archive import Archive
from engine.storage.records import Manifest

#: Ways to what a member for other programs holds, for who does not trust one.
_ANEW = {
    VIEWER: "lightarc bundle view opens a newly made page",
    SHADER: "lightarc export --to shaders writes a new one",
    BRDF: "the BRDF that counts is the one in the manifest",
}

#: The key in `software` of the manifest, and the folders of resources that texts are put together from.
MAKER, _FOLDERS = "maker", ("viewer", "bundle", "shaders")


def maker() -> str:
    """16 hexadecimal digits of the version, the texts of a material of one texel, and the resources of all others."""
    return _maker_with(tuple(MODELS))


@functools.cache
def _maker_with(_models: tuple[str, ...]) -> str:
    digest = hashlib.sha256(engine.__version__.encode())
    texel, error = np.full((1, 1, 3), 0.5, np.float32), np.zeros((1, 1), np.float32)
    plain = Material(None, PowerLawMap(texel, texel, 1.0, 0.0, np.zeros(3), error), "lambert", 1.0)
    for make in (viewer, shader, brdf_json):
        digest.update(make(plain).encode())
    for folder in _FOLDERS:
        for path in sorted((RESOURCES / folder).rglob("*.*")):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def check_made_anew(archive: Archive, manifest: Manifest, material: Material) -> tuple[list[str], list[str]]:
    """Faults of the members for other programs, and sentences on those that cannot be checked.

    They are made anew and compared, by the fingerprints in the manifest first, which are those of the members: a page
    runs in a browser. Those of another maker may differ without fault, and are named: the maker that the manifest
    states is not believed, for whoever replaced a page can have written it.
    """
    problems = directional_problems(archive, manifest, material.directional)
    unchecked: list[str] = []
    makers: dict[str, Callable[[Material], str | OneFile]] = {BRDF: brdf_json, SHADER: shader, VIEWER: make_page}
    for name, make in makers.items():
        if name not in manifest.members:
            continue
        try:
            made = make(material)
            same = manifest.members[name].sha256 == _hash(made) or is_same_text(
                archive.read(name, SMALL_LIMIT_BYTES), made if isinstance(made, str) else viewer(material)
            )
        except UsageError:  # a page for a material that has none
            same = False
        if same:
            continue
        if manifest.software.get(MAKER) == maker():
            problems.append(f"{name} is not what this program makes of the material; export the bundle again.")
        else:
            unchecked.append(f"{name} {_is_of_another_maker(manifest)}; {_ANEW[name]}.")
    return problems, unchecked


def _hash(made: str | OneFile) -> str:
    """SHA-256 of what was made, by which the manifest knows a member."""
    digest = hashlib.sha256()
    for piece in (made.encode(),) if isinstance(made, str) else made:
        digest.update(piece)
    return digest.hexdigest()


def _is_of_another_maker(manifest: Manifest) -> str:
    version = manifest.software.get("lightarc", "")
    stated = f"version {version[:20]!r}" if version else "no version that is named"
    if version == engine.__version__:
        stated = f"another build of version {version}"
    return f"was written by {stated}, and this one cannot check whether somebody changed it"
