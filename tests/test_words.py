"""Plain words: names and sentences in the terms of the field, and functions that are verbs.

`python -m tests.test_words` prints how often each word stands in the sources, and functions named by participles.
"""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[1]
FOLDERS = ("app", "benchmarks", "engine", "lightarc")

#: Words that the field has a term for; the term stands beside each.
OLD_WORDS = {
    "matt": "diffuse",
    "creep": "shading drift",
    "told": "predicted, reported",
    "tells": "reports",
    "truth": "reference, ground truth",
    "harmonics": "spherical_harmonics",
    "picture": "image; photograph, frame",
    "pictures": "images",
    "knob": "parameter, setting",
    "knobs": "parameters",
    "rung": "step, term_error",
    "rungs": "steps, term_errors",
    "ladders": "sweeps, term_errors",
    "person": "user",
    "persons": "users",
    "people": "users",
}

#: Names that stored files and published JSON have, and standard terms that hold such a word.
KEPT = {
    "matt",
    "matt_s",
    "truth",
    "spherical_harmonics",
    "visibility_harmonics",
    "mean_picture",
    "mean_picture_rmse_srgb8",
    "picture_balance",
    "save_picture",
}

#: Words that no sentence has, in docstrings, comments and messages alike.
OLD_PROSE = re.compile(
    r"(?<![\w`\"'/.\-#])(?:an? (?:picture|person|knob|rung)|pictures|knobs|rungs)(?![\w`\"'/.\-=(])", re.I
)

#: Phrases of messages, labels and manuals for which the field has a shorter term.
OLD_PHRASES = re.compile(
    r"known are |is called so|codes of 255|in sample:|by their mean|widths of a texel|what you lose by|"
    r"smallest within|choose the smallest$|follows the import\.|open sky|white card:|sample anew|first hints:|"
    r"like a bust|go on with all|plain canvas:|head-on|opening did not work|give a \.lightarc|is damaged or no |"
    r"kept among your|as the system writes|half of what is free:|what takes long stands|to its makers|"
    r"looking at the scene|preparing kernels|lamps stood on several sides|answered nonsense|that cannot be\.|"
    r"\b(?:is|are) no (?:BRDF|file|folder|image|list|mesh|number|photograph|project|stack|text|whole)\b",
    re.I,
)

#: Words that no label, hint or message of the window has.
OLD_IN_WINDOW = re.compile(
    r"\b(?:pictures?|(?<!mirror )balls?(?!:FILE)|knobs?|ladders?|rungs?|twins?|look-?ups?|looked up|persons?|people|"
    r"processors?|campaigns?|mends?|mended|tells?|told|beside|left out|codes? of|doubtful|errs?|relit|anew|head-on|"
    r"open sky|white card|plain canvas|first hints|opening did not work)\b|\d° (?:up|round)\b|" + OLD_PHRASES.pattern,
    re.I,
)

#: Texts that users read beside the sources.
PAGES = ("README.md", "docs/manual", "resources/manual", "resources/viewer")

#: Bounds are MAX_ and MIN_.
OLD_BOUNDS = re.compile(r"_?(?:MOST|LEAST)_[A-Z0-9_]+")

#: Words of that list wherever they stand; only files that have one are taken apart.
ANYWHERE = re.compile(rf"(?<![^\W_])(?:{'|'.join(OLD_WORDS)}|most|least)(?![^\W_])", re.IGNORECASE)

#: Participles that do not end in "ed", and words that end so and are none.
IRREGULAR = {
    "of",
    "drawn",
    "made",
    "taken",
    "written",
    "known",
    "given",
    "shown",
    "seen",
    "held",
    "kept",
    "found",
    "left",
    "laid",
    "lit",
    "relit",
    "gone",
    "done",
    "begun",
    "sent",
    "bound",
    "spent",
    "met",
    "told",
    "said",
    "lost",
    "shot",
    "frozen",
    "broken",
    "hidden",
    "chosen",
    "worth",
    "bent",
    "built",
    "rewritten",
    "undone",
    "paid",
    "grown",
}
NO_PARTICIPLES = {"need", "speed", "seed", "feed", "red", "embed", "bed", "shed", "exceed", "proceed", "heed"}

#: Functions named by participles: fewer, never more. Properties are nouns and do not count.
MAX_PARTICIPLES = 100


#: Functions that `participles` may find, and docstrings that begin as none may: other modules are not taken apart,
#: which takes 4 s for all.
ANY_PARTICIPLE = re.compile(rf"\bdef _*(?:[a-z0-9]*ed|{'|'.join(IRREGULAR)})(?![a-z0-9])")
LATE_NOUN = re.compile(r"\"\"\"\s*(?:Of|What|Where|Whether|Whoever|How|Which)\b")


@cache
def sources(folder: str) -> dict[str, str]:
    """The modules below a folder of the project, by their paths."""
    paths = sorted((PROJECT / folder).rglob("*.py"))
    return {path.relative_to(PROJECT).as_posix(): path.read_text(encoding="utf-8") for path in paths}


@cache
def tokens(folder: str) -> tuple[tuple[str, int, str], ...]:
    """Path, kind and text of names, strings and comments in the modules below a folder that have one of the words."""
    return tuple(
        (path, token.type, token.string)
        for path, text in sources(folder).items()
        if ANYWHERE.search(text)
        for token in tokenize.generate_tokens(io.StringIO(text).readline)
        if token.type in (tokenize.NAME, tokenize.STRING, tokenize.COMMENT)
    )


def strings(source: str) -> Iterator[str]:
    """String literals of a module, the constant parts of formatted ones included, without docstrings."""
    tree = ast.parse(source)
    documented = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
    docstrings = {
        id(node.body[0].value)  # type: ignore[attr-defined]
        for node in ast.walk(tree)
        if isinstance(node, documented) and _has_text(node)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docstrings:
            yield node.value


def _has_text(node: ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    return bool(node.body) and isinstance(node.body[0], ast.Expr) and isinstance(node.body[0].value, ast.Constant)


def page_files(path: Path) -> list[Path]:
    found = [path] if path.is_file() else path.rglob("*")
    return [each for each in found if each.suffix in {".md", ".html", ".js"}]


def participles(folder: str) -> list[str]:
    """Functions and methods that a participle or a preposition begins, as 'path: name'."""
    found = []
    for path, text in sources(folder).items():
        for node in ast.walk(ast.parse(text)) if ANY_PARTICIPLE.search(text) else ():
            if isinstance(node, ast.FunctionDef) and not any("property" in ast.unparse(d) for d in node.decorator_list):
                first = node.name.strip("_").split("_")[0]
                if first in IRREGULAR or (first.endswith("ed") and first not in NO_PARTICIPLES):
                    found.append(f"{path}: {node.name}")
    return found


@pytest.mark.parametrize("folder", FOLDERS)
def test_names_are_terms_of_the_field(folder: str) -> None:
    names = {
        (path, name) for path, kind, name in tokens(folder) if kind == tokenize.NAME and name.strip("_") not in KEPT
    }
    old = [f"{path}: {name}" for path, name in sorted(names) if OLD_WORDS.keys() & set(name.lower().split("_"))]
    old += [f"{path}: {name}" for path, name in sorted(names) if OLD_BOUNDS.fullmatch(name)]
    assert old == []


@pytest.mark.parametrize("folder", FOLDERS)
def test_sentences_are_in_terms_of_the_field(folder: str) -> None:
    """Strings of more than one word, and comments; keys of files and of JSON are single words."""
    found = [
        f"{path}: {match[0]}"
        for path, kind, text in tokens(folder)
        if kind != tokenize.NAME and " " in text
        for match in OLD_PROSE.finditer(text)
    ]
    assert found == []


def test_messages_and_pages_have_the_phrases_of_the_field() -> None:
    texts = [
        (path, text)
        for folder in FOLDERS
        for path, source in sources(folder).items()
        if OLD_PHRASES.search(source)
        for text in strings(source)
    ]
    for page in PAGES:
        for path in sorted(page_files(PROJECT / page)):
            texts.append((path.relative_to(PROJECT).as_posix(), path.read_text(encoding="utf-8")))
    assert [f"{path}: {match[0]}" for path, text in texts for match in OLD_PHRASES.finditer(text)] == []


def test_pages_for_users_are_in_words_of_the_field() -> None:
    """Sentences of README, manual and help; code in them is in that of the program. "Relit" is a plain participle."""
    found = [
        f"{path.relative_to(PROJECT)}: {match[0]}"
        for page in PAGES
        for path in sorted(page_files(PROJECT / page))
        if path.suffix == ".md"
        for match in OLD_IN_WINDOW.finditer(re.sub(r"(`+)[^`]+\1", "", path.read_text(encoding="utf-8")))
        if match[0] != "relit"
    ]
    assert found == []


def test_public_docstrings_begin_with_a_verb_or_a_noun() -> None:
    """Not with "Of …", "What …" or "Whether …", after which the noun comes late or never."""
    found = []
    for folder in FOLDERS:
        for path, text in sources(folder).items():
            if path.startswith("engine/capture/calibration/") or not LATE_NOUN.search(text):
                continue
            for node in ast.walk(ast.parse(text)):
                if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
                    begin = (ast.get_docstring(node) or "-").split()[0]
                    if begin in {"Of", "What", "Where", "Whether", "Whoever", "How", "Which"}:
                        found.append(f"{path}: {node.name}")
    assert found == []


def test_functions_are_verbs() -> None:
    found = [name for folder in FOLDERS for name in participles(folder)]
    assert len(found) <= MAX_PARTICIPLES, "\n".join(found)


def main() -> None:
    """Print how often each word stands in the sources, and the functions that participles name."""
    words: Counter[str] = Counter()
    for folder in FOLDERS:
        for text in sources(folder).values():
            words.update(match[0].lower() for match in ANYWHERE.finditer(text))
    for word, count in words.most_common():
        print(f"{count:6d}  {word}")
    named = [name for folder in FOLDERS for name in participles(folder)]
    print(f"{len(named)} functions named by participles", *named, sep="\n")


if __name__ == "__main__":
    main()
