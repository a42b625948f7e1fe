"""Write the third-party notices and the software bill of materials (SBOM) of what an installation runs with.

    .venv/bin/python packaging/notices.py

Both are generated from `packaging/requirements.lock` and from the metadata of the packages as they are installed in
the environment that runs this script, so that a new lock is followed by a new run (`tests/test_notices.py` compares
them). `resources/licences/third-party.txt` holds each package with its licence and the full texts that the package
ships; Qt and shiboken6 ship none in their wheels, and are licensed under the texts `LGPL-3.0.txt` and `GPL-3.0.txt`
next to it. `resources/licences/sbom.cdx.json` is CycloneDX 1.6, with the hashes of the lock and the libraries that
wheels declare to hold (their `sboms/*.cdx.json`, from Linux on x86-64).

The tool cyclonedx-bom was weighed: it adds ten packages to those of the tests and does not look into wheels.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

PROJECT = Path(__file__).resolve().parents[1]
LOCK = PROJECT / "packaging" / "requirements.lock"
FOLDER = PROJECT / "resources" / "licences"
NOTICES, SBOM = FOLDER / "third-party.txt", FOLDER / "sbom.cdx.json"

#: Files of a distribution that hold a licence or a notice.
_TEXT = re.compile(r"(^|/)(licen[cs]e|copying|notice|authors\.libraw)[^/]*$|/licenses/.*", re.IGNORECASE)

#: A shared library that a wheel holds, without the hash in its name.
_LIBRARY = re.compile(
    r"(?:\.libs|/Qt/lib|^rawpy)/(?P<name>lib[^/]+?)(?:-[0-9a-f]{8})?\.so(?:\.(?P<version>[\d.a-z]+))?$"
)

#: Licences of packages whose metadata name none, give the whole text, or pass over what the wheel holds.
LICENCES = {
    "colorama": "BSD-3-Clause",
    "cycler": "BSD-3-Clause",
    "embreex": "MIT AND Apache-2.0",
    "exifread": "BSD-3-Clause",
    "flip-evaluator": "BSD-3-Clause",
    "kiwisolver": "BSD-3-Clause",
    "matplotlib": "PSF-2.0",
    "opencv-contrib-python-headless": "Apache-2.0 AND LGPL-2.1-or-later",
    "openexr": "BSD-3-Clause",
    "rawpy": "MIT AND (LGPL-2.1-only OR CDDL-1.0)",
    "scipy": "BSD-3-Clause",
}

#: Sentences for packages whose licence asks for more than its text.
REMARKS = {
    "pyside6-essentials": (
        "Qt and Qt for Python are used under the GNU Lesser General Public License, version 3 (LGPL-3.0.txt and "
        "GPL-3.0.txt next to this file). They are separate, dynamically loaded libraries that a user may replace with "
        "versions of their own: install another PySide6-Essentials into the same environment. Their source code is "
        "published by The Qt Company at https://code.qt.io/cgit/pyside/pyside-setup.git and "
        "https://code.qt.io/cgit/qt/."
    ),
    "shiboken6": "Used under the GNU Lesser General Public License, version 3, as PySide6-Essentials is.",
    "rawpy": (
        "The wheel holds LibRaw, used under the GNU Lesser General Public License, version 2.1, as a separate, "
        "dynamically loaded library that a user may replace. Its source code is published at "
        "https://github.com/LibRaw/LibRaw."
    ),
    "opencv-contrib-python-headless": (
        "The wheel holds FFmpeg, used under the GNU Lesser General Public License, version 2.1, as separate, "
        "dynamically loaded libraries that a user may replace; its texts are among those below."
    ),
}

_RULE = "=" * 100


@dataclass(frozen=True)
class Locked:
    """A package of the lock file: its name, version and SHA-256 hashes (of its files on all platforms)."""

    name: str
    version: str
    hashes: tuple[str, ...]


def read_lock(path: Path = LOCK) -> tuple[Locked, ...]:
    """Read the packages of a lock file, in its order; one that stands there for several systems once."""
    found: dict[str, Locked] = {}
    for block in re.split(r"\n(?=\S)", path.read_text(encoding="utf-8")):
        head = re.match(r"([A-Za-z0-9._-]+)==([^\s;\\]+)", block)
        if head is not None:
            hashes = tuple(re.findall(r"sha256:([0-9a-f]{64})", block))
            found.setdefault(head[1].lower(), Locked(head[1].lower(), head[2], hashes))
    return tuple(found.values())


def licence_of(package: Distribution, name: str) -> str:
    """Name the licence of an installed package, as its metadata or `LICENCES` say."""
    keys = ("License-Expression", "License")
    said = LICENCES.get(name) or next((package.metadata[key] for key in keys if key in package.metadata), "")
    return said.strip().splitlines()[0] if said.strip() else "see the text below"


def texts_of(package: Distribution) -> Iterator[tuple[str, str]]:
    """Yield name and content of each licence text that an installed package ships."""
    for file in sorted(package.files or (), key=str):
        inner = str(file).partition(".dist-info/")[2]
        if inner and _TEXT.search(f"/{inner}"):
            yield inner, file.read_text(encoding="utf-8")


def libraries_of(package: Distribution) -> Iterator[Mapping[str, Any]]:
    """Yield the components that the wheel of an installed package holds: those it declares, and shared libraries."""
    for file in sorted(package.files or (), key=str):
        if re.search(r"\.dist-info/sboms/.*\.cdx\.json$", str(file)):
            for each in json.loads(file.read_text(encoding="utf-8")).get("components", ()):
                if not str(each.get("purl", "")).startswith("pkg:pypi/"):
                    yield each
        library = _LIBRARY.search(str(file))
        if library is not None:
            yield {"name": library["name"], **({"version": library["version"]} if library["version"] else {})}


def write_notices(packages: Sequence[tuple[Locked, Distribution | None]]) -> str:
    """Compose the notices; a text that several packages ship stands there once."""
    lines = [
        "Third-party software that Lightarc runs with",
        "",
        "Lightarc itself is under the MIT licence. The fonts in resources/fonts are under the SIL Open Font License",
        "(OFL.txt next to them). The packages below are installed next to Lightarc, each under its own licence.",
        "Texts are those that the packages ship for Linux on x86-64.",
        "",
    ]
    seen: dict[str, str] = {}
    for locked, package in packages:
        lines += [_RULE, f"{locked.name} {locked.version}"]
        if package is None:
            lines += ["Installed on other systems only; its licence is that of its distribution there.", ""]
            continue
        home = next((url.split(", ", 1)[1] for url in package.metadata.get_all("Project-URL") or ()), "")
        lines += [f"Licence: {licence_of(package, locked.name)}", *([home] if home else [])]
        if locked.name in REMARKS:
            lines += ["", REMARKS[locked.name]]
        held = [f"{each['name']} {each.get('version', '')}".strip() for each in libraries_of(package)]
        if held:
            lines += ["", f"The wheel also holds: {', '.join(held)}"]
        for name, text in texts_of(package):
            place = f"{locked.name}, {name}"
            first = seen.setdefault(" ".join(text.split()), place)
            lines += ["", f"--- {name}" if first == place else f"--- {name}: the same text as {first}"]
            if first == place:
                lines += ["", text.strip()]
        lines.append("")
    return "\n".join(line.rstrip() for line in "\n".join(lines).splitlines()) + "\n"


def write_sbom(packages: Sequence[tuple[Locked, Distribution | None]], version: str) -> dict[str, Any]:
    """Compose the bill of materials (CycloneDX 1.6), without a time or a random number: equal inputs, equal bytes."""
    components = []
    for locked, package in packages:
        purl = f"pkg:pypi/{locked.name}@{locked.version}"
        component: dict[str, Any] = {
            "type": "library",
            "bom-ref": purl,
            "name": locked.name,
            "version": locked.version,
            "purl": purl,
            "properties": [{"name": "lightarc:sha256", "value": each} for each in locked.hashes],
        }
        if package is not None:
            component["licenses"] = [{"license": {"name": licence_of(package, locked.name)}}]
            held = [
                {
                    "type": "library",
                    "bom-ref": f"{purl}#{each['name']}",
                    "name": each["name"],
                    **({"version": each["version"]} if "version" in each else {}),
                    **({"purl": each["purl"]} if "purl" in each else {}),
                }
                for each in {one["name"]: one for one in libraries_of(package)}.values()
            ]
            if held:
                component["components"] = held
        components.append(component)
    own = {"type": "application", "bom-ref": "lightarc", "name": "lightarc", "version": version}
    return {
        "$schema": "http://cyclonedx.org/schema/bom-1.6.schema.json",
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": {"component": {**own, "licenses": [{"license": {"id": "MIT"}}]}},
        "components": components,
        "dependencies": [{"ref": "lightarc", "dependsOn": [each["bom-ref"] for each in components]}],
    }


def find_installed(packages: Sequence[Locked]) -> list[tuple[Locked, Distribution | None]]:
    """Pair each package with its installation; ValueError where the installed version is another."""
    pairs: list[tuple[Locked, Distribution | None]] = []
    for each in packages:
        try:
            found = distribution(each.name)
        except PackageNotFoundError:
            pairs.append((each, None))
            continue
        if found.version != each.version:
            raise ValueError(f"{each.name} {found.version} is installed, but the lock names {each.version}")
        pairs.append((each, found))
    return pairs


def main() -> int:
    sys.path.insert(0, str(PROJECT))
    import engine

    pairs = find_installed(read_lock())
    NOTICES.write_text(write_notices(pairs), encoding="utf-8")
    SBOM.write_text(json.dumps(write_sbom(pairs, engine.__version__), indent=1) + "\n", encoding="utf-8")
    print(f"{NOTICES} and {SBOM}: {len(pairs)} packages")
    return 0


if __name__ == "__main__":
    sys.exit(main())
