"""`lightarc completion`: the script by which a shell completes verbs, options and values.

The script is written from the parsers and holds all words, so that a Tab costs no start of the program. shtab was
weighed, which knows no fish; argcomplete starts the program at each Tab, whose libraries take a second.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from app.arguments.results import Input, Output
from engine.core.steps import Step

EXAMPLE = "lightarc completion bash > ~/.local/share/bash-completion/completions/lightarc"

#: Where each shell looks for completions of a user.
PLACES = {
    "bash": "~/.local/share/bash-completion/completions/lightarc",
    "zsh": "a folder of $fpath, as _lightarc",
    "fish": "~/.config/fish/completions/lightarc.fish",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    lines = "; ".join(f"{shell}: {place}" for shell, place in PLACES.items())
    parser.add_argument("shell", choices=tuple(PLACES), help=f"the script goes into a file, {lines}")


def run(arguments: argparse.Namespace, _show: Callable[[Step], None]) -> dict[str, Any]:
    words = list(find_words(arguments.build_parser(None)))
    write = {"bash": write_bash, "zsh": write_zsh, "fish": write_fish}[arguments.shell]
    script = write(words)
    if arguments.json:
        return {"script": script, "warnings": []}
    print(script, end="")  # and nothing else, which a shell would run
    return {}


@dataclass(frozen=True)
class Word:
    """A verb, an action of a verb, or an option.

    Attributes
    ----------
    path : the verb, and the action, that it follows: '', 'render', 'brdf fit'.
    names : its spellings, as ('-o', '--output').
    help : what it does.
    values : words that may follow an option; None where it takes none, () for any text.
    is_file : True where the name of a file follows.
    """

    path: str
    names: tuple[str, ...]
    help: str
    values: tuple[str, ...] | None = None
    is_file: bool = False


def find_words(parser: argparse.ArgumentParser, path: str = "") -> Iterator[Word]:
    """All words of a parser and of those below it; of arguments without an option the values that are listed."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            helps = {each.dest: each.help or "" for each in action._choices_actions}
            for name, below in action.choices.items():
                yield Word(path, (name,), helps.get(name, ""))
                yield from find_words(below, f"{path} {name}".strip())
        elif action.help != argparse.SUPPRESS:
            values = None if action.nargs == 0 else tuple(map(str, action.choices or ()))
            text = parser._get_formatter()._expand_help(action) if action.help else ""
            if action.option_strings:
                yield Word(path, tuple(action.option_strings), text, values, isinstance(action.type, Input | Output))
            else:
                for value in values or ():
                    yield Word(path, (value,), "")


def shorten_help(text: str) -> str:
    """The beginning of a help text, without marks that a shell or its completion reads."""
    first = text.replace("\n", " ").split("; ")[0].split(". ")[0]
    kept = "".join(letter for letter in first if letter not in "'\"`\\$[]:{}()|&<>")
    return kept if len(kept) <= 70 else f"{kept[:69]}…"


def write_bash(words: list[Word]) -> str:
    """A function with a table: the words that follow each verb, and the values that follow each option."""
    lines = [
        "# lightarc completion bash",
        "_lightarc() {",
        '    local word="${COMP_WORDS[COMP_CWORD]}" before="${COMP_WORDS[COMP_CWORD-1]}" path="" each',
        '    for each in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do',
        '        case "$path $each" in',
    ]
    paths = sorted({each.path for each in words if each.path})
    lines.append(f"            {'|'.join(_quote(f'{_above(path)} {path.split()[-1]}') for path in paths)})")
    lines += [
        '                path="${path:+$path }$each" ;;',
        "        esac",
        "    done",
        '    case "$path $before" in',
    ]
    for word in words:
        if word.values is not None:
            names = "|".join(_quote(f"{word.path} {name}") for name in word.names)
            found = (
                '$(compgen -f -- "$word")' if word.is_file else f'$(compgen -W "{" ".join(word.values)}" -- "$word")'
            )
            lines.append(f"        {names}) {_reply(found)}; return ;;")
    lines += ["    esac", '    case "$path" in']
    for path in ["", *paths]:
        known = " ".join(name for word in words if word.path == path for name in word.names)
        lines.append(f'        "{path}") {_reply(f"""$(compgen -W "{known}" -- "$word")""")} ;;')
    lines += ["    esac", "}", "complete -o default -o bashdefault -F _lightarc lightarc", ""]
    return "\n".join(lines)


def _above(path: str) -> str:
    return path.rpartition(" ")[0]


def _quote(text: str) -> str:
    return f'"{text}"'


def _reply(found: str) -> str:
    return f"local IFS=$' \\t\\n'; COMPREPLY=({found})"


def write_zsh(words: list[Word]) -> str:
    """A function that describes the words which follow the verb, or else completes names of files."""
    paths = sorted({each.path for each in words if each.path})
    lines = [
        "#compdef lightarc",
        "# lightarc completion zsh",
        "_lightarc() {",
        "    local path_=() each",
        "    local -a found",
    ]
    lines += ["    for each in ${words[2,CURRENT-1]}; do", '        case "${path_[*]} $each" in']
    lines.append(f"            {'|'.join(_quote(f'{_above(path)} {path.split()[-1]}') for path in paths)})")
    lines += ["                path_+=($each) ;;", "        esac", "    done"]
    lines += ['    case "${path_[*]} ${words[CURRENT-1]}" in']
    for word in words:
        if word.values is not None:
            names = "|".join(_quote(f"{word.path} {name}") for name in word.names)
            act = "_files" if word.is_file or not word.values else f"compadd {' '.join(word.values)}"
            lines.append(f"        {names}) {act}; return ;;")
    lines += ["    esac", '    case "${path_[*]}" in']
    for path in ["", *paths]:
        shown = [f"'{name}:{shorten_help(word.help)}'" for word in words if word.path == path for name in word.names]
        lines.append(f'        "{path}") found=({" ".join(shown)}) ;;')
    lines += [
        "    esac",
        "    _describe lightarc found",
        "    [[ $PREFIX == -* ]] || _files",
        "}",
        '_lightarc "$@"',
        "",
    ]
    return "\n".join(lines)


def write_fish(words: list[Word]) -> str:
    """A line for each word, with the verb that must have been typed."""
    verbs = sorted({each.path.split()[0] for each in words if each.path})
    lines = ["# lightarc completion fish"]
    for word in words:
        seen = [f"__fish_seen_subcommand_from {name}" for name in word.path.split()]
        if not word.path and not word.names[0].startswith("-"):
            seen = [f"not __fish_seen_subcommand_from {' '.join(verbs)}"]
        parts = ["complete -c lightarc", *([f"-n '{'; and '.join(seen)}'"] if seen else [])]
        for name in word.names:
            kind = "-l" if name.startswith("--") else "-s" if name.startswith("-") else "-a"
            parts.append(f"{kind} {name.lstrip('-')}")
        if word.values is not None:
            parts.append("-rF" if word.is_file or not word.values else f"-xa '{' '.join(word.values)}'")
        elif not word.names[0].startswith("-"):
            parts.append("-f")
        lines.append(" ".join([*parts, f"-d '{shorten_help(word.help)}'"]))
    return "\n".join([*lines, ""])
