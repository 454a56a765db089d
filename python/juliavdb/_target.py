# SPDX-License-Identifier: Apache-2.0
"""Targets as they are given to functions: the name of a file, or arrays."""
import os

from . import _juliavdb, _options


def given(vertices, faces, options):
    """The recipe, and the arrays if the target is in memory."""
    recipe = _options.recipe(options)
    if hasattr(vertices, "cells_dict"):  # a mesh of meshio
        if faces is not None:
            raise ValueError("faces were given with a mesh of meshio; leave them out")
        triangles = vertices.cells_dict.get("triangle")
        if triangles is None:
            raise ValueError(f"the mesh of meshio has no triangles, but cells of the kinds {sorted(vertices.cells_dict)}; turn "
                             "them into triangles first")
        vertices, faces = vertices.points, triangles
    if isinstance(vertices, (str, os.PathLike)):
        if faces is not None:
            raise ValueError("faces were given with the name of a file; give vertices and faces, or the name alone")
        if "input" in recipe:
            raise ValueError("the target was given twice, as an argument and as input; leave one of them out")
        recipe["input"] = os.fspath(vertices)
        vertices = None
    elif vertices is None and faces is not None:
        raise ValueError("faces were given without vertices; give both")
    elif vertices is not None and faces is None and "points-radius" not in recipe:
        raise ValueError("vertices were given without faces; give both, or, if they are points of a surface, also "
                         "points_radius")
    elif vertices is not None and "input" in recipe:
        raise ValueError("the target was given twice, as arrays and as input; leave one of them out")
    return recipe, vertices, faces


def named(recipe):
    """The target of a recipe in words."""
    name = recipe.get("input")
    return "a mesh in memory" if name == "memory" else repr(name) if name else f"the map {recipe['map']}"


def scene(vertices, faces, progress, resources, options):
    """What a field or a fractal is made of. The resources are memory, threads and device."""
    options, versor, own_map = _options.with_functions(options)
    rest = options.get("rest")
    if rest is not None and not isinstance(rest, (str, os.PathLike)):
        options = {name: value for name, value in options.items() if name != "rest"}
    else:
        rest = None
    return _juliavdb.Scene(*given(vertices, faces, options), resources, progress, versor, own_map, rest)
