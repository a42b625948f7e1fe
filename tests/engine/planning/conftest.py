"""Costs of a machine that never was, and ways to plan with them."""

from __future__ import annotations

import pytest

from engine.planning.choices import SHARE
from engine.planning.costs.cost_model import NAMES, CostModel
from engine.planning.effects.estimates import Scenery, estimates


def every_rate() -> CostModel:
    """Every rate is a microsecond and doubles where its parameter does; frames are cheap, as on a graphics card."""
    tables = dict.fromkeys(NAMES, ((1.0, 1e-06), (16.0, 1.6e-05), (64.0, 6.4e-05)))
    shares = ("-pixel", "-pixel-each", "-vertex-each")
    cheap = {name: ((1.0, 1e-9 if name.endswith("pixel") else 1e-10),) for name in NAMES if name.endswith(shares)}
    return CostModel("machine", "processor", {**tables, **cheap})


@pytest.fixture(scope="session")
def costs() -> CostModel:
    return every_rate()


def threshold(scene: Scenery, effect: str) -> float:
    """The budget from which on the effect may be left out: it, and all that are worth less."""
    found = estimates(scene)
    own = found[effect].error_rel
    errors = [each.error_rel for name, each in found.items() if name != "all-frequency-light"]
    return sum(error for error in errors if error <= own) / SHARE
