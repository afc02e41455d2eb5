"""Explains syntax errors in YAML text."""

import re

import yaml

_QUOTED = re.compile(r"\"[^\"\n]*\"|'[^'\n]*'")
_WORDS = {
    "block sequence entries are not allowed": "put the first '-' of a list on its own line, below the key",
    "found unexpected end of stream": "the quotation mark that opens here is not closed",
    "found character that cannot start": "text that begins with this character must be quoted",
}


def explain(error: yaml.MarkedYAMLError, text: str) -> tuple[int, str]:
    """Return line and message of a syntax error."""
    opened, problem_mark = error.context_mark, error.problem_mark
    rows = text.splitlines()
    first, last = (min(mark.line + 1, len(rows)) if mark is not None else 0 for mark in (opened, problem_mark))
    context, problem = error.context or "", error.problem or "syntax error"
    line = last if "block" in context or not first else first
    for number in (first, last):
        row = rows[number - 1] if number else ""
        if "\t" in row[: len(row) - len(row.lstrip())]:
            return number, "tabs cannot indent YAML: use spaces"
    for beginning, words in _WORDS.items():
        if problem.startswith(beginning):
            return line, f"not valid YAML: {words}"
    if problem_mark is not None and problem.startswith("mapping values are not allowed"):
        return last, f"not valid YAML: {_colon(rows, last, problem_mark.column)}"
    if opened is not None and problem_mark is not None and "flow" in context:
        unclosed = _unclosed(context, "the end of the file" if problem_mark.line >= len(rows) else f"line {last}")
        return first, f"not valid YAML: {unclosed}{_parameter_hint(rows[first - 1 : last])}"
    if opened is not None and problem_mark is not None and "block" in context:
        row = rows[problem_mark.line] if problem_mark.line < len(rows) else ""
        return last, f"not valid YAML: {_misfit(row, problem_mark.column, opened.column, first)}"
    return line, f"not valid YAML: {', '.join(part for part in (context, problem) if part)}"


def _colon(rows: list[str], line: int, column: int) -> str:
    """Explain a misplaced ':'."""
    row = rows[line - 1]
    above = [number for number in range(1, line) if rows[number - 1].partition("#")[0].strip()]
    if ": " in row[:column] or not above:
        return "a second ':' in one line: text that contains ': ' must be quoted"
    before = rows[above[-1] - 1].partition("#")[0]
    if not re.search(r":(\s|$)", before):
        return f"line {above[-1]}, above this one, is not a 'key: value' with a space after the ':'"
    return f"indented deeper than line {above[-1]}, whose key already has a value"


def _unclosed(context: str, where: str) -> str:
    bracket = "{" if "mapping" in context else "["
    return f"the '{bracket}' that opens here is not closed, or a comma is missing, before {where}"


def _misfit(row: str, column: int, expected: int, first: int) -> str:
    """Explain a line that does not continue a block: wrong indentation, or text after a value."""
    if row[:column].strip():
        rest = row[column:].strip()[:20]
        return f"'{rest}' cannot follow the text before it: there is an extra mark, or two lines are joined"
    indent = len(row) - len(row.lstrip())
    if indent == expected:
        return f"this line does not continue line {first}: either all items begin with '-', or none"
    return f"indented by {indent}, but by {expected} in line {first}: items of one block must begin in the same column"


def _parameter_hint(rows: list[str]) -> str:
    is_parameter = "${" in _QUOTED.sub("", "\n".join(rows))
    return '; within { } or [ ], text with ${...} in it must be quoted: "${name}"' if is_parameter else ""
