#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every warning and every error with what to do: docs/reference/errors.md from the messages in the sources.

A message says what happened and then what to do or what is valid. Where an error says no more, its exit code does (ADVICE); a warning has no code.
Fortran: `raise(error, code_x, message)`, and `push`, `need` and `ask` into lists of warnings or faults. Python: exceptions of hdengine.
The page is made whenever the site is built (docs/conf.py) and is not kept in the repository. Usage: tools/messages_page.py
"""
import ast
import re
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
VALUE = "…"  # stands for what is known at run time alone
CODES = {  # name in Fortran: exit code, exception of Python, what happened
    "internal": (1, "InternalError", "a bug in hdengine"),
    "input": (2, "InputError", "a key, a value or an option is not valid"),
    "file": (3, "FileError", "no such file, it is damaged, or the folder holds results or is in use"),
    "not_converged": (4, "NotConvergedError", "no equilibrium was found, as in gross slip"),
    "linear_solver": (5, "LinearSolverError", "a matrix cannot be factorised: a body is not held"),
    "memory": (6, "EngineMemoryError", "the mesh does not fit into the memory"),
    "stopped": (7, "StoppedError", "a signal or a limit of time; finished steps are kept")}
ADVICE = {  # what to do, where the message says no more
    "internal": "Report it with `echo.nml` and the message.",
    "input": "Change what is named.",
    "file": "Check the path; `--out` takes another folder, `--force` replaces what is there.",
    "not_converged": "More `load.torque_steps` or `solver.max_iterations`, less `load.torque`, or more `contact.friction`.",
    "linear_solver": "Hold the body: check `load.support` and `contact.mode`.",
    "memory": "Take a coarser mesh, or raise `mesh.memory_limit_mb`.",
    "stopped": "The same again with `--resume`."}
MARKS = re.findall(r"warning_t\('(.*?)', ", (ROOT / "fortran/drive/scene/hd_warning_list.f90").read_text())  # of warnings, by number
WARNING_LISTS = ("lines", "plan%warnings", "record%warnings", "run%record%warnings")
HEAD = """# Which warning means what: warnings and errors

A **warning** does not stop a run. It stands at the end of the log, in `warnings` of `summary.json` and in the report. An **error** ends it with an exit code;
Python raises the exception of the same row, derived from `HdengineError`. Load steps that were finished stay in the folder.

"""
TAIL = f"""
All mistakes of an input are shown at once, each with its line, the value seen and the nearest valid name; `--check` shows them without a run, `--explain KEY` what a key means.
Warnings come by their number (W1), with which the log ends them. In the lists below {VALUE} stands for what is known at run time alone, ‹this / that› for one of them.
"""


class Message(NamedTuple):
    """One warning or error: where it is raised, of which kind (a key of CODES, or warning), what it says."""

    place: str
    kind: str
    text: str


def split(text, at):
    """Parts of a Fortran or Python expression at a mark that stands in no bracket and no string."""
    parts, depth, quote, i, begin = [], 0, "", 0, 0
    while i < len(text):
        c = text[i]
        if quote:
            quote = "" if c == quote else quote
        elif c in "'\"":
            quote = c
        elif c in "([":
            depth += 1
        elif c in ")]":
            depth -= 1
            if depth < 0:
                break
        elif depth == 0 and text.startswith(at, i):
            parts.append(text[begin:i])
            begin = i + len(at)
            i = begin - 1
        i += 1
    return [*parts, text[begin:i]]


def words(expression, known=None):
    """What a Fortran expression of strings says; known: what variables were set to."""
    parts = ""
    for part in map(str.strip, split(expression, "//")):
        name = part.removeprefix("trim(").removesuffix(")").split("%")[-1]
        if part[:1] in "'\"" and part[-1:] == part[:1]:
            parts += part[1:-1].replace(part[0] * 2, part[0])
        elif re.fullmatch(r"nl|new_line\('a'\)", part):
            parts += " "
        elif re.match(r"(trim\()?merge\('", part):
            parts += one_of(x.strip() for x in re.findall(r"'([^']*)'", part)[:2])
        else:
            parts += (known or {}).get(name, VALUE)
    return tidy(parts)


def settings(text):
    """What variables of strings are set to."""
    found = {}
    for name, expression in re.findall(r"^[^!\n]*?\b(\w+) = ((?:trim\([\w%]+\)//)?['\"].*)$", text, re.M):
        found.setdefault(name, {})[words(expression)] = True
    return {name: one_of(sorted((x for x in texts if re.search("[a-z]{3}|^$", x)), key=lambda x: not x)) for name, texts in found.items()}


def one_of(texts):
    """Alternatives as they are shown; nothing is the last."""
    texts = [*texts]
    return f"‹{' / '.join(texts)}›" if len(texts) > 1 else "".join(texts) or VALUE


def tidy(said):
    """Text without the word error, runs of blanks and doubled marks of what is left out."""
    said = re.sub(rf"{VALUE}(\s?{VALUE})+", VALUE, re.sub(r"\s+", " ", said).strip())
    return said.removeprefix("error: ").strip()


def fortran():
    """Messages of the engine."""
    texts = {path: re.sub(r"&\s*\n\s*&?", "", re.sub(r"^\s*!.*\n", "", path.read_text(), flags=re.M)) for path in sorted((ROOT / "fortran").rglob("*.f90"))}
    doubts = {name: said for text in texts.values() for name, said in settings("\n".join(re.findall(r"^.*%\w+_doubt = .*$", text, re.M))).items()}
    for path, text in texts.items():
        for call in re.finditer(r"call (raise|push|need|ask)\(", text):
            begin = max(text.rfind("subroutine", 0, call.start()), text.rfind("function", 0, call.start()))
            known = doubts | settings(text[begin:call.start()])
            args = [a.strip() for a in split(text[call.end():], ",")]
            if call[1] == "raise" and args[1].startswith("code_"):
                yield Message(path.stem, args[1].removeprefix("code_"), words(args[2], known))
            elif call[1] == "push" and (args[0] in WARNING_LISTS or args[0].endswith("faults")):
                yield Message(path.stem, "warning" if args[0] in WARNING_LISTS else "input", words(args[1], known))
            elif call[1] in ("need", "ask") and len(args) > 4:
                yield Message(path.stem, "input", f"{words(args[2])} = {VALUE} valid: {words(args[4])}")


def python():
    """Messages of the package."""
    kinds = {name: kind for kind, (_, name, _) in CODES.items()}
    for path in sorted((ROOT / "python/hdengine").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if not isinstance(node, ast.Call) or not node.args:
                continue
            name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            if name in kinds:
                yield Message(path.stem, kinds[name], tidy(said(node.args[0])))


def said(node):
    """What a Python expression of strings says."""
    if isinstance(node, ast.Constant):
        return str(node.value)
    if isinstance(node, ast.JoinedStr):
        return "".join(said(v) for v in node.values)
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        return said(node.left) + said(node.right)
    return VALUE


def messages():
    """All messages that say more than what is known at run time, sorted by their text; of two alike one."""
    found = {m.text: m for m in (*fortran(), *python()) if re.search(r"[a-z]{3}", m.text)}
    return sorted(found.values(), key=lambda m: m.text.lstrip(f"{VALUE}‹'-: ").lower())


def page():
    """The page as text."""
    rows = "".join(f"| {code} | `{name}` | {what} | {ADVICE[kind]} |\n" for kind, (code, name, what) in CODES.items())
    text = f"{HEAD}| code | exception | what happened | what to do, where the message says no more |\n|---|---|---|---|\n"
    text += f'| 0 | | done; `"status": "complete"` in `summary.json` | Read the warnings. |\n{rows}{TAIL}'
    titles = {"warning": "Warnings"} | {kind: f"Code {code}: {what}" for kind, (code, _, what) in CODES.items()}
    found = sorted(messages(), key=lambda m: number(m.text) if m.kind == "warning" else 0)
    for kind in ("warning", "not_converged", "linear_solver", "memory", "stopped", "file", "internal", "input"):
        lines = "".join(f"- {f'W{number(m.text)} ' if kind == 'warning' and number(m.text) <= len(MARKS) else ''}{marked(m.text)}\n"
                        for m in found if m.kind == kind)
        text += f"\n## {titles[kind]}\n\n{lines}"
    return text


def number(text):
    """Number of a warning, as the log ends it; one more than there are: none."""
    return next((i for i, mark in enumerate(MARKS, 1) if mark.rstrip() in text), len(MARKS) + 1)


def marked(text):
    """A message as Markdown: its first words in bold, for the eye."""
    text = re.sub(r"([\\*_|<>`$\[\]])", r"\\\1", text)
    first = re.match(r"((?:‹[^›]*›|[^‹]){12,}?)(?=[;:,.]? valid:|[;:,] |\. [A-Z]|‹|$)", text)
    return f"**{first[0].strip()}**{text[first.end():]}" if first else text
