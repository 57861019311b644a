"""Writes the docstrings of a stub as a C++ header, so that help() says what the stub says.

Usage: docstrings.py STUB HEADER. The header has kDocstrings, pairs of a name ("Scene.render", "" for the module) and its text.
"""
import ast
import pathlib
import sys


def docstrings(node, name=""):
    """(name, text) of a module or class and all below it."""
    if text := ast.get_docstring(node):
        yield name, text
    for child in node.body:
        if isinstance(child, (ast.ClassDef, ast.FunctionDef)):
            below = f"{name}.{child.name}".lstrip(".")
            yield from docstrings(child, below)


def main(stub, header):
    rows = [f'    {{"{name}", R"doc({text})doc"}},\n' for name, text in docstrings(ast.parse(pathlib.Path(stub).read_text()))]
    pathlib.Path(header).write_text(
        "#pragma once\n\n#include <string_view>\n\nnamespace pathfit::app {\n\n"
        "struct Docstring {\n  std::string_view name;\n  const char* text;\n};\n\n"
        f"inline constexpr Docstring kDocstrings[] = {{\n{''.join(rows)}}};\n\n}}  // namespace pathfit::app\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
