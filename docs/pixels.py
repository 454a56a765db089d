# SPDX-License-Identifier: Apache-2.0
"""What the scripts of this folder read in the files of pictures: PNG, the JPEG of thumbnails, and GIF."""
import struct
import zlib


def chunks(data):
    """The chunks of a PNG, as (kind, all bytes of it)."""
    at = 8
    while at < len(data):
        length, = struct.unpack(">I", data[at:at + 4])
        yield data[at + 4:at + 8], data[at:at + 12 + length]
        at += 12 + length


def segments(data):
    """The segments of a JPEG, as (marker, all bytes of it); the last one has the picture."""
    at = 2
    while at < len(data) and data[at + 1] != 0xDA:
        length, = struct.unpack(">H", data[at + 2:at + 4])
        yield data[at + 1], data[at:at + 2 + length]
        at += 2 + length
    yield 0xDA, data[at:]


def pixels(picture):
    """What a file shows, without what its text says: the rows of a PNG as they are stored, the coded blocks of a JPEG, or all of a
    GIF, which has no text."""
    data = picture.read_bytes()
    if data[:3] == b"GIF":
        return data
    if data[:2] == b"\xff\xd8":
        return [segment for marker, segment in segments(data) if not 0xE1 <= marker <= 0xEF and marker != 0xFE]
    found = [(kind, chunk[8:-4]) for kind, chunk in chunks(data) if kind in (b"IHDR", b"PLTE", b"tRNS", b"IDAT")]
    return ([chunk for chunk in found if chunk[0] != b"IDAT"],
            zlib.decompress(b"".join(content for kind, content in found if kind == b"IDAT")))


def same(made, stored):
    """Whether both files are there and show the same, pixel for pixel."""
    return made.exists() and stored.exists() and pixels(made) == pixels(stored)
