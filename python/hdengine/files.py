# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that Python writes: nothing is overwritten unasked, and what is cut short does not look whole."""
from __future__ import annotations

import contextlib
import errno
import io
import json
import os
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from . import _engine
from ._check import MOST_BYTES, input_file
from ._engine import FileError
from ._types import PathLike

__all__: list[str] = []
# files that say what a folder holds
_MARKS = ("summary.json", "study.json", "echo.nml", "record.json", "surface.json", "joint.json", "gaps.json")


def check_folder(folder: PathLike, names: Sequence[str], force: bool = False) -> None:
    """Refuse, before any work, a folder in which files would be overwritten, or cannot be written.

    Parameters
    ----------
    folder : path-like
    names : iterable of str
        Files that are to be written.
    force : bool
        Files of these names may be replaced; what another command wrote never is.

    Raises
    ------
    FileError
        The folder holds what another command wrote, one of the files, or something else in its place; or it cannot be made, or
        takes no files.
    """
    folder, names = Path(folder), list(names)
    for name in (m for m in _MARKS if m not in names):
        if (folder / name).exists():
            raise FileError(f"'{folder}' holds {name} of another command: choose another folder with --out")
    for name in names:
        if (folder / name).exists() and not force:
            raise FileError(f"'{folder}' holds {name} already: add --force to replace it, or choose another folder with --out")
        _check_place(folder / name)
    with writing(folder):
        _takes_files(next(p for p in (folder.absolute() / "x").parents if os.path.lexists(p)))


def check_file(path: PathLike | None, force: bool = False) -> None:
    """Refuse, before any work, to replace a file that the user named, or to write one where none can be; None is not checked.

    Raises
    ------
    FileError
        It is there and `force` is not given, or something else than a file is, or its folder is not there or takes no files.
    """
    if path is None:
        return
    if Path(path).is_file() and not force:
        raise FileError(f"'{path}' is there already: add --force to replace it, or choose another with --out")
    _check_place(Path(path))
    with writing(path):
        _takes_files(Path(path).absolute().parent)


def _check_place(path):
    """Refuse the name of a folder, a link, a pipe or a device."""
    if not path.name:
        raise FileError(f"'{path}' is a folder, not the name of a file")
    with writing(path):
        if path.is_symlink() or (path.exists() and not path.is_file()):
            raise OSError(errno.EINVAL, "it is no regular file: remove it, or choose another folder")


def _takes_files(folder):
    """Refuse what is no folder, or one in which no file can be made."""
    if not folder.is_dir():
        raise OSError(errno.ENOTDIR, f"'{folder}' is no folder")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise OSError(errno.EACCES, f"no file can be made in '{folder}'")


def write_folder(folder: PathLike, record: str, head: dict, files: dict, force: bool = False) -> list:
    """Write files into a folder and last of all the JSON record that lists them: without it they are not whole.

    Parameters
    ----------
    folder : path-like
    record : str
        Name of the record; an earlier one is removed first, with the files it lists.
    head : dict
        What the record holds besides "status", "hdengine" and "files".
    files : dict
        Text, or a matplotlib figure, by name.
    force : bool
        Replace files of these names.

    Returns
    -------
    list of Path
        The record first.

    Raises
    ------
    FileError
        As `check_folder`, or the folder cannot be written.
    """
    folder = Path(folder)
    check_folder(folder, [record, *files], force)
    whole = {"status": "complete", "hdengine": _engine.version(), **head, "files": list(files)}
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
    with _parts({folder / name: content for name, content in (*files.items(), (record, json_text(whole)))}):
        if (folder / record).exists():
            earlier = read_json(folder / record).get("files", [])
            (folder / record).unlink()
            for name in (n for n in earlier if isinstance(n, str) and Path(n).name == n):
                (folder / name).unlink(missing_ok=True)
    return [folder / record, *(folder / name for name in files)]


def write_files(files: Mapping[Path, Any]) -> None:
    """Write files that belong together: each is there whole or as it was before.

    Parameters
    ----------
    files : dict
        Text, bytes, an iterator of bytes, a matplotlib figure, or a function that writes the file at the path that it is given, by
        path; they are made one after the other.

    Raises
    ------
    FileError
        Something else than a file stands there (a link, a pipe), or it cannot be written.
    """
    with _parts(files):
        pass


@contextlib.contextmanager
def _parts(files):
    """Files under temporary names; at the end of the block they get their own, in order."""
    for path in files:
        _check_place(path)
    parts = {path: path.with_name(path.name + ".part") for path in files}
    try:
        for path, content in files.items():
            with writing(path):
                _write(parts[path], _content(path, content))
        yield
        for path, part in parts.items():
            with writing(path):
                os.replace(part, path)
    except BaseException:
        for part in parts.values():
            with contextlib.suppress(OSError):
                part.unlink(missing_ok=True)
        raise


def _content(path, content):
    """Bytes of a file, part by part. Text may hold a path that is no UTF-8."""
    if isinstance(content, str):
        return [content.encode("utf-8", "replace")]
    if isinstance(content, bytes):
        return [content]
    if isinstance(content, Iterator):
        return content
    if callable(content):
        with tempfile.TemporaryDirectory() as folder:
            made = Path(folder, path.name)
            with writing(made):
                content(made)
            return [made.read_bytes()]
    drawn = io.BytesIO()
    content.savefig(drawn, format=path.suffix[1:])
    return [drawn.getvalue()]


def _write(path, parts):
    """A new file, on the disk to its last byte."""
    path.unlink(missing_ok=True)
    with open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666), "wb") as file:
        size = sum(map(file.write, parts))
        file.flush()
        try:
            os.fsync(file.fileno())
        except OSError as e:
            if e.errno not in (errno.EINVAL, errno.ENOTSUP, errno.EROFS):   # some file systems know no fsync
                raise
        if os.fstat(file.fileno()).st_size != size:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@contextlib.contextmanager
def writing(path: PathLike) -> Iterator[None]:
    """Errors of the system as errors of the package that name the file."""
    try:
        yield
    except FileError:
        raise
    except OSError as e:
        raise FileError(f"'{path}' cannot be written: {e.strerror or e}") from None


def json_text(value: object) -> str:
    """JSON of what is to be written: UTF-8 in all texts, null for numbers that are not finite."""
    return json.dumps(_plain(value), indent=1, allow_nan=False) + "\n"


def _plain(value):
    """The same for JSON: arrays as lists, numbers that are not finite as null, texts without what is no UTF-8."""
    if isinstance(value, dict):
        return {_plain(k): _plain(v) for k, v in value.items()}
    if isinstance(value, str):
        return value.encode("utf-8", "replace").decode()
    if isinstance(value, (list, tuple, np.ndarray)):
        return [_plain(v) for v in value]
    if isinstance(value, (float, np.floating)):
        return float(value) if np.isfinite(value) else None
    return value.item() if isinstance(value, np.generic) else value


def csv_text(columns: dict) -> str:
    """A CSV table of columns: words as they are, numbers with ten digits, NaN as an empty cell."""
    def cell(v):
        return v if isinstance(v, str) else "" if v != v else f"{v:.10g}"
    return "\n".join([",".join(columns), *(",".join(map(cell, row)) for row in zip(*columns.values()))]) + "\n"


def read_json(path: PathLike, *needed: str) -> dict:
    """A JSON object; entries that are needed must be there.

    Raises
    ------
    FileError
        The file cannot be read, holds no JSON object, or lacks an entry.
    """
    file = input_file(path, MOST_BYTES)
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as e:
        raise FileError(f"'{path}' cannot be read: {getattr(e, 'strerror', None) or e}") from None
    if not isinstance(found, dict):
        raise FileError(f"'{path}' is not what hdengine writes: no JSON object")
    missing = [name for name in needed if name not in found]
    if missing:
        raise FileError(f"'{path}' is not what hdengine writes: no entry {', '.join(missing)}")
    return found
