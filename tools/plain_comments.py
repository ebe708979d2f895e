# SPDX-License-Identifier: GPL-3.0-or-later
"""Markdown for FORD in which stars and underscores are themselves: comments hold formulas, not emphasis."""
from markdown.extensions import Extension


class PlainComments(Extension):
    """Takes emphasis out of Markdown's inline patterns."""

    def extendMarkdown(self, md):  # noqa: N802  (the name that Markdown calls)
        """Called by Markdown when the extension is loaded."""
        for pattern in ("em_strong", "em_strong2"):
            md.inlinePatterns.deregister(pattern, strict=False)


def makeExtension(**options):  # noqa: N802  (the name that Markdown asks for)
    """The extension."""
    return PlainComments(**options)
