"""A package's `__all__` is its front door: what somebody outside uses, and the types that its signatures name."""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

from tests.structure.test_imports import dotted, modules

LIBRARY = {dotted(path): path for path in modules("estimators")}
USERS = {
    dotted(path): path
    for path in modules("estimators") + modules("published") + modules("app") + modules("validation")
}
PACKAGES = [name for name, path in LIBRARY.items() if path.name == "__init__.py"]
AWAITED = {
    # Measured and tested, and not yet shown by the service: live guidance and the measures of its page.
    "estimators.comparison.measures",
    "estimators.guidance",
}


@pytest.mark.parametrize("package", sorted(set(PACKAGES) - AWAITED))
def test_a_front_door_opens_for_somebody_outside(package: str) -> None:
    exported = listed(LIBRARY[package])
    used = {
        name for user in USERS if not within(user, package) for door, name in taken(user) if door == package
    }
    pending = used & exported
    named: set[str] = set()
    while pending:
        named |= pending
        pending = {word for name in pending for word in signature(package, name)} & exported - named
    assert exported - named == set(), "import it from its module, or from `published`, and drop it here"


def test_an_ordinary_module_lists_no_names() -> None:
    """Only a module that hands on what others define has a door of its own; elsewhere a leading `_` says it."""
    needless = [
        module
        for module, path in USERS.items()
        if path.name != "__init__.py" and listed(path) and listed(path) <= defined(path)
    ]
    assert not needless, "delete `__all__`"


def test_the_walk_sees_users_and_signatures() -> None:
    assert "JointLoad" in signature("estimators.kinetics", "ShoeKinetics")
    assert ("estimators.arm", "ArmModel") in {one for user in USERS for one in taken(user)}


def within(module: str, package: str) -> bool:
    return module == package or module.startswith(f"{package}.")


@cache
def tree(module: str) -> ast.Module:
    return ast.parse(USERS[module].read_text())


def listed(path: Path) -> set[str]:
    """Names in `__all__`; none where there is no such list."""
    for node in ast.parse(path.read_text()).body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return set(ast.literal_eval(node.value))
    return set()


def defined(path: Path) -> set[str]:
    """Names that a module defines itself, at its top."""
    found: set[str] = set()
    for node in ast.parse(path.read_text()).body:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            found.add(node.name)
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            found |= {word for target in targets for word in re.findall(r"\w+", ast.unparse(target))}
    return found


@cache
def taken(user: str) -> frozenset[tuple[str, str]]:
    """Package and name of what a module takes, by `from package import name` or by an attribute of the package."""
    nodes = list(ast.walk(tree(user)))
    found, bound = set(), {}
    for node in nodes:
        if isinstance(node, ast.ImportFrom):
            for alias in node.names:
                found.add((str(node.module), alias.name))
                bound[alias.asname or alias.name] = f"{node.module}.{alias.name}"
    for node in nodes:
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            found.add((bound.get(node.value.id, ""), node.attr))
    return frozenset(found)


def signature(module: str, name: str) -> set[str]:
    """Words of the annotations of a function or class, wherever the package takes it from."""
    for node in tree(module).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name == name:
            return words(node) - {name}
        if isinstance(node, ast.Assign | ast.AnnAssign) and re.match(rf"{name}\b", ast.unparse(node)):
            return set(re.findall(r"\w+", ast.unparse(node))) - {name}
        if isinstance(node, ast.ImportFrom) and node.module in LIBRARY:
            for alias in node.names:
                if (alias.asname or alias.name) == name:
                    return signature(node.module, alias.name)
    return set()


def words(node: ast.FunctionDef | ast.ClassDef) -> set[str]:
    parts: list[ast.expr | None] = []
    if isinstance(node, ast.ClassDef):
        parts += [*node.bases, *(one.annotation for one in node.body if isinstance(one, ast.AnnAssign))]
        inner = [one for one in node.body if isinstance(one, ast.FunctionDef)]
        return {word for part in parts if part for word in re.findall(r"\w+", ast.unparse(part))} | {
            word for one in inner for word in words(one)
        }
    given = node.args.args + node.args.kwonlyargs + node.args.posonlyargs
    parts += [*(one.annotation for one in given), node.returns]
    return {word for part in parts if part for word in re.findall(r"\w+", ast.unparse(part))}
