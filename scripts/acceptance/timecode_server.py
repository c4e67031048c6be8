#!/usr/bin/python3
"""scripts/rtsp_server.py with a target in its time code pattern: a red patch that moves slowly.

The options are the same. The patch is PATCH pixels wide and high. It rests in the middle for REST_S seconds
after the first picture, because a program on a busy machine may receive the first picture late.
"""

import functools
import math
import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import rtsp_server

PATCH = 64
RED = (81, 90, 240)  # Y, U, V of red in BT.601, limited range; in BT.709 it is a red, too.

REST_S = 3.0


@functools.cache
def blank(width: int, height: int) -> bytes:
    return b"\x80" * (width * height + 2 * ((width + 1) // 2) * ((height + 1) // 2))


def code(width: int, height: int) -> bytes:
    """The rows of rtsp_server's time code: CLOCK_MONOTONIC in milliseconds as 32 blocks, the highest bit on
    the left."""
    millis = int(time.monotonic() * 1000) & 0xFFFFFFFF
    block = width // 32
    row = b"".join((b"\xeb" if millis >> (31 - bit) & 1 else b"\x10") * block for bit in range(32))
    return (row + b"\x80" * (width - len(row))) * max(height // 16, 8)


@functools.cache
def first_picture() -> float:
    return time.monotonic()


def place(width: int, height: int) -> tuple[int, int]:
    """Position of the patch, on even pixels: it moves to and fro over about a third of the picture's width in
    8 s."""
    swing = math.sin(max(time.monotonic() - first_picture() - REST_S, 0.0) * math.tau / 8)
    return (width // 2 - PATCH // 2 + int(swing * width / 6)) & ~1, (height // 2 - PATCH // 2) & ~1


def timecode(width: int, height: int) -> bytes:
    """Draws the patch first and the time code last, so that the age of the picture does not include the
    drawing."""
    x, y = place(width, height)
    picture = bytearray(blank(width, height))
    chroma_width, luma = (width + 1) // 2, width * height
    chroma = chroma_width * ((height + 1) // 2)
    for row in range(y, y + PATCH):
        picture[row * width + x : row * width + x + PATCH] = bytes([RED[0]]) * PATCH
    for plane, value in enumerate(RED[1:]):
        for row in range(y // 2, (y + PATCH) // 2):
            begin = luma + plane * chroma + row * chroma_width + x // 2
            picture[begin : begin + PATCH // 2] = bytes([value]) * (PATCH // 2)
    rows = max(height // 16, 8)
    picture[: width * rows] = code(width, height)
    return bytes(picture)


rtsp_server.timecode = timecode

if __name__ == "__main__":
    rtsp_server.main()
