"""A certificate for all sides of a cluster with TLS, by openssl."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path


def can_make_certificates() -> bool:
    return shutil.which("openssl") is not None


def make_certificate(folder: Path) -> dict[str, str]:
    """Settings of Dask for one certificate of all sides, which signs itself, in files of `folder`."""
    key, cert = folder / "key.pem", folder / "cert.pem"
    words = ["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1", "-nodes"]
    words += ["-days", "2", "-subj", "/CN=localhost", "-keyout", os.fspath(key), "-out", os.fspath(cert)]
    subprocess.run(words, check=True, capture_output=True)
    sides = {
        f"distributed.comm.tls.{side}.{kind}" for side in ("client", "worker", "scheduler") for kind in ("key", "cert")
    }
    named = {name: os.fspath(key if name.endswith("key") else cert) for name in sides}
    return {**named, "distributed.comm.tls.ca-file": os.fspath(cert)}
