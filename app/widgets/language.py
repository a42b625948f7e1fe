"""The language of the window: one function translates every text that reaches the screen.

Texts are written in English where they arise, also in declarations and messages of the engine, which knows no window.
`use` lets the setters of Qt (`SETTERS`) pass them through `translate`, so that no caller has to think of it; in English
nothing is replaced. The translations are `resources/language/LANGUAGE.ts`, in the format of Qt Linguist, read as they
are; `packaging/translate.py` keeps them in step with the sources.

A text is found whole, or by a template: "%1 of %2 selected" stands for the formatted string with two values, which are
translated in turn, since they may be texts again. What is said of a file is found behind its name. Failing that, the
sentences of a text and the parts of a list are translated one by one; what is in no translation, as the name of a file,
stays. Templates are looked up by their rarest words; a text costs some 0.1 ms once, and is remembered.
"""

from __future__ import annotations

import functools
import re
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from html import unescape
from itertools import chain
from typing import Any

from PySide6.QtCore import QLibraryInfo, QLocale, QTranslator
from PySide6.QtGui import QAction, QFontMetrics, QFontMetricsF, QPainter, QUndoCommand, QUndoStack
from PySide6.QtWidgets import (
    QAbstractButton,
    QApplication,
    QCheckBox,
    QComboBox,
    QDockWidget,
    QFileDialog,
    QInputDialog,
    QLabel,
    QLineEdit,
    QListWidgetItem,
    QMenu,
    QMenuBar,
    QMessageBox,
    QPlainTextEdit,
    QPushButton,
    QTableWidget,
    QTableWidgetItem,
    QToolTip,
    QTreeWidget,
    QTreeWidgetItem,
    QWidget,
)

from app.widgets.resources import RESOURCES
from engine.core.errors import VERBS
from engine.core.figure_text import local
from engine.core.health import pluralise

#: Languages of the window by their codes, each by its own name.
LANGUAGES = {"en": "English", "de": "Deutsch"}

#: The functions of Qt that take a text for the screen; their first text is it.
SETTERS: dict[type, str] = {
    QLabel: "__init__ setText",
    QAbstractButton: "setText",
    QPushButton: "__init__",
    QCheckBox: "__init__",
    QAction: "__init__ setText setToolTip",
    QWidget: "setToolTip setWindowTitle setAccessibleName setAccessibleDescription",
    QComboBox: "addItem insertItem setItemText setItemData setPlaceholderText",
    QLineEdit: "setPlaceholderText",
    QPlainTextEdit: "setPlaceholderText",
    QDockWidget: "__init__",
    QMenu: "__init__ addAction addMenu setTitle",
    QMenuBar: "addMenu",
    QMessageBox: "__init__ setText setInformativeText addButton",
    QInputDialog: "setLabelText",
    QListWidgetItem: "__init__ setText setToolTip",
    QTableWidget: "setHorizontalHeaderLabels",
    QTableWidgetItem: "__init__ setText setToolTip",
    QTreeWidget: "setHeaderLabels",
    QTreeWidgetItem: "__init__ setText setToolTip",
    QUndoCommand: "__init__ setText",
    QUndoStack: "createUndoAction createRedoAction",
    QPainter: "drawText",
    QFontMetrics: "horizontalAdvance elidedText boundingRect",
    QFontMetricsF: "horizontalAdvance elidedText boundingRect",
}

#: Functions that ask for a file, with a caption and a choice of kinds.
FILE_DIALOGS = ("getOpenFileName", "getOpenFileNames", "getSaveFileName", "getExistingDirectory")

#: Boundaries of the sentences and of the parts of a text, in the order in which they are tried.
SENTENCES = (re.compile(r"(\n)"), re.compile(r"( · )"), re.compile(r"((?<=[.!?…]) )"))
PARTS = tuple(map(re.compile, (r"(; )", r"(: )", r"(, )", r"([.:…]{1,3}$)", r"( \(|\)$)", r"(^[●○] {1,2})")))

#: Templates with fewer letters (the second where a value begins them), or of one word behind a value, as '%1 lights',
#: hold for values that are single words, numbers or texts with a translation; the shortest not for single words.
SHORT, SHORT_BEHIND, SHORTEST = 8, 12, 4

_MESSAGE = re.compile(r"<source>([^<]{1,2000}+)</source>\s{0,99}+<translation>([^<]{1,3000}+)</translation>")
_WORD = re.compile(r"[^\W\d_]{2}")
_NO_LETTER = re.compile(r"[\W\d_]")
_NUMBER = re.compile(r"[−-]?[\d.,\u202f]{1,24}(?:$|\W)")
_VALUE = re.compile(r"%(\d{1,2})")
_END, _LINE_END = re.compile(r"[.!?] |\n| · "), re.compile(r"\n")
_MARK = re.compile(r"[.:…]{1,3}$")

#: A number with a point, as the engine writes many, and the unit behind it.
_PLAIN = re.compile(r"([−-]?\d{1,9}+\.\d{1,9}+)( ?[^\s\d.,]{1,4})?$")

#: Sources of a finding that are only counted, and verbs behind one source by those behind several.
_MORE = re.compile(r"and \d{1,9} more(?=:? )")
_ADDED = re.compile(r"(?<=.)(?:[.,;] | \()")
_LINE = re.compile(r"[Ll]ine \d{1,9} ")
_THEIR = re.compile(r"\btheir\b")
_SINGULAR = {pluralise(verb): verb for verb in VERBS}

#: A mark or a key behind a phrase: '.', '…', ' (Ctrl+P)'.
_BEHIND = re.compile(r"[.:…]{1,3}$| \((?:[A-Z]|[A-Z][a-z]{1,8}\+\w{1,9})\)$")


@dataclass(frozen=True)
class Template:
    """A formatted string: its `pieces` between the values, the names of these, and the translation."""

    pieces: tuple[str, ...]
    names: tuple[str, ...]
    translation: str

    def find_values(self, text: str) -> list[str] | None:
        """The values with which the template is `text`, each as short as it can be; None where it is another text.

        No value has a line break, and none in a template of one sentence goes beyond that or a part behind '·'.
        """
        (first, *middle), last = self.pieces[:-1], self.pieces[-1]
        if len(text) < len(first) + len(last) or not (text.startswith(first) and text.endswith(last)):
            return None
        values, rest = [], text[len(first) : len(text) - len(last)]
        for piece in middle:
            value, found, rest = rest.partition(piece) if piece else ("", True, rest)
            if not found:
                return None
            values.append(value)
        values.append(rest)
        beyond = _LINE_END if any(_END.search(piece) for piece in self.pieces) else _END
        return None if any(beyond.search(value) for value in values) else values


_phrases: dict[str, str] = {}

#: Templates by their number of letters, the most first, and the places of those whose rarest word it is.
_templates: list[tuple[int, str]] = []
_with_word: dict[str, list[int]] = {}


def choose(wanted: str) -> str:
    """The code of the language for the preference `wanted`; 'system' is the first one that the system prefers."""
    preferred = [wanted] if wanted != "system" else [each.partition("-")[0] for each in QLocale.system().uiLanguages()]
    return next((code for code in preferred if code in LANGUAGES), "en")


def locale_of(wanted: str) -> QLocale:
    """The forms of numbers of the language `wanted`."""
    return QLocale.system() if wanted == "system" else QLocale(wanted)


def use(language: str, application: QApplication) -> None:
    """Show all texts in `language` from now on, a code of `LANGUAGES`, and those of Qt's own dialogs."""
    _load(language)
    if language == "en":
        return
    QLocale.setDefault(QLocale(language))
    translator = QTranslator(application)
    if translator.load(f"qtbase_{language}", QLibraryInfo.path(QLibraryInfo.LibraryPath.TranslationsPath)):
        application.installTranslator(translator)
    _replace_setters()


def _load(language: str) -> None:
    global _phrases, _templates, _with_word
    _phrases, _templates, _with_word = {}, [], {}
    find_translation.cache_clear()
    _template.cache_clear()
    path = RESOURCES / "language" / f"{language}.ts"
    if not path.is_file():
        return
    messages = _MESSAGE.findall(path.read_text(encoding="utf-8"))
    _phrases = {unescape(source): unescape(translation) for source, translation in messages if translation}
    for source in [source for source in _phrases if source != source.strip()]:  # stands beside others, or alone
        _phrases.setdefault(source.strip(), _phrases[source].strip())
    sources = [source for source in _phrases if _VALUE.search(source)]
    _templates = sorted(((len(_NO_LETTER.sub("", source)), source) for source in sources), key=lambda each: -each[0])
    words = [[word for word in source.split(" ") if "%" not in word] for _, source in _templates]
    uses = Counter(chain.from_iterable(words))
    for place, each in enumerate(words):
        _with_word.setdefault(min(each, key=uses.__getitem__, default=""), []).append(place)


@functools.cache
def _template(source: str) -> Template:
    pieces = _VALUE.split(source)
    return Template(tuple(pieces[::2]), tuple(pieces[1::2]), _phrases[source])


def translate(text: str) -> str:
    """`text` in the language of the window; what has no translation stays as it is."""
    return (find_translation(text) or text) if _phrases else text


@lru_cache(maxsize=16384)
def find_translation(text: str) -> str | None:
    """The translation of `text`, or None where no part of it has one."""
    bare = text.strip()
    if not bare:
        return None
    if bare != text:
        whole = _phrases.get(text) or _fill_template(text, SHORT)
        inner = None if whole else find_translation(bare)
        return whole or (inner and text.replace(bare, inner, 1))
    if found := _find_phrase(bare):
        return found
    if not _WORD.search(bare):
        return None
    return (
        _fill_template(bare, SHORT_BEHIND)
        or _translate_statement(bare)
        or _fill_template(bare, SHORT)
        or _translate_addition(bare)
        or _translate_parts(bare, SENTENCES)
        or _fill_template(bare, SHORTEST)
        or _translate_end(bare)
        or _fill_template(bare, 0)
        or _translate_parts(bare, PARTS)
    )


def _find_phrase(text: str) -> str | None:
    """A phrase as it is, with a mark or a key behind it, or with its first letter in the other case."""
    phrase, behind = text, ""
    if text not in _phrases and (found := _BEHIND.search(text)):
        phrase, behind = text[: found.start()], found[0]
    if phrase in _phrases:
        return _phrases[phrase] + behind
    other = _phrases.get(_other_case(phrase))
    return other and (_other_case(other) if phrase[:1].isupper() and other[:1].islower() else other) + behind


def _other_case(text: str) -> str:
    return text[:1].swapcase() + text[1:]


def _fill_template(text: str, letters: int, start: str = "") -> str | None:
    """The translation of the template with the most letters, and no fewer than `letters`, that `text` fits.

    Only templates that begin with `start` count. The text may have a mark more than the template behind it, and a
    capital where the template has none.
    """
    bare = _MARK.sub("", text)
    forms = [(bare, text[len(bare) :]), (text, "")] if bare != text else [(text, "")]
    if text[:1].isupper() and letters >= SHORT:
        forms += [(_other_case(form), mark) for form, mark in forms]
    words = {"", *(word for form, _ in forms for word in form.split(" "))}
    for place in sorted(chain.from_iterable(_with_word.get(word, ()) for word in words)):
        if _templates[place][0] < letters:
            return None
        if not _templates[place][1].startswith(start):
            continue
        for form, mark in forms:
            if form[:1] == text[:1]:
                new = _fill(*_templates[place], form)
            elif new := _fill(*_templates[place], form, is_other_case=True):
                new = new[:1].upper() + new[1:]
            if new:
                return new + mark
    return None


def _fill(size: int, source: str, text: str, *, is_other_case: bool = False) -> str | None:
    """The translated template `source` of `size` letters with the values of `text`; None where it is another."""
    template = _template(source)
    values = template.find_values(text)
    if values is None:
        return None
    known = [find_translation(value) or _write_number(value) for value in values]
    doubtful = [value for value, new in zip(values, known, strict=True) if not new and not _NUMBER.match(value)]
    is_word = source.count(" ") < 2
    is_short = size < SHORT or (not template.pieces[0] and (size < SHORT_BEHIND or is_word))
    is_shortest = size < SHORTEST or (is_word and is_other_case)  # 'Material made' is none of 'material %1'
    if (doubtful and is_shortest) or (is_short and any(" " in value for value in doubtful)):
        return None
    new = {name: new or value for name, value, new in zip(template.names, values, known, strict=True)}
    return _VALUE.sub(lambda found: new[found[1]], template.translation)


def _write_number(value: str) -> str | None:
    """A number that the engine has written with a point, in the form of the user's language."""
    return f"{local(found[1])}{found[2] or ''}" if (found := _PLAIN.match(value)) else None


def _translate_statement(text: str) -> str | None:
    """What is said of a file behind its name: 'felt.obj is %1 wide', 'a.tif and 4 more are noisy'."""
    words = text.split(" ")
    for place, word in enumerate(words[:9]):
        name, rest = " ".join([*words[:place], ""]), " ".join(words[place:])
        if word == "and" and (more := _MORE.match(rest)):
            verb, _, said = rest[more.end() :].lstrip(": ").partition(" ")
            said = f"{_SINGULAR.get(verb, verb)} {_THEIR.sub('its', said)}"
            each = _fill_template(f"{more[0]}: each" if verb in _SINGULAR else f"{more[0]}:", SHORTEST)
            return f"{name}{each} {find_translation(said) or said}" if each else None
        if word in VERBS and (phrase := _find_phrase(rest) or _fill_template(rest, SHORTEST)):
            line = _LINE.fullmatch(name) and _fill_template(name.lower(), SHORTEST)
            return f"{line or name}{phrase}"
        said = rest.partition(" ")[2]
        if word.endswith(":") and (phrase := _find_phrase(said) or _fill_template(said, SHORT)):
            return f"{find_translation(name + word) or name + word} {phrase}"
        if word.endswith(".") or "\n" in word:
            return None
    return None


def _translate_addition(text: str) -> str | None:
    """A text with another one that begins by a mark, since it stands behind others alone: ', the worst of all'."""
    for found in _ADDED.finditer(text):
        addition = text[found.start() :]
        if new := _phrases.get(addition) or _fill_template(addition, SHORTEST, found[0]):
            first = text[: found.start()]
            return (find_translation(first) or first) + new
    return None


def _translate_end(text: str) -> str | None:
    """A name with a phrase behind it: 'felt.obj is damaged'."""
    words = text.split(" ")
    for place in range(1, min(len(words) - 1, 8)):
        rest = " ".join(words[place:])
        if words[place - 1][-1:] not in ",;:" and rest[:1].islower() and (phrase := _find_phrase(rest)):
            return f"{' '.join(words[:place])} {phrase}"
    return None


def _translate_parts(text: str, boundaries: Sequence[re.Pattern[str]]) -> str | None:
    """The parts of `text` between the first of the boundaries that it has, one by one."""
    for boundary in boundaries:
        parts = boundary.split(text, 1)
        known = [find_translation(part) if part != text else None for part in parts]
        if any(known):
            return "".join(new or part for part, new in zip(parts, known, strict=True))
    return None


@functools.cache
def _replace_setters() -> None:
    for owner, names in SETTERS.items():
        for name in names.split():
            setattr(owner, name, _translating(getattr(owner, name)))
    QToolTip.showText = staticmethod(_translating(QToolTip.showText))  # type: ignore[method-assign]
    for name in FILE_DIALOGS:
        setattr(QFileDialog, name, staticmethod(_asking(getattr(QFileDialog, name))))


def _translating(setter: Callable[..., Any]) -> Callable[..., Any]:
    """`setter` with the translation of its first text, or of a list of texts."""

    @functools.wraps(setter)
    def show(*given: Any, **more: Any) -> Any:
        arguments = list(given)
        for at, argument in enumerate(arguments):
            if isinstance(argument, str):
                arguments[at] = translate(argument)
                break
            if isinstance(argument, list | tuple) and all(isinstance(each, str) for each in argument):
                arguments[at] = [translate(each) for each in argument]
                break
        return setter(*arguments, **more)

    return show


def _asking(dialog: Callable[..., Any]) -> Callable[..., Any]:
    """A dialog for files with its caption and kinds translated; the chosen kind comes back as it was given."""

    @functools.wraps(dialog)
    def ask(parent: QWidget, caption: str = "", folder: str = "", kinds: str = "", **more: Any) -> Any:
        shown = dict(zip(translate(kinds).split(";;"), kinds.split(";;"), strict=True))
        answer = dialog(parent, translate(caption), folder, *([";;".join(shown)] if kinds else []), **more)
        return (answer[0], shown.get(answer[1], answer[1])) if isinstance(answer, tuple) else answer

    return ask
