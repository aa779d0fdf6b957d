"""``QUANTITY=EXPRESSION:UNIT``: which column, or arithmetic of columns, is which quantity."""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motorid.capture import quadrature
from motorid.capture.columns import unknown_column
from motorid.capture.units import AMBIENT, QUANTITIES, TIME, Unit, unit_of
from motorid.errors import UsageError, nearest

Floats = NDArray[np.float64]
ROW = "row"  # a column that every file has: 0, 1, 2, ...
SHORTHAND = {"voltage": "terminal_voltage"}
_BINARY: dict[type[ast.AST], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
_SIGNS: dict[type[ast.AST], Callable[[Any], Any]] = {ast.USub: operator.neg, ast.UAdd: operator.pos}
_LONGEST = 500  # characters of an expression


@dataclass(frozen=True)
class ChannelMap:
    """One --map: the quantity, the expression as written, its unit."""

    quantity: str
    expression: str
    unit: Unit


def parse_maps(maps: Sequence[str], counts_per_turn: float = 0.0) -> dict[str, ChannelMap]:
    """The maps of a command line by quantity. Raises UsageError on a bad or a repeated one."""
    parsed = {
        quantity: ChannelMap(quantity, expression, unit_of(quantity, unit, counts_per_turn))
        for quantity, (expression, unit) in stated(maps).items()
    }
    if not parsed.keys() - {TIME, AMBIENT}:
        raise UsageError("nothing is mapped: give --map QUANTITY=COLUMN:UNIT, such as current=i:mA")
    return parsed


def stated(maps: Sequence[str]) -> dict[str, tuple[str, str]]:
    """Expression and unit of every ``QUANTITY=COLUMN:UNIT``, by quantity; the unit may be empty.

    Raises UsageError on another text, an unknown quantity, and one that is mapped twice.
    """
    found: dict[str, tuple[str, str]] = {}
    for text in maps:
        quantity, expression, unit = _parted(text)
        if quantity in found:
            raise UsageError(f"{quantity} is mapped twice: give each quantity one --map")
        found[quantity] = expression, unit
    return found


def _parted(text: str) -> tuple[str, str, str]:
    left, equals, right = text.partition("=")
    expression, colon, unit = right.rpartition(":")
    quantity = SHORTHAND.get(left.strip(), left.strip())
    if not (equals and colon and expression.strip()):
        raise UsageError(f"--map {text!r} is not QUANTITY=COLUMN:UNIT, such as current=i:mA")
    if quantity not in QUANTITIES:
        known = (*QUANTITIES, *SHORTHAND)
        raise UsageError(
            f"{quantity!r} is not a quantity{nearest(quantity, known)}; known: {', '.join(known)}"
        )
    return quantity, expression.strip(), unit.strip()


class Formula:
    """Arithmetic over columns and constants: ``vir*gtau``, ``Input Power/Current``, ``-i``.

    ``quadrature(A,B)`` counts the edges of an encoder's two lines.
    A column's own name wins over arithmetic: in a file with a column ``a-b``, that is what ``a-b``
    means. Raises UsageError on what is neither.
    """

    def __init__(self, text: str, columns: Sequence[str], constants: Mapping[str, float]) -> None:
        self.text = text
        self._constants = constants
        self._known = list(columns)
        self.columns: list[str] = []  # those that the formula needs
        self._tree = self._parse(text)
        self._check(self._tree)

    def _parse(self, text: str) -> ast.expr:
        names = sorted((*self._known, ROW), key=len, reverse=True)
        if text in names:
            return ast.parse(self._code(text), mode="eval").body
        pattern = "|".join(rf"(?<![\w.]){re.escape(name)}(?![\w.\[(])" for name in names if name)
        coded = re.sub(pattern, lambda hit: self._code(hit.group()), text)
        try:
            if len(text) > _LONGEST:
                raise SyntaxError
            return ast.parse(coded, mode="eval").body
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            raise unknown_column(text, self._known) from None

    def _code(self, name: str) -> str:
        if name not in self.columns:
            self.columns.append(name)
        return f"_c{self.columns.index(name)}"

    def _check(self, node: ast.AST) -> None:
        match node:
            case ast.BinOp(left=left, op=op, right=right) if type(op) in _BINARY:
                self._check(left)
                self._check(right)
            case ast.UnaryOp(op=op, operand=operand) if type(op) in _SIGNS:
                self._check(operand)
            case ast.Call(func=ast.Name(id=quadrature.NAME), args=[ast.Name(), ast.Name()]) if (
                not node.keywords
            ):
                for line in node.args:
                    self._check(line)
            case ast.Constant(value=int() | float() as number):
                _refuse_endless(number)
            case ast.Name(id=name) if name in self._constants or name in self._codes():
                pass
            case _:
                raise unknown_column(self._as_written(node), self._known)

    def _as_written(self, node: ast.AST) -> str:
        text = ast.unparse(node)
        for code, name in reversed(list(zip(self._codes(), self.columns, strict=True))):
            text = text.replace(code, name)
        return text

    def _codes(self) -> list[str]:
        return [f"_c{index}" for index in range(len(self.columns))]

    def evaluate(self, columns: Mapping[str, Floats], rows: int) -> Floats:
        """The values of the expression, shape (rows,); not finite where it divides by zero."""
        found = dict(columns)
        if ROW in self.columns:
            found[ROW] = np.arange(rows, dtype=np.float64)
        values: dict[str, Any] = dict(self._constants)
        values.update(zip(self._codes(), (found[name] for name in self.columns), strict=True))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            result = _value(self._tree, values)
        if isinstance(result, np.ndarray) and result.shape == (rows,):
            return result.astype(np.float64, copy=False)  # a large column is not copied
        return np.array(np.broadcast_to(result, (rows,)), dtype=np.float64)


def _refuse_endless(number: float) -> None:
    """Raises UsageError for a number beyond what a column can hold."""
    try:
        if math.isfinite(float(number)):
            return
    except OverflowError:
        pass
    raise UsageError(
        f"--map: the number {str(number)[:20]}... is out of range: write a smaller one"
    )


def _value(node: ast.AST, values: Mapping[str, Any]) -> Any:
    match node:
        case ast.BinOp(left=left, op=op, right=right):
            return _BINARY[type(op)](_value(left, values), _value(right, values))
        case ast.UnaryOp(op=op, operand=operand):
            return _SIGNS[type(op)](_value(operand, values))
        case ast.Call(args=[a, b]):
            lines = np.broadcast_arrays(_value(a, values), _value(b, values))
            return quadrature.counts(*(np.atleast_1d(line) for line in lines))
        case ast.Name(id=name):
            return np.asarray(values[name], dtype=np.float64)
        case ast.Constant(value=int() | float() as number):
            return np.float64(number)
    raise AssertionError(ast.dump(node))
