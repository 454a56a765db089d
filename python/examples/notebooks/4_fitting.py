# SPDX-License-Identifier: Apache-2.0
# %% [markdown]
# # How many roots does a shape need?
# A fit finds a rational map whose Julia set has the shape of a mesh. As a script: 4_fitting.py MESH OUT.png [SIZE]

# %%
import os
import sys
import tempfile

import juliavdb
import numpy as np
from pictures import save

mesh, out = sys.argv[1:3]
size = int(sys.argv[3]) if len(sys.argv) > 3 else 300
counts = (8, 24, 72)

# %%
pictures, overlaps = [], []
with tempfile.TemporaryDirectory() as folder:
    for roots in counts:
        fit = juliavdb.fit(mesh, roots=roots, resolution=33)
        overlaps.append(fit.info["iou"])
        path = os.path.join(folder, "shape.json")
        fit.write(path)
        pictures.append(juliavdb.render(map="rational", rational=path, iterations=1, size=(size, size), samples=1))

# %% [markdown]
# The answer: the overlap with the target (its intersection by its union) rises with the roots.

# %%
save(out, np.concatenate(pictures, axis=1))
for roots, overlap in zip(counts, overlaps):
    print(f"at most {roots} roots: IoU {overlap:.3f}")
