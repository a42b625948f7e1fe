"""A parser that refuses words in one sentence, and options that are given twice.

What argparse says of a wrong word is a page of usage with the cause at its end. Here the cause stands alone, with the
known word that is most like the wrong one. Options are given at most once, but for those that collect values
(`append`): argparse drops the first value without a word.
"""

from __future__ import annotations

import argparse
import weakref
from typing import TYPE_CHECKING, Any, NoReturn

from engine.core.escape import escape_controls
from engine.core.suggestion import suggest

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

#: Characters of a user's word that a message repeats.
_LONGEST = 60

#: Choices that are listed also where one of them is suggested.
_FEW = 20


class OnceParser(argparse.ArgumentParser):
    """An ArgumentParser that refuses an option that is given twice, and suggests what a wrong word may have meant."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        for name, action in ((None, _StoreOnce), ("store", _StoreOnce), ("store_true", _StoreTrueOnce)):
            self.register("action", name, action)

    def error(self, message: str) -> NoReturn:
        """End with exit code 2 and one sentence."""
        self.exit(2, escape_controls(f"{self.prog}: {message.rstrip('.')}. See {self.prog} -h.") + "\n")

    def parse_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse all words; the error of a word too many names the verb that does not take it."""
        found, left = self.parse_known_args(args, namespace)
        if left:
            word = repr(left[0][:_LONGEST])
            problem = f"{word} is a word too many; a name with spaces needs quotes"
            problem = f"{word} is no option" if left[0].startswith("-") else problem
            self._parser_of(found).error(problem)
        return found

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Refuse an unknown option first: argparse would miss the required one that it was meant to be."""
        for name in self._options_in(args or ()):
            known = self._option_string_actions
            if name not in known and not any(option.startswith(name) for option in known):
                self.error(f"{name[:_LONGEST]} is no option{suggest(name, known)}")
        return super().parse_known_args(args, namespace)

    def _options_in(self, words: Sequence[str]) -> Iterator[str]:
        """The names of long options among the words of this parser, which end at the word for a parser below."""
        has_verbs = any(isinstance(action, argparse._SubParsersAction) for action in self._actions)
        for word in words:
            if word == "--" or (has_verbs and not word.startswith("-")):
                return
            if word.startswith("--"):
                yield word.partition("=")[0]

    def _parser_of(self, found: argparse.Namespace) -> argparse.ArgumentParser:
        """The parser of the verb, and of its action, that was chosen."""
        for action in self._actions:
            if isinstance(action, argparse._SubParsersAction) and getattr(found, action.dest, None) is not None:
                below: OnceParser = action.choices[getattr(found, action.dest)]
                return below._parser_of(found)
        return self

    def _get_value(self, action: argparse.Action, text: str) -> Any:
        """Say of a value that is none what it should be, where its type has no message of its own: argparse would name
        the function that reads it."""
        kind = action.type
        if not callable(kind):
            return super()._get_value(action, text)
        try:
            return kind(text)
        except argparse.ArgumentTypeError as error:
            raise argparse.ArgumentError(action, str(error)) from None
        except (TypeError, ValueError):
            form = action.metavar if isinstance(action.metavar, str) else action.dest.upper()
            noun = "no whole number" if kind is int else "no number" if kind is float else f"not {form}"
            raise argparse.ArgumentError(action, f"{text[:_LONGEST]!r} is {noun}") from None

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is None or value in action.choices:
            return
        known = [str(each) for each in action.choices]
        typed = str(value)
        if isinstance(action, argparse._SubParsersAction):
            self.error(f"{typed[:_LONGEST]!r} is no {str(action.metavar).lower()}{suggest(typed, known)}")
        meant = suggest(typed, known)
        others = "" if meant and len(known) > _FEW else f"; {', '.join(known)} are"
        raise argparse.ArgumentError(action, f"{typed[:_LONGEST]!r} is not possible{meant}{others}")


class _Once(argparse.Action):
    """Refuses an option that the namespace it is stored in has met before."""

    _met: weakref.ref[argparse.Namespace] | None = None

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[Any] | None,
        option: str | None = None,
    ) -> None:
        if option is not None and self._met is not None and self._met() is namespace:
            raise argparse.ArgumentError(self, "is given twice")
        self._met = weakref.ref(namespace)
        super().__call__(parser, namespace, values, option)


class _StoreOnce(_Once, argparse._StoreAction):
    pass


class _StoreTrueOnce(_Once, argparse._StoreTrueAction):
    pass
