#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the types of the module juliavdb, as editors and type checkers read them: make_stubs.py FILE.pyi"""
import inspect
import sys
import textwrap

import juliavdb
from juliavdb import _grid, _options

HEAD = '''# SPDX-License-Identifier: Apache-2.0
# Made by make_stubs.py from the tables of options.
import os
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

Value = Union[str, float, os.PathLike[str], Sequence[Union[str, float]]]
Target = Union[str, os.PathLike[str], ArrayLike]
Directions = Callable[[NDArray[np.float64]], ArrayLike]
Map = Callable[[NDArray[np.float64], NDArray[np.float64]], ArrayLike]
Progress = Callable[[str, Optional[float]], Any]
__version__: str
'''

OWN = {"vertices": "Optional[Target]", "faces": "Optional[ArrayLike]", "progress": "Optional[Progress]",
       "memory": "Optional[str]", "texture": "Optional[Union[Value, Directions]]",
       "map": "Optional[Union[Value, Map]]", "texture_over": "Optional[Union[Value, Directions]]",
       "choice": "str", "points": "ArrayLike", "limited": "bool", "centres": "ArrayLike", "radius": "ArrayLike", "step": "Optional[float]",
       "threads": "Optional[int]", "device": "Optional[str]", "array": "ArrayLike", "voxel_size": "float",
       "origin": "Sequence[float]", "name": "str", "grid": "Any", "field": "str", "axis": "str", "position": "Optional[float]",
       "size": "int", "versors": "int", "resolutions": "Sequence[int]", "paths": "Union[str, os.PathLike[str]]", "path": "Union[str, os.PathLike[str]]",
       "trusted": "bool"}


def parameter(each):
    if each.name in ("self", "cls"):
        return each.name
    options = {**_options.FRACTAL, **_options.VIEW, **_options.FIT, **_grid.SDF}
    if each.name in OWN and not (each.name in options and each.default is None and each.name in ("origin", "grid", "size", "voxel_size")):
        kind = OWN[each.name]
    else:
        argument, _ = options[each.name]
        kind = "Optional[Value]" if argument else "bool"
    star = "*" if each.kind is each.VAR_POSITIONAL else ""
    default = "" if star or each.default is each.empty else " = False" if kind == "bool" and not each.default else f" = {each.default!r}"
    return f"{star}{each.name}: {kind}{default}"


def stub(function, result, indent=""):
    words = []
    for each in inspect.signature(function).parameters.values():
        if each.kind is each.KEYWORD_ONLY and not any(word.startswith("*") for word in words):
            words.append("*")
        words.append(parameter(each))
    head = textwrap.fill(", ".join(words), 110, initial_indent=indent + "    ", subsequent_indent=indent + "    ",
                         break_on_hyphens=False, break_long_words=False)
    text = textwrap.indent(inspect.getdoc(function).replace("\\", "\\\\"), indent + "    ")
    return f'{indent}def {function.__name__}(\n{head}\n{indent}) -> {result}:\n{indent}    """{text.lstrip()}\n{indent}    """\n'


def attribute(owner, name, result):
    text = textwrap.indent(inspect.getdoc(getattr(owner, name)), "        ").lstrip()
    return f'    @property\n    def {name}(self) -> {result}:\n        """{text}"""\n'


def stubs():
    picture, floats = "NDArray[np.uint8]", "NDArray[np.float64]"
    corner = "tuple[float, float, float]"
    fractal, field, fit, orbit = juliavdb.Fractal, juliavdb.Field, juliavdb.Fit, juliavdb.Orbit
    grid = juliavdb.Grid
    return "\n".join([
        HEAD, f'class DataError(ValueError):\n    """{juliavdb.DataError.__doc__}"""\n',
        f'class Fractal:\n    """{fractal.__doc__}"""\n',
        attribute(fractal, "vertices", floats), attribute(fractal, "faces", "NDArray[np.uint32]"),
        attribute(fractal, "normals", "NDArray[np.float32]"), attribute(fractal, "info", "dict[str, Any]"),
        stub(fractal.write, "None", "    "), stub(fractal.to_meshio, "Any", "    "), f'class Orbit(NamedTuple):\n    """{orbit.__doc__}"""\n',
        f"    iterates: {floats}\n    log_moduli: {floats}\n    steps: NDArray[np.int32]\n    ends: NDArray[np.str_]\n",
        f'class Field:\n    """{field.__doc__}"""\n',
        stub(field.__init__, "None", "    "), stub(field.__call__, floats, "    "),
        stub(field.inside, "NDArray[np.bool_]", "    "),
        *(stub(each, floats, "    ") for each in (field.distance, field.thickness, field.octave, field.exponent, field.versor, field.trap,
                                                  field.gradient)),
        stub(field.orbit, "Orbit", "    "), stub(field.decide, "NDArray[np.int8]", "    "),
        stub(field.plane, floats, "    "), attribute(field, "recipe", "dict[str, str]"), attribute(field, "space", f"tuple[{corner}, float]"), attribute(field, "bounds", f"tuple[{corner}, {corner}]"),
        attribute(field, "metadata", "dict[str, str]"), stub(field.render, picture, "    "),
        f'class Grid:\n    """{grid.__doc__}"""\n', stub(grid.__init__, "None", "    "),
        "    @classmethod\n" + stub(grid.read.__func__, "Grid", "    "), attribute(grid, "name", "str"),
        attribute(grid, "voxel_size", "float"), attribute(grid, "background", "float"),
        attribute(grid, "metadata", "dict[str, str]"),
        stub(grid.array, f"tuple[NDArray[np.float32], {corner}]", "    "), stub(grid.sample, floats, "    "),
        stub(grid.write, "None", "    "), stub(grid.to_pyopenvdb, "Any", "    "),
        "    @classmethod\n" + stub(grid.from_pyopenvdb.__func__, "Grid", "    "),
        f'class Fit:\n    """{fit.__doc__}"""\n', attribute(fit, "info", "dict[str, Any]"),
        stub(fit.write, "None", "    "), stub(juliavdb.fit, "Fit"),
        stub(juliavdb.sdf, "Grid"), stub(juliavdb.slice, "NDArray[Any]"), stub(juliavdb.study, "dict[str, Any]"),
        stub(juliavdb.dimension, "dict[str, Any]"), "from . import fitting as fitting\n",
        stub(juliavdb.devices, "list[dict[str, Any]]"), stub(juliavdb.trust_importer, "None"), stub(juliavdb.use_device, "str"),
        stub(juliavdb.fractal, "Fractal"), stub(juliavdb.render, picture)])


if __name__ == "__main__":
    with open(sys.argv[1], "w", encoding="utf-8") as file:
        file.write(stubs())
