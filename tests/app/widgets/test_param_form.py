"""Forms of parameters: those of all BRDF models have room in a panel."""

from __future__ import annotations

from typing import Any

import pytest

from app.widgets.labels import BRDF_LABELS
from app.widgets.panels import SCROLL_BAR, WIDTH
from app.widgets.param_form import ParamForm
from app.widgets.theme import PADDING
from engine.brdf.brdf import MODELS
from engine.core.params import parameters


@pytest.mark.parametrize("name", MODELS)
def test_forms_of_models_have_room_in_a_panel(qtbot: Any, name: str) -> None:
    """A panel does not scroll sideways: what has no room is cut off."""
    brdf = MODELS[name]()
    form = ParamForm(brdf, {each.name: BRDF_LABELS.get(each.name, each.label) for each in parameters(brdf)})
    qtbot.addWidget(form)
    assert form.minimumSizeHint().width() <= WIDTH - 2 * PADDING - SCROLL_BAR
