"""Build the manual as pages for a browser.

    python3 packaging/dev.py manual
    .venv/bin/python packaging/manual.py FOLDER [--without-examples]

The sources are `docs/manual`, the pages of the panels in `resources/manual`, which the window shows as well,
`docs/format.md` and `docs/long-tests.md`. The pages of the verbs, of the settings, of the functions of `lightarc` and
of where the papers are implemented are written from the declarations. All lie together in FOLDER/source while Sphinx
reads them; the result is FOLDER/html. A warning of Sphinx, a link that leads nowhere among them, ends the build.
Nothing is fetched from elsewhere. Without FOLDER it is `build/manual`, from which a wheel takes the pages.

Examples are the scripts of the gallery (sphinx-gallery) and the notebooks (MyST-NB), which are run while the manual is
built, some two minutes; their images are those of this run.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import lightarc
from app.command_line import VERBS, build_parser
from app.document.document import Look
from app.help.anchors import anchor_of
from engine.brdf.brdf import MODELS
from engine.core.params import Parameter, parameters
from engine.factor.settings import FactorSettings
from engine.light.lamps import LampSettings
from engine.light.near_lamps import NearLampSettings
from engine.scene.mode import MODES
from engine.scene.settings import SceneSettings
from engine.simulate.arc import LightArc
from engine.transport.method import METHODS

PROJECT = Path(__file__).resolve().parents[1]
DEFAULT_FOLDER = PROJECT / "build" / "manual"

#: Folders of what is run while the manual is built; Sphinx makes the folder `gallery` of the scripts.
EXAMPLES = ("scripts", "notebooks")

#: The papers by their keys in the bibliography.
PAPERS = ("Kautz2004", "Kautz2002", "Wang2004", "Green2006", "Cole2002")


def main() -> int:
    parser = argparse.ArgumentParser(description="Build the manual as pages for a browser.")
    parser.add_argument("folder", nargs="?", type=Path, default=DEFAULT_FOLDER)
    parser.add_argument("--theme", default="furo", help="theme of Sphinx; basic is made in half the time")
    parser.add_argument("--without-examples", action="store_true", help="leave out the gallery and the notebooks")
    options = parser.parse_args()
    return build(options.folder, options.theme, examples=not options.without_examples)


def build(folder: Path, theme: str, examples: bool) -> int:
    """Gather the sources in `folder`/source and make `folder`/html of them; the exit code of Sphinx."""
    gather(folder / "source", examples)
    html = folder / "html"
    options = ["-W", "--keep-going", "-q", "-b", "html", "-d", str(folder / "doctrees"), "-D", f"html_theme={theme}"]
    code = subprocess.run([sys.executable, "-m", "sphinx", *options, str(folder / "source"), str(html)]).returncode
    if code == 0:
        size = sum(path.stat().st_size for path in html.rglob("*") if path.is_file())
        print(f"{html / 'index.html'}: {len([*html.rglob('*.html')])} pages, {size / 1e6:.1f} MB")
    return code


def gather(source: Path, examples: bool) -> None:
    """Write all sources of the manual into the folder `source`, and remove what is no source any more."""
    texts = {**read_pages(), **generated_pages()}
    if not examples:
        texts = {place: text for place, text in texts.items() if place.parts[0] not in EXAMPLES}
        index = Path("index.md")
        texts[index] = re.sub(r"```\{toctree\}[^`]*\ngallery/index\n[^`]*```\n", "", texts[index])
    images = {path.relative_to(PROJECT / "docs" / "manual"): path for path in binary_files()}
    for path in [*source.rglob("*")] if source.exists() else []:
        place = path.relative_to(source)
        if path.is_file() and place not in {*texts, *images} and not (examples and place.parts[0] == "gallery"):
            path.unlink()
    for place, text in texts.items():
        path = source / place
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.is_file() or path.read_text(encoding="utf-8") != text:  # Sphinx reads again what is newer
            path.write_text(text, encoding="utf-8")
    for place, path in images.items():
        (source / place).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(path, source / place)


def binary_files() -> Iterator[Path]:
    yield from (path for path in (PROJECT / "docs" / "manual").rglob("*") if path.suffix in {".png", ".webp", ".svg"})


def read_pages() -> dict[Path, str]:
    """The texts that somebody wrote, by their place in the manual."""
    docs = PROJECT / "docs"
    pages = {
        path.relative_to(docs / "manual"): path.read_text(encoding="utf-8")
        for path in (docs / "manual").rglob("*")
        if path.suffix in {".md", ".rst", ".py", ".css", ".html"} and "__pycache__" not in path.parts
    }
    for name in ("format.md", "manifest.schema.json"):
        pages[Path("reference", name)] = (docs / name).read_text(encoding="utf-8")
    pages[Path("long-tests.md")] = (docs / "long-tests.md").read_text(encoding="utf-8")
    for path in (PROJECT / "resources" / "manual").glob("*.md"):
        pages[Path("reference", "workspaces", path.name)] = with_anchors(path)
    return pages


def with_anchors(page: Path) -> str:
    """The page of a panel with a target before each heading, which F1 opens."""
    lines = []
    for line in page.read_text(encoding="utf-8").splitlines():
        if line.startswith("## "):
            lines += [f"({anchor_of(page.stem, line.removeprefix('## '))})=", ""]
        lines.append(line)
    return "\n".join([f"({anchor_of(page.stem)})=", *lines, ""])


def generated_pages() -> dict[Path, str]:
    """The pages that are written from declarations, by their place in the manual."""
    reference = Path("reference")
    pages = {
        reference / "settings.md": settings_page(),
        **python_pages(),
        Path("papers", "modules.md"): papers_page(),
    }
    for name, _, text in VERBS:
        pages[reference / "verbs" / f"{name}.md"] = verb_page(name, text)
    return pages


def verb_page(name: str, text: str) -> str:
    parser = build_parser(name)
    (verbs,) = (action for action in parser._actions if isinstance(action, argparse._SubParsersAction))
    verb: argparse.ArgumentParser = verbs.choices[name]
    return "\n".join([f"# lightarc {name}", "", escaped(text), "", *parser_lines(verb)])


def parser_lines(parser: argparse.ArgumentParser) -> Iterator[str]:
    """The example, the usage and the options of a verb, and those of the verbs below it."""
    if parser.epilog and parser.epilog.startswith("example: "):
        yield from ("Example:", "", "```console", f"$ {parser.epilog.removeprefix('example: ')}", "```", "")
    usage = parser.format_usage().removeprefix("usage: ").rstrip()
    yield from (":::{dropdown} Usage", "```text", usage, "```", ":::", "")
    below: dict[str, argparse.ArgumentParser] = {}
    for group in parser._action_groups:
        shown = [each for each in group._group_actions if each.help != argparse.SUPPRESS]
        nested = [each for each in shown if isinstance(each, argparse._SubParsersAction)]
        for each in nested:
            below |= each.choices
        shown = [each for each in shown if each not in nested and not isinstance(each, argparse._HelpAction)]
        if shown:
            yield from (f"**{escaped((group.title or 'options').capitalize())}**", "")
        for action in shown:
            meaning = parser._get_formatter()._expand_help(action) if action.help else ""
            yield from (f"`{invocation(action)}`", f": {escaped(meaning) or '–'}", "")
    for name, nested_parser in below.items():
        yield from (f"## {parser.prog.removeprefix('lightarc ')} {name}", "")
        if nested_parser.description:
            yield from (escaped(nested_parser.description), "")
        yield from parser_lines(nested_parser)


def invocation(action: argparse.Action) -> str:
    """How an option or an argument is typed: `-o MATERIAL, --output MATERIAL`."""
    if isinstance(action.metavar, tuple):
        value = " ".join(action.metavar)
    elif action.choices is not None:
        value = "{" + ",".join(map(str, action.choices)) + "}"
    else:
        value = action.metavar or action.dest.upper()
    if not action.option_strings:
        return value
    if action.nargs == 0:
        return ", ".join(action.option_strings)
    value = f"[{value}]" if action.nargs == "?" else f"{value} …" if action.nargs in {"*", "+"} else value
    return ", ".join(f"{option} {value}" for option in action.option_strings)


def settings_page() -> str:
    """Every declared parameter: default, range, unit and meaning."""
    groups: list[tuple[str, str, type]] = [
        ("Scene", "What `render`, `bake`, `plan` and the window take where nothing else is given.", SceneSettings),
        ("Display of the View workspace", "None of these changes the material.", Look),
        ("Light", "A distant light: `--lamp elevation_deg=…` (see `lightarc render`).", LampSettings),
        ("Near light", "A sphere, rectangle or disc that shines evenly: `--near-lamp …`.", NearLampSettings),
        ("Simulated capture", "The virtual light arc of `lightarc simulate`.", LightArc),
        ("Factorisation", "The verb `factor` and the Factor workspace.", FactorSettings),
    ]
    for method in METHODS:
        groups.append((f"{method.title}: bake", f"The verb `bake --mode {method.name}`.", method.settings))
        groups.append((f"{method.title}: light", "On a finished bake.", method.light))
    lines = ["# Settings", "", "All settings that are declared with a range. A value outside of it is refused.", ""]
    for title, text, declared in groups:
        lines += table(title, text, parameters(declared))
    lines += [
        "## Modes without a bake",
        "",
        "| mode | parameter | default | range | meaning |",
        "|---|---|---|---|---|",
    ]
    for mode in MODES.values():
        for name, each in mode.parameters.items():
            cells = (mode.title, f"`{name}`", f"{each.default:g}", f"{each.low:g} … {each.high:g}", escaped(each.text))
            lines.append(f"| {' | '.join(cells)} |")
    lines += [
        "",
        "## BRDF models",
        "",
        "A BRDF is typed as `ggx:alpha=0.2,f0=0.5`; `lightarc brdf list` lists these.",
        "",
    ]
    for name, model in MODELS.items():
        lines += table(f"{model.label} (`{name}`)", "", parameters(model), level=3)
    return "\n".join(lines)


def table(title: str, text: str, declared: Iterable[Parameter], level: int = 2) -> list[str]:
    declared = list(declared)
    if not declared:
        return []
    rows = ["| parameter | default | range | unit | meaning |", "|---|---|---|---|---|"]
    for each in declared:
        cells = (f"`{each.name}`", value_text(each.default), range_text(each), each.unit, escaped(each.doc))
        rows.append(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |")
    return [f"{'#' * level} {title}", "", *([text, ""] if text else []), *rows, ""]


def value_text(value: object) -> str:
    if value is None:
        return "by others"
    if isinstance(value, bool):
        return "on" if value else "off"
    if isinstance(value, tuple):
        return " / ".join(f"{each:g}" for each in value) if value else "none"
    return f"{value:g}" if isinstance(value, int | float) else str(value)


def range_text(each: Parameter) -> str:
    if each.values:
        return ", ".join(map(str, each.values))
    if each.kind == "flag":
        return "on, off"
    return f"{each.low:g} … {each.high:g}" if each.kind in {"number", "whole"} else "text"


def python_pages() -> dict[Path, str]:
    """A page for each public function, in the order in which they are used, and one for all classes."""
    folder = Path("reference", "python")
    found = {name: getattr(lightarc, name) for name in lightarc.__all__ if not name.startswith("__")}
    classes = [name for name, value in found.items() if isinstance(value, type)]
    functions = [name for name, value in found.items() if callable(value) and name not in classes]
    pages = {
        folder / f"{name}.md": f"# {name}\n\n```{{eval-rst}}\n.. autofunction:: lightarc.{name}\n```\n"
        for name in functions
    }
    directives = "\n\n".join(f".. autoclass:: lightarc.{name}" for name in classes)
    pages[folder / "classes.md"] = f"# Classes and errors\n\n```{{eval-rst}}\n{directives}\n```\n"
    rows = [f"| [`{name}`](python/{name}.md) | {escaped(first_sentence(found[name]))} |" for name in functions]
    listed = "\n".join(["classes", *functions])
    pages[Path("reference", "python.md")] = f"""# Python

```{{eval-rst}}
.. automodule:: lightarc
   :no-members:
```

| function | purpose |
|---|---|
{chr(10).join(rows)}

The values that they take and return are described under [classes and errors](python/classes.md).

```{{toctree}}
:hidden:

{"".join(f"python/{name}{chr(10)}" for name in listed.split())}```
"""
    return pages


def first_sentence(documented: object) -> str:
    text = " ".join((documented.__doc__ or "").split("\n\n")[0].split())
    return re.split(r"(?<=[.:;])\s", text)[0].rstrip(".:;")


def papers_page() -> str:
    """Modules that cite each paper, with the equations that their texts name."""
    cited: dict[str, list[str]] = {paper: [] for paper in PAPERS}
    for path in sorted((PROJECT / "engine").rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        first = re.match(r'"""(.+?)(?:\.(?:\s|$)|\n|""")', text)
        for paper in PAPERS:
            if paper in text:
                found = {match[1] for match in re.finditer(rf"{paper}\s+Eq\.\s+([\d.]*\d)", text)}
                numbers = ", ".join(sorted(found, key=lambda number: [int(part) for part in number.split(".")]))
                place = path.relative_to(PROJECT).as_posix()
                cited[paper].append(f"| `{place}` | {numbers or '–'} | {escaped(first[1] if first else '')} |")
    lines = ["# Modules by paper", "", "Written from the docstrings, which cite section and equation.", ""]
    for paper, rows in cited.items():
        lines += [f"## {paper}", "", "| module | equations | subject |", "|---|---|---|", *rows, ""]
    return "\n".join(lines)


def escaped(text: str) -> str:
    """Plain text as Markdown that shows it so; what stands between backticks stays."""
    parts = re.split(r"(`[^`]*`)", " ".join(text.split()))
    return "".join(
        part if part.startswith("`") else re.sub(r"([\\*_\[\]<>#|$'\"~^{}])", r"\\\1", part) for part in parts
    )


if __name__ == "__main__":
    sys.exit(main())
