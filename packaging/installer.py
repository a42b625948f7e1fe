"""Build the installers of Lightarc for Linux: a Debian package and an archive, with everything inside.

    .venv/bin/python packaging/installer.py -o build/installer [--no-kernels]

Both hold one folder that runs from any place: the Python that runs this script, without what Lightarc does not use,
with the shared libraries that it takes from the system besides glibc; the packages of `packaging/requirements.lock` as
they are installed here (not stripped, which breaks libraries that a wheel has moved); Lightarc as its wheel has it; and
kernels that are compiled already. PyInstaller was weighed: it hides modules in an archive, where the confined decoder
process, which is a Python of its own, does not find them. patchelf, zstd and dpkg-deb are needed.

Kernels are compiled for x86-64-v3 (AVX2 and FMA, from 2013 on), by a run of the program with `NUMBA_CACHE_DIR`, where
they are named by content (`engine.core.kernel_cache`) and so stay good at another place. The start script lays them
into the user's cache once for each version; on an older CPU, kernels are compiled when they are first used.

glibc is that of the build machine or newer: build on the oldest system that shall be served.
"""

from __future__ import annotations

import argparse
import compileall
import os
import py_compile
import re
import shutil
import subprocess
import sys
import time
import zipfile
from collections.abc import Iterator, Sequence
from fnmatch import fnmatch
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(PROJECT), str(PROJECT / "packaging")]

VERSIONED = f"python{sys.version_info.major}.{sys.version_info.minor}"

#: Parts of the standard library that the program does not use.
UNUSED_LIBRARY = (
    *("test", "idlelib", "tkinter", "turtledemo", "ensurepip", "lib2to3", "distutils", "site-packages", "venv"),
    *("pydoc_data", "unittest/test", "sqlite3/test", "ctypes/test", "__pycache__"),
    *("lib-dynload/_tkinter*", "lib-dynload/_test*", "lib-dynload/xx*", "lib-dynload/nis*", "lib-dynload/_curses*"),
    *("lib-dynload/readline*", "lib-dynload/_dbm*", "lib-dynload/_gdbm*", "lib-dynload/_crypt*"),
    "config-*",
)

#: Files in packages that the program does not use: sources of other languages, tests, tools, and parts of Qt.
UNUSED_FILES = re.compile(
    r"\.pyi$|\.h$|\.hpp$|\.pxd$|\.a$|/__pycache__/|\.dist-info/(RECORD|INSTALLER|REQUESTED|direct_url\.json)$"
    r"|^(numpy|scipy|numba|matplotlib|pyqtgraph|trimesh|imagecodecs|fontTools|PIL|mpl_toolkits|contourpy)/(.{0,200}/)?"
    r"(tests?|testing/tests|examples)/"
    r"|^matplotlib/mpl-data/(sample_data|plot_directive)/"
    r"|^PySide6/(Qt/(qml|metatypes|libexec|translations/(?!qtbase_(de|en)))|typesystems|glue|include|scripts|doc)"
    r"|^PySide6/(assistant|designer|linguist|lrelease|lupdate|qml|svgtoqml|balsam|rcc|uic|qsb)"
    r"|^PySide6/Qt(Quick|Qml|Designer|Help|UiTools|Sql|Test|Network|Xml)\w{0,40}\.abi3\.so$"
    r"|^PySide6/Qt/lib/libQt6(Quick|Qml|Designer|Help|UiTools|Sql|Test|Labs|Wayland(Egl|Eglfs)?Compositor)"
    r"|^PySide6/Qt/plugins/(qmltooling|qmllint|designer|sqldrivers|networkinformation|tls|help|renderers|sceneparsers)/"
    r"|^setuptools|^pkg_resources|^_distutils_hack|^distutils-precedence"
)

#: Libraries that every Linux system with a desktop has, or that must be its own: they are the package's dependencies.
SYSTEM_LIBRARIES = re.compile(
    r"^(linux-vdso|ld-linux|libc\.|libm\.|libdl\.|libpthread\.|librt\.|libutil\.|libresolv\.|libGL|libEGL|libX|libxcb"
    r"|libxkb|libwayland|libdbus|libfontconfig|libfreetype|libglib|libgthread|libdrm|libgbm)"
)

#: Debian's packages of the libraries above, and of glibc.
DEPENDS = (
    "libegl1, libgl1, libgl1-mesa-dri, libglib2.0-0, libdbus-1-3, libfontconfig1, libxkbcommon-x11-0, libxcb-cursor0, "
    "libxcb-icccm4, libxcb-image0, libxcb-keysyms1, libxcb-render-util0, libxcb-shape0, libxcb-xinerama0, "
    "fonts-dejavu-core | fonts-freefont-ttf"
)

#: The CPU that kernels are compiled for, with what it can do.
CPU = "x86-64-v3"
FEATURES = "+sse4.2,+popcnt,+avx,+avx2,+bmi,+bmi2,+f16c,+fma,+lzcnt,+movbe,+xsave,+cx16"

#: The program: its folder may lie anywhere. Kernels and numbers must be those of one CPU on every machine that has it.
START = """#!/bin/sh
# Start Lightarc from the folder in which this script lies.
here=$(dirname "$(readlink -f "$0")")
root=$(dirname "$here")
if [ -z "$NUMBA_CACHE_DIR" ] && [ -d "$root/kernels" ]; then
    case " $(grep -m1 '^flags' /proc/cpuinfo 2>/dev/null) " in
    *" avx2 "*)
        export NUMBA_CPU_NAME={cpu} NUMBA_CPU_FEATURES={features}
        NUMBA_CACHE_DIR="${{XDG_CACHE_HOME:-$HOME/.cache}}/lightarc/kernels-{stamp}"
        if [ ! -d "$NUMBA_CACHE_DIR" ]; then
            mkdir -p "$(dirname "$NUMBA_CACHE_DIR")" 2>/dev/null
            part="$NUMBA_CACHE_DIR.$$"
            {{ cp -R "$root/kernels" "$part" && mv "$part" "$NUMBA_CACHE_DIR"; }} 2>/dev/null || rm -rf "$part"
        fi
        [ -d "$NUMBA_CACHE_DIR" ] && export NUMBA_CACHE_DIR || unset NUMBA_CACHE_DIR
        ;;
    esac
fi
unset PYTHONPATH PYTHONHOME
exec "$root/python/bin/{python}" -I -m lightarc "$@"
"""

#: Runs that compile the kernels which first uses need, in a folder of their own.
WARM_UP = (
    "demo -o demo",
    "simulate -o dome --size 32 --azimuths 4 --elevations 3 --sample leather",
    "import dome -o dome.stack",
    "shade dome.stack -o dome.lightarc",
    "normals dome.stack -o maps --no-errors",
    "render sphere --brdf ggx --mode reference --samples 1 --width 32 --height 24 --ground -o reference.png",
    "render sphere --material demo/cloth.lightarc --renderer cpu --width 32 --height 24 --samples 1 -o cpu.png",
    "bake blob --brdf ggx --mode sh --order 3 --cube 16 --no-check -o sh.transport",
    "bake blob --brdf ggx --mode wavelet --cube 16 --no-check -o wavelet.transport",
    "bake blob --brdf ggx --mode gaussian --views 6 --samples 64 --no-check -o gaussian.transport",
    "render wavelet.transport --env studio --width 32 --height 24 -o wavelet.png",
    "render sh.transport --env studio --width 32 --height 24 -o sh.png",
    "factor ggx --size 8 --samples 300 --terms 1 -o factors",
    "plan blob --brdf ggx --env studio --width 32 --height 24",
    "selftest",
)


def main() -> int:
    parser = argparse.ArgumentParser(description="Build the Debian package and the archive.")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FOLDER")
    parser.add_argument("--no-kernels", action="store_true", help="leave out compiled kernels")
    options = parser.parse_args()
    folder = options.output.resolve()
    shutil.rmtree(folder, ignore_errors=True)
    root = folder / "lightarc"
    (root / "bin").mkdir(parents=True)
    steps = {
        "Python": lambda: put_python(root / "python"),
        "packages": lambda: put_packages(site_of(root)),
        "Lightarc": lambda: put_lightarc(site_of(root), folder),
        "shared libraries": lambda: put_libraries(root),
        "bytecode": lambda: compile_modules(root / "python"),
        "entries of the desktop": lambda: put_entries(root),
    }
    if not options.no_kernels:
        steps["kernels"] = lambda: put_kernels(root, folder)
    for name, step in steps.items():
        begun = time.monotonic()
        step()
        print(f"{name}: {time.monotonic() - begun:.0f} s, {size_mb(root):.0f} MB so far", flush=True)
    for path in (pack_archive(root, folder), pack_debian(root, folder)):
        print(f"{path}: {path.stat().st_size / 1e6:.0f} MB, {size_mb(root):.0f} MB installed")
    return 0


def version() -> str:
    import engine

    return engine.__version__


def site_of(root: Path) -> Path:
    return root / "python" / "lib" / VERSIONED / "site-packages"


def size_mb(folder: Path) -> float:
    """Size of all files in megabytes (10^6 bytes), links not followed."""
    return sum(path.lstat().st_size for path in folder.rglob("*") if not path.is_dir()) / 1e6


def put_python(target: Path) -> None:
    """Copy the interpreter that runs this script, with its standard library."""
    base = Path(sys.base_prefix)
    library = Path(os.__file__).parent
    (target / "bin").mkdir(parents=True)
    binary = Path(sys.executable).resolve()
    shutil.copy(binary, target / "bin" / VERSIONED)
    (target / "lib").mkdir()
    for shared in (base / "lib").glob(f"lib{VERSIONED}*.so.*"):
        shutil.copy(shared, target / "lib" / shared.name)

    def choose(folder: str, names: list[str]) -> set[str]:
        """What is left out: names in a folder of the library."""
        place = Path(folder).relative_to(library).as_posix()
        paths = {name: name if place == "." else f"{place}/{name}" for name in names}
        unused = ("__pycache__", *UNUSED_LIBRARY)
        return {name for name in names if name in unused[:1] or any(fnmatch(paths[name], each) for each in unused)}

    shutil.copytree(library, target / "lib" / VERSIONED, ignore=choose, dirs_exist_ok=True)
    site_of(target.parent).mkdir(exist_ok=True)


def put_packages(site: Path) -> None:
    """Copy the locked packages, each with the files that its installer recorded, less what is not used."""
    from notices import find_installed, read_lock

    for locked, package in find_installed(read_lock()):
        if package is None or locked.name == "setuptools":
            continue
        for file in package.files or ():
            source = Path(str(package.locate_file(file)))
            name = str(file)
            if name.startswith("..") or UNUSED_FILES.search(name) or not source.is_file():
                continue
            (site / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(source, site / name)


def put_lightarc(site: Path, folder: Path) -> None:
    """Unpack the wheel of this checkout."""
    options = ["-q", "--no-deps", "--no-build-isolation", "-w", str(folder)]
    subprocess.run([sys.executable, "-m", "pip", "wheel", *options, str(PROJECT)], check=True)
    (wheel,) = folder.glob("lightarc-*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    wheel.unlink()


def put_libraries(root: Path) -> None:
    """Copy the shared libraries of the interpreter and its modules, and let it look for them beside itself."""
    python = root / "python"
    target = python / "lib"
    modules = (target / VERSIONED / "lib-dynload").glob("*.so")
    wanted = [python / "bin" / VERSIONED, *modules, *site_of(root).glob("*.so")]
    for name, path in sorted(set(dependencies(wanted))):
        if not SYSTEM_LIBRARIES.match(name) and not (target / name).exists():
            shutil.copy(path, target / name)
    patchelf = shutil.which("patchelf") or str(Path(sys.executable).parent / "patchelf")
    for binary in (python / "bin" / VERSIONED, *(target / VERSIONED / "lib-dynload").glob("*.so")):
        above = "/".join([".."] * (len(binary.relative_to(python).parts) - 1))  # a path of its own hides that of Python
        subprocess.run([patchelf, "--force-rpath", "--set-rpath", f"$ORIGIN/{above}/lib", str(binary)], check=True)


def dependencies(binaries: Sequence[Path]) -> Iterator[tuple[str, Path]]:
    """Name and place of each shared library that some `binaries` take from the system."""
    done = subprocess.run(["ldd", *map(str, binaries)], capture_output=True, text=True)
    for name, path in re.findall(r"^\s(\S+) => (/\S+)", done.stdout, re.MULTILINE):
        yield name, Path(path)


def compile_modules(python: Path) -> None:
    """Bytecode that is used whatever the times of files are: packages may change them, and nobody may write here."""
    mode = py_compile.PycInvalidationMode.UNCHECKED_HASH
    compileall.compile_dir(str(python / "lib"), quiet=2, workers=0, invalidation_mode=mode, stripdir=str(python.parent))


def put_entries(root: Path) -> None:
    """The start script, the files of the desktop, and the notices."""
    from app.cli.desktop_install import entries
    from app.command_line import build_parser

    start = root / "bin" / "lightarc"
    stamp = f"{version()}-{VERSIONED}"
    start.write_text(START.format(cpu=CPU, features=FEATURES, stamp=stamp, python=VERSIONED), encoding="utf-8")
    start.chmod(0o755)
    for name, content in entries(["lightarc"], build_parser()):
        path = root / "share" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    notices = root / "share" / "doc" / "lightarc"
    notices.mkdir(parents=True)
    licences = PROJECT / "resources" / "licences"
    shutil.copy(PROJECT / "LICENSE", notices / "copyright")
    for name in ("third-party.txt", "sbom.cdx.json"):
        shutil.copy(licences / name, notices / name)


def put_kernels(root: Path, folder: Path) -> None:
    """Compile kernels by runs of the installed program, and keep them without the times of this machine."""
    place, work = root / "kernels", folder / "warm-up"
    work.mkdir()
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(place), "NUMBA_CPU_NAME": CPU, "NUMBA_CPU_FEATURES": FEATURES}
    for words in WARM_UP:
        done = subprocess.run(
            [str(root / "bin" / "lightarc"), *words.split()], cwd=work, env=environment, capture_output=True, text=True
        )
        print(f"  lightarc {words}: {done.returncode}{done.stderr[-300:] if done.returncode else ''}", flush=True)
    shutil.rmtree(work)


def pack_archive(root: Path, folder: Path) -> Path:
    """The archive: a folder `lightarc` with `bin/lightarc`."""
    path = folder / f"lightarc-{version()}-linux-x86_64.tar.zst"
    command = [
        "tar",
        "--sort=name",
        "--owner=0",
        "--group=0",
        "--numeric-owner",
        "-C",
        str(folder),
        "-I",
        "zstd -12 -T0",
    ]
    subprocess.run([*command, "-cf", str(path), root.name], check=True)
    return path


def pack_debian(root: Path, folder: Path) -> Path:
    """The Debian package: the folder in /usr/lib, and entries, man page and command where systems look for them."""
    tree = folder / "debian"
    (tree / "usr" / "lib").mkdir(parents=True)
    (tree / "usr" / "bin").mkdir()
    shutil.copytree(root, tree / "usr" / "lib" / "lightarc", copy_function=os.link, symlinks=True)
    shutil.move(tree / "usr" / "lib" / "lightarc" / "share", tree / "usr" / "share")
    (tree / "usr" / "bin" / "lightarc").symlink_to("../lib/lightarc/bin/lightarc")
    (tree / "DEBIAN").mkdir()
    libc = distribution_of_glibc()
    control = {
        "Package": "lightarc",
        "Version": version(),
        "Architecture": "amd64",
        "Maintainer": "Lightarc developers <lightarc@localhost>",
        "Installed-Size": str(round(size_mb(tree) * 1e6 / 1024)),
        "Depends": f"libc6 (>= {libc}), {DEPENDS}",
        "Recommends": "desktop-file-utils, shared-mime-info",
        "Section": "graphics",
        "Priority": "optional",
        "Description": "photographs of a material under a moving light become a relightable material",
    }
    (tree / "DEBIAN" / "control").write_text("".join(f"{key}: {value}\n" for key, value in control.items()))
    path = folder / f"lightarc_{version()}_amd64.deb"
    subprocess.run(["dpkg-deb", "--root-owner-group", "-Zzstd", "--build", str(tree), str(path)], check=True)
    shutil.rmtree(tree)
    return path


def distribution_of_glibc() -> str:
    """The version of glibc here, from which on the package runs."""
    return os.confstr("CS_GNU_LIBC_VERSION").split()[-1]  # type: ignore[union-attr]


if __name__ == "__main__":
    sys.exit(main())
