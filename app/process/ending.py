"""The end that a user or the system asks for: Ctrl+C, SIGTERM, SIGHUP, at any moment of the process.

`watch` comes before any other import. From then on `during` sets the answer to a wish: the process ends at once
(`END`, while there is nothing to unwind), the work is interrupted so that every `finally` runs (`INTERRUPT`), the
finished work is reported (`FINISH`), or a function is called (the window closes itself). A process that has not ended
`GRACE_S` later, because a library does not return, ends hard: partial files and children of this process go, one
sentence is printed, and the exit code is `CANCELLED`. A second wish does that at once.

Python runs handlers of signals between two bytecodes of the main thread, which a long call of a library keeps waiting.
The byte that Python's own handler in C writes does not wait; a thread reads it.
"""

from __future__ import annotations

import atexit
import os
import signal
import sys
import threading
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import NoReturn

CANCELLED = 4

SENTENCE = "Cancelled; nothing was written."

#: Seconds from the wish to the hard end: of a verb, of a verb that has work to keep, and of a window that has written
#: all that it holds.
GRACE_S, KEEPING_S, WINDOW_S = 0.35, 10.0, 3.0

#: Seconds of a window until then, also on a slow disk and a busy machine. Systems that shut down kill what is there
#: after 20 s or more, and what that leaves half-written the next start removes.
SAVING_S = 60.0

#: Seconds that tidying up may take when the end is hard.
TIDYING_S = 1.0

WISHES = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK") if hasattr(signal, name))

#: Clean-up functions by module and name, called if the module is loaded: decoders, partial files, working folders.
_TIDIERS = (
    ("engine.storage.untrusted", "stop_children"),
    ("engine.storage.atomic", "remove_own_partials"),
    ("app.session.settings", "close_own_sessions"),
)

Answer = Callable[[], None]


def END() -> None:
    """End at once: nothing has begun that must be unwound."""
    _end_hard()


def INTERRUPT() -> None:
    """Raise KeyboardInterrupt in the main thread, which its handler does."""


def FINISH() -> None:
    """Go on: the work is done and only reported."""


_answer: Answer = END
_grace_s = GRACE_S
_interrupted: BaseException | None = None
_late: threading.Timer | None = None
_wished = threading.Event()
_ends = threading.Lock()


def watch() -> None:
    """Heed wishes from now on, but for those that the process was started to ignore (`nohup`, in the background)."""
    with suppress(OSError, RuntimeError):  # without a pipe or a thread the main thread alone answers
        reading, writing = os.pipe()
        os.set_blocking(writing, False)
        threading.Thread(target=_attend, args=(reading,), name="ending", daemon=True).start()
        signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    for number in WISHES:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _handle)
    sys.unraisablehook = _unraisable


def is_end_wished() -> bool:
    """True once the end was asked for."""
    return _wished.is_set()


def keep_work() -> None:
    """Give an interrupted verb `KEEPING_S`, because there is something now that it still writes."""
    global _grace_s
    _grace_s = KEEPING_S


def go_on() -> None:
    """Go on after a wish that was answered by other work than the end; the next one ends the process at once."""
    _wished.clear()
    if _late is not None:
        _late.cancel()


def keep_frames(interrupt: BaseException) -> None:
    """Keep the functions that `interrupt` left, with all that they hold, until the process has ended.

    An interrupt falls between any two steps of a library: LLVM frees a module twice where it fell between the call that
    gives the module to the compiler and the note of it. What is not freed does no harm to a process that ends.
    """
    global _interrupted
    _interrupted = interrupt


@contextmanager
def during(answer: Answer, grace_s: float = GRACE_S) -> Iterator[None]:
    """While the block runs, the first wish calls `answer`, on another thread, and the end is due `grace_s` later.

    Whatever a library made of the KeyboardInterrupt on the way becomes one again.
    """
    global _answer, _grace_s
    before, (_answer, _grace_s) = (_answer, _grace_s), (answer, grace_s)
    try:
        yield
    except BaseException:
        if answer is INTERRUPT and is_end_wished():
            raise KeyboardInterrupt from None
        raise
    finally:
        _answer, _grace_s = before


def finish(code: int) -> NoReturn:
    """End with `code` after a verb has done all: a wish that comes now changes nothing.

    Python would give the handlers of signals back while it takes its modules apart, and a wish would end the process as
    if the verb had failed. After an interrupt libraries are not told of the end: what they would free may be half made.
    """
    global _answer
    _answer = FINISH
    if code != CANCELLED:
        atexit._run_exitfuncs()
    leave(code)


def leave(code: int) -> NoReturn:
    """End with `code` without waiting for threads that are still at work."""
    with _ends:
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError):
                stream.flush()
        _end(code)


def end_within(seconds: float, code: int = CANCELLED) -> None:
    """End hard with `code` unless the process has ended by itself before; in place of what was said before.

    The code is 0 where all is done and only threads are left at work.
    """
    global _late
    if _late is not None:
        _late.cancel()
    _late = threading.Timer(seconds, _end_hard, (code,))
    _late.daemon = True
    _late.start()


def _handle(number: int, _frame: FrameType | None) -> None:
    """Runs in the main thread, some time after the byte was written."""
    if _answer is END:
        END()
    if _answer is INTERRUPT and not is_end_wished():
        _wished.set()
        raise KeyboardInterrupt


def _attend(reading: int) -> None:
    """Answer the first wish; at the second, or when the time is over, end hard."""
    while os.read(reading, 1)[0] not in WISHES:
        pass
    answer, grace_s = _answer, _grace_s
    if answer is not INTERRUPT:
        _wished.set()
    end_within(grace_s)
    answer()
    while os.read(reading, 1)[0] not in WISHES:
        pass
    _end_hard()


def _end_hard(code: int = CANCELLED) -> None:
    _ends.acquire(timeout=TIDYING_S)
    mark = "\r\x1b[K" if sys.stderr is not None and sys.stderr.isatty() else ""
    _end(code, f"{mark}{SENTENCE}\n" if code else "")


def _end(code: int, words: str = "") -> NoReturn:
    """Tidy up, say `words`, and end; on a thread of its own, because a disk or a full pipe may keep either waiting."""
    last = threading.Thread(target=_tidy_up, args=(words,), daemon=True)
    with suppress(RuntimeError):  # no thread starts any more once the interpreter ends by itself
        last.start()
        last.join(TIDYING_S)
    os._exit(code)


def _tidy_up(words: str) -> None:
    """Say `words`, and remove what no `finally` will."""
    sys.excepthook = lambda *_: None
    threading.excepthook = lambda *_: None
    if words:
        with suppress(OSError):
            os.write(2, words.encode())
    for module, function in _TIDIERS:
        # a module that is only being imported has nothing to tidy up, and perhaps no such function yet
        tidy = getattr(sys.modules.get(module), function, None)
        if tidy is not None:
            tidy()
    # folders for temporary files; the module has no other way to tell. What libraries would free is still at work in
    # other threads, whom that would crash.
    for each in list(getattr(weakref.finalize, "_registry", ())):
        kept = each.peek()
        if kept is not None and getattr(kept[1], "__module__", "") == "tempfile":
            with suppress(OSError):
                each()


def _unraisable(hook: sys.UnraisableHookArgs) -> None:
    """Drop an interrupt that fell into a destructor: the end that was asked for comes all the same."""
    if not (is_end_wished() and issubclass(hook.exc_type, KeyboardInterrupt)):
        sys.__unraisablehook__(hook)
