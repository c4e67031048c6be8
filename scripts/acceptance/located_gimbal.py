"""A gimbal whose vehicle says where it is, a run with it, and places on Earth."""

import math
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from client import Program, Request
from independent_gimbal import GimbalManager

LATITUDE, LONGITUDE, HEADING_DEG, HEIGHT_M = 54.1234567, -10.7654321, 30.0, 12.5
WORLD = "sim:rescue?size=640x360"


class LocatedGimbal(GimbalManager):
    """A gimbal whose vehicle reports its position and the direction of its nose.

    It looks so far down that every line of sight meets the water nearby.
    """

    def __init__(self) -> None:
        super().__init__()
        self.angles = [0.0, -0.9]

    def _attitude(self) -> Any:
        lat, lon = round(LATITUDE * 1e7), round(LONGITUDE * 1e7)
        height = round(HEIGHT_M * 1e3)
        self._send(
            mavlink.MAVLink_global_position_int_message(
                self._ms(), lat, lon, 40_000, height, 0, 0, 0, round(HEADING_DEG * 100)
            )
        )
        return super()._attitude()


def place_of(x: float, y: float) -> tuple[float, float]:
    """Latitude and longitude (WGS 84) of a point to the right of the camera and ahead of it, metres."""
    heading, phi = math.radians(HEADING_DEG), math.radians(LATITUDE)
    north, east = y * math.cos(heading) - x * math.sin(heading), y * math.sin(heading) + x * math.cos(heading)
    a, e2 = 6378137.0, 6.69437999014e-3
    shape = 1 - e2 * math.sin(phi) ** 2
    meridian, normal = a * (1 - e2) / shape**1.5, a / math.sqrt(shape)
    return (
        LATITUDE + math.degrees(north / meridian),
        LONGITUDE + math.degrees(east / (normal * math.cos(phi))),
    )


def distance_m(place: tuple[float, float], other: tuple[float, float]) -> float:
    """Between two nearby places on Earth."""
    metres = 111_320.0
    north, east = (place[0] - other[0]) * metres, (place[1] - other[1]) * metres
    return math.hypot(north, east * math.cos(math.radians(LATITUDE)))


def located_run(barrelman: Any, gimbal: GimbalManager, *options: Any) -> Program:
    """A run that follows the boat, and has a place and a person marked."""
    program = Program(
        barrelman,
        "run",
        *options,
        *("--no-record", "--video", WORLD, "--profile", "mavlink-gimbal", "--link", gimbal.url),
        *("--vessel", "sim:"),
    )
    program.wait(lambda status: status["boat"] and status["boat"]["on_earth"], "the boat's place on Earth")
    for kind in ("place", "person"):
        status = program.status()
        width, height = status["video"]["size"]
        at = {"u": width / 4, "v": 0.75 * height}
        answer = program.request(
            Request("mark", mark=kind, at=at, captured_ns=status["video"]["captured_ns"])
        )
        assert answer["answer"] == "accepted", answer
    return program
