# SPDX-License-Identifier: Apache-2.0
"""A mesh that numpy makes, a fractal of it, and a measurement of that: dents.py OUT.ply [RESOLUTION]"""
import sys

import juliavdb
import numpy as np


def torus(major=1.0, minor=0.4, around=96, across=48):
    """Vertices and triangles of a torus, outward."""
    u, v = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    a, b = 2 * np.pi * u / around, 2 * np.pi * v / across
    ring = major + minor * np.cos(b)
    vertices = np.stack([ring * np.cos(a), ring * np.sin(a), minor * np.sin(b)], axis=-1).reshape(-1, 3)
    number = lambda i, j: (i % around) * across + j % across
    p, q, r, s = number(u, v), number(u + 1, v), number(u + 1, v + 1), number(u, v + 1)
    return vertices, np.concatenate([np.stack([p, q, r], -1).reshape(-1, 3), np.stack([p, r, s], -1).reshape(-1, 3)])


def main():
    resolution = int(sys.argv[2]) if len(sys.argv) > 2 else 200
    vertices, faces = torus()
    made = juliavdb.fractal(vertices, faces, detail=0.4, texture="quills", resolution=resolution)
    made.write(sys.argv[1])

    # How far the fractal's vertices lie from the torus's surface.
    ring = np.hypot(made.vertices[:, 0], made.vertices[:, 1]) - 1.0
    distance = np.hypot(ring, made.vertices[:, 2]) - 0.4
    print(f"{len(made.vertices)} vertices, from {distance.min():.3f} to {distance.max():.3f} off the torus, "
          f"{100 * made.info['volume'] / made.info['target_volume']:.0f} % of its volume")


if __name__ == "__main__":
    main()
