"""Faults in Python: what a slip of the pen, a wrong sign or a forgotten line would make."""

from __future__ import annotations

import ast
import copy
from collections.abc import Iterator
from itertools import pairwise

from tools.mutants.mutant import Mutant, line_of

COMPARED: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}
COMPUTED: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Div,
    ast.Mod: ast.Mult,
    ast.Pow: ast.Mult,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.BitXor: ast.BitAnd,
}
CALLED = {"min": "max", "max": "min", "any": "all", "all": "any"}
COMMUTING = {"min", "max", "hypot", "minimum", "maximum", "fmin", "fmax", "union1d", "intersect1d"}
FACTOR = 3.0  # of a figure that is not whole, or large: one more of many is no fault
FEW = 10
Change = tuple[str, ast.AST, str]  # the operator, the node, what stands there instead


def mutants(path: str, source: bytes) -> Iterator[Mutant]:
    """Every mutant of a file, in the order of its lines."""
    tree = ast.parse(source)
    starts = _starts(source)
    for node, called in _walk(tree, False):
        for operator, spot, text in _changes(node):
            begin, end = _span(spot, starts)
            line, before, after = line_of(source, begin, end, text)
            yield Mutant(path, line, operator, begin, end, text, before, after, not called)


def _walk(node: ast.AST, called: bool) -> Iterator[tuple[ast.AST, bool]]:
    """Nodes that a fault may strike, each with whether it is inside a function."""
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "type_params"):
            continue
        inside = called or (isinstance(node, ast.FunctionDef | ast.Lambda) and name == "body")
        for child in value if isinstance(value, list) else [value]:
            if not isinstance(child, ast.AST) or isinstance(child, ast.Assert | ast.JoinedStr):
                continue  # assertions are for the type checker; texts are judged by readers
            if isinstance(child, ast.keyword) and child.arg == "strict":
                continue  # of zip: an assertion too
            if isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test):
                continue
            yield child, inside
            yield from _walk(child, inside)


def _changes(node: ast.AST) -> Iterator[Change]:
    match node:
        case ast.Compare():
            for at, operator in enumerate(node.ops):
                for other in COMPARED[type(operator)]:
                    ops = [*node.ops[:at], other(), *node.ops[at + 1 :]]
                    yield "comparison", node, _with(node, ops=ops)
        case ast.BinOp() if not _is_type(node):
            yield "arithmetic", node, _with(node, op=COMPUTED.get(type(node.op), ast.Sub)())
        case ast.AugAssign():
            changed = COMPUTED.get(type(node.op), ast.Sub)()
            yield "arithmetic", node, _with(node, op=changed)
            yield "statement", node, "pass"
        case ast.UnaryOp(op=ast.USub() | ast.Not()):
            yield "sign", node, f"({ast.unparse(node.operand)})"
        case ast.BoolOp():
            other = ast.Or() if isinstance(node.op, ast.And) else ast.And()
            yield "boolean", node, _with(node, op=other)
        case ast.If() | ast.While():
            yield "condition", node.test, f"(not ({ast.unparse(node.test)}))"
        case ast.IfExp():
            yield "condition", node, _with(node, body=node.orelse, orelse=node.body)
        case ast.Constant():
            yield from (("constant", node, text) for text in _constants(node.value))
        case ast.Return(value=ast.AST() as value) if not _is_none(value):
            yield "return", value, "None"
        case ast.Expr(value=ast.Call()) | ast.Raise() | ast.Continue() | ast.Break():
            yield "statement", node, "pass"
        case ast.Call():
            yield from _calls(node)


def _calls(node: ast.Call) -> Iterator[Change]:
    if isinstance(node.func, ast.Name) and node.func.id in CALLED:
        yield "function", node.func, CALLED[node.func.id]
    if _name(node.func) in COMMUTING:
        return  # in another order they are the same: that is no fault
    for at, (one, two) in enumerate(pairwise(node.args)):
        alike = type(one) is type(two) and not isinstance(one, ast.Starred)
        if alike and ast.dump(one) != ast.dump(two):
            order = [*node.args[:at], two, one, *node.args[at + 2 :]]
            yield "arguments", node, _with(node, args=order)


def _name(called: ast.expr) -> str:
    """``hypot`` of ``math.hypot``; of a method like ``x.max``, whose arguments do differ, none."""
    match called:
        case ast.Name():
            return called.id
        case ast.Attribute(value=ast.Name(id="np" | "numpy" | "math")):
            return called.attr if called.attr not in CALLED else ""
    return ""


def _constants(value: object) -> Iterator[str]:
    match value:
        case bool():
            yield str(not value)
        case int():
            yield str(value + 1 if abs(value) < FEW else int(value * FACTOR))
        case float():
            yield repr(value * FACTOR if value else 1.0)


def _with(node: ast.AST, **fields: object) -> str:
    """The node's text with other fields."""
    other = copy.copy(node)
    for name, value in fields.items():
        setattr(other, name, value)
    text = ast.unparse(other)
    return text if isinstance(node, ast.stmt) else f"({text})"


def _is_none(node: ast.AST) -> bool:
    return isinstance(node, ast.Constant) and node.value is None


def _is_type(node: ast.BinOp) -> bool:
    """``int | None``, which no caller computes with; and texts put together."""
    if isinstance(node.op, ast.BitOr):
        sides = (node.left, node.right)
        return any(_is_none(one) or _names_a_class(one) for one in sides)
    return any(isinstance(one, ast.JoinedStr) for one in (node.left, node.right))


def _names_a_class(node: ast.AST) -> bool:
    return isinstance(node, ast.Name) and node.id[0].isupper() and not node.id.isupper()


def _starts(source: bytes) -> list[int]:
    """Where each line begins."""
    starts, at = [0], source.find(b"\n")
    while at >= 0:
        starts.append(at + 1)
        at = source.find(b"\n", at + 1)
    return starts


def _span(node: ast.AST, starts: list[int]) -> tuple[int, int]:
    assert isinstance(node, ast.expr | ast.stmt)
    last = node.end_lineno or node.lineno  # a parsed node has both
    return (
        starts[node.lineno - 1] + node.col_offset,
        starts[last - 1] + (node.end_col_offset or 0),
    )
