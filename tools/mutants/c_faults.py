"""Faults in C, by its tokens: comments, texts and the preprocessor's lines are left alone."""

from __future__ import annotations

import re
from collections.abc import Iterator

from tools.mutants.mutant import Mutant, line_of

QUIET = re.compile(
    rb"/\*.*?\*/|//[^\n]*|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'|^[ \t]*#(?:\\\n|[^\n])*",
    re.DOTALL | re.MULTILINE,
)
# Binary operators have a blank on both sides here, and so differ from pointers and signs.
SWAPPED = {
    "comparison": {
        "<": ("<=", ">="), "<=": ("<", ">"), ">": (">=", "<="), ">=": (">", "<"),
        "==": ("!=",), "!=": ("==",),
    },
    "arithmetic": {
        "+": ("-",), "-": ("+",), "*": ("/",), "/": ("*",), "%": ("*",), "<<": (">>",),
        ">>": ("<<",), "&": ("|",), "|": ("&",), "^": ("&",), "+=": ("-=",), "-=": ("+=",),
        "|=": ("&=",), "&=": ("|=",),
    },
    "boolean": {"&&": ("||",), "||": ("&&",)},
}  # fmt: skip
BINARY = re.compile(rb"(?<= )(?:[<>=!+\-|&]=|<<|>>|&&|\|\||[<>+\-*/%&|^])(?= )")
NUMBER = re.compile(rb"(?<![\w.])(?:0[xX][0-9a-fA-F]+|\d+)(?=[uUlL]*\b)(?![\w.]*\.)")
WORD = re.compile(rb"\b(?:true|false)\b")
NOT = re.compile(rb"!(?=[A-Za-z_(])")
STEP = re.compile(rb"\+\+|--")
# a call, an assignment or a jump that is a line of its own
STATEMENT = re.compile(
    rb"^[ \t]+((?!return\b|else\b|if\b|for\b|while\b|switch\b|case\b|static\b|const\b|typedef\b)"
    rb"(?:[\w>.\[\]-]+(?: [+\-|&*]?= [^;{}\n]+|\([^;{}\n]*\))|break|continue));[ \t]*$",
    re.MULTILINE,
)


def mutants(path: str, source: bytes) -> Iterator[Mutant]:
    """Every mutant of a file, in the order of its bytes."""
    quiet = QUIET.sub(lambda found: re.sub(rb"[^\n]", b"~", found[0]), source)
    found = sorted(_changes(quiet), key=lambda change: change[1:])
    for operator, begin, end, text in found:
        line, before, after = line_of(source, begin, end, text)
        yield Mutant(path, line, operator, begin, end, text, before, after)


def _changes(source: bytes) -> Iterator[tuple[str, int, int, str]]:
    for one in BINARY.finditer(source):
        for operator, table in SWAPPED.items():
            for text in table.get(one[0].decode(), ()):
                yield operator, *one.span(), text
    for one in NUMBER.finditer(source):
        yield "constant", *one.span(), str(int(one[0], 0) + 1)
    for one in WORD.finditer(source):
        yield "constant", *one.span(), "false" if one[0] == b"true" else "true"
    for one in NOT.finditer(source):
        yield "sign", *one.span(), ""
    for one in STEP.finditer(source):
        yield "arithmetic", *one.span(), "--" if one[0] == b"++" else "++"
    for one in STATEMENT.finditer(source):
        yield "statement", *one.span(1), "(void)0"
