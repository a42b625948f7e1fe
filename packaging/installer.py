"""Build the installers of Lightarc for Linux: a Debian package and an archive, with everything inside.

    .venv/bin/python packaging/installer.py -o build/installer [--no-kernels] [--level 3]

Both hold one folder that runs from any place: the Python that runs this script, without what Lightarc does not use,
with the shared libraries that it takes from the system besides glibc; the packages of `packaging/requirements.lock` as
they are installed here, less tests, sources, codecs and parts of Qt that nothing imports; Lightarc as its wheel has it;
and kernels that are compiled already. PyInstaller was weighed: it hides modules in an archive, where the confined
decoder process, which is a Python of its own, does not find them. patchelf, binutils, gcc, zstd and dpkg-deb are
needed. The manual goes along where `packaging/dev.py manual` has built it.

Symbols that only debuggers read are stripped, except where a library, moved by its wheel, no longer loads without them.
Of the data of ICU, with which Qt sorts names, what this window's languages need is kept. OpenCV brings an OpenBLAS of
its own for nineteen functions; here these lead to that of SciPy.

Kernels are compiled for x86-64-v3 (AVX2 and FMA, from 2013 on), by a run of the program with `NUMBA_CACHE_DIR`, where
they are named by content (`engine.core.kernel_cache`) and so stay good at another place. The start script links them
into the user's cache, where kernels of other types are added; on an older CPU, all are compiled when first used.
Kernels of an earlier build in the same folder are taken again; a release is built in an empty one.

glibc is that of the build machine or newer: build on the oldest system that shall be served.
"""

from __future__ import annotations

import argparse
import ast
import compileall
import hashlib
import os
import py_compile
import re
import shutil
import struct
import subprocess
import sys
import time
import zipfile
from collections.abc import Iterator, Sequence
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

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

#: Codecs of images and of this program's own files; imagecodecs loads each when it is first used.
CODECS = (
    "shared|shared_cython|imcd|bitshuffle|ccitt|cms|deflate|jpeg2k|jpeg8|jpegls|jpegxl|jpegxr|lerc|ljpeg|lzma|pixarlog"
    "|png|rgbe|webp|zlib|zlibng|zstd"
)

#: Files in packages that the program does not use: sources of other languages, tests, tools, codecs of other data, what
#: matplotlib needs for PDF, and parts of Qt and SciPy.
UNUSED_FILES = re.compile(
    r"\.(pyi|h|hpp|pxd|pyx|pxi|c|cc|cpp|f90|f|a|o|lib)$|/__pycache__/"
    r"|\.dist-info/(RECORD|INSTALLER|REQUESTED|direct_url\.json)$"
    r"|^(numpy|scipy|numba|matplotlib|pyqtgraph|trimesh|imagecodecs|fontTools|PIL|mpl_toolkits|contourpy)/(.{0,200}/)?"
    r"(tests?|testing/tests|examples)/"
    r"|^matplotlib/mpl-data/(sample_data|plot_directive|fonts/(afm|pdfcorefonts|ttf/STIX))"
    r"|^fontTools/(cffLib|colorLib|cu2qu|designspaceLib|feaLib|merge|mtiLib|otlLib|pens|qu2cu|subset|svgLib|t1Lib|ttLib"
    r"|ufoLib|varLib|voltLib)/|^fontTools/misc/.{1,40}\.so$"
    rf"|^imagecodecs/_(?!({CODECS})\.)\w{{1,40}}\.(abi3|cpython-[\w-]{{1,40}})\.so$"
    r"|^scipy/(datasets|differentiate|fftpack|io|misc|odr|signal)/"
    r"|^PIL/_(avif|imagingtk|imagingft)\.|^numpy/(_core/lib|random/lib|_core/_simd\.|_core/_\w{0,40}_tests\.)"
    r"|^numba/np/ufunc/tbbpool"
    r"|^PySide6/(Qt/(qml|metatypes|libexec|translations/(?!qtbase_(de|en)))|typesystems|glue|include|scripts|doc)"
    r"|^PySide6/(assistant|designer|linguist|lrelease|lupdate|qml|svgtoqml|balsam|rcc|uic|qsb)"
    r"|^PySide6/Qt(Quick|Qml|Designer|Help|UiTools|Sql|Test|Network|Xml|Concurrent)\w{0,40}\.abi3\.so$"
    r"|^PySide6/Qt/plugins/(qmltooling|qmllint|designer|sqldrivers|networkinformation|tls|help|renderers|sceneparsers"
    r"|vectorimageformats|egldeviceintegrations|generic|wayland-graphics-integration-server)/"
    r"|^PySide6/Qt/plugins/platforms/libq(eglfs|linuxfb|minimalegl|vkkhrdisplay|vnc)"
    r"|^PySide6/Qt/plugins/(platforminputcontexts/libqtvirtualkeyboard|imageformats/libqpdf)"
    r"|^setuptools|^pkg_resources|^_distutils_hack|^distutils-precedence"
)

#: Packages of extras, and of proofs and tests, which the program does without.
OPTIONAL = {
    *("DracoPy", "MaterialX", "_typeshed", "bpy", "dask", "distributed", "gphoto2", "hypothesis", "mitsuba", "pxr"),
    "watchdog",
}

#: Folders of shared libraries that only other libraries of the packages load.
LIBRARY_FOLDERS = ("*.libs", "PySide6/Qt/lib", "PySide6")

#: Of ICU's data: the order of names in the languages of the window.
ICU_DATA = re.compile(
    r"^(coll/(root|de|en|res_index|ucadata)|root|de|en|pool|res_index|cnvalias|nfkc?)\.(res|icu|nrm)$"
)

#: Libraries that every Linux system with a desktop has, or that must be its own: they are the package's dependencies.
SYSTEM_LIBRARIES = re.compile(
    r"^(linux-vdso|ld-linux|libc\.|libm\.|libdl\.|libpthread\.|librt\.|libutil\.|libresolv\.|libGL|libEGL|libX|libxcb"
    r"|libxkb|libwayland|libdbus|libfontconfig|libfreetype|libglib|libgthread|libdrm|libgbm|libstdc\+\+|libgcc_s|libz\.)"
)

#: Debian's packages of the libraries above, and of glibc.
DEPENDS = (
    "libstdc++6, zlib1g, libegl1, libgl1, libgl1-mesa-dri, libglib2.0-0, libdbus-1-3, libfontconfig1, "
    "libxkbcommon-x11-0, libx11-xcb1, libxcb-cursor0, libxcb-icccm4, libxcb-image0, libxcb-keysyms1, libxcb-randr0, "
    "libxcb-render-util0, libxcb-shape0, libxcb-shm0, libxcb-sync1, libxcb-xfixes0, libxcb-xinerama0, libxcb-xkb1, "
    "fonts-dejavu-core | fonts-freefont-ttf"
)

#: The CPU that kernels are compiled for, with what it can do.
CPU = "x86-64-v3"
FEATURES = "+sse4.2,+popcnt,+avx,+avx2,+bmi,+bmi2,+f16c,+fma,+lzcnt,+movbe,+xsave,+cx16"

#: The program: its folder may lie anywhere. Kernels and numbers must be those of one CPU on every machine that has it.
#: Links to the kernels lie in the user's cache, where numba writes beside them; its index files it replaces whole.
START = """#!/bin/sh
# Start Lightarc from the folder in which this script lies.
here=$(dirname "$(readlink -f "$0")")
root=$(dirname "$here")
if [ -z "$NUMBA_CACHE_DIR" ] && [ -r "$root/kernels/stamp" ]; then
    case " $(grep -m1 '^flags' /proc/cpuinfo 2>/dev/null) " in
    *" avx2 "*)
        export NUMBA_CPU_NAME={cpu} NUMBA_CPU_FEATURES={features}
        NUMBA_CACHE_DIR="${{XDG_CACHE_HOME:-$HOME/.cache}}/lightarc/kernels-$(cat "$root/kernels/stamp")"
        if [ "$(readlink "$NUMBA_CACHE_DIR/stamp" 2>/dev/null)" != "$root/kernels/stamp" ]; then
            part="$NUMBA_CACHE_DIR.$$"
            {{
                mkdir -p "$part" && cp -Rs "$root/kernels/." "$part/" && rm -rf "$NUMBA_CACHE_DIR" &&
                    mv -T "$part" "$NUMBA_CACHE_DIR"
            }} 2>/dev/null || rm -rf "$part"
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
    "simulate -o arc --size 32",
    "import arc -o arc.stack",
    "shade arc.stack -o arc.lightarc",
    "render sphere --material arc.lightarc --renderer cpu --width 32 --height 24 --samples 1 -o arc.png",
    "render sphere --material dome.lightarc --renderer cpu --width 32 --height 24 --samples 1 -o dome.png",
    "export arc.lightarc --to textures gltf web shaders --stack arc.stack -o exported",
    "bake plane --brdf ggx --mode sh --order 3 --cube 16 --no-check -o sh.transport",
    "bake plane --brdf ggx --mode wavelet --cube 16 --no-check -o wavelet.transport",
    "bake plane --brdf ggx --mode gaussian --no-check -o gaussian.transport",
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
    parser.add_argument("--level", type=int, default=19, help="compression by zstd, 1 … 19")
    options = parser.parse_args()
    folder = options.output.resolve()
    root, kept = folder / "lightarc", folder / "kernels"
    if (root / "kernels").is_dir():
        shutil.rmtree(kept, ignore_errors=True)
        shutil.move(root / "kernels", kept)
    for old in folder.glob("*"):
        if old != kept:
            shutil.rmtree(old) if old.is_dir() else old.unlink()
    (root / "bin").mkdir(parents=True)
    work = folder / "work"
    work.mkdir()
    steps = {
        "Python": lambda: put_python(root / "python"),
        "packages": lambda: put_packages(site_of(root)),
        "shared libraries of packages": lambda: trim_libraries(site_of(root), work),
        "Lightarc": lambda: put_lightarc(site_of(root), folder),
        "shared libraries": lambda: put_libraries(root),
        "imports": lambda: check_imports(root),
        "bytecode": lambda: compile_modules(root / "python"),
        "entries of the desktop": lambda: put_entries(root),
    }
    if not options.no_kernels:
        steps["kernels"] = lambda: put_kernels(root, folder)
    for name, step in steps.items():
        begun = time.monotonic()
        step()
        print(f"{name}: {time.monotonic() - begun:.0f} s, {size_mb(root):.0f} MB so far", flush=True)
    for path in (pack_archive(root, folder, options.level), pack_debian(root, folder, options.level)):
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


def trim_libraries(site: Path, work: Path) -> None:
    """Take away what no program reads of the shared libraries in packages, and libraries that none takes any more."""
    trim_icu_data(site, work)
    share_openblas(site, work)
    remove_untaken(site)
    strip_symbols(site.parents[1], work)
    link_equal_libraries(site)


def trim_icu_data(site: Path, work: Path) -> None:
    """Write the data library of ICU anew with the items of `ICU_DATA`.

    Its one symbol is a header and a table of names with offsets, sorted, and then the items, each at a multiple of 16
    bytes (icu4c, `unicode/udata.h` and `ucmndata.h`: the table of contents "ToCP").
    """
    (library,) = (site / "PySide6" / "Qt" / "lib").glob("libicudata.so.*")
    symbol = re.search(r"icudt\d{2,3}_dat", run_tool("nm", "-D", str(library)))[0]  # type: ignore[index]
    place = re.search(rf"(\w{{16}}) . {symbol}", run_tool("nm", "-D", str(library)))[1]  # type: ignore[index]
    sections = re.findall(r"\.rodata\s+PROGBITS\s+(\w+) (\w+) (\w+)", run_tool("readelf", "-SW", str(library)))
    address, offset, size = (int(number, 16) for number in sections[0])
    begin = offset + int(place, 16) - address
    data = library.read_bytes()[begin : offset + size]
    header_bytes = int.from_bytes(data[:2], "little")
    header, table = data[:header_bytes], data[header_bytes:]
    count = int.from_bytes(table[:4], "little")
    places = [struct.unpack_from("<II", table, 4 + 8 * item) for item in range(count)]
    ends = [start for _, start in places[1:]] + [len(table)]
    items = {}
    for (name_at, start), end in zip(places, ends, strict=True):
        name = table[name_at : table.index(b"\0", name_at)].decode("ascii")
        if ICU_DATA.search(name.split("/", 1)[-1]):
            items[name] = table[start:end]
    names_at = 4 + 8 * len(items)
    names = b"".join(name.encode() + b"\0" for name in items)
    at = -(-(header_bytes + names_at + len(names)) // 16) * 16 - header_bytes
    written, name_at, content = [struct.pack("<I", len(items))], names_at, b""
    for name, item in items.items():
        written.append(struct.pack("<II", name_at, at + len(content)))
        name_at += len(name) + 1
        content += item + bytes(-len(item) % 16)
    kept = header + b"".join(written) + names
    kept += bytes(header_bytes + at - len(kept)) + content
    (work / "icu.bin").write_bytes(kept)
    source = f""".globl {symbol}
.section .rodata
.balign 16
.type {symbol}, @object
.size {symbol}, {len(kept)}
{symbol}: .incbin "{work / "icu.bin"}"
"""
    link_library(library, source, library.name, work)


def share_openblas(site: Path, work: Path) -> None:
    """Put a library of jumps to SciPy's OpenBLAS in the place of the one that OpenCV's wheel holds, 39 MB.

    Both have 32-bit integers; SciPy's has names of its own, with `scipy_` in front.
    """
    (old,) = site.glob("opencv*.libs/libopenblas*.so")
    (shared,) = site.glob("scipy.libs/libscipy_openblas*.so")
    wanted = re.findall(r"\bU (\w+)", run_tool("nm", "-D", "--undefined-only", str(site / "cv2" / "cv2.abi3.so")))
    offered = set(re.findall(r"\bT (\w+)", run_tool("nm", "-D", "--defined-only", str(old))))
    names = [name for name in wanted if name in offered]
    source = ".text\n" + "".join(
        f".globl {name}\n.type {name}, @function\n{name}: jmp scipy_{name}@PLT\n" for name in names
    )
    path = f"-Wl,--enable-new-dtags,-rpath,$ORIGIN/../{shared.parent.name}"
    link_library(old, source, old.name, work, str(shared), path, "-Wl,-z,defs")


def link_library(target: Path, source: str, name: str, work: Path, *options: str) -> None:
    """Assemble and link a shared library of the given name in the place of `target`."""
    assembly = work / "library.s"
    assembly.write_text(source + '.section .note.GNU-stack,"",@progbits\n', encoding="ascii")
    target.unlink()
    run_tool("gcc", "-shared", "-nostdlib", f"-Wl,-soname,{name}", "-o", str(target), str(assembly), *options)


def remove_untaken(site: Path) -> None:
    """Remove the shared libraries of packages that no binary there needs, again and again until all are needed."""
    while True:
        binaries = list(find_binaries(site))
        wanted = run_tool("readelf", "-d", *map(str, binaries))
        needed = set(re.findall(r"\(NEEDED\).{0,40}\[(.+?)\]", wanted))
        folders = {folder for pattern in LIBRARY_FOLDERS for folder in site.glob(pattern)}
        untaken = [path for path in binaries if path.parent in folders and path.name not in needed]
        untaken = [path for path in untaken if path.name.startswith("lib")]
        if not untaken:
            return
        for path in untaken:
            path.unlink()


def strip_symbols(library: Path, work: Path) -> None:
    """Strip what only debuggers and static linkers read, where a library loads with it alone."""
    stripped = work / "stripped"
    loads = [sys.executable, "-I", "-S", "-c", "import ctypes, os, sys; ctypes.CDLL(sys.argv[1]); os._exit(0)"]
    for path in [*find_binaries(library), library.parent / "bin" / VERSIONED]:
        run_tool("strip", "--strip-unneeded", "-o", str(stripped), str(path))
        if stripped.stat().st_size >= path.stat().st_size:
            continue
        kept = work / "kept"
        shutil.move(path, kept)
        shutil.copy(stripped, path)
        path.chmod(kept.stat().st_mode)
        if path.name != VERSIONED and subprocess.run([*loads, str(path)], capture_output=True).returncode:
            stripped.write_bytes(path.read_bytes())
            shutil.copy(kept, path)
            if not subprocess.run([*loads, str(path)], capture_output=True).returncode:
                print(f"  {path.name} is not stripped, as it does not load without symbols")
                continue
            shutil.copy(stripped, path)
    stripped.unlink()


def link_equal_libraries(site: Path) -> None:
    """Leave one of libraries with the same content, such as those that a wheel has under several names."""
    first: dict[bytes, Path] = {}
    for path in find_binaries(site):
        known = first.setdefault(hashlib.sha256(path.read_bytes()).digest(), path)
        if known != path:
            path.unlink()
            path.symlink_to(os.path.relpath(known, path.parent))


def find_binaries(folder: Path) -> Iterator[Path]:
    """All shared libraries and extension modules below a folder."""
    for path in sorted(folder.rglob("*.so*")):
        if path.is_file() and not path.is_symlink() and path.open("rb").read(4) == b"\x7fELF":
            yield path


def run_tool(*command: str) -> str:
    """What a tool prints; its own words end the build where it fails."""
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"{command[0]} failed: {done.stderr.strip()[-500:]}")
    return done.stdout


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
    site = site_of(root)
    wanted = [python / "bin" / VERSIONED, *modules, *site.glob("*.so"), *site.glob("numba/np/ufunc/omppool*.so")]
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


def check_imports(root: Path) -> None:
    """End the build where a module that Lightarc's sources import is not there: something was left out by mistake."""
    names: set[str] = set()
    for path in (site_of(root) / "lightarc").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                names.update(alias.name for alias in node.names)
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                names.add(node.module)
    program = """if True:
        import importlib.util, sys
        def missing(name):
            try:
                return importlib.util.find_spec(name) is None
            except ModuleNotFoundError:
                return True
        print(*(name for name in sys.argv[1:] if missing(name)))
    """
    python = str(root / "python" / "bin" / VERSIONED)
    missing = {name.partition(".")[0] for name in run_tool(python, "-I", "-B", "-c", program, *sorted(names)).split()}
    if missing - OPTIONAL:
        raise SystemExit(f"not in the installation: {', '.join(sorted(missing - OPTIONAL))}")


def compile_modules(python: Path) -> None:
    """Bytecode that is used whatever the times of files are: packages may change them, and nobody may write here.

    That of packages takes the place of their sources, which only show lines in tracebacks; OpenCV reads its own.
    """
    options: dict[str, Any] = {"quiet": 2, "workers": 0, "stripdir": str(python.parent)}
    site = site_of(python.parent)
    for path in site.iterdir():
        if path.is_dir() and path.name not in {"lightarc", "cv2"}:
            compileall.compile_dir(str(path), legacy=True, **options)
            for source in path.rglob("*.py"):
                if source.with_suffix(".pyc").is_file():
                    source.unlink()
    unchecked = py_compile.PycInvalidationMode.UNCHECKED_HASH
    compileall.compile_dir(str(python / "lib"), invalidation_mode=unchecked, **options)


def put_entries(root: Path) -> None:
    """The start script, the files of the desktop, and the notices."""
    from app.cli.desktop_install import entries
    from app.command_line import build_parser

    start = root / "bin" / "lightarc"
    start.write_text(START.format(cpu=CPU, features=FEATURES, python=VERSIONED), encoding="utf-8")
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
    """Compile kernels by runs of the installed program, and name them by a hash of their content."""
    place, work = root / "kernels", folder / "warm-up"
    work.mkdir()
    if (folder / "kernels").is_dir():
        shutil.move(folder / "kernels", place)
    home = {"HOME": str(work), "XDG_CACHE_HOME": str(work / "cache"), "XDG_CONFIG_HOME": str(work / "config")}
    kernels = {"NUMBA_CACHE_DIR": str(place), "NUMBA_CPU_NAME": CPU, "NUMBA_CPU_FEATURES": FEATURES}
    for words in WARM_UP:
        begun = time.monotonic()
        done = subprocess.run(
            [str(root / "bin" / "lightarc"), *words.split()],
            cwd=work,
            env={**os.environ, **home, **kernels},
            capture_output=True,
            text=True,
        )
        print(f"  lightarc {words}: {time.monotonic() - begun:.0f} s", flush=True)
        if done.returncode:
            raise SystemExit(done.stderr.strip()[-500:])
    shutil.rmtree(work)
    digest = hashlib.sha256()
    for path in sorted(place.rglob("*.nb?")):
        digest.update(path.relative_to(place).as_posix().encode() + b"\0" + path.read_bytes())
    (place / "stamp").write_text(f"{version()}-{digest.hexdigest()[:12]}\n", encoding="ascii")


def pack_archive(root: Path, folder: Path, level: int) -> Path:
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
        f"zstd -{level} -T2",
    ]
    subprocess.run([*command, "-cf", str(path), root.name], check=True)
    return path


def pack_debian(root: Path, folder: Path, level: int) -> Path:
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
    subprocess.run(
        ["dpkg-deb", "--root-owner-group", "-Zzstd", f"-z{level}", "--build", str(tree), str(path)], check=True
    )
    shutil.rmtree(tree)
    return path


def distribution_of_glibc() -> str:
    """The version of glibc here, from which on the package runs."""
    return os.confstr("CS_GNU_LIBC_VERSION").split()[-1]  # type: ignore[union-attr]


if __name__ == "__main__":
    sys.exit(main())
