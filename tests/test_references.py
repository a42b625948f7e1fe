"""Citations of one form, `Green2006 Eq. 8`: each tag is in the bibliography, each implemented equation has its tag."""

from __future__ import annotations

import re
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1]

#: Numbered equations of the five papers that the program implements.
IMPLEMENTED = {
    "Cole2002": ("1.4", "1.5", "1.6", "1.7", "1.9", "1.10", "3.4", "3.6", "3.11"),
    "Green2006": ("2", "4", "5", "6", "7", "8", "9", "10", "11"),
    "Kautz2002": ("1",),
    "Kautz2004": ("1", "2", "3", "4"),
    "Wang2004": ("1", "2", "3", "4", "5", "6", "7", "8"),
}


def test_citations_are_in_the_bibliography_and_equations_are_tagged() -> None:
    bibliography = (PROJECT / "resources" / "references.bib").read_text(encoding="utf-8")
    known = re.findall(r"^@\w+\{(\w+),", bibliography, re.MULTILINE)
    assert len(known) == len(set(known))
    source = "\n".join(path.read_text(encoding="utf-8") for path in sorted((PROJECT / "engine").rglob("*.py")))
    cited = set(re.findall(r"\b[A-Z][A-Za-z]+(?:19|20)\d\d[a-z]?\b", source))
    assert cited - set(known) == set()
    found = {" ".join(tag.split()) for tag in re.findall(r"\b\w+\d{4}\s+Eq\.\s+[\d.]*\d", source)}
    assert {f"{paper} Eq. {number}" for paper, numbers in IMPLEMENTED.items() for number in numbers} - found == set()
    assert re.findall(r"\bEqs\.|\b[Ee]quations? \d|(?<!\d\s)\bEq\. \d", source) == []


def test_works_are_cited_by_their_keys() -> None:
    """Captions of the papers' figures, which users read, name the authors."""
    by_name = re.compile(r"\bet al\.|\b[A-Z][a-z]+,? \(?(?:19|20)\d\d\b(?!,? \")")
    lines = [
        f"{path.relative_to(PROJECT).as_posix()}:{number} {line.strip()}"
        for path in sorted((PROJECT / "engine").rglob("*.py"))
        if path.parent.name != "papers"
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if by_name.search(line)
    ]
    assert lines == []
