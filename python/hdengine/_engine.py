# SPDX-License-Identifier: GPL-3.0-or-later
"""The one door to the Fortran engine: a process-wide lock, errors as exceptions, interrupts, the log, forks."""
from __future__ import annotations

import functools
import logging
import os
import threading
import time
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np

MOST_THREADS = 1024   # as in hd_system.c


def _load() -> Any:
    """Entries of the extension. Its threads soon sleep while they wait (hd_system.c), unless the environment says otherwise; OpenMP
    ends the process where it asks for a hundred thousand."""
    sets = {"OMP_WAIT_POLICY": "passive", "GOMP_SPINCOUNT": "1000"}
    if sets.keys() & os.environ.keys():
        sets = {}
    threads = os.environ.get("OMP_NUM_THREADS", "")
    if threads.isdecimal() and int(threads) > MOST_THREADS:
        sets["OMP_NUM_THREADS"] = str(MOST_THREADS)
    before = {name: os.environ.get(name) for name in sets}
    os.environ.update(sets)
    try:
        from . import _hdengine as extension  # type: ignore[attr-defined]  # compiled
    finally:
        for name, value in before.items():
            del os.environ[name]
            os.environ.update({} if value is None else {name: value})
    modules = [module for name, module in vars(extension).items() if name.startswith("f2py_")]
    entries = SimpleNamespace(**{name: entry for module in modules for name, entry in vars(module).items()})
    entries.engine_begin()
    return entries


_hdengine = _load()
_lock = threading.RLock()  # MUMPS is not safe in concurrent calls
_logger = logging.getLogger("hdengine")
_logger.addHandler(logging.NullHandler())
_LONG = ("run_open", "run_advance", "scene_text")  # they stop at a signal and write the log


class HdengineError(Exception):
    """Base of all errors of the engine; `code` is the exit code of hdengine.x."""

    code = 1


class InternalError(HdengineError):
    """A bug in hdengine."""

    code = 1


class InputError(HdengineError, ValueError):
    """A key, a value or a combination of them is not valid."""

    code = 2


class FileError(HdengineError, OSError):
    """A file cannot be read or written, or holds earlier results."""

    code = 3


class NotConvergedError(HdengineError):
    """No equilibrium was found (gross slip, no convergence); converged steps are kept."""

    code = 4


class LinearSolverError(HdengineError):
    """The factorisation failed: a body is not held."""

    code = 5


class EngineMemoryError(HdengineError, MemoryError):
    """The problem does not fit into memory."""

    code = 6


class StoppedError(HdengineError):
    """The run stopped at a limit; finished steps are kept."""

    code = 7


_classes = {
    kind.code: kind
    for kind in (InputError, FileError, NotConvergedError, LinearSolverError, EngineMemoryError, StoppedError)
}


def _bytes(argument):
    """A text as bytes: f2py takes no letter beyond ASCII otherwise."""
    try:
        return os.fsencode(argument) if isinstance(argument, str) else argument
    except UnicodeEncodeError:
        raise InputError(f"{argument!r}: has a character that no file name can have") from None


def _text():
    """The text that the last call handed over, of any length."""
    parts = [_hdengine.handed_text(1)]
    while parts[-1].strip():
        parts.append(_hdengine.handed_text(sum(map(len, parts)) + 1))
    return b"".join(parts).decode(errors="replace").strip()


def call_with_text(name: str, *args: object) -> tuple:
    """Call an entry of the extension that hands over a text, too.

    Returns
    -------
    tuple
        The other results, then the text.

    Raises
    ------
    HdengineError
        As `call`.
    """
    with _lock:
        results = call(name, *args)
        return *(results or ()), _text()


def call_text(name: str, *args: object) -> str:
    """Text that an entry of the extension hands over.

    Returns
    -------
    str

    Raises
    ------
    HdengineError
        As `call`.
    """
    return call_with_text(name, *args)[-1]


def call(name: str, *args: object) -> Any:
    """Call an entry of the extension that can fail: its last result is the status.

    Returns
    -------
    The other results: a tuple, a single value, or None.

    Raises
    ------
    HdengineError
        The subclass that belongs to the status.
    """
    with _lock:
        entry = getattr(_hdengine, name)
        found = (_watched if name in _LONG else _plain)(entry, [*map(_bytes, args)])
        *results, status = found if isinstance(found, tuple) else (found,)
        text = _text() if status != 0 else ""
    if status != 0:
        raise _classes.get(int(status), InternalError)(text.removeprefix("error: "))
    if not results:
        return None
    return results[0] if len(results) == 1 else tuple(results)


def ask(name: str, *args: object) -> Any:
    """Call an entry of the extension that cannot fail."""
    with _lock:
        return getattr(_hdengine, name)(*args)


def _plain(entry, args):
    return entry(*args)


def _watched(entry, args):
    """Call an entry that takes long: signals stop it, lines of its log go to the logger `hdengine` while it works."""
    done = threading.Event()
    reader: Any = None
    _forward_log(False)
    if _logger.isEnabledFor(logging.INFO):
        reader = threading.Thread(target=_follow_log, args=(done,), daemon=True)
        reader.start()
    _hdengine.signals_watch()
    try:
        return entry(*args)
    finally:
        stopped = _hdengine.signals_unwatch()
        done.set()
        if reader:
            reader.join()
            _forward_log(True)
        if stopped:
            time.sleep(0)  # Python's own handler comes first: KeyboardInterrupt, not StoppedError


def _follow_log(done):
    """Pass lines on until the engine is done."""
    while not done.wait(0.2):
        _forward_log(True)


def _forward_log(wanted):
    """Pass all kept lines on, or throw them away."""
    line, found = _hdengine.log_take()
    while found:
        if wanted:
            _logger.info("%s", line.decode(errors="replace").rstrip())
        line, found = _hdengine.log_take()


def checksum(path: str | os.PathLike, size: int = -1) -> str:
    """Checksum of the first bytes of a file, of all by default; '' where it cannot be read. Waits for no run."""
    return _hdengine.checksum_of(os.fsencode(os.path.realpath(path)), size).decode().strip()


def stop_signals() -> list[int]:
    """Signals that end a run in order: one list for hdengine.x, the command and the engine in a program of others."""
    return [int(number) for number in _hdengine.signals_list() if number]


class FolderLock:
    """A folder that this process alone writes into, as a context.

    Raises
    ------
    FileError
        Another process is at work in it; the message names it.
    """

    def __init__(self, folder: str | os.PathLike) -> None:
        self._folder = str(folder)

    def __enter__(self) -> FolderLock:
        self._handle = call("folder_lock", self._folder)
        return self

    def __exit__(self, *exc: Any) -> None:
        ask("folder_unlock", self._handle)


def _after_fork():
    """In a forked child: the lock is open, the engine computes with one thread."""
    global _lock
    _lock = threading.RLock()
    _hdengine.fork_child()


# A fork waits for the end of the call that is at work: the child would find the engine in the middle of it.
os.register_at_fork(before=lambda: _lock.acquire(), after_in_parent=lambda: _lock.release(), after_in_child=_after_fork)


@functools.cache
def names(values: str) -> tuple[str, ...]:
    """Names of the places of a list of numbers that crosses to the engine and back (hd_named_values)."""
    return tuple(call_text("value_names", values).split(","))


def supported(scene: Mapping[str, Any], answer: str) -> bool:
    """An answer of `support_t` (hd_support) holds of the scene's support: contact, loop, struts, teeth ..."""
    return scene["load.support"] in names(f"support_{answer}")


def named(values: str, **given: float) -> np.ndarray:
    """A list of numbers for the engine, from its values by name.

    Raises
    ------
    InternalError
        A name is missing, or is none of the list's.
    """
    if wrong := set(given) ^ set(names(values)):
        raise InternalError(f"the list '{values}' and the names given differ by {', '.join(sorted(wrong))}")
    return np.array([float(given[name]) for name in names(values)])


def version() -> str:
    """Version of the engine."""
    return ask("engine_version").decode().strip()
