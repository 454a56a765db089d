# SPDX-License-Identifier: Apache-2.0
"""A fractal's level set in pyopenvdb: through_pyopenvdb.py MESH OUT.vdb [RESOLUTION]"""
import sys

import juliavdb
import numpy as np
import pyopenvdb


def main():
    mesh, out = sys.argv[1:3]
    resolution = int(sys.argv[3]) if len(sys.argv) > 3 else 200
    look = dict(detail=0.25, outward=0.1, texture="rings", resolution=resolution)
    made = juliavdb.fractal(mesh, **look, grids="surface")
    made.write(out)

    grid = pyopenvdb.read(out, "surface")
    low, high = grid.evalActiveVoxelBoundingBox()
    values = np.empty(np.array(high) - low + 1, dtype=np.float32)
    grid.copyToArray(values, ijk=low)
    inside = np.count_nonzero(values < 0) * made.info["voxel_size"] ** 3
    print(f"voxels inside hold {inside:.4f}, the mesh holds {made.info['volume']:.4f}")

    # The same question, asked of the map itself at the voxels' places.
    field = juliavdb.Field(mesh, **look)
    places = np.stack(np.meshgrid(*map(np.arange, values.shape), indexing="ij"), -1).reshape(-1, 3) + low
    same = np.mean(field.inside(places * made.info["voxel_size"]) == (values.ravel() < 0))
    print(f"the map says the same at {100 * same:.2f} % of the voxels")


if __name__ == "__main__":
    main()
