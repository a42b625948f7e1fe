"""Every text of the window: in words of the field, and accessible names and roles, read from one window."""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any

import pytest
from PySide6.QtCore import QLocale, Qt, QTranslator
from PySide6.QtGui import QAccessible, QColor
from PySide6.QtWidgets import QAbstractScrollArea, QApplication, QComboBox, QLabel, QTabBar, QWidget

from app.widgets import accessible, language, theme
from app.window.main_window import MainWindow
from app.window.top_bar import WORKSPACES
from benchmarks.app.faults import cut
from engine.core.errors import VERBS
from engine.core.figure_text import write_with
from tests.app.conftest import open_window
from tests.app.visible_text import read
from tests.app.window.test_keys_and_themes import contrast
from tests.app.window.test_main_window import fill, is_quiet, wait
from tests.test_architecture import tree_of
from tests.test_words import OLD_IN_WINDOW, PROJECT

LANGUAGES = PROJECT / "resources" / "language"

#: Workspaces in which a light is one of the scene; in the others a lamp stands before the sample.
RENDERED = ("view", "varying", "viewport")


#: Names of people, files and programs, and what the test has put into the window.
NAMES = re.compile(
    r"a rather long name|has something to say|^Test$|lightarc-|/tmp|pytest|^/|\.(?:tif|lap|png|json|exr|lightarc)\b|"
    r"Undo Fill"
)

#: A word that a translation must have, and words that are English alone.
WORD = re.compile(r"[^\W\d_]{4}")
ENGLISH = re.compile(r"\b(?:the|of|is|are|and|with|not|this|for|by|from|light|image|what|which)\b")


def load_translate() -> Any:
    spec = spec_from_file_location("translate", PROJECT / "packaging" / "translate.py")
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


translate = load_translate()


@pytest.fixture(scope="module")
def phrases() -> dict[str, list[str]]:
    """Texts of the sources that the window may show, by context."""
    return dict(translate.collect(tree_of))


@pytest.fixture(scope="module")
def whole(qapp: QApplication, tmp_path_factory: pytest.TempPathFactory) -> Iterator[MainWindow]:
    """One window for all tests of this file, with all workspaces and a material with findings of every kind."""
    folder = tmp_path_factory.mktemp("home")
    with pytest.MonkeyPatch.context() as monkeypatch:
        for name in ("CACHE", "CONFIG", "DATA"):
            monkeypatch.setenv(f"XDG_{name}_HOME", str(folder / name.lower()))
        with open_window(monkeypatch, WORKSPACES) as made:
            fill(made)
            yield made


def test_texts_of_the_window_are_in_words_of_the_field(whole: MainWindow) -> None:
    shown = {text for _, text in read(whole)}
    assert len(shown) > 900, "the walk has lost most of the window"
    assert [f"{found[0]}: {text}" for text in sorted(shown) for found in OLD_IN_WINDOW.finditer(text)] == []


def test_texts_that_the_window_may_show_are_in_words_of_the_field(phrases: dict[str, list[str]]) -> None:
    found = [
        f"{context}: {match[0]}: {text}"
        for context, texts in phrases.items()
        for text in texts
        for match in (OLD_IN_WINDOW.search(text), context in RENDERED and re.search(r"\blamps? |\bLamps?\b", text))
        if match
    ]
    assert found == []


@pytest.mark.parametrize("path", sorted(LANGUAGES.glob("*.ts")), ids=lambda path: path.stem)
def test_every_text_of_the_sources_has_a_translation(path: Path, phrases: dict[str, list[str]]) -> None:
    known = {source for context in translate.read(path).values() for source, text in context.items() if text}
    missing = {context: [text for text in texts if text not in known] for context, texts in phrases.items()}
    assert {context: texts for context, texts in missing.items() if texts} == {}, "run packaging/translate.py"


def test_values_of_a_text_are_values_of_its_translation() -> None:
    """A translation may say less than a text, as where a plural has a form of its own, and never asks for more."""
    for path in LANGUAGES.glob("*.ts"):
        pairs = [pair for context in translate.read(path).values() for pair in context.items()]
        for source, text in pairs:
            assert {*re.findall(r"%\d+", text)} <= {*re.findall(r"%\d+", source)}, source
            assert text.count("\n") == source.count("\n"), source


@pytest.fixture
def german() -> Iterator[None]:
    """The German translations, without the replaced setters: the window stays as it is."""
    language._load("de")
    yield
    language._load("en")


def test_every_text_of_the_window_has_a_translation(whole: MainWindow, german: None) -> None:
    shown = {text for _, text in read(whole)}
    published = {text for text in shown if "Lafortune fits" in text}
    shown -= published | {text.split("\n")[0] for text in published}  # names and sources of published materials
    english = {text: language.translate(text) for text in shown if not NAMES.search(text)}
    found = [f"{text!r}: {new!r}" for text, new in english.items() if is_english(text, new)]
    assert "\n".join(sorted(found)) == ""


def is_english(text: str, new: str) -> bool:
    """True for a text of words without a translation, or one with words that are English alone."""
    return (language.find_translation(text) is None and bool(WORD.search(text))) or bool(ENGLISH.search(new))


def test_a_text_is_translated_whole_by_its_template_and_part_by_part(german: None) -> None:
    assert language.translate("3 of 12 selected") == "3 von 12 ausgewählt"
    assert language.translate("1 project") == "1 Projekt"
    assert language.translate("2 projects") == "2 Projekte"
    assert language.translate("felt of wool.obj does not exist") == "felt of wool.obj existiert nicht"
    assert language.translate("No photograph is used. Nothing was changed.") == (
        "Kein Foto wird verwendet. Nichts wurde geändert."
    )
    assert language.translate("Aligning 8 of 10 · 30 s left") == "8 von 10 wird ausgerichtet · noch 30 s"
    assert language.translate("House of stone") == "House of stone", "no short template takes a name apart"
    assert language.translate("12.5 ms") == "12.5 ms"


def test_what_the_engine_says_of_a_file_is_translated_with_the_remedy(
    german: None, phrases: dict[str, list[str]]
) -> None:
    texts = [text for name, each in phrases.items() if name.startswith("engine/") for text in each]
    said = [re.sub(r"%\d", "12", text) for text in texts if text.split(" ", 1)[0] in VERBS and not text.endswith(" ")]
    assert len(said) > 400
    shown = {text: f"felt.tif {text}.\nExport it as PLY.\n\n/photos/felt.tif" for text in said}
    new = {text: language.translate(message) for text, message in shown.items()}
    end = ".\nAls PLY exportieren.\n\n/photos/felt.tif"
    assert {text: each for text, each in new.items() if ENGLISH.search(each) or not each.endswith(end)} == {}
    assert not {text for text, each in new.items() if each.startswith(f"felt.tif {text}")}


def test_findings_about_many_photographs_are_translated(german: None) -> None:
    assert language.translate("and 4 more are noisy: their mean is 2 to 6 times the noise") == (
        "und 4 weitere: jedes ist verrauscht: sein Mittel ist das 2 bis 6-fache des Rauschens"
    )
    assert language.translate(
        "a b.tif and 4 more: 3 % of the pixels are clipped; a shorter exposure would keep them"
    ) == ("a b.tif und 4 weitere: 3 % der Pixel sind übersteuert; eine kürzere Belichtung würde sie erhalten")


def test_a_text_that_stands_behind_another_is_translated_with_it(german: None) -> None:
    worst = (
        "a.tif is predicted from the others with an error of 68 % of its mean radiance, the worst of all (and 1 more)"
    )
    assert language.translate(worst) == (
        "a.tif wird aus den anderen mit einem Fehler von 68 % seiner mittleren Strahldichte vorhergesagt, am "
        "schlechtesten von allen (und 1 weitere)"
    )
    assert language.translate("a.tif: 3 % of the pixels are black (and 2 more)") == (
        "a.tif: 3 % der Pixel sind schwarz (und 2 weitere)"
    )


def test_numbers_that_the_engine_wrote_with_a_point_are_in_the_form_of_the_language(german: None) -> None:
    write_with(",")
    assert language.translate("a.tif is noisy: its mean is 2.5 times the noise.") == (
        "a.tif ist verrauscht: sein Mittel ist das 2,5-fache des Rauschens."
    )
    write_with(".")
    assert language.translate("alignment left 1.5 px") == "die Ausrichtung ließ 1.5 px übrig"


def test_a_setter_translates_its_first_text_and_no_data(german: None) -> None:
    shown: list[Any] = []
    setter = language._translating(lambda *given: shown.append(given))
    setter(3, "Open", "open")
    setter(3, ["Job", "Time", ""])
    assert shown == [(3, "Öffnen", "open"), (3, ["Auftrag", "Zeit", ""])]


@pytest.mark.long
def test_no_german_words_are_cut_off(qapp: QApplication, qtbot: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    language.use("de", qapp)
    try:
        with open_window(monkeypatch, WORKSPACES) as window:
            fill(window)
            window.resize(1280, 800)
            for name in WORKSPACES:
                window.show_workspace(name)
                wait(qtbot, lambda: is_quiet(window))
                qtbot.wait(60)
                assert cut(window) == [], name
            assert QLabel("Open").text() == "Öffnen"
    finally:
        language._load("en")
        for translator in qapp.findChildren(QTranslator):
            qapp.removeTranslator(translator)
        QLocale.setDefault(QLocale.system())


def test_screen_readers_know_name_and_role_of_all_that_takes_keys_or_is_painted(whole: MainWindow) -> None:
    accessible.install()
    nameless = []
    for widget in whole.findChildren(QWidget):
        is_stated = getattr(widget, "accessible_role", None) is not None
        takes_keys = bool(widget.focusPolicy() & Qt.FocusPolicy.TabFocus) and not isinstance(widget, QTabBar)
        if not (is_stated or takes_keys) or isinstance(widget.parentWidget(), QComboBox | QAbstractScrollArea):
            continue  # a part of another control
        interface = QAccessible.queryAccessibleInterface(widget)
        is_popup = widget.window() is not whole
        if not is_popup and (
            not interface.text(QAccessible.Text.Name)
            or interface.role() in (QAccessible.Role.Client, QAccessible.Role.NoRole)
        ):
            nameless.append(f"{type(widget).__name__} in {type(widget.parentWidget()).__name__}")
    assert "\n".join(sorted(nameless)) == ""


@pytest.mark.parametrize("name", list(theme.THEMES))
def test_text_and_focus_of_each_theme_can_be_told_from_what_is_behind_them(name: str) -> None:
    """WCAG 2.1, level AA: 4.5 for text (what is disabled is exempt), 3 for the edge of what has the focus."""
    colours = theme.THEMES[name]
    pairs = [
        (ink, behind) for ink in ("text", "secondary") for behind in ("window", "panel", "field", "hover", "canvas")
    ]
    pairs += [(ink, behind) for ink in ("accent", "good", "warning", "bad") for behind in ("window", "panel", "field")]
    pairs += [("on_accent", "accent"), ("on_accent", "accent_hover")]
    values = {pair: contrast(*(QColor(getattr(colours, use)) for use in pair)) for pair in pairs}
    assert {pair: round(value, 2) for pair, value in values.items() if value < 4.5} == {}
    for behind in ("window", "panel", "field"):
        assert contrast(QColor(colours.accent), QColor(getattr(colours, behind))) >= 3.0


def test_each_control_shows_the_focus() -> None:
    sheet = theme._sheet()
    controls = ("QPushButton", "QToolButton", "QLineEdit", "QComboBox", "QCheckBox", "QAbstractItemView")
    assert [control for control in controls if f"{control}:focus" not in sheet] == []
