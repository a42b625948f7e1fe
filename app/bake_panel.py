"""The rows of the View workspace that tell of one method's bake: its settings, what it takes, and the button."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtWidgets import QComboBox

from app.baking import BakeChoices, Baking
from app.number_field import plain
from app.panels import Rows, button, enable, line, text
from app.theme import STEP

ORDERS = (3, 5, 7, 9, 12, 15)
TERMS = (1, 2, 4, 8, 12)
EDGES = (16, 32, 64)


class BakePanel(Rows):
    """Shows one `Baking` and begins or stops it."""

    def __init__(self, baking: Baking) -> None:
        super().__init__("Harmonics" if baking.method == "sh" else "Wavelets")
        self.baking = baking
        self.choices: dict[str, QComboBox] = {}
        if baking.method == "sh":
            self._choice("order", "Order", ORDERS, "Bands of harmonics: more of them keep sharper light and highlights")
        else:
            self._choice("terms", "Terms", TERMS, "Products that the reflectance is made of: glossy ones need more")
            self._choice(
                "edge", "Cube", EDGES, "Texels along a face of the cube map of light: more keep sharper shadows"
            )
        self.words = text("", "secondary", wrap=True)
        self.wide(self.words)
        self.go = button("Bake", "primary", hint="Work out what light does at each vertex, in the background")
        self.go.clicked.connect(lambda: self.baking.cancel() if self.baking.job is not None else self.baking.bake())
        self.wide(self.go)
        self.grid.setRowMinimumHeight(self.grid.rowCount(), 2 * STEP)
        self.wide(line())
        self.grid.setRowMinimumHeight(self.grid.rowCount(), 2 * STEP)
        baking.changed.connect(self.refresh)
        self.refresh()

    def _choice(self, name: str, label: str, values: tuple[int, ...], hint: str) -> None:
        choice = QComboBox()
        for value in values:
            choice.addItem(str(value), value)
        choice.setCurrentIndex(choice.findData(getattr(BakeChoices(), name)))
        choice.activated.connect(
            lambda _index: self.baking.choose(replace(self.baking.choices, **{name: choice.currentData()}))
        )
        self.choices[name] = choice
        self.row(label, choice, hint)

    def refresh(self) -> None:
        """Say how things stand."""
        baking = self.baking
        self.words.setText(state_text(baking))
        running = baking.job is not None
        self.go.setText("Stop baking" if running else "Bake")
        self.go.setVisible(running or not baking.is_made)
        enable(self.go, "" if running or baking.estimate is not None else "What the bake takes is being estimated")
        for choice in self.choices.values():
            enable(choice, "A bake is running" if running else "")


def state_text(baking: Baking) -> str:
    """What a person has to know of the bake, in one to three sentences."""
    if baking.job is not None:
        return f"{baking.job.step.note.capitalize() or 'Waiting'}. Until then the picture shows {_shown(baking)}."
    made, estimate = baking.made, baking.estimate
    if baking.is_made and made is not None:
        return f"Baked in {time_text(made.bake_s)}, {size_text(made.size_bytes)}. Light and camera move freely."
    takes = "Estimating…"
    if estimate is not None:
        takes = f"Baking takes about {time_text(estimate.bake_s)} and {size_text(estimate.size_bytes)}."
    reason = baking.why_stale or ("" if not baking.is_drawn else "These settings were not baked yet.")
    return " ".join(filter(None, (reason, takes, f"Until then the picture shows {_shown(baking)}.")))


def _shown(baking: Baking) -> str:
    return "the bake before" if baking.is_drawn else "direct light without shadows"


def time_text(seconds: float) -> str:
    """'12 s' or '2:10 min'."""
    whole = max(1, round(seconds))
    return f"{whole} s" if whole < 60 else f"{whole // 60}:{whole % 60:02d} min"


def size_text(size_bytes: int) -> str:
    """'84 MB'."""
    return f"{plain(float(f'{size_bytes / 1e6:.2g}'))} MB" if size_bytes < 1e9 else f"{size_bytes / 1e9:.1f} GB"
