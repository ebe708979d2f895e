# SPDX-License-Identifier: GPL-3.0-or-later
"""The one door to the Fortran engine: a process-wide lock, and errors as exceptions."""
import threading

from . import _hdengine

_lock = threading.RLock()  # MUMPS is not safe in concurrent calls


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


def call(name, *args):
    """Call an entry of the extension; its last two results are status and message.

    Returns
    -------
    The other results: a tuple, a single value, or None.

    Raises
    ------
    HdengineError
        The subclass that belongs to the status.
    """
    with _lock:
        *results, status, message = getattr(_hdengine, name)(*args)
    if status != 0:
        text = message.decode(errors="replace") if isinstance(message, bytes) else str(message)
        raise _classes.get(int(status), InternalError)(text.strip().removeprefix("error: "))
    if not results:
        return None
    return results[0] if len(results) == 1 else tuple(results)


def asperity(*args):
    """Entry `asperity` of the extension (it cannot fail)."""
    with _lock:
        return _hdengine.asperity(*args)


def version():
    """Version of the engine."""
    text = _hdengine.engine_version()
    return (text.decode() if isinstance(text, bytes) else str(text)).strip()
