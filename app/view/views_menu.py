"""The views of the model: its sides, and those that a user keeps, which belong to the project."""

from __future__ import annotations

import itertools

from PySide6.QtWidgets import QMenu, QWidget

from app.document.open_document import Document
from app.viewport.viewport import VIEWS, Viewport

#: Views that a project keeps, at most.
MAXIMUM = 12


class ViewsMenu(QMenu):
    """Leads the camera of `viewport`; kept views are steps of the history of `document`."""

    def __init__(self, document: Document, viewport: Viewport, parent: QWidget) -> None:
        super().__init__(parent)
        self.document, self.viewport = document, viewport
        self.aboutToShow.connect(self.fill)
        self.fill()

    def fill(self) -> None:
        """The views that there are now."""
        self.clear()
        for side in VIEWS:
            self.addAction(side).triggered.connect(lambda _on=False, side=side: self.viewport.look_along(side))
        self.addSeparator()
        views = self.document.project.views
        for name, camera in views.items():
            self.addAction(name).triggered.connect(lambda _on=False, camera=camera: self.viewport.look_from(camera))
        keep = self.addAction("Keep this view")
        keep.setEnabled(self.viewport.camera is not None and len(views) < MAXIMUM)
        keep.triggered.connect(lambda _on=False: self.keep())
        if views:
            forget = self.addMenu("Forget")
            for name in views:
                forget.addAction(name).triggered.connect(lambda _on=False, name=name: self.forget(name))

    def keep(self) -> None:
        """Keep the view of now under a name that is free."""
        views, camera = self.document.project.views, self.viewport.camera
        if camera is not None and len(views) < MAXIMUM:
            name = next(each for at in itertools.count(1) if (each := f"View {at}") not in views)
            self.document.change(f"Keep {name}", views={**views, name: camera})

    def forget(self, name: str) -> None:
        """Keep a view no longer."""
        views = {each: camera for each, camera in self.document.project.views.items() if each != name}
        self.document.change(f"Forget {name}", views=views)
