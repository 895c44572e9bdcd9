"""Small faults in Python source: a changed operator or bound, or a missing check, step or field."""

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

COMPARISONS: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip
OPERATORS: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.BitOr: ast.BitAnd, ast.BitAnd: ast.BitOr,
}  # fmt: skip
CALLS = {"min": "max", "max": "min", "any": "all", "all": "any"}

OF_STATEMENTS = {"step left out", "answer left out"}
"""Faults in place of a whole statement; any other stands in parentheses, as it may go over several lines."""
OF_RECORDS = {"frozen", "kw_only", "slots"}
"""Options of records: they protect programmers from mistakes, and change nothing else; so does `strict` of a zip."""


@dataclass(frozen=True, slots=True, order=True)
class Mutant:
    """One fault: its place in a file, and both texts."""

    path: str
    line: int
    column: int
    end_line: int
    end_column: int
    operator: str
    before: str
    after: str
    within: str = ""
    """The classes and the function around it."""

    @property
    def name(self) -> str:
        """Return the fault's description, also for the list of those that change nothing."""
        return f"{':'.join(filter(None, (self.path, self.within)))}: {' '.join(self.before.split())} -> {self.after}"

    def put_into(self, source: str) -> str:
        """Return the source with this fault in it."""
        lines = source.encode().splitlines(keepends=True)  # ast counts columns in bytes
        head = lines[self.line - 1][: self.column]
        tail = lines[self.end_line - 1][self.end_column :]
        after, gone = self.after.encode(), b"\n" * (self.end_line - self.line)
        after = after + gone if self.operator in OF_STATEMENTS else b"(" + after + gone + b")"
        return b"".join([*lines[: self.line - 1], head, after, tail, *lines[self.end_line :]]).decode()


def mutants(root: Path, path: str) -> list[Mutant]:
    """Return every possible fault of a file, in order."""
    source = (root / path).read_text()
    tree = ast.parse(source)
    skipped = {id(part) for node in ast.walk(tree) for part in _not_run(node)}
    faults = []
    for node, within in _named(tree, ""):
        if id(node) in skipped or not isinstance(node, ast.expr | ast.stmt):
            continue
        for target, operator, after in _faults(node):
            before = ast.get_source_segment(source, target)
            if before is not None and target.end_lineno is not None and target.end_col_offset is not None:
                ends = target.end_lineno, target.end_col_offset
                faults.append(Mutant(path, target.lineno, target.col_offset, *ends, operator, before, after, within))
    return sorted(set(faults))


def _named(node: ast.AST, within: str) -> Iterator[tuple[ast.AST, str]]:
    """Yield a node and all in it, each with the names of its surroundings."""
    yield node, within
    if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
        within = f"{within}.{node.name}" if within else node.name
    for part in ast.iter_child_nodes(node):
        yield from _named(part, within)


def _not_run(node: ast.AST) -> Iterator[ast.AST]:
    """Yield what no test can reach: annotations, protocols, code for type checkers, and guards against mistakes."""
    annotations = [getattr(node, "annotation", None), getattr(node, "returns", None)]
    if isinstance(node, ast.ClassDef) and any(ast.unparse(base).startswith("Protocol") for base in node.bases):
        annotations += node.body
    if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
        annotations.append(node)
    if isinstance(node, ast.Call) and ast.unparse(node.func).endswith("Meta"):
        annotations += [word.value for word in node.keywords if word.arg == "description"]
    if isinstance(node, ast.Call) and ast.unparse(node.func) == "zip":
        annotations += [word for word in node.keywords if word.arg == "strict"]
    if isinstance(node, ast.ClassDef):
        calls = [one.keywords for one in node.decorator_list if isinstance(one, ast.Call)]
        annotations += [word for words in (node.keywords, *calls) for word in words if word.arg in OF_RECORDS]
    for part in annotations:
        if part is not None:
            yield from ast.walk(part)


def _faults(node: ast.expr | ast.stmt) -> Iterator[tuple[ast.expr | ast.stmt, str, str]]:
    for faults in (_turned, _moved, _left_out):
        yield from faults(node)


def _turned(node: ast.expr | ast.stmt) -> Iterator[tuple[ast.expr | ast.stmt, str, str]]:
    match node:
        case ast.Compare(left, [first, *others], rights):
            turned = COMPARISONS[type(first)]()
            yield node, "comparison", f"({ast.unparse(ast.Compare(left, [turned, *others], rights))})"
        case ast.BoolOp(operator, values):
            other = ast.Or() if isinstance(operator, ast.And) else ast.And()
            yield node, "and, or", f"({ast.unparse(ast.BoolOp(other, values))})"
        case ast.UnaryOp(ast.Not(), operand):
            yield node, "not", f"({ast.unparse(operand)})"
        case ast.BinOp(left, operator, right) if type(operator) in OPERATORS:
            yield node, "arithmetic", f"({ast.unparse(ast.BinOp(left, OPERATORS[type(operator)](), right))})"
        case _:
            return


def _moved(node: ast.expr | ast.stmt) -> Iterator[tuple[ast.expr | ast.stmt, str, str]]:
    match node:
        case ast.Constant(bool(value)):
            yield node, "truth", str(not value)
        case ast.Constant(int(value) | float(value)):
            yield node, "number", repr(value * 2 if value else value + 1)
        case ast.Call(ast.Name(name), args, keywords) if name in CALLS:
            yield node, "call", ast.unparse(ast.Call(ast.Name(CALLS[name]), args, keywords))
        case _:
            return


def _left_out(node: ast.expr | ast.stmt) -> Iterator[tuple[ast.expr | ast.stmt, str, str]]:
    match node:
        case ast.Call(function, args, [_, *_] as keywords) if ast.unparse(function).endswith("replace"):
            for omitted in keywords:
                kept = [word for word in keywords if word is not omitted]
                yield node, "field left out", ast.unparse(ast.Call(function, args, kept))
        case ast.If(test) | ast.IfExp(test):
            yield test, "check left out", "False"
            yield test, "check always", "True"
        case ast.AugAssign() | ast.Expr(ast.Call()) | ast.Assign([ast.Attribute()]):
            yield node, "step left out", "pass"
        case ast.Return(ast.expr() as value) if not isinstance(value, ast.Constant):
            yield node, "answer left out", "return None"
        case _:
            return
