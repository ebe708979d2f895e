#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Words and Flesch reading ease of every page, worst first; printed by `./hd docs`.

Flesch: 206.835 - 1.015 words a sentence - 84.6 syllables a word; 60 and more reads easily, below 30 is hard. Code, tables, links' targets and
formulas are left out of both. Syllables are counted as groups of vowels, so compare pages with each other, not with other tools.

    tools/readability.py              the pages as they are
    tools/readability.py COMMIT       beside those of a commit
"""
import re
import subprocess
import sys
from pathlib import Path
from statistics import median

ROOT = Path(__file__).parents[1]
LISTS = {"parameters.md", "command_line.md", "command_line_run.md", "command_line_results.md", "command_line_surfaces.md", "command_line_teeth.md", "requirements.md", "record_ages.md", "coverage.md", "equations.md"}  # made from the sources


def prose(text):
    """Sentences of a page without code, tables, headings, targets of links and formulas."""
    text = re.sub(r"^```.*?^```", "", text, flags=re.S | re.M)
    text = re.sub(r"<!--.*?-->", "", text, flags=re.S)
    text = re.sub(r"^\s*(\||#).*$", "\n", text, flags=re.M)
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    text = re.sub(r"`([^`]*)`|\$[^$]*\$", "name", text)
    text = re.sub(r"^\s*(?:[-*]|\d+\.) ", ". ", text, flags=re.M)
    return [s for s in re.split(r"[.!?;:](?=\s|$)|\n\s*\n", text) if re.search(r"[A-Za-z]{2}", s)]


def syllables(word):
    """Groups of vowels, a silent e at the end left out; at least one."""
    word = word.lower()
    count = len(re.findall(r"[aeiouy]+", word))
    return max(1, count - (word.endswith("e") and not word.endswith("le")))


def measure(text):
    """Words of the whole page, and Flesch of its prose (None without any)."""
    sentences = prose(text)
    words = re.findall(r"[A-Za-z][A-Za-z'-]*", " ".join(sentences))
    if len(words) < 30:
        return len(text.split()), None
    return len(text.split()), 206.835 - 1.015 * len(words) / len(sentences) - 84.6 * sum(map(syllables, words)) / len(words)


def pages(commit=None):
    """Name and text of README and docs, of the folder or of a commit."""
    if commit is None:
        found = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
        return {str(p.relative_to(ROOT)): p.read_text() for p in found if "_build" not in p.parts}
    git = ["git", "-C", str(ROOT)]
    names = subprocess.run([*git, "ls-tree", "-r", "--name-only", commit, "--", "README.md", "docs"], capture_output=True, text=True, check=True)
    return {n: subprocess.run([*git, "show", f"{commit}:{n}"], capture_output=True, text=True, check=True).stdout
            for n in names.stdout.split() if n.endswith(".md")}


def shown(found):
    """Words and Flesch as one cell."""
    return f"{found[0]:6d} {'-' if found[1] is None else format(found[1], '.0f'):>4}" if found else f"{'-':>6} {'-':>4}"


def summary(name, found):
    """One line on the pages besides notebook and lists: number, longest, medians of words and Flesch."""
    own = {page: (words, ease) for page, (words, ease) in found.items() if page.startswith("docs/") and not {"notebook", "gallery", "api"} & set(page.split("/"))
           and page.rsplit("/", 1)[1] not in LISTS}
    longest = max(own, key=lambda page: own[page][0])
    return (f"  {name}: {len(own)} pages, longest {own[longest][0]} words ({longest}), median {median(w for w, _ in own.values()):.0f} words, "
            f"Flesch {median(e for _, e in own.values() if e is not None):.0f}")


def main():
    """Print the table."""
    commit = sys.argv[1] if len(sys.argv) > 1 else None
    now = {name: measure(text) for name, text in pages().items()}
    old = {name: measure(text) for name, text in pages(commit).items()} if commit else {}
    print(f"{'words, Flesch':>13}{'  of ' + commit[:7] if commit else ''}")
    for name in sorted({**now, **old}, key=lambda n: (now.get(n) or old[n])[1] or 100):
        print(f"  {shown(now.get(name))}{'  ' + shown(old.get(name)) if commit else ''}  {name}")
    for name, found in ((commit, old), ("now", now)):
        if found:
            print(summary(name, found))
    print(f"  {sum(w for w, _ in now.values()):6d} words on {len(now)} pages" + (f", {sum(w for w, _ in old.values())} on {len(old)}" if commit else ""))


if __name__ == "__main__":
    main()
