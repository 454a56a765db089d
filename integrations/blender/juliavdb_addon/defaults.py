# SPDX-License-Identifier: Apache-2.0
"""What the program says of its options, so that a fractal made in Blender is the one that the program makes. Nothing here
knows Blender."""

import os
import pathlib

from . import program as programs

# What `juliavdb fractal --describe json` has said. The build packs it into the archive of the add-on.
PACKED = "fractal.json"
# What the words of --frequency stand for.
FREQUENCIES = {"coarse": 1, "medium": 2, "fine": 4}


def _options():
    packed = pathlib.Path(__file__).with_name(PACKED)
    if packed.exists():
        return programs.described(packed.read_text(encoding="utf-8"))
    # The add-on runs from its sources, so there is a program beside them.
    return programs.described(programs.answer(os.environ.get("JULIAVDB", "juliavdb"), "fractal", "--describe", "json"))


OPTIONS = _options()


def text(name):
    """The default of an option, as it is typed."""
    return OPTIONS[name]["default"]


def number(name):
    return float(FREQUENCIES.get(text(name), text(name)))


def whole(name):
    return int(text(name))


def span(name):
    """The two numbers of LOW:HIGH."""
    low, high = text(name).split(":")
    return float(low), float(high)
