"""Light and view that change in turn: what is drawn is what a fresh image shows, whichever way was taken."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.steps import drain
from engine.geometry.camera import Camera
from engine.geometry.ground import Ground
from engine.render.transported import image_of
from engine.transport.baking.spatially_varying import Variation
from engine.transport.relight import RelightSh
from engine.transport.sh.bake import BakeSettings, bake, prepare
from engine.transport.sh.transfer import ShTransport, transfer
from engine.transport.sh_relight import Relighter
from tests.engine.transport.sh.test_transfer import small

EYES = (3.0, 1.0, 2.0), (-2.0, 3.0, 1.0)


@pytest.fixture
def transport(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> ShTransport:
    """A sphere on a ground whose gloss varies."""
    monkeypatch.setattr("engine.transport.sh.brdf_table.SAMPLES", 256)
    settings = BakeSettings(order=3, edge=8, fine=1)
    brdf, varied = brdf_from_text("ggx:kd=0.3/0.5/0.2,alpha=0.5,f0=0.04"), [Variation("alpha", 0.4, 0.5, "y")]
    work = drain(prepare(small(), brdf, settings, Ground(cells=4), varied))
    return drain(bake(tmp_path / "a.transport", work)).transport


def lights(near: int | None = None) -> list[np.ndarray]:
    shape = (9, 3) if near is None else (near, 9, 3)
    found = np.random.default_rng(5).normal(size=(2, *shape))
    found[..., 0, :] += 4.0
    return list(found)


def image(relit: RelightSh, eye: tuple[float, float, float]) -> np.ndarray:
    camera = Camera(eye, (0.0, 0.0, 0.0))
    return drain(image_of(relit, camera, (40, 30), 1)).image


@pytest.mark.parametrize("near", [False, True])
def test_fixed_light_and_fixed_view_show_the_same(transport: ShTransport, near: bool) -> None:
    shone = lights(len(transport.mesh.positions) if near else None)
    relighter = Relighter(transport)
    ways = []
    for light, eye in ((0, 0), (0, 1), (1, 1), (0, 1), (0, 1), (0, 0), (1, 1)):  # view, light, light, none, view, both
        relit = relighter.relit(shone[light], EYES[eye])
        ways.append("light" if relit.transport is transport else "view")
        assert relighter.is_for(relit, EYES[eye])
        assert relighter.is_for(relit, EYES[1 - eye]) == (ways[-1] == "light")
        fresh = image(RelightSh(transport, transfer(transport, shone[light])), EYES[eye])
        assert fresh[..., :3].max() > 0.0
        np.testing.assert_allclose(image(relit, EYES[eye]), fresh, atol=2e-5 * fresh.max())
    assert ways == ["light", "light", "view", "view", "view", "light", "light"]


def test_what_has_not_moved_is_not_worked_out_again(transport: ShTransport) -> None:
    relighter, shone = Relighter(transport), lights()
    first = relighter.relit(shone[0], EYES[0])
    assert relighter.relit(shone[0].copy(), EYES[1]) is first
    seen = relighter.relit(shone[1], EYES[1])
    assert relighter.relit(shone[1], EYES[1]) is seen
    vectors = relighter._vectors
    relighter.relit(shone[0], EYES[1])
    assert relighter._vectors is vectors


def test_a_diffuse_model_has_nothing_of_the_view_to_fix(tmp_path: Path) -> None:
    work = drain(prepare(small(), brdf_from_text("lambert"), BakeSettings(order=3, edge=8, fine=1)))
    diffuse = drain(bake(tmp_path / "a.transport", work)).transport
    relighter = Relighter(diffuse)
    for light in lights():
        assert relighter.relit(light, EYES[0]).transport is diffuse
