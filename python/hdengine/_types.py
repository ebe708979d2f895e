# SPDX-License-Identifier: GPL-3.0-or-later
"""Types of arguments that several modules take."""
from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias, Union

# A file or a folder; the value of a key or of a group of a scene; distance of points, one or (dy, dx) [m].
PathLike: TypeAlias = Union[str, "os.PathLike[str]"]  # noqa: UP007
Value: TypeAlias = Union[float, str, bool, Sequence[float | str], Mapping[str, Any]]  # noqa: UP007
Spacing: TypeAlias = Union[float, Sequence[float]]  # noqa: UP007
