"""The installers: what is left out of the packages, and the start script. The build itself takes minutes."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

PROJECT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def installer() -> Any:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "path", [str(PROJECT / "packaging"), *sys.path])
        return import_module("installer")


@pytest.mark.parametrize(
    "name",
    [
        "cv2/cv2.abi3.so",
        "cv2/config.py",
        "imagecodecs/_jpeg8.abi3.so",
        "imagecodecs/_shared.abi3.so",
        "imagecodecs/imagecodecs.py",
        "PIL/_webp.cpython-311-x86_64-linux-gnu.so",
        "scipy/cluster/vq.py",
        "numba/np/ufunc/omppool.cpython-311-x86_64-linux-gnu.so",
        "fontTools/agl.py",
        "PySide6/QtOpenGL.abi3.so",
        "PySide6/Qt/plugins/platforms/libqxcb.so",
        "PySide6/Qt/translations/qtbase_de.qm",
        "matplotlib/mpl-data/fonts/ttf/DejaVuSans.ttf",
        "scipy-1.17.1.dist-info/LICENSE.txt",
    ],
)
def test_what_the_program_loads_is_kept(installer: Any, name: str) -> None:
    assert not installer.UNUSED_FILES.search(name)


@pytest.mark.parametrize(
    "name",
    [
        "numpy/_core/include/numpy/arrayobject.h",
        "scipy/special/tests/test_basic.py",
        "scipy/signal/__init__.py",
        "imagecodecs/_sz3.abi3.so",
        "fontTools/ttLib/woff2.py",
        "PySide6/QtQuick.abi3.so",
        "PySide6/Qt/qml/QtQuick/qmldir",
        "PySide6/Qt/translations/qtbase_fr.qm",
        "PySide6/Qt/plugins/platforminputcontexts/libqtvirtualkeyboardplugin.so",
        "numpy-2.4.6.dist-info/RECORD",
    ],
)
def test_what_nothing_loads_is_left_out(installer: Any, name: str) -> None:
    assert installer.UNUSED_FILES.search(name)


def test_the_start_script_links_kernels_where_the_cpu_runs_them(installer: Any) -> None:
    text = installer.START.format(cpu=installer.CPU, features=installer.FEATURES, python=installer.VERSIONED)
    assert text.startswith("#!/bin/sh\n")
    assert 'cp -Rs "$root/kernels/."' in text
    assert "{" not in text.replace("{XDG_CACHE_HOME", "").replace("            {\n", "")
