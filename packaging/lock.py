"""Make the lock files anew from pyproject.toml, for every platform and Python ≥ 3.11.

    python3 packaging/lock.py [--upgrade]

Needs uv (`python3 -m pip install uv`). Versions already locked are kept where they still fit; `--upgrade` takes the
newest ones. The tests' lock, with what builds the manual, is made under the constraint of the first, so that tests run
on what users get.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1]
RUN, TEST = "packaging/requirements.lock", "packaging/requirements-test.lock"
OPTIONS = "--universal --generate-hashes --no-emit-index-url --no-header --no-annotate --python-version 3.11"


def main() -> int:
    if not shutil.which("uv"):
        print("uv is missing. Type: python3 -m pip install uv", file=sys.stderr)
        return 5
    compiled = [
        "uv",
        "pip",
        "compile",
        "--quiet",
        *OPTIONS.split(),
        "pyproject.toml",
        "--extra",
        "gui",
        "--extra",
        "build",
    ]
    for lock, more in ((RUN, []), (TEST, ["--extra", "test", "--extra", "manual", "-c", RUN])):
        code = subprocess.run([*compiled, *more, "-o", lock, *sys.argv[1:]], cwd=PROJECT).returncode
        if code:
            return code
    return 0


if __name__ == "__main__":
    sys.exit(main())
