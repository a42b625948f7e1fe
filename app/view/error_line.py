"""The error of the image in the View workspace, as the status bar shows it, and what was compared."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject

from app.view.image_error import ImageError
from engine.core.figure_text import percent, percent_range

if TYPE_CHECKING:
    from app.view.tab import ViewTab
    from app.widgets.status_bar import StatusBar

#: Said in place of a figure that is on its way; a "…" alone looks cut.
COMING = "being measured"

CERTAINTY = "The true error lies within ± of this value in 95 % of all cases."


class ErrorLine(QObject):
    """Follows the images of `view`; until their error is known it shows the prediction of the plan."""

    def __init__(self, status: StatusBar, view: ViewTab) -> None:
        super().__init__()
        self.status, self.view = status, view
        for changed in (view.error_found, view.planning.changed, view.setting_changed, view.images.progressed):
            changed.connect(lambda *_what: self.refresh())

    def refresh(self) -> None:
        """Show the error as far as it is known."""
        images, error = self.view.images, self.view.images.error
        if not self.view.isVisible() or not images.modes:
            self.status.show_image_error(None)
        elif error is not None:
            self.status.show_image_error(f"{error.text} ({self._compared})", self._hint(error))
        elif len(images.modes) > 1 or self.view.images.progressive is not None:
            self.status.show_image_error(COMING, "The images are not complete yet")
        else:
            self.status.show_image_error(*self._expect())

    @property
    def _compared(self) -> str:
        """What the error is of: the mode on screen and what it is compared with."""
        names = [mode.label for mode in self.view.images.modes]
        if self.view.images.progressive is not None and len(names) == 1:
            return "noise of the reference"
        return f"{names[0]} against {names[1] if len(names) > 1 else 'the reference'}"

    def _hint(self, error: ImageError) -> str:
        """The tooltip: the two compared images, the pixels and the samples."""
        images, where = self.view.images, f"{error.pixels:,} pixels".replace(",", "\u202f")
        samples = f"{error.samples} sample{'s' * (error.samples != 1)}"
        if images.progressive is not None and len(images.modes) == 1:
            return f"The noise of the reference after {samples} of each of {where}.\n{CERTAINTY}"
        words = f"{self._compared}: relative RMSE of linear radiance on {where}"
        if not error.samples:
            return f"{words}."
        return f"{words}; the reference has {samples} of each.\n{CERTAINTY}"

    def _expect(self) -> tuple[str, str]:
        """The text and tooltip before the error is known."""
        why_not, predicted = self.view.images.why_no_error, self.view.planning.predicted(self.view.setting)
        if predicted is not None:
            coming = "" if why_not or not self.view.images.measuring else " It is measured once the image rests."
            error, interval = predicted
            sentence = f"The error that the plan predicts: {percent_range(*interval)} in 95 of 100 scenes.{coming}"
            return f"≈ {percent(error)} predicted", sentence
        if why_not:
            return "–", f"There is no reference to compare with. {why_not}."
        if not self.view.images.measuring:
            return "", ""
        return COMING, "Measured against a reference that refines in the background, once the image rests"
