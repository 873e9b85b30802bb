"""The type stubs tell what the native part has."""

import ast
import importlib.metadata
import inspect
import subprocess
import sys
from pathlib import Path

import wherein
from wherein import _native

STUB = Path(wherein.__file__).with_name("_native.pyi")


def public(names):
    return {name for name in names if not name.startswith("_")}


def test_stubs_name_what_there_is_and_nothing_else():
    tree = ast.parse(STUB.read_text())
    classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
    functions = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    assert public(vars(_native)) == set(classes) | functions
    for name, node in classes.items():
        stated = public(member.name for member in node.body if isinstance(member, ast.FunctionDef))
        own = getattr(_native, name)
        assert public(vars(own)) == stated, name


def test_everything_public_is_documented_and_exported():
    assert set(wherein.__all__) <= set(dir(wherein))
    for name in wherein.__all__:
        thing = getattr(wherein, name)
        assert inspect.getdoc(thing), name
        members = public(vars(thing)) if inspect.isclass(thing) and thing.__module__.startswith("wherein") else ()
        for member in members:
            assert inspect.getdoc(getattr(thing, member)), f"{name}.{member}"


def test_the_version_is_that_of_the_installed_package():
    assert wherein.__version__ == importlib.metadata.version("wherein")


def test_the_installed_package_has_its_licences():
    installed = {path.name for path in importlib.metadata.files("wherein")}
    assert {"LICENSE-MIT", "LICENSE-APACHE"} <= installed


def test_a_type_checker_accepts_the_package_and_the_examples():
    examples = sorted(str(path) for path in (Path(__file__).parents[1] / "examples").glob("*.py"))
    checked = subprocess.run([sys.executable, "-m", "mypy", "--ignore-missing-imports", "-p", "wherein"], capture_output=True, text=True)
    assert checked.returncode == 0, checked.stdout + checked.stderr
    for example in examples:
        checked = subprocess.run([sys.executable, "-m", "mypy", "--ignore-missing-imports", example], capture_output=True, text=True)
        assert checked.returncode == 0, checked.stdout + checked.stderr
