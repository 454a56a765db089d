# SPDX-License-Identifier: Apache-2.0
"""Keyword arguments into the options of the command line, and the options' help into docstrings and signatures."""
import inspect
import numbers
import os
import textwrap

from . import _juliavdb

FRACTAL = {name.replace("-", "_"): (argument, text) for name, argument, text in _juliavdb.options()}
VIEW = {name.replace("-", "_"): (argument, text) for name, argument, text in _juliavdb.view_options()}

FIT = {name.replace("-", "_"): (argument, text) for name, argument, text in _juliavdb.fit_options()}


def _text(name, value):
    """The value as the command line has it."""
    if hasattr(value, "tolist"):  # an array of numpy, or one of its numbers
        value = value.tolist()
    if value is True:
        return "true"
    if isinstance(value, str):
        return value
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, numbers.Integral):
        return str(int(value))
    if isinstance(value, numbers.Real):
        return repr(float(value))
    if isinstance(value, (tuple, list)):
        separator = "x" if name == "size" else ","
        return separator.join(_text(name, item) for item in value)
    raise TypeError(f"{name} is {value!r}; it must be a number, a string, a path, a list of these, or True for a flag")


def with_functions(options):
    """The options with the word "function" for a texture and a map that are one, and these functions, or None for each."""
    names = ("texture", "texture_over", "versor", "versor_over")
    functions = {name: options[name] for name in names if callable(options.get(name))}
    if len(functions) > 1:
        raise ValueError(" and ".join(functions) + " are both functions; mix them in one function, and give that as texture")
    own_map = options["map"] if callable(options.get("map")) else None
    if own_map is not None:
        functions["map"] = own_map
    words = {**options, **dict.fromkeys(functions, "function")}
    return words, next((functions[name] for name in names if name in functions), None), own_map


def recipe(options):
    """The given options as entries of a recipe, without those that are None or False."""
    result = {}
    for name, value in options.items():
        if value is None or value is False:
            continue
        entry = _juliavdb.current_name(name.replace("_", "-"))
        if entry in result:
            raise ValueError(f"{name} is given twice, by its two names; give it once")
        result[entry] = _text(name, value)
    return result


def documented(*tables):
    """A decorator that adds the options to a function's docstring and signature."""
    known = {name: entry for table in tables for name, entry in table.items() if name != "input"}

    def decorate(function):
        lines = []
        for name, (argument, text) in known.items():
            head = f"{name}={argument}" if argument else f"{name}=True"
            lines.append(textwrap.fill(f"{head}: {text}", 100, initial_indent="    ", subsequent_indent="        ",
                                       break_on_hyphens=False))
        function.__doc__ = inspect.getdoc(function) + "\n\nOptions:\n" + "\n".join(lines)
        signature = inspect.signature(function)
        own = [p for p in signature.parameters.values() if p.kind is not inspect.Parameter.VAR_KEYWORD]
        added = [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None) for name in known]
        function.__signature__ = signature.replace(parameters=own + added)
        return function

    return decorate
