"""The rows of the View workspace for one method's bake: its settings, its cost, and the button."""

from __future__ import annotations

from typing import Any

from PySide6.QtWidgets import QComboBox

from app.document.bake_request import Made, Wanted
from app.view.baking import Baking
from app.view.planning import LOOKING
from app.widgets.controls import ComboBox
from app.widgets.labels import MIN_ERROR, NAMES
from app.widgets.panels import Rows, button, enable, line, text
from app.widgets.theme import STEP, role
from engine.core.figure_text import percent, size_text, time_text
from engine.core.params import Parameter, parameters
from engine.transport.method import Method

#: Effects that a plan may advise to leave out.
ADVISED = ("self-shadowing", "glossy", "anisotropy")


#: Error of a bake that follows another BRDF above which the panel warns.
POOR = 0.25


def choices_of(method: Method) -> tuple[Parameter, ...]:
    """The parameters that the panel offers for a method: of its bake, and of the light on a finished bake."""
    return tuple(each for of in (method.settings, method.light) for each in parameters(of) if each.offered)


class BakePanel(Rows):
    """Shows one `Baking` and begins or stops it."""

    def __init__(self, baking: Baking) -> None:
        super().__init__(baking.method.title)
        self.baking = baking
        self.choices: dict[str, QComboBox] = {}
        for parameter in choices_of(baking.method):
            self._choice(parameter)
        self.words = text("", "secondary", wrap=True)
        self.wide(self.words)
        self.go = button(
            "Bake", "primary", hint="Compute the light transport at each vertex, in the background (Ctrl+Enter)"
        )
        self.go.clicked.connect(self.baking.begin_or_stop)
        self.wide(self.go)
        self.grid.setRowMinimumHeight(self.grid.rowCount(), 2 * STEP)
        self.wide(line())
        self.grid.setRowMinimumHeight(self.grid.rowCount(), 2 * STEP)
        baking.changed.connect(self.refresh)
        self.refresh()

    def _choice(self, parameter: Parameter) -> None:
        choice, name = ComboBox(), parameter.name
        for value, words in parameter.offered:
            choice.addItem(words, value)
        choice.activated.connect(
            lambda _index: self.baking.choose(self.baking.choices.with_values({name: choice.currentData()}))
        )
        self.choices[name] = choice
        self.row(parameter.label, choice, f"{parameter.doc[:1].upper()}{parameter.doc[1:]}")

    def refresh(self) -> None:
        """Show the state of the bake."""
        baking = self.baking
        self.words.setText(state_text(baking))
        is_doubtful = baking.is_made and (baking.difference or _is_poor(baking.made))
        role(self.words, "warning" if is_doubtful else "secondary")
        running = baking.job is not None or baking.is_awaited
        self.go.setText("Stop baking" if running else "Bake")
        self.go.setVisible(running or not baking.is_made)
        estimate = baking.ready
        enable(self.go, "" if running or estimate is None else estimate.why_not)
        forced = baking.plan is not None and baking.plan.decision("interreflection").startswith("forced")
        for name, choice in self.choices.items():
            by_plan = forced and name == "interreflection"
            is_of_light = hasattr(baking.choices.light, name)
            why_fixed = "Forced under Effects" if by_plan else "" if is_of_light else "A bake is running"
            enable(choice, why_fixed if running or by_plan else "")
            _show(choice, (baking.chosen if by_plan else baking.choices).value(name))


def _show(choice: QComboBox, value: Any) -> None:
    """Show `value`, which may have been chosen elsewhere and be none of the usual ones."""
    if choice.findData(value) < 0:
        choice.addItem(str(value), value)
    choice.setCurrentIndex(choice.findData(value))


def state_text(baking: Baking) -> str:
    """The state of the bake for the user, in one to three sentences."""
    if baking.is_awaited:
        return f"{'Analysing the scene' if baking.is_planning else 'Preparing'}, then it bakes."
    if baking.job is not None:
        return f"{baking.job.step.note.capitalize() or 'Waiting'}. Until then the image shows {_show_values(baking)}."
    made, estimate = baking.made, baking.ready
    if baking.is_made and made is not None:
        took = f"Baked in {time_text(made.bake_s)}" if made.bake_s else "Baked"
        words = f"{took}, {size_text(made.size_bytes)}."
        found = (_describe_error(made), describe_left_out(made.wanted), baking.difference, _price_another(made))
        return " ".join(filter(None, (words, *found, "Light and camera move freely.")))
    takes = LOOKING if baking.is_planning else "Estimating…"
    if estimate is not None and estimate.why_not:
        takes = estimate.why_not
    elif estimate is not None:
        words = f"Baking takes about {time_text(estimate.bake_s)} and {size_text(estimate.size_bytes)}."
        takes = " ".join(filter(None, (words, describe_left_out(estimate.wanted), advice_text(baking))))
    reason = baking.why_stale or ("" if not baking.is_drawn else "This was not baked yet.")
    return " ".join(filter(None, (reason, takes, f"Until then the image shows {_show_values(baking)}.")))


def _price_another(made: Made) -> str:
    """'Another BRDF takes about 3 s.', where it takes a bake whose time is known."""
    if made.another_s is None or not made.why_baked_for_one:
        return ""
    return f"Another BRDF takes about {time_text(made.another_s)}."


def _describe_error(made: Made) -> str:
    """The method's own error where the bake was not compared with the reference."""
    if made.error is None or "error_rmse_rel" not in made.error:
        return ""
    said = f"Error {percent(made.error['error_rmse_rel'])} in the {made.error['error_env']}"
    return f"{said}: another mode, or more of this one, shows this BRDF better." if _is_poor(made) else f"{said}."


def _is_poor(made: Made | None) -> bool:
    return made is not None and made.error is not None and made.error.get("error_rmse_rel", 0.0) > POOR


def describe_left_out(wanted: Wanted) -> str:
    """'Not shown: shadows (12 %).': the effects left out, and the error of leaving them out."""
    parts = [
        NAMES[effect.effect].lower()
        + (f" ({percent(effect.estimated_error_rel)})" if effect.estimated_error_rel >= MIN_ERROR else "")
        for effect in wanted.left_out
    ]
    return f"Not shown: {', '.join(parts)}." if parts else ""


def advice_text(baking: Baking) -> str:
    """The effects that the plan would do without to save time or memory, and the place that switches them off."""
    effects = baking.plan.effects if baking.plan is not None else ()
    spared = [
        f"{NAMES[effect.effect].lower()} ({percent(effect.estimated_error_rel)})"
        for effect in effects
        if effect.effect in ADVISED and effect.decision == "skipped" and effect.estimated_error_rel >= MIN_ERROR
    ]
    return f"The plan leaves off {', '.join(spared)}: switch off under Effects." if spared else ""


def _show_values(baking: Baking) -> str:
    """The name of what stands for the bake on screen, with its error where that is known."""
    first = baking.first_image
    if first is not None:
        error = "" if first.error_rel is None else f" (error {percent(first.error_rel)} in the studio)"
        bare = " without interreflection" if baking.chosen.value("interreflection") else ""
        return f"a first image in spherical harmonics{bare}{error}"
    return "the previous bake" if baking.is_drawn else "direct light without shadows"
