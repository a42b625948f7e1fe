"""Phrases of the window in the sources, and the files of their translations.

`python packaging/translate.py` adds new phrases to `resources/language/*.ts`, marked as unfinished, and removes
those that are gone. The files have Qt's own format, so that Qt Linguist opens them. `pyside6-lupdate` finds only
arguments of `tr`; here a phrase is a text of the sources wherever it stands, because widgets translate what they show
(`app/widgets/language.py`): also a label in a table, a message of a job, or a declaration of the engine. A formatted
string is a phrase with %1, %2 … in place of its values.

The rule for the engine is the same: every text of words in a package that the window uses is a phrase, since a message
reaches the window as an error, a warning, a step or a part of one, whatever function it passes through. Left out are
modules and functions that write another program's language, and texts with marks of code (`CODE`). That collects some
texts that no user meets, and misses none that arises in one piece.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Callable, Iterator
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
    "watch",
    "jobs",
    "project",
    "session",
)

#: Packages of the engine of which messages reach the window, each a context too, as "engine/capture".
ENGINE = (
    *("core", "storage", "images", "geometry", "light", "texel", "capture", "brdf", "factor", "shading", "surface"),
    *("scene", "transport", "render", "gl", "accuracy", "planning", "tradeoff", "bundle", "exchange"),
)

#: Functions whose texts no user of the window reads: names, patterns, queries and messages of the log.
SILENT = {
    *("ValueError", "TypeError", "KeyError", "RuntimeError", "AssertionError", "NotImplementedError", "TypeVar"),
    *("getattr", "setattr", "hasattr", "cast", "import_module", "getLogger", "debug", "info", "warning", "error"),
    *("exception", "execute", "executemany", "executescript", "setObjectName", "role", "property", "setProperty"),
    *("glob", "rglob", "startswith", "endswith", "removeprefix", "removesuffix", "findChild", "split", "rsplit"),
    *("partition", "strip", "replace", "encode", "decode", "with_suffix", "get", "pop", "sub", "fullmatch", "match"),
    *(
        "search",
        "findall",
        "compile",
        "Struct",
        "unpack",
        "warn",
        "_suffixes",
        "index",
        "count",
        "icon",
        "pixmap",
        "setStyleSheet",
        "QKeySequence",
        "QByteArray",
    ),
}

#: Texts that are no phrase: queries of the database, style sheets, mark-up, keys, and formats of the log.
NO_PHRASE = re.compile(
    r"\s*(?:CREATE|SELECT|INSERT|UPDATE|DELETE|Q[A-Z]\w+ \{|typeof|length\(|palette|%\()|.*[{;]\s*\n|<[a-z]|[A-Z_]+$|"
    r"(?:Ctrl|Shift|Alt)\+|[A-Za-z]*[a-z][A-Z]\w*$|Steps\[|%1\.[a-z]{2,8}$",
    re.DOTALL,
)

#: Modules of which no text is read: names of functions of Qt, and the style sheet with names of type faces.
SILENT_MODULES = ("language.py", "theme.py", "lanes.py", "batch/report.py", "batch/worker.py")

#: Modules of the engine that write or read another language alone: shaders, tags of cameras and of licences.
SILENT_IN_ENGINE = ("gl/program.py", "images/exif.py", "images/credits.py")

#: Marks of code in a text of the engine: patterns, signatures of kernels, XML, USD, glTF, shaders, and names.
CODE = re.compile(
    r"[\\{}@]|\[\]|<[!?/a-z ]|::1|[\";]$|^ {2,}|^\s*#\w|^= |^\w+\(|Array\(|^\.\*|HHII| = [\"<\[]|^\w+:\w+$|"
    r"\n(?:#|import)|\b(?:in|out)puts:|^const |metersPerUnit|colorSpace|-src '|JSON with|rmse_rel|^null |^\w+_\w+: |"
    r"^\s*(?:def|uniform|string|token|asset|rel|color|u?int|float\d?|bool) [\"%\w]+[ \"]|"
    r"^[A-Z]{3,}_|^[A-Z]+\d?$|^[A-Z]+[=:][A-Z]|_color "
)


#: Nodes of a syntax tree within which no text is, most of all.
_WITHOUT_TEXT = (ast.Name, ast.expr_context, ast.operator, ast.unaryop, ast.boolop, ast.alias)


def parse(path: Path) -> ast.Module:
    """The syntax tree of a module."""
    return ast.parse(path.read_text(encoding="utf-8"))


def find_phrases(node: ast.AST) -> Iterator[str]:
    """Texts of a syntax tree that a user may read; a value of a formatted string is %1, %2 …"""
    if isinstance(node, _WITHOUT_TEXT):
        return
    match node:
        case ast.Expr(value=ast.Constant()) | ast.Compare() | ast.Import() | ast.ImportFrom():
            return  # a docstring, or a text that only the program compares
        case ast.Assign(targets=[ast.Name(id="__all__")]):
            return
        case ast.AnnAssign():
            yield from find_phrases(node.value) if node.value else ()
        case ast.FunctionDef() | ast.AsyncFunctionDef():
            for each in (*node.args.defaults, *filter(None, node.args.kw_defaults), *node.body):
                yield from find_phrases(each)
        case ast.Subscript():
            yield from find_phrases(node.value)
        case ast.Call(func=ast.Attribute(value=ast.Constant(), attr="split")):
            return  # a list of names
        case ast.Call() if _name(node.func) in SILENT:
            yield from find_phrases(node.func)
        case ast.JoinedStr():
            yield from (text for text in [_template(node)] if is_phrase(text))
            for part in node.values:
                if isinstance(part, ast.FormattedValue):
                    yield from find_phrases(part.value)
        case ast.Constant(value=str()):
            yield from (text for text in [_number(str(node.value))] if is_phrase(text))
        case _:
            for child in ast.iter_child_nodes(node):
                yield from find_phrases(child)


def _name(function: ast.expr) -> str:
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def _template(node: ast.JoinedStr) -> str:
    return _number("".join(str(part.value) if isinstance(part, ast.Constant) else "{}" for part in node.values))


def _number(text: str) -> str:
    """`text` with %1, %2 … in place of its braces for values, as {} and {:.1f}."""
    numbers = iter(range(1, 1000))
    return re.sub(r"\{(?::[^{}]{1,9})?\}", lambda _: f"%{next(numbers)}", text)


def is_phrase(text: str) -> bool:
    """True for a text of words: several, or one that begins with a capital letter."""
    words = re.sub(r"%\d+|&", "", text)
    several = " " in words.strip() or words[:1].isupper() or (words != text and " " in text)
    return bool(several and re.search(r"[^\W\d_]{2}", words) and not NO_PHRASE.match(text))


def collect(parse: Callable[[Path], ast.Module] = parse) -> dict[str, list[str]]:
    """The phrases of each context, each phrase in the first one that has it; `parse` gives the tree of a module."""
    seen: set[str] = set()
    found: dict[str, list[str]] = {}
    for context, path in [(name, f"app/{name}") for name in CONTEXTS] + [(f"engine/{name}",) * 2 for name in ENGINE]:
        silent = {f"engine/{name}" for name in SILENT_IN_ENGINE} if context.startswith("engine/") else {*SILENT_MODULES}
        paths = sorted((PROJECT / path).rglob("*.py"))
        modules = [each for each in paths if not {each.name, f"{context}/{each.name}"} & silent]
        texts = [text for module in modules for text in find_phrases(parse(module))]
        texts = [text for text in texts if not (context.startswith("engine/") and CODE.search(text))]
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

    Contexts that are no package are kept, but for phrases that a package has: declarations of the engine that are
    composed, and forms for several things.
    """
    phrases = collect()
    for path in sorted(LANGUAGES.glob("*.ts")):
        before = read(path)
        known = {source: translation for context in before.values() for source, translation in context.items()}
        now = {name: {text: known.get(text, "") for text in texts} for name, texts in phrases.items()}
        collected = {source for context in now.values() for source in context}
        for name, context in before.items():
            if name not in phrases:
                now[name] = {source: text for source, text in context.items() if source not in collected}
        write(path, now)
        missing = sum(not translation for context in now.values() for translation in context.values())
        print(f"{path.name}: {sum(map(len, now.values()))} phrases, {missing} unfinished")
    return 0


if __name__ == "__main__":
    sys.exit(main())
