"""Phrases of the window in the sources, and the files of their translations.

`python packaging/translate.py` adds new phrases to `resources/language/*.ts`, marked as unfinished, and removes
those that are gone. The files have Qt's own format, so that Qt Linguist opens them. `pyside6-lupdate` finds only
arguments of `tr`; here a phrase is a text of the sources wherever it stands, because widgets translate what they show
(`app/widgets/language.py`): also a label in a table, a message of a job, or a declaration of the engine. A formatted
string is a phrase with %1, %2 … in place of its values.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

PROJECT = Path(__file__).resolve().parents[1]
LANGUAGES = PROJECT / "resources" / "language"

#: Packages of the window, each a context of the translation; what a command line alone says is in none.
CONTEXTS = (
    "capture",
    "material",
    "brdf",
    "factor",
    "view",
    "export",
    "varying",
    "viewport",
    "widgets",
    "docks",
    "window",
    "start",
    "help",
    "document",
    "commands",
    "batch",
    "jobs",
    "project",
    "session",
)

#: Functions whose texts no user of the window reads: names, patterns, queries and messages of the log.
SILENT = {
    *("ValueError", "TypeError", "KeyError", "RuntimeError", "AssertionError", "NotImplementedError", "TypeVar"),
    *("getattr", "setattr", "hasattr", "cast", "import_module", "getLogger", "debug", "info", "warning", "error"),
    *("exception", "execute", "executemany", "executescript", "setObjectName", "role", "property", "setProperty"),
    *("glob", "rglob", "startswith", "endswith", "removeprefix", "removesuffix", "findChild", "split", "rsplit"),
    *("partition", "strip", "replace", "encode", "decode", "with_suffix", "get", "pop", "sub", "fullmatch", "match"),
    *("search", "findall", "index", "count", "icon", "pixmap", "setStyleSheet", "QKeySequence", "QByteArray"),
}

#: Texts that are no phrase: queries of the database, style sheets, mark-up, keys, and formats of the log.
NO_PHRASE = re.compile(
    r"\s*(?:CREATE|SELECT|INSERT|UPDATE|DELETE|Q[A-Z]\w+ \{|typeof|length\(|palette|%\()|.*[{;]\s*\n|<[a-z]|[A-Z_]+$|"
    r"(?:Ctrl|Shift|Alt)\+|[A-Za-z]*[a-z][A-Z]\w*$|Steps\[|%1\.[a-z]{2,8}$",
    re.DOTALL,
)

#: Modules of which no text is read: names of functions of Qt, and the style sheet with names of type faces.
SILENT_MODULES = ("language.py", "theme.py", "lanes.py", "batch/report.py", "batch/worker.py")


def find_phrases(path: Path) -> Iterator[tuple[int, str]]:
    """Texts of a module that a user may read, each with its line; a value of a formatted string is %1, %2 …"""
    yield from _find(ast.parse(path.read_text(encoding="utf-8")))


def _find(node: ast.AST) -> Iterator[tuple[int, str]]:
    match node:
        case ast.Expr(value=ast.Constant()) | ast.Compare() | ast.Import() | ast.ImportFrom():
            return  # a docstring, or a text that only the program compares
        case ast.AnnAssign():
            yield from _find(node.value) if node.value else ()
        case ast.FunctionDef() | ast.AsyncFunctionDef():
            for each in (*node.args.defaults, *filter(None, node.args.kw_defaults), *node.body):
                yield from _find(each)
        case ast.Subscript():
            yield from _find(node.value)
        case ast.Call() if _name(node.func) in SILENT:
            yield from _find(node.func)
        case ast.JoinedStr():
            yield from ((node.lineno, text) for text in [_template(node)] if is_phrase(text))
            for part in node.values:
                if isinstance(part, ast.FormattedValue):
                    yield from _find(part.value)
        case ast.Constant(value=str()):
            yield from ((node.lineno, text) for text in [_number(str(node.value))] if is_phrase(text))
        case _:
            for child in ast.iter_child_nodes(node):
                yield from _find(child)


def _name(function: ast.expr) -> str:
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def _template(node: ast.JoinedStr) -> str:
    return _number("".join(str(part.value) if isinstance(part, ast.Constant) else "{}" for part in node.values))


def _number(text: str) -> str:
    """`text` with %1, %2 … in place of its empty braces."""
    numbers = iter(range(1, 1000))
    return re.sub(r"\{\}", lambda _: f"%{next(numbers)}", text)


def is_phrase(text: str) -> bool:
    """True for a text of words: several, or one that begins with a capital letter."""
    words = re.sub(r"%\d+|&", "", text)
    several = " " in words.strip() or words[:1].isupper() or (words != text and " " in text)
    return bool(several and re.search(r"[^\W\d_]{2}", words) and not NO_PHRASE.match(text))


def collect() -> dict[str, list[str]]:
    """The phrases of each context, each phrase in the first one that has it."""
    seen: set[str] = set()
    found: dict[str, list[str]] = {}
    for context in CONTEXTS:
        paths = sorted((PROJECT / "app" / context).rglob("*.py"))
        paths = [path for path in paths if not {path.name, f"{context}/{path.name}"} & {*SILENT_MODULES}]
        texts = [text for path in paths for _, text in find_phrases(path)]
        found[context] = [text for text in dict.fromkeys(texts) if text not in seen]
        seen.update(found[context])
    return found


def read(path: Path) -> dict[str, dict[str, str]]:
    """The translations of a file by context and phrase; an unfinished one is empty."""
    root = ElementTree.parse(path).getroot()
    return {
        context.findtext("name", ""): {
            each.findtext("source", ""): each.findtext("translation", "") for each in context.iter("message")
        }
        for context in root.iter("context")
    }


def write(path: Path, contexts: dict[str, dict[str, str]]) -> None:
    """Write translations as Qt Linguist does."""
    root = ElementTree.Element("TS", version="2.1", language=path.stem, sourcelanguage="en")
    for name, phrases in contexts.items():
        context = ElementTree.SubElement(root, "context")
        ElementTree.SubElement(context, "name").text = name
        for source, translation in phrases.items():
            message = ElementTree.SubElement(context, "message")
            ElementTree.SubElement(message, "source").text = source
            state = {} if translation else {"type": "unfinished"}
            ElementTree.SubElement(message, "translation", state).text = translation
    ElementTree.indent(root, " ")
    text = ElementTree.tostring(root, encoding="unicode")
    path.write_text(f'<?xml version="1.0" encoding="utf-8"?>\n<!DOCTYPE TS>\n{text}\n', encoding="utf-8")


def main() -> int:
    """Bring each file of translations up to the sources, and print how many phrases are unfinished.

    Contexts that are none of the window's packages are kept: declarations of the engine, and forms for several things.
    """
    phrases = collect()
    for path in sorted(LANGUAGES.glob("*.ts")):
        before = read(path)
        known = {source: translation for context in before.values() for source, translation in context.items()}
        now = {name: {text: known.get(text, "") for text in texts} for name, texts in phrases.items()}
        write(path, now | {name: context for name, context in before.items() if name not in phrases})
        missing = sum(not translation for context in now.values() for translation in context.values())
        print(f"{path.name}: {sum(map(len, now.values()))} phrases, {missing} unfinished")
    return 0


if __name__ == "__main__":
    sys.exit(main())
