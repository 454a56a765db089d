# SPDX-License-Identifier: Apache-2.0
"""Pictures of arrays, for the tools."""
import pathlib
import struct
import zlib

import numpy


def write_png(path, pixels):
    """8 bits of grey, (height, width), or of red, green and blue, (height, width, 3), from 0 to 255. The first row is on top."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    height, width = pixels.shape[:2]
    rows = b"".join(b"\0" + row.tobytes() for row in pixels.astype(numpy.uint8))
    pathlib.Path(path).write_bytes(b"\x89PNG\r\n\x1a\n"
                                   + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 2 if pixels.ndim == 3 else 0, 0, 0, 0))
                                   + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))
