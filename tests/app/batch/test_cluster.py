"""A batch on a cluster with TLS: the same results, also where a worker is killed."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import Any

import pytest

from app.batch.captures import find_captures
from app.batch.record import open_record
from app.batch.run import Settings, make_batch
from engine.core.errors import InputError
from engine.core.steps import drain
from tests.engine.core.certificate import can_make_certificates, make_certificate

distributed = pytest.importorskip("distributed")
dask = pytest.importorskip("dask")

pytestmark = pytest.mark.skipif(
    os.name == "nt" or not can_make_certificates(),
    reason="no openssl makes a certificate, or no SIGKILL ends workers",
)

FAST = "tests.app.batch.fast:make"


@pytest.mark.long
def test_a_killed_worker_costs_no_capture(tmp_path: Path) -> None:
    source, output = tmp_path / "source", tmp_path / "results"
    output.mkdir()
    for name in ("one", "two", "three", "four", "refuse"):
        (source / name).mkdir(parents=True)
        (source / name / "a.png").write_bytes(name.encode())
    with (
        dask.config.set(make_certificate(tmp_path)),
        distributed.LocalCluster(
            n_workers=2,
            threads_per_worker=1,
            protocol="tls://",
            security=distributed.Security(require_encryption=True),
            dashboard_address=None,
            silence_logs=50,
        ) as cluster,
    ):
        address = cluster.scheduler_address
        assert address.startswith("tls://")
        with distributed.Client(cluster, set_as_default=False) as client:
            workers = list(client.run(os.getpid).values())
        with open_record(output) as record:
            captures, killed = find_captures([str(source)]), False
            for step in make_batch(output, record, captures, Settings(cluster=address), FAST):
                if not killed and any(row.state == "running" for row in step.partial or ()):
                    os.kill(workers[0], signal.SIGKILL)
                    killed = True
            rows = {row.capture.name: row for row in record.rows()}
    assert {name: row.state for name, row in rows.items() if row.state != "done"} == {"refuse": "failed"}
    assert "is <b>no</b> capture" in rows["refuse"].reason
    assert sorted(path.name for path in output.iterdir() if path.is_dir()) == ["four", "logs", "one", "three", "two"]


def test_a_cluster_that_is_not_there_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Captures wait then; they have not failed."""
    monkeypatch.setattr("engine.core.cluster.PATIENCE_S", 0.3)
    (tmp_path / "one").mkdir()
    (tmp_path / "one" / "a.png").write_bytes(b"a")
    settings: Any = Settings(cluster="tcp://127.0.0.1:9")
    with open_record(tmp_path) as record:
        with pytest.raises(InputError, match="no scheduler of a cluster answers"):
            drain(make_batch(tmp_path, record, find_captures([str(tmp_path / "one")]), settings, FAST))
        assert [row.state for row in record.rows()] == ["waiting"]
