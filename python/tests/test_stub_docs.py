"""What an editor shows of the compiled module is what the module itself says."""

from __future__ import annotations

import ast
from importlib import resources

import pytest

import sesc._sesc as compiled

STUB = ast.parse(resources.files("sesc").joinpath("_sesc.pyi").read_text())
CLASSES = [node for node in STUB.body if isinstance(node, ast.ClassDef) and hasattr(compiled, node.name)]


def first(doc: str | None) -> str:
    """The first paragraph, in one line."""
    return " ".join((doc or "").split("\n\n")[0].split())


@pytest.mark.parametrize("stub", CLASSES, ids=lambda stub: stub.name)
def test_the_stub_has_the_documentation_of_the_module(stub: ast.ClassDef) -> None:
    found = getattr(compiled, stub.name)
    assert first(ast.get_docstring(stub)) == first(found.__doc__)
    for method in stub.body:
        if not isinstance(method, ast.FunctionDef) or method.name.startswith("_"):
            continue
        if any(isinstance(name, ast.Name) and name.id == "property" for name in method.decorator_list):
            continue
        said = first(getattr(found, method.name).__doc__)
        assert not said or first(ast.get_docstring(method)) == said, method.name
