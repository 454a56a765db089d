# SPDX-License-Identifier: Apache-2.0
"""The meshes that the entries read, under the names by which their commands know them ($bunny), and where they come from.

The files of the papers' authors cannot be had, so every mesh is one of the same object, or a substitute. `--mesh NAME=FILE`
gives another one. A small run takes the coarse bunny for every scan.
"""
import dataclasses
import functools
import pathlib
import subprocess

from harness import ROOT, sha256

BUNNY = pathlib.Path("/usr/share/glmark2/models/bunny.obj")
HORSE = pathlib.Path("/usr/share/glmark2/models/horse.3ds")


class MissingMesh(Exception):
    """A mesh cannot be had."""


@dataclasses.dataclass(frozen=True)
class Mesh:
    path: pathlib.Path
    origin: str  # in words, with a substitute stated

    @functools.cached_property
    def hash(self):
        return sha256(self.path)


@dataclasses.dataclass(frozen=True)
class Source:
    """@param scan     whether it is the scan of an object: of another mesh, with holes perhaps
    @param options  what commands need to take it
    @param make     the command that writes it to stdout; of a scan the one that makes its substitute
    @param origin   what that is
    """
    scan: bool
    options: str
    make: str
    origin: str


# The two scans that have to be fetched have a substitute that Debian has, or that is made.
SOURCES = {
    "bunny": Source(True, "", f"cat {BUNNY}", "the Stanford bunny of Debian's glmark2-data"),
    "dragon": Source(True, "--repair", "docs/make-shapes horse", "a substitute: the horse of Debian's glmark2-data"),
    "armadillo": Source(True, "--repair", "reproduce/shapes frog", "a substitute: the frog of reproduce/shapes"),
    "chair": Source(False, "--repair", "docs/make-shapes chair", "a substitute: the chair of docs/make-shapes"),
    "tooth": Source(False, "", "reproduce/shapes tooth", "a substitute: the tooth of reproduce/shapes"),
    "frog": Source(False, "--repair", "reproduce/shapes frog", "a substitute: the frog of reproduce/shapes"),
    "hand": Source(False, "--repair", "reproduce/shapes hand", "a substitute: the hand of reproduce/shapes"),
}


def use(name):
    """The mesh as a command has it: its variable, and the option that it needs."""
    return " ".join(filter(None, [f"${name}", SOURCES[name].options]))


def _made(command, path, environment=None):
    with open(path, "w") as file:
        done = subprocess.run(["bash", "-c", command], cwd=ROOT, stdout=file, stderr=subprocess.PIPE, text=True, env=environment)
    if done.returncode:
        raise MissingMesh(f"'{command}' failed: {done.stderr.strip()}")


def _coarse_bunny(folder, runner):
    """Some 5000 triangles in the place of 70 000, which take most of the time of a small run."""
    place = folder / "coarse-bunny.obj"
    if not place.exists():
        _made(f"juliavdb sdf {BUNNY} -o {folder}/s.vdb --resolution 32 --progress none >&2 && "
              f"juliavdb mesh {folder}/s.vdb -o {folder}/b.obj --from-grid --progress none >&2 && "
              f"grep '^[vf] ' {folder}/b.obj | sed -E 's|/[^ ]*||g'", place, runner.environment({}))
    return place


def prepare(names, given, folder, runner):
    """The meshes of these names, as files.

    @param given   files by name, of the command line
    @param folder  where those that are made can lie
    @throw MissingMesh"""
    found = {}
    for name in names:
        source, small = SOURCES[name], runner.size.name == "small"
        if name in given:
            path = given[name]
            if not path.is_file():
                raise MissingMesh(f"there is no file {path} for the mesh {name}")
            found[name] = Mesh(path, f"--mesh {name}={path.name}")
        elif source.scan and not BUNNY.is_file():
            raise MissingMesh(f"the mesh {name} needs {BUNNY} of Debian's package glmark2-data; install it, or use "
                              f"--mesh {name}=FILE")
        elif source.scan and small:
            found[name] = Mesh(_coarse_bunny(folder, runner), "the bunny of Debian's glmark2-data, made coarse")
        elif name == "bunny":
            found[name] = Mesh(BUNNY, source.origin)
        else:
            path = folder / f"{name}.obj"
            if not path.exists():
                coarse = " --coarse" if small and source.make.startswith("reproduce/shapes") else ""
                _made(source.make + coarse, path)
            found[name] = Mesh(path, source.origin)
    return found
