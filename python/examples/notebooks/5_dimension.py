# SPDX-License-Identifier: Apache-2.0
# %% [markdown]
# # How rough is a surface?
# The triangles of a smooth surface grow as the square of the resolution N. Those of a fractal grow faster, and the exponent
# estimates its dimension. As a script: 5_dimension.py MESH OUT.png [LARGEST N]

# %%
import sys

import juliavdb
import numpy as np
from pictures import plot, save

mesh, out = sys.argv[1:3]
largest = int(sys.argv[3]) if len(sys.argv) > 3 else 160
resolutions = np.unique(np.round(np.geomspace(largest / 4, largest, 4)).astype(int))

# %%
surfaces = {"the plain mesh": dict(mask=0), "scales": dict(texture="scales"),
            "deep random roots": dict(detail=0.8, iterations=8, texture="random")}
lines = []
for name, options in surfaces.items():
    triangles = [len(juliavdb.fractal(mesh, resolution=int(n), crumbs="keep", sdf_resolution=100, **options).faces) for n in resolutions]
    lines.append((resolutions, triangles))

# %% [markdown]
# The answer is the slope of each line in the plot of logarithms.

# %%
save(out, plot(*lines))
for name, (n, triangles) in zip(surfaces, lines):
    print(f"{name}: dimension {np.polyfit(np.log(n), np.log(triangles), 1)[0]:.2f}")
