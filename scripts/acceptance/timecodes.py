"""The time codes in the pictures of a recording: the lower 32 bits of CLOCK_MONOTONIC in milliseconds."""

import pathlib

import cv2

from camera import HEIGHT, WIDTH
from recording import Recording

BIT_ROWS = HEIGHT // 16


def read_codes(recording: Recording, folder: pathlib.Path) -> dict[int, int]:
    """The time code of every picture by its time of capture, nanoseconds of the recording."""
    formats = {message.format for message in recording["/video"]}
    capture = cv2.VideoCapture(str(recording.stream(folder / f"stream.{formats.pop()}")))
    codes: list[int] = []
    while True:
        there, picture = capture.read()
        if not there:
            break
        grey = cv2.cvtColor(picture[: BIT_ROWS - 8], cv2.COLOR_BGR2GRAY)
        bits = [
            grey[8:, bit * WIDTH // 32 + 8 : (bit + 1) * WIDTH // 32 - 8].mean() > 128 for bit in range(32)
        ]
        codes.append(sum(1 << (31 - bit) for bit, one in enumerate(bits) if one))
    units = recording["/video/unit"]
    # Units before the first key frame give no picture.
    first = next((index for index, unit in enumerate(units) if unit.key), len(units))
    return {unit.captured_ns: code for unit, code in zip(units[first:], codes, strict=False)}
