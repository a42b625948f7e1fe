"""The rows of the View workspace that tell of one method's bake: its settings, what it takes, and the button."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from PySide6.QtWidgets import QComboBox

from app.accuracy import share_text
from app.bake_work import Method, Wanted
from app.baking import Baking
from app.effect_names import LEAST_ERROR, NAMES
from app.number_field import plain
from app.panels import Rows, button, enable, line, text
from app.planning import LOOKING
from app.theme import STEP

#: Values of a choice and what they are called, where that is not the number itself.
Values = tuple[tuple[Any, str], ...]


def _numbers(*values: int) -> Values:
    return tuple((value, str(value)) for value in values)


PLANNED: Values = ((None, "As planned"), (False, "Left out"), (True, "With"))

TITLES: dict[Method, str] = {"sh": "Harmonics", "wavelet": "Wavelets", "gaussian": "Gaussians"}

#: For each method the fields of `BakeChoices` that it has, what they are called, their values, and what they are for.
CHOICES: dict[Method, tuple[tuple[str, str, Values, str], ...]] = {
    "sh": (
        ("order", "Order", _numbers(3, 5, 7, 9, 12, 15), "Bands: more of them keep sharper light and highlights"),
        ("interreflection", "Bounced light", PLANNED, "Light that parts of the model send each other"),
        (
            "window",
            "Window",
            (("none", "None"), ("hanning", "Hanning"), ("lanczos", "Lanczos")),
            "Damps high bands against ringing, at the price of blurred light; asks for no bake",
        ),
    ),
    "wavelet": (
        ("terms", "Terms", _numbers(1, 2, 4, 8), "Products that the reflectance is made of: glossy ones need more"),
        ("coefficients", "Coefficients", _numbers(32, 64, 96, 200, 400), "Kept for each vertex: more keep more shadow"),
        ("edge", "Cube", _numbers(16, 32, 64), "Texels along a face of the map of light: more keep sharper shadows"),
        (
            "occluder_cells",
            "Shaded by",
            ((0, "The model"), (128, "128 cells"), (64, "64 cells"), (32, "32 cells")),
            "What casts shadows: the model, or a simpler one, whose rays are quicker",
        ),
    ),
    "gaussian": (
        (
            "lobes",
            "Lobes",
            _numbers(1, 2, 3),
            "Gaussians for each vertex and view: more follow partly shaded highlights",
        ),
        ("interreflection", "Bounced light", PLANNED, "Highlights of light that comes by way of the model"),
    ),
}


class BakePanel(Rows):
    """Shows one `Baking` and begins or stops it."""

    def __init__(self, baking: Baking) -> None:
        super().__init__(TITLES[baking.method])
        self.baking = baking
        self.choices: dict[str, QComboBox] = {}
        for name, label, values, hint in CHOICES[baking.method]:
            self._choice(name, label, values, hint)
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

    def _choice(self, name: str, label: str, values: Values, hint: str) -> None:
        choice = QComboBox()
        for value, words in values:
            choice.addItem(words, value)
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
        estimate = baking.ready
        why_not = estimate.why_not if estimate is not None else "What the bake takes is being estimated"
        enable(self.go, "" if running else why_not)
        forced = baking.plan is not None and baking.plan.decision("interreflection").startswith("forced")
        for name, choice in self.choices.items():
            by_plan = forced and name == "interreflection"
            why_fixed = "Forced under Effects" if by_plan else "A bake is running" if name != "window" else ""
            enable(choice, why_fixed if running or by_plan else "")
            _show(choice, getattr(baking.chosen if by_plan else baking.choices, name))


def _show(choice: QComboBox, value: Any) -> None:
    """Show `value`, which may have been chosen elsewhere and be none of the usual ones."""
    if choice.findData(value) < 0:
        choice.addItem(str(value), value)
    choice.setCurrentIndex(choice.findData(value))


def state_text(baking: Baking) -> str:
    """What a person has to know of the bake, in one to three sentences."""
    if baking.job is not None:
        return f"{baking.job.step.note.capitalize() or 'Waiting'}. Until then the picture shows {_shown(baking)}."
    made, estimate = baking.made, baking.ready
    if baking.is_made and made is not None:
        words = f"Baked in {time_text(made.bake_s)}, {size_text(made.size_bytes)}."
        return " ".join(filter(None, (words, left_out_text(made.wanted), "Light and camera move freely.")))
    takes = LOOKING if baking.is_planning else "Estimating…"
    if estimate is not None and estimate.why_not:
        takes = estimate.why_not
    elif estimate is not None:
        words = f"Baking takes about {time_text(estimate.bake_s)} and {size_text(estimate.size_bytes)}."
        takes = " ".join(filter(None, (words, left_out_text(estimate.wanted))))
    reason = baking.why_stale or ("" if not baking.is_drawn else "This was not baked yet.")
    return " ".join(filter(None, (reason, takes, f"Until then the picture shows {_shown(baking)}.")))


def left_out_text(wanted: Wanted) -> str:
    """'The plan leaves out shadows, and gloss at 0.2 %.': what is not worked out, and what that costs."""
    parts = [
        NAMES[effect.effect].lower()
        + (f" ({share_text(effect.estimated_error_rel)})" if effect.estimated_error_rel >= LEAST_ERROR else "")
        for effect in wanted.left_out
    ]
    return f"Left out as planned: {', '.join(parts)}." if parts else ""


def _shown(baking: Baking) -> str:
    return "the bake before" if baking.is_drawn else "direct light without shadows"


def time_text(seconds: float) -> str:
    """'12 s' or '2:10 min'."""
    whole = max(1, round(seconds))
    return f"{whole} s" if whole < 60 else f"{whole // 60}:{whole % 60:02d} min"


def size_text(size_bytes: int) -> str:
    """'84 MB'."""
    return f"{plain(float(f'{size_bytes / 1e6:.2g}'))} MB" if size_bytes < 1e9 else f"{size_bytes / 1e9:.1f} GB"
