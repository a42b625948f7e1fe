"""Fixtures that all tests share, and campaigns: tests marked `long`, which run with `--long` only.

A campaign is best an ordinary test repeated with other seeds: `@pytest.mark.campaign(rounds=25)` and an argument `seed`
give one run with seed 0 in every suite and 24 more with `--long`. The name of a test holds its seed, so that
naming it repeats it; `--seed` repeats all campaigns with one seed. What fails is kept (`tests.kept`).
"""

from __future__ import annotations

import gc
import hashlib
import math
import os
from collections.abc import Callable, Iterator
from pathlib import Path

import platformdirs
import pytest
from hypothesis import HealthCheck, settings

from engine.accuracy import bake_check
from engine.core.steps import Steps
from engine.storage import untrusted

# The time of an example depends on the machine and its load, not on the code.
untimed = settings(settings.default, deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("untimed", untimed)
settings.load_profile("untimed")

PROJECT = Path(__file__).resolve().parents[1]

# Nothing of what is collected is garbage, and to look for some takes a fifth of the time; tests begin with it on.
gc.disable()

# Kernels are compiled once for all checkouts with the same packages (`engine.core.kernel_cache`), not once for each;
# and shaders by Mesa once for all tests, of which many have a cache folder of their own.
_PACKAGES = hashlib.sha256((PROJECT / "packaging" / "requirements-test.lock").read_bytes()).hexdigest()[:16]
_COMPILED = platformdirs.user_cache_path("lightarc-tests")
os.environ.setdefault("NUMBA_CACHE_DIR", str(_COMPILED / f"kernels-{_PACKAGES}"))
os.environ.setdefault("MESA_SHADER_CACHE_DIR", str(_COMPILED))

SHARED_DATA = PROJECT.parent / "shared" / "data"

#: Seconds after which a test of a campaign is taken to hang.
LONG_TIMEOUT_S = 3600


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("campaigns")
    group.addoption("--long", action="store_true", help="run the campaigns as well (-m long: nothing else)")
    group.addoption("--share", type=float, default=1.0, help="part of each campaign that is run, 0.01 for a hundredth")
    group.addoption("--seed", type=int, help="run each campaign with this seed alone")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "long: takes minutes or hours, and runs with --long only")
    config.addinivalue_line("markers", "dressed: the window has its style sheet (`tests.app.conftest`)")
    config.addinivalue_line("markers", "checked_bakes: bakes end with their check, as those of users do")
    config.addinivalue_line("markers", "campaign(rounds): repeat with seeds 1 to rounds - 1 under --long")


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    campaign = metafunc.definition.get_closest_marker("campaign")
    if campaign is None:
        return
    chosen = metafunc.config.getoption("--seed")
    rounds = math.ceil(campaign.kwargs["rounds"] * metafunc.config.getoption("--share"))
    seeds = range(rounds if metafunc.config.getoption("--long") else 1) if chosen is None else [chosen]
    marks = {seed: [pytest.mark.long] if seed and chosen is None else [] for seed in seeds}
    metafunc.parametrize("seed", [pytest.param(seed, id=f"seed{seed}", marks=marks[seed]) for seed in seeds])


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    campaigns = [item for item in items if item.get_closest_marker("long")]
    for item in campaigns:
        item.add_marker(pytest.mark.timeout(LONG_TIMEOUT_S))
    if campaigns and not config.getoption("--long"):
        config.hook.pytest_deselected(items=campaigns)
        items[:] = [item for item in items if item not in set(campaigns)]


def pytest_collection_finish() -> None:
    """Set modules and collected tests aside: each search for garbage would look at all of these objects again."""
    gc.collect()
    gc.freeze()
    gc.enable()


@pytest.fixture(scope="session", autouse=True)
def no_waiting_for_the_disk() -> Iterator[None]:
    """Files of tests need not outlive a loss of power; `atomic.fault` still sees whether they are synchronised."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(os, "fsync", lambda _descriptor: None)
        yield


@pytest.fixture(scope="session", autouse=True)
def one_origin() -> Iterator[None]:
    """Files of all tests share their decoder processes, also after a damaged one, so that few have to start.

    Of each kind one may wait: the tests of a file often open photographs, models and bundles in turn.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(untrusted, "_origin", lambda _path: "tests")
        patch.setattr(untrusted, "IDLE", 12)
        yield


@pytest.fixture(scope="session", autouse=True)
def typefaces_listed_once() -> Iterator[None]:
    """The list of typefaces that matplotlib makes in 2 s, kept for all tests and the processes that they start."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MPLCONFIGDIR", str(PROJECT / "build" / "matplotlib"))
        yield


@pytest.fixture(scope="session", autouse=True)
def bakes_without_check() -> Iterator[Callable[..., Steps[object]]]:
    """Leave out the comparison with the reference that ends each bake and takes seconds; gives what was left out."""

    def leave_out(*_words: object) -> Steps[None]:
        yield from ()

    left_out = bake_check.check_bake
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bake_check, "check_bake", leave_out)
        yield left_out


@pytest.fixture(autouse=True)
def _bakes_with_check(
    request: pytest.FixtureRequest, bakes_without_check: Callable[..., Steps[object]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Bakes end as those of users do in tests that are marked `checked_bakes`."""
    if request.node.get_closest_marker("checked_bakes") is not None:
        monkeypatch.setattr(bake_check, "check_bake", bakes_without_check)


@pytest.fixture(scope="session")
def shared_data() -> Callable[[str], Path]:
    """Path of a real file beside the project; the test that asks for an absent one is skipped, naming it."""

    def find(name: str) -> Path:
        path = SHARED_DATA / name
        if not path.exists():
            pytest.skip(f"{name} is absent: the folder shared/data does not lie beside the project")
        return path

    return find
