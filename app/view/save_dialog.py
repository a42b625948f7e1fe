"""The dialog that saves an image of the View workspace, or a film of a turn of the model or of its light."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, get_args

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QDialog, QFileDialog, QHBoxLayout, QVBoxLayout, QWidget

from app.commands.images import Background, Saving
from app.document.modes import Mode
from app.widgets.controls import ComboBox
from app.widgets.number_field import NumberField
from app.widgets.panels import Rows, Segments, button, enable, text
from app.widgets.theme import PADDING, STEP
from engine.render.turntable import TURNS

#: Sizes that users ask for; that of the screen comes first.
SIZES = ((1280, 720), (1920, 1080), (2560, 1440), (3840, 2160), (7680, 4320), (1080, 1080))

BACKGROUNDS: dict[Background, str] = {
    "plain": "Plain grey",
    "environment": "Environment",
    "transparent": "Transparent",
}

TURN_NAMES = {"model": "The model", "light": "The light", "both": "Both together"}

ENDINGS = {
    "picture": "PNG (*.png);;OpenEXR, linear radiance (*.exr)",
    "turntable": "MP4 (*.mp4);;Animated WebP (*.webp);;Folder of PNG (*)",
}


class SaveDialog(QDialog):
    """Asks for the size and kind of an image; `chosen(saving)` follows when a place has been named as well."""

    chosen = Signal(object)

    def __init__(
        self, parent: QWidget, kind: str, screen_px: tuple[int, int], mode: Mode, why_no_sky: str, place: Path
    ) -> None:
        """`kind` is 'picture' or 'turntable'; `why_no_sky` says why no environment can be behind the model.

        `place` is the folder and the name, without its ending, that are proposed.
        """
        super().__init__(parent)
        assert set(BACKGROUNDS) == set(get_args(Background))
        self.screen_px, self.mode, self.place = screen_px, mode, place
        self.setWindowTitle("Save an image" if kind == "picture" else "Save a turntable")
        column = QVBoxLayout(self)
        column.setContentsMargins(2 * PADDING, PADDING, 2 * PADDING, PADDING)
        column.setSpacing(3 * STEP)
        self.kind = Segments((("picture", "Image", "One image"), ("turntable", "Turntable", "A film of one turn")))
        self.kind.choose(kind)
        self.kind.chosen.connect(lambda _kind: self._refresh())
        column.addWidget(self.kind)
        column.addWidget(self._make_size())
        self.still = self._make_still()
        self.film = self._make_film()
        column.addWidget(self.still)
        column.addWidget(self.film)
        self.background.model().item(1).setEnabled(not why_no_sky)  # type: ignore[attr-defined]
        self.background.setItemData(1, why_no_sky, 3)
        self.words = text("", "secondary", wrap=True)
        column.addWidget(self.words)
        column.addLayout(self._make_foot())
        self.setMinimumWidth(380)
        self._refresh()
        self.kind.buttons[kind].setFocus()

    def _make_size(self) -> Rows:
        rows = Rows()
        self.size_choice = ComboBox()
        self.size_choice.addItem(f"As on screen, {self.screen_px[0]} × {self.screen_px[1]}", self.screen_px)
        for width, height in SIZES:
            self.size_choice.addItem(f"{width} × {height}", (width, height))
        self.size_choice.activated.connect(lambda _at: self._take_size(self.size_choice.currentData()))
        rows.row("Size", self.size_choice, "Any size: images beyond the limit of the graphics device come in tiles")
        self.width_field = self._number(float(self.screen_px[0]), 2.0, 65536.0, "px")
        self.height_field = self._number(float(self.screen_px[1]), 2.0, 65536.0, "px")
        rows.row("Width", self.width_field)
        rows.row("Height", self.height_field)
        self.background = ComboBox()
        for value, words in BACKGROUNDS.items():
            self.background.addItem(words, value)
        self.background.activated.connect(lambda _at: self._refresh())
        rows.row("Background", self.background, "What is behind the model")
        self.blur = self._number(0.0, 0.0, 90.0, "°")
        rows.row("Blur", self.blur, "Blur of the environment behind the model, as an angle; the light stays as it is")
        self.paths = self._number(64.0, 1.0, 65536.0, "")
        rows.row("Samples", self.paths, "Paths of each pixel: four times as many halve the noise")
        return rows

    def _make_still(self) -> Rows:
        rows = Rows()
        self.layers = QCheckBox("Albedo and normals in .exr")
        self.layers.setToolTip("Layers in the same file; the reference always has its standard error")
        rows.wide(self.layers)
        return rows

    def _make_film(self) -> Rows:
        rows = Rows()
        self.turns = ComboBox()
        for turns in TURNS:
            self.turns.addItem(TURN_NAMES[turns], turns)
        rows.row("What turns", self.turns, "The model before a light that rests, the light, or both as one")
        self.seconds = self._number(4.0, 0.1, 300.0, "s")
        rows.row("Length", self.seconds, "Of one full turn")
        self.fps = self._number(30.0, 1.0, 120.0, "")
        rows.row("Frames/s", self.fps)
        return rows

    def _make_foot(self) -> QHBoxLayout:
        self.go = button("Save…", "primary", hint="Choose a place, and draw in the background")
        self.go.setDefault(True)
        self.go.clicked.connect(self._ask)
        cancel = button("Cancel")
        cancel.clicked.connect(self.reject)
        row = QHBoxLayout()
        row.addStretch(1)
        row.addWidget(cancel)
        row.addWidget(self.go)
        return row

    def _number(self, value: float, low: float, high: float, unit: str) -> NumberField:
        field = NumberField(value, low, high, unit=unit)
        field.edited.connect(lambda _value, _final: self._refresh())
        return field

    def _take_size(self, size: tuple[int, int]) -> None:
        self.width_field.show_value(float(size[0]))
        self.height_field.show_value(float(size[1]))
        self._refresh()

    @property
    def is_film(self) -> bool:
        return self.kind.value == "turntable"

    def saving(self, path: Path) -> Saving:
        """The choices, for the file `path`."""
        count = max(2, round(self.seconds.value * self.fps.value)) if self.is_film else 0
        return Saving(
            path=path,
            size=(round(self.width_field.value), round(self.height_field.value)),
            background=self.background.currentData(),
            blur_deg=self.blur.value,
            frames=count,
            turns=self.turns.currentData(),
            fps=self.fps.value,
            paths=round(self.paths.value),
            layers=self.layers.isChecked(),
        )

    def _refresh(self) -> None:
        self.still.setVisible(not self.is_film)
        self.film.setVisible(self.is_film)
        has_sky = self.background.currentData() == "environment"
        enable(self.blur, "" if has_sky else "Only an environment behind the model can be blurred")
        enable(self.paths, "" if self.mode.progressive else "Only the reference draws with random paths")
        saving = self.saving(Path("a.webp" if self.is_film else "a.png"))
        about = (
            f"{saving.frames} frames, drawn as {self.mode.label}." if self.is_film else f"Drawn as {self.mode.label}."
        )
        self.words.setText(saving.why_not or about)
        enable(self.go, saving.why_not)

    def _ask(self) -> None:
        """Ask for a place; an ending that is left out is that of the chosen kind."""
        endings = ENDINGS[self.kind.value]
        proposed = free(self.place, ".mp4" if self.is_film else ".png")
        chosen, kind = QFileDialog.getSaveFileName(self, self.windowTitle(), str(proposed), endings)
        if not chosen:
            return
        path = Path(chosen)
        if not path.suffix and "*." in kind:
            path = path.with_name(f"{path.name}.{kind.rpartition('*.')[2].rstrip(')')}")
        saving = self.saving(path)
        if saving.why_not:
            self.words.setText(saving.why_not)
            return
        self.accept()
        self.chosen.emit(saving)


def free(place: Path, ending: str) -> Path:
    """`place` with its ending, and with a number where such a file is there: nothing has to be replaced."""
    paths = (place.with_name(f"{place.name}{number}{ending}") for number in ("", *(f" {n}" for n in range(2, 1000))))
    return next((path for path in paths if not path.exists()), place.with_name(place.name + ending))


def ask(parent: QWidget, kind: str, take: Callable[[Any], None], **about: Any) -> SaveDialog:
    """Open the dialog; `take` gets the `Saving` that the user chose."""
    dialog = SaveDialog(parent, kind, **about)
    dialog.chosen.connect(take)
    dialog.finished.connect(dialog.deleteLater)
    dialog.open()
    return dialog
