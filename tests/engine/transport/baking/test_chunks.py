"""Bakes on a cluster: the same file, whatever happens to its workers, and words where it cannot be used."""

from __future__ import annotations

import importlib
import os
import signal
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from engine.brdf.brdf import brdf_from_text
from engine.core.budget import thread_count
from engine.core.cluster import measure_cluster
from engine.core.errors import InputError, MissingCapability
from engine.core.steps import Steps, drain
from engine.geometry.ground import Ground
from engine.geometry.shapes import open_mesh
from engine.light.cube_map import cube_of
from engine.light.environment_file import open_environment
from engine.transport.baking import chunks
from engine.transport.baking.chunks import Chunk, Recipe, Remote, run
from engine.transport.gaussian import bake as gaussian_bake
from engine.transport.sh import bake as sh_bake
from engine.transport.wavelet import bake as wavelet_bake
from engine.transport.wavelet.bake import BakeSettings, Work, bake, factors_for, prepare
from tests.engine.core.certificate import can_make_certificates, make_certificate
from tests.engine.transport.gaussian.gaussian_lobes import icosphere

distributed = pytest.importorskip("distributed")
dask = pytest.importorskip("dask")


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """Two workers, each a process of its own, that find MAKERS; by TLS where there is a certificate."""
    folder = tmp_path_factory.mktemp("makers")
    (folder / "makers.py").write_text(MAKERS)
    sys.path.insert(0, str(folder))
    words: dict[str, Any] = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "dashboard_address": None}
    settings = make_certificate(folder) if can_make_certificates() else {}
    with dask.config.set(settings):
        if settings:
            words |= {"protocol": "tls://", "security": distributed.Security(require_encryption=True)}
        with distributed.LocalCluster(silence_logs=50, **words) as found:
            assert found.scheduler_address.startswith("tls://" if settings else "tcp://")
            yield found
    sys.path.remove(str(folder))


def maker(name: str) -> Any:
    return getattr(importlib.import_module("makers"), name)


@pytest.fixture
def work(monkeypatch: pytest.MonkeyPatch) -> Work:
    """A ball on a ground, in several chunks."""
    monkeypatch.setattr(wavelet_bake, "CHUNK_TEXELS", 400 * 6 * 8 * 8)
    factors = drain(factors_for(brdf_from_text("phong:exponent=5"), 2))
    settings = BakeSettings(8, 20, 2, bounces=2, gather=16)
    return prepare(icosphere(1), factors, settings, Ground(cells=30, albedo=0.3))


@pytest.mark.parametrize("kills", [1, pytest.param(8, marks=pytest.mark.long)])
def test_a_cluster_bakes_the_same_wavelets_and_a_killed_worker_costs_no_more_than_its_chunks(
    cluster: Any, work: Work, tmp_path: Path, kills: int
) -> None:
    here, there = tmp_path / "here.transport", tmp_path / "there.transport"
    bounces = drain(bake(here, work)).transport.bounces
    assert bounces is not None
    assert bounces.counts.max() == 10
    work = replace(work, kept=tmp_path / "seen")
    bake_and_kill(bake(there, work, cluster.scheduler_address), cluster, kills)
    assert there.read_bytes() == here.read_bytes()
    assert len(list(tmp_path.iterdir())) == 3
    assert not wavelet_bake.casts_rays(work), "what the workers saw is kept"


@pytest.mark.parametrize("kills", [0, pytest.param(3, marks=pytest.mark.long)])
def test_a_cluster_bakes_the_same_harmonics_and_the_light_between_parts(
    cluster: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, kills: int
) -> None:
    monkeypatch.setattr(sh_bake, "CHUNK_VALUES", 200 * 6 * 8 * 8)
    monkeypatch.setattr("engine.transport.sh.brdf_table.SAMPLES", 256)
    here, there = tmp_path / "here.transport", tmp_path / "there.transport"
    settings = sh_bake.BakeSettings(3, 8, 2, bounces=2, gather=16)
    ground = Ground(cells=20, albedo=0.3)
    asked = drain(sh_bake.prepare(open_mesh("plane"), brdf_from_text("phong:exponent=5"), settings, ground))
    assert asked.plan.chunks > 2
    drain(sh_bake.bake(here, asked))
    asked = replace(asked, kept=tmp_path / "seen")
    bake_and_kill(sh_bake.bake(there, asked, cluster=cluster.scheduler_address), cluster, kills)
    assert there.read_bytes() == here.read_bytes()
    assert [*(tmp_path / "seen").iterdir()], "what the workers saw is kept"


@pytest.mark.parametrize("kills", [0, pytest.param(5, marks=pytest.mark.long)])
def test_a_cluster_bakes_the_same_gaussians_whenever_workers_are_killed(
    cluster: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, kills: int
) -> None:
    """Two lobes, so that neighbours are made to agree; blocks of few vertices; and a record of visibility."""
    monkeypatch.setattr("engine.transport.gaussian.fitting.fit.BLOCK", 2)
    here, there = tmp_path / "here.transport", tmp_path / "there.transport"
    settings = gaussian_bake.BakeSettings(lobes=2, samples=16, edge=8, fine=1, indirect=kills > 0)
    brdf, studio = brdf_from_text("ggx:kd=0.3,alpha=0.3,f0=0.2"), ("studio", cube_of(open_environment("studio"), 8))
    mesh, ground = icosphere(1 if kills else 0), Ground(cells=2)
    work = drain(gaussian_bake.prepare(mesh, brdf, settings, ground, (), studio, probes=2))
    assert len(work.parts) > 4
    drain(gaussian_bake.bake(here, work))
    work = replace(work, kept=tmp_path / "seen")
    bake_and_kill(gaussian_bake.bake(there, work, cluster.scheduler_address), cluster, kills)
    assert there.read_bytes() == here.read_bytes()
    assert settings.indirect or not gaussian_bake.casts_rays(work), "what the workers saw is kept"


def bake_and_kill(steps: Steps[Any], cluster: Any, kills: int) -> None:
    """Go through a bake and kill a random worker at so many random places of it."""
    random = np.random.default_rng(1)
    due = sorted(random.random(kills).tolist())
    for step in steps:
        if due and step.done >= due[0]:
            alive = [each.process.pid for each in cluster.workers.values() if each.process and each.process.pid]
            if alive:
                os.kill(int(random.choice(alive)), signal.SIGKILL)
                due.pop(0)
    assert not due


def test_threads_of_a_machine_are_shared_by_its_workers_and_the_connection_is_measured(cluster: Any) -> None:
    threads, link = measure_cluster(cluster.scheduler_address)
    assert threads == [0.5 * thread_count()] * 2
    assert link.bytes_per_s > 0.0
    assert link.latency_s > 0.0


def worker_processes(cluster: Any) -> list[int]:
    """Processes of both workers, once another has taken the place of one that was killed."""
    with distributed.Client(cluster, set_as_default=False) as client:
        client.wait_for_workers(2)
        return list(client.run(os.getpid).values())


#: A module of its own that the workers can import; they cannot import this file.
MAKERS = """
from engine.transport.baking.chunks import Chunk
def numbered(recipe):
    return lambda number: Chunk(number, {"rows": [number * recipe["factor"]] * 2}, 0.0)
def failing(recipe):
    raise RuntimeError("no way")
"""


def nothing(_number: int) -> Chunk:
    raise AssertionError("not here")


def test_chunks_come_from_here_or_there_in_any_order_and_can_be_given_up(cluster: Any) -> None:
    remote = Remote(cluster.scheduler_address, maker("numbered"), {"factor": np.float64(2.0)})
    for found in (list(run(remote.maker(remote.recipe), range(9))), list(run(nothing, range(9), remote))):
        assert sorted(chunk.number for chunk in found) == list(range(9))
        assert all(chunk.rows["rows"] == [2.0 * chunk.number] * 2 for chunk in found)
    assert list(run(nothing, [], remote)) == []
    some = run(nothing, range(100), remote)
    next(some)
    some.close()


def unknown(_recipe: Recipe) -> Any:
    """A maker that workers do not find, wherever they look for modules."""


unknown.__module__ = "makers_of_another_version"


def test_what_workers_cannot_do_is_said_and_leaves_them_alive(cluster: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    address, before = cluster.scheduler_address, worker_processes(cluster)
    for faulty, words in {maker("failing"): "no way", unknown: "No module named"}.items():
        with pytest.raises(InputError, match=f"could not do its part .*{words}"):
            list(run(nothing, [0], Remote(address, faulty, {})))
    monkeypatch.setattr(cast(Any, chunks).engine, "__version__", "99.0")
    with pytest.raises(InputError, match=r"not 99\.0.*Install Lightarc 99\.0"):
        list(run(nothing, [0], Remote(address, maker("numbered"), {})))
    assert set(worker_processes(cluster)) == set(before)


def test_a_scheduler_that_goes_away_is_said(cluster: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    def is_gone(*_words: Any) -> None:
        raise distributed.comm.CommClosedError("it went away")

    monkeypatch.setattr(distributed.Client, "nthreads", is_gone)
    with pytest.raises(InputError, match=r"could not do its part .it went away.*goes on where it stopped"):
        list(run(nothing, [0], Remote(cluster.scheduler_address, maker("numbered"), {"factor": 1.0})))


def test_a_cluster_that_is_not_there_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.core.cluster.PATIENCE_S", 0.3)
    with pytest.raises(InputError, match="no scheduler of a cluster answers"):
        list(run(nothing, [0], Remote("tcp://127.0.0.1:9", unknown, {})))
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(MissingCapability, match="pip install distributed"):
        list(run(nothing, [0], Remote("tcp://127.0.0.1:9", unknown, {})))
