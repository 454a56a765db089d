# SPDX-License-Identifier: Apache-2.0
"""What the notebooks of this folder show their answers with: PNG files of arrays, and plots of lines. Where matplotlib is
installed, plt.imshow(pixels) and plt.loglog(x, y) do the same."""
import struct
import zlib

import numpy as np


def save(path, pixels):
    """Writes an array (height, width, 3) of uint8 as a PNG."""
    height, width, _ = pixels.shape

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = np.concatenate([np.zeros((height, 1), np.uint8), pixels.reshape(height, -1)], axis=1)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0))
                   + chunk(b"IDAT", zlib.compress(rows.tobytes())) + chunk(b"IEND", b""))


COLOURS = np.array([(40, 80, 160), (190, 60, 40), (60, 130, 60), (150, 90, 160)], np.uint8)


def plot(*lines, size=(400, 300)):
    """Pixels of a plot with logarithmic axes. Each line is two arrays, x and y, above 0; all of them share the axes."""
    width, height, margin = *size, 20
    logs = [np.log(np.array(line, float)) for line in lines]
    whole = np.concatenate(logs, axis=1)
    low, range_ = whole.min(axis=1), np.maximum(np.ptp(whole, axis=1), 1e-9)
    pixels = np.full((height, width, 3), 255, np.uint8)
    pixels[margin:height - margin, margin] = pixels[height - margin, margin:width - margin] = 0
    for (x, y), colour in zip(logs, COLOURS[np.arange(len(lines)) % len(COLOURS)]):
        at = np.stack([margin + (x - low[0]) / range_[0] * (width - 2 * margin - 1),
                       height - margin - (y - low[1]) / range_[1] * (height - 2 * margin - 1)])
        for (x0, y0), (x1, y1) in zip(at.T, at.T[1:]):
            part = np.linspace(0, 1, width + height)
            pixels[np.round(y0 + part * (y1 - y0)).astype(int), np.round(x0 + part * (x1 - x0)).astype(int)] = colour
        for x0, y0 in np.round(at.T).astype(int):
            pixels[max(y0 - 2, 0):y0 + 3, max(x0 - 2, 0):x0 + 3] = colour
    return pixels
