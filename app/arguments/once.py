"""A parser whose options are given at most once, but for those that collect values (`append`)."""

from __future__ import annotations

import argparse
import weakref
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Sequence


class OnceParser(argparse.ArgumentParser):
    """An ArgumentParser that refuses an option that is given twice: argparse drops the first value without a word."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        for name, action in ((None, _StoreOnce), ("store", _StoreOnce), ("store_true", _StoreTrueOnce)):
            self.register("action", name, action)


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
