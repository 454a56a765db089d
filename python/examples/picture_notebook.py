# SPDX-License-Identifier: Apache-2.0
# In a notebook each "# %%" begins a cell; as a script: picture_notebook.py MESH OUT.png [SIZE]

# %% What is needed
import struct
import sys
import zlib

import juliavdb
import numpy as np

mesh, out = sys.argv[1:3]
size = int(sys.argv[3]) if len(sys.argv) > 3 else 300

# %% One field, three textures
pictures = []
for texture in ("quills", "scales", "thorns"):
    field = juliavdb.Field(mesh, detail=0.4, texture=texture)
    pictures.append(field.render(size=(size, size), samples=1))
strip = np.concatenate(pictures, axis=1)


# %% Show it. With matplotlib this is plt.imshow(strip); here it becomes a PNG by hand
def png(pixels):
    """The bytes of a PNG of an array (height, width, 3) of uint8."""
    height, width, _ = pixels.shape

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = np.concatenate([np.zeros((height, 1), np.uint8), pixels.reshape(height, -1)], axis=1)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows.tobytes())) + chunk(b"IEND", b""))


with open(out, "wb") as file:
    file.write(png(strip))
print(f"{strip.shape[1]} x {strip.shape[0]} pixels")
