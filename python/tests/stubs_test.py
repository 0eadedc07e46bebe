# SPDX-License-Identifier: Apache-2.0
"""The type stubs tell of the package as it is, and all of it has a docstring."""

import ast
import inspect
import pathlib
import re
import unittest

import knuckle
from testing import PROJECT  # noqa: F401 - skips where numpy is missing

STUB = ast.parse(pathlib.Path(knuckle.__file__).with_suffix(".pyi").read_text())


def is_public(name):
    return not name.startswith("_")


def parameters_of(function):
    """Names of a stub's parameters."""
    arguments = function.args
    return [argument.arg for argument in [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs] if argument.arg != "self"]


def own_parameters(function):
    """Names of the parameters of a function, of ours or of pybind11's, whose docstring begins with the signature."""
    if inspect.isfunction(function):
        return [name for name in inspect.signature(function).parameters if name != "self"]
    signature = function.__doc__.splitlines()[0]
    inner = signature[signature.index("(") + 1:signature.rindex(") ->")]
    return [name for name in re.findall(r"(?:^|, )(\w+): ", inner) if name != "self"]


class Stubs(unittest.TestCase):
    def test_names_are_those_of_the_package(self):
        declared = [node.name for node in STUB.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))]
        self.assertEqual(sorted([*declared, "conventions"]), sorted(knuckle.__all__))
        for name in knuckle.__all__:
            self.assertTrue(hasattr(knuckle, name), name)

    def test_conventions_cannot_be_changed(self):
        self.assertEqual(len(knuckle.conventions["knuckle22"]), 22)
        for change in (lambda: knuckle.conventions.clear(), lambda: knuckle.conventions["knuckle22"].clear(),
                       lambda: knuckle.conventions.pop("knuckle22")):
            with self.assertRaises(AttributeError):
                change()
        with self.assertRaises(TypeError):
            knuckle.conventions["knuckle22"] = ()

    def test_members_are_those_of_the_classes(self):
        for node in STUB.body:
            if not isinstance(node, ast.ClassDef) or node.name == "Error":
                continue
            declared = {member.name for member in node.body if is_public(member.name)}
            actual = {name for name in vars(getattr(knuckle, node.name)) if is_public(name)}
            self.assertEqual(declared, actual, node.name)

    def test_parameters_are_those_of_the_functions(self):
        count = 0
        for node in STUB.body:
            if isinstance(node, ast.FunctionDef):
                self.assertEqual(parameters_of(node), own_parameters(getattr(knuckle, node.name)), node.name)
            elif isinstance(node, ast.ClassDef) and node.name not in ("Error", "Source"):
                for member in node.body:
                    is_property = any(getattr(mark, "id", "") == "property" for mark in member.decorator_list) if isinstance(
                        member, ast.FunctionDef) else True
                    if is_property or member.name in ("__eq__", "__hash__"):
                        continue
                    function = getattr(getattr(knuckle, node.name), member.name)
                    self.assertEqual(parameters_of(member), own_parameters(function), f"{node.name}.{member.name}")
                    count += 1
        self.assertGreater(count, 8)

    def test_everything_has_a_docstring(self):
        for name in knuckle.__all__:
            thing = getattr(knuckle, name)
            if name == "conventions":
                continue
            self.assertTrue(thing.__doc__, name)
            for member_name, member in vars(thing).items() if inspect.isclass(thing) else ():
                if is_public(member_name):
                    self.assertTrue(getattr(thing, member_name).__doc__ or member.__doc__, f"{name}.{member_name}")

    def test_classes_are_named_by_the_package(self):
        for name in knuckle.__all__:
            thing = getattr(knuckle, name)
            if inspect.isclass(thing):
                self.assertEqual(thing.__module__, "knuckle", name)


if __name__ == "__main__":
    unittest.main()
