"""The word that a user may have meant: the known one that is most like what was typed."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

#: Likeness of two words, 1 for equal ones, from which one is taken for the other.
LIKENESS = 0.6

#: Characters of a word that are compared; what is longer is no word.
_LONGEST = 60


def suggest(word: str, known: Iterable[str]) -> str:
    """The addition ` (did you mean 'render'?)` to a message about `word`, empty where no `known` word is like it.

    Letter case, and _ in place of -, make no difference; a word of which `word` is the beginning, or part, is like it.
    """
    plain = {_plain(each): each for each in reversed(list(known))}
    typed = _plain(word[:_LONGEST])
    close = get_close_matches(typed, plain, 1, LIKENESS)
    if not close and len(typed) > 2:
        close = [each for each in reversed(plain) if typed in each or (len(each) > 2 and each in typed)]
    return f" (did you mean {plain[close[0]]}?)" if close else ""


def _plain(word: str) -> str:
    return word.lower().replace("_", "-").lstrip("-")
