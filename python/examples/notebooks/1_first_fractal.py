# SPDX-License-Identifier: Apache-2.0
# %% [markdown]
# # What does a fractal keep of its target?
# A fractal has the shape of a mesh, and detail in a shell about its surface. How deep the detail goes is a share of the
# thickness at each place, so thin parts stay. As a script: 1_first_fractal.py MESH OUT.png [SIZE]

# %%
import sys

import juliavdb
import numpy as np
from pictures import save

mesh, out = sys.argv[1:3]
size = int(sys.argv[3]) if len(sys.argv) > 3 else 300

# %% [markdown]
# Three fractals of the same mesh. The first hardly differs from it.

# %%
details, fine = (0.05, 0.3, 0.8), dict(sdf_resolution=100)
pictures, shares = [], []
for detail in details:
    fractal = juliavdb.fractal(mesh, detail=detail, resolution=size // 3, **fine)
    shares.append(fractal.info["volume"] / fractal.info["target_volume"])
    pictures.append(juliavdb.render(mesh, detail=detail, size=(size, size), samples=1, **fine))

# %% [markdown]
# The answer: less of the volume, the deeper the detail goes; and the same outline.

# %%
save(out, np.concatenate(pictures, axis=1))
for detail, share in zip(details, shares):
    print(f"detail {detail}: {100 * share:.1f} % of the volume")
