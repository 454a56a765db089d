# SPDX-License-Identifier: Apache-2.0
"""What is measured of fractals: slices, averages over versors, dimensions."""
from . import _juliavdb, _options, _target
from ._field import Field

SLICES = {"membership": lambda field, at, more: field.inside(at, **more),
          "f": lambda field, at, more: field(at, **more),
          "phi": lambda field, at, more: field.distance(at, **more),
          "e": lambda field, at, more: field.exponent(at, **more),
          "iterations": lambda field, at, more: field.orbit(at, **more).steps,
          "versor": lambda field, at, more: field.versor(at, **more)}


@_options.documented(_options.FRACTAL)
def slice(vertices=None, faces=None, *, field="membership", axis="z", position=None, size=800, progress=None, memory=None,
          threads=None, device=None, **options):
    """The numbers of a field on a plane: an array (height, width), or (height, width, 4) of versors.

    field is membership, f, phi, e, iterations or versor, and the pixels are those of 'juliavdb slice': axis is
    perpendicular to the plane, position is where the plane cuts it, in the target's units (by default in the middle),
    and size is the number of pixels along the longer side. The target and the options are those of fractal().
    """
    if field not in SLICES:
        raise ValueError(f"field is {field!r}; it must be one of {', '.join(SLICES)}")
    made = Field(vertices, faces, progress=progress, memory=memory, threads=threads, device=device, **options)
    return SLICES[field](made, made.plane(axis=axis, position=position, size=size), {"progress": progress, "threads": threads})


@_options.documented(_options.FRACTAL)
def study(vertices=None, faces=None, *, versors=1000, axis="z", position=None, size=800, progress=None, memory=None, threads=None,
          device=None, **options):
    """What a target decides by itself on a plane, whatever the versor, as 'juliavdb study' counts it over random versors.

    A dict: versors, how many; inside, an array (height, width) of int32, how many of the sets hold the pixel; circles, a
    dict of arrays with an entry a circle about the origin of the dynamics (radius; mean, least and greatest distance to
    the target; sphere_mean, the mean over the sphere of that radius; membership, the mean share of the circle that lies in
    the sets); undecided, the two distances between which the versor decides, or None; origin_inside.
    """
    if not {"texture", "versor"} & set(options):
        options["texture"] = "random"
    scene = _target.scene(vertices, faces, progress, (memory, threads, device), options)
    return scene.study(axis, position, size, versors, progress, threads)


@_options.documented(_options.FRACTAL)
def dimension(vertices=None, faces=None, *, resolutions, progress=None, memory=None, threads=None, device=None, **options):
    """How the mesh of a fractal grows with its resolution, as 'juliavdb study --dimension' measures it.

    resolutions are at least three whole numbers, the smallest first. A dict: dimension, the slope of log(triangles) over
    log(resolution); its standard_error and its 95 % interval; factor; and arrays with an entry a resolution: resolutions,
    triangles, points, evaluated_nodes.
    """
    options, *functions = _options.with_functions(options)
    if any(function is not None for function in functions):
        raise ValueError("a dimension is not measured of a versor or a map that is a function; give one by its name")
    return _juliavdb.dimension(*_target.given(vertices, faces, options), [int(each) for each in resolutions],
                               (memory, threads, device), progress)
