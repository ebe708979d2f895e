# SPDX-License-Identifier: GPL-3.0-or-later
"""What arguments must be, stated beside the functions that take them: kind, shape, finite values, range.

A rule takes the name and the value of an argument and returns the value as the function wants it, or raises InputError with the
name, the value seen and what is valid.
"""
import contextlib
import functools
import importlib
import inspect
import operator
import os
import re
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ._engine import FileError, InputError

MOST_BYTES = 2**30  # of a file that is read as a whole, as in the engine
ROUNDING = 1e-9     # relative, or in the unit of a table: numbers that differ by less are one
HUGE = 1e300        # beyond: no number that anything is computed with
NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", re.ASCII)  # float takes 1_0 and all scripts
F = TypeVar("F", bound=Callable)


def alike(a, b):
    """Whether two values of a key are one."""
    if isinstance(a, str) or isinstance(b, str):
        return a == b
    return a is not None and abs(a - b) <= ROUNDING * max(abs(a), abs(b))


def seen(value):
    """A value as short text."""
    if isinstance(value, np.ndarray) and value.ndim:
        return f"array of shape {value.shape}, {value.dtype}"
    if isinstance(value, np.generic):
        value = value.item()
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else text[:57] + "..."


def _fail(name, value, valid):
    raise InputError(f"{name} = {seen(value)}: must be {valid}") from None


def _range_text(above, least, below, most):
    low = f" above {above:g}" if above is not None else f" of {least:g} or more" if least is not None else ""
    high = f" below {below:g}" if below is not None else f" up to {most:g}" if most is not None else ""
    return " and".join(part for part in (low, high) if part)


def _outside(x, above, least, below, most):
    """Which values are outside of the range."""
    out = np.zeros(np.shape(x), bool)
    for limit, wrong in ((above, np.less_equal), (least, np.less), (below, np.greater_equal), (most, np.greater)):
        if limit is not None:
            out |= wrong(x, limit)
    return out


def _floats(value):
    """A value as float array, or None where it is no array of real numbers."""
    try:
        a = np.asarray(value)
        if a.dtype.kind == "O":  # integers beyond 64 bits, or a list with None
            if not all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in a.flat):
                return None
        elif a.dtype.kind not in "fiu" and a.size:
            return None
        return a.astype(float, copy=False)
    except (TypeError, ValueError, OverflowError):
        return None


def number(above=None, least=None, below=None, most=None, finite=True, optional=False):
    """A rule: one real number."""
    valid = f"a {'finite ' if finite else ''}number{_range_text(above, least, below, most)}"

    def rule(name, value):
        if optional and value is None:
            return None
        if type(value) in (float, int) and -HUGE < value < HUGE and (above is None or value > above) \
                and (least is None or value >= least) and (below is None or value < below) and (most is None or value <= most):
            return float(value)  # the same without arrays, which cost as much as a small surface
        x = _floats(value)
        if x is None or x.ndim or isinstance(value, (bool, np.bool_)) or (finite and not np.isfinite(x)) \
                or _outside(x, above, least, below, most):
            _fail(name, value, valid + (", or None" if optional else ""))
        return float(x)
    return rule


def integer(least=None, most=2**31 - 1, optional=False):
    """A rule: one whole number."""
    valid = f"a whole number{_range_text(None, least, None, most)}"

    def rule(name, value):
        if optional and value is None:
            return None
        try:
            x = operator.index(value)
        except TypeError:
            _fail(name, value, valid)
        if isinstance(value, (bool, np.bool_)) or _outside(x, None, least, None, most):
            _fail(name, value, valid)
        return x
    return rule


def array(shape=None, above=None, least=None, most=None, finite=True, holes=False, optional=False, empty=False):
    """A rule: an array of real numbers; a shape has None where any length will do, and may be a list of shapes."""
    shapes = [shape] if isinstance(shape, tuple) else shape
    among = f" of shape {' or '.join(str(s).replace('None', 'n') for s in shapes)}" if shapes else ""
    text = _range_text(above, least, None, most)
    valid = f"{'' if holes or not finite else 'finite '}numbers{text and ',' + text}{among}" + (", or None" if optional else "")
    unlimited = all(limit is None for limit in (above, least, most))

    def rule(name, value):
        if optional and value is None:
            return None
        a = _floats(value)
        if a is None or (not a.size and not empty) or (shapes and not any(
                len(s) == a.ndim and all(m in (None, n) for m, n in zip(s, a.shape)) for s in shapes)):
            _fail(name, value, valid)
        if unlimited and np.isfinite(a).all():
            return a
        wrong = _outside(a, above, least, None, most)
        if holes:
            wrong |= np.isinf(a)
        elif finite:
            wrong |= ~np.isfinite(a)
        if wrong.any():
            at = np.unravel_index(np.argmax(wrong), a.shape)
            place = f"[{', '.join(map(str, at))}]" if a.ndim else ""
            _fail(name + place, float(a[at]), valid)
        return a
    return rule


def integers(shape=None, least=None, most=2**31 - 1, optional=False, empty=False):
    """A rule: an array of whole numbers (int64)."""
    valid = f"whole numbers{_range_text(None, least, None, most)}" + (f" of shape {shape}".replace("None", "n") if shape else "")

    def rule(name, value):
        if optional and value is None:
            return None
        a = _floats(value)
        if a is None or (not a.size and not empty) or (shape is not None and (
                len(shape) != a.ndim or any(m not in (None, n) for m, n in zip(shape, a.shape)))) \
                or not np.isfinite(a).all() or (a != np.floor(a)).any() or _outside(a, None, least, None, most).any():
            _fail(name, value, valid)
        return a.astype(np.int64, copy=False)
    return rule


def flag(name, value):
    """A rule: true or false."""
    if isinstance(value, (bool, np.bool_)) or (isinstance(value, (int, np.integer)) and value in (0, 1)):
        return bool(value)
    return _fail(name, value, "True or False")


def optional(rule):
    """A rule: another one, or None."""
    return lambda name, value: None if value is None else rule(name, value)


def like(what, *names):
    """A rule: an object that has attributes of some names, as what `what` says has."""
    def rule(name, value):
        return value if all(hasattr(value, n) for n in names) else _fail(name, value, what)
    return rule


RUN = like("a Result: what hdengine.load gives", "scene", "steps", "summary", "folder")
AXES = optional(like("matplotlib axes, or None", "loglog"))
function = like("a function", "__call__")


def word(*choices):
    """A rule: one of some words."""

    def rule(name, value):
        return value if isinstance(value, str) and value in choices else _fail(name, value, "one of " + ", ".join(choices))
    return rule


def text(name, value):
    """A rule: a text."""
    whole = isinstance(value, str) and not any(c == "\0" or "\ud800" <= c <= "\udfff" for c in value)  # or half a letter
    return value if whole else _fail(name, value, "a text")


def path(name, value):
    """A rule: the path of a file or folder."""
    if isinstance(value, (str, os.PathLike)) and not isinstance(value, bytes):
        with contextlib.suppress(UnicodeError):
            found = os.fsencode(value) if isinstance(os.fspath(value), str) else b"\0"
            if b"\0" not in found and not found.endswith(b" ") and len(found) < 4096 and max(map(len, found.split(b"/"))) < 256:
                return value
    return _fail(name, value, "a path: a text or a pathlib.Path, names of up to 255 bytes, no blank at its end")


def folder(name, value):
    """A rule: the path of a folder; '' is none."""
    if isinstance(value, str) and not value:
        _fail(name, value, "the path of a folder, as 'run.out'; '.' is the current one")
    return path(name, value)


def input_file(path, most=None):
    """The path of a file to read, as `pathlib.Path`; pipes and devices, which may have no end, are refused before they are opened.

    Raises
    ------
    FileError
        Absent, a folder, no regular file, or longer than `most` bytes.
    """
    try:
        found = os.stat(path)
    except OSError as e:
        raise FileError(f"'{path}' cannot be read: {e.strerror}") from None
    if not stat.S_ISREG(found.st_mode):
        raise FileError(f"'{path}' is a folder, not an input file" if stat.S_ISDIR(found.st_mode) else
                        f"'{path}' is no file that can be read twice, as an input must be: copy it into one")
    if most is not None and found.st_size > most:
        raise FileError(f"'{path}' holds {found.st_size} bytes; valid: up to {most}")
    return Path(path)


def package(name, what, extra):
    """A package that need not be installed; InputError with the way to it where it is not."""
    try:
        return importlib.import_module(name)
    except ImportError:
        raise InputError(f"{what} needs {name}: pip install 'hdengine[{extra}]'") from None


def kind(*classes, optional=False):
    """A rule: an object of a class."""
    valid = " or ".join(c.__name__ for c in classes) + (", or None" if optional else "")

    def rule(name, value):
        if not (optional and value is None) and not isinstance(value, classes):
            _fail(name, value, f"of type {valid}")
        return value
    return rule


def mapping(name, value):
    """A rule: a dict whose keys are texts."""
    if not isinstance(value, dict) or not all(isinstance(k, str) for k in value):
        _fail(name, value, "a dict whose keys are texts")
    return value


def checked(**rules: Any) -> Callable[[F], F]:
    """Decorate a function with rules for its arguments; they apply to what is given, not to defaults."""
    def decorate(function: F) -> F:
        signature = inspect.signature(function)
        assert set(rules) <= set(signature.parameters), set(rules) - set(signature.parameters)

        @functools.wraps(function)
        def checking(*args, **keys):
            bound = signature.bind(*args, **keys)
            for name, value in bound.arguments.items():
                if name in rules:
                    bound.arguments[name] = rules[name](name, value)
            return function(*bound.args, **bound.kwargs)
        return checking  # type: ignore[return-value]  # wraps keeps what it takes and gives
    return decorate


def fields(instance, **rules):
    """Apply rules to the attributes of a dataclass, frozen or not."""
    for name, rule in rules.items():
        object.__setattr__(instance, name, rule(name, getattr(instance, name)))


def together(**arrays):
    """Arrays broadcast to one shape; InputError where that cannot be."""
    try:
        return np.broadcast_arrays(*arrays.values())
    except ValueError:
        shapes = ", ".join(f"{name} {np.shape(a)}" for name, a in arrays.items())
        raise InputError(f"shapes that do not fit together: {shapes}") from None
