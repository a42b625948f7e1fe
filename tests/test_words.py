"""Plain words: sentences that say what a thing is."""

from __future__ import annotations

import io
import re
import tokenize
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[1]

#: Words of names that the field has a term for; the term stands beside each.
OLD_WORDS = {
    "matt": "diffuse",
    "creep": "shading drift",
    "told": "predicted, reported",
    "tells": "reports",
    "truth": "reference, ground truth",
    "harmonics": "spherical_harmonics",
}

#: Names that stored files and published JSON have, and standard terms that hold such a word.
KEPT = {"matt", "matt_s", "truth", "spherical_harmonics", "visibility_harmonics"}


#: Words of that list wherever they stand; only files that have one are taken apart.
ANYWHERE = re.compile(rf"(?<![^\W_])(?:{'|'.join(OLD_WORDS)})(?![^\W_])", re.IGNORECASE)


@pytest.mark.parametrize("folder", ["app", "benchmarks", "engine", "lightarc"])
def test_names_are_terms_of_the_field(folder: str) -> None:
    texts = {path: path.read_text(encoding="utf-8") for path in sorted((PROJECT / folder).rglob("*.py"))}
    names = {
        (path.relative_to(PROJECT).as_posix(), token.string)
        for path, text in texts.items()
        if ANYWHERE.search(text)
        for token in tokenize.generate_tokens(io.StringIO(text).readline)
        if token.type == tokenize.NAME and token.string.strip("_") not in KEPT
    }
    old = [f"{path}: {name}" for path, name in sorted(names) if OLD_WORDS.keys() & set(name.lower().split("_"))]
    assert old == []
