"""The operator's own map under boat and marks: tiles of an MBTiles file, made here, at the place of a vehicle
that reports where it is.

The tiles have a line ahead of the vehicle, which must stand upright on the page's map, above the camera.
"""

import math
import pathlib
import sqlite3
from collections.abc import Iterator

import cv2
import numpy
import pytest

from client import WORLD, Program
from conftest import Check
from located_gimbal import HEADING_DEG, LATITUDE, LONGITUDE, LocatedGimbal
from machine import wait_until
from page import Page
from process import run

pytestmark = pytest.mark.apart

ZOOM, TILE_PX, AROUND = 19, 256, 3
ATTRIBUTION = "harbour office"
RADIUS_M = 6_378_137.0
SEA, LINE = (96, 64, 16), (255, 0, 255)
LINE_M = 40.0


def tile_place() -> tuple[float, float]:
    """The vehicle's place in tiles, from the west and from the north."""
    side, phi = 2**ZOOM, math.radians(LATITUDE)
    return ((LONGITUDE + 180) / 360 * side, (1 - math.asinh(math.tan(phi)) / math.pi) / 2 * side)


def make_map(path: pathlib.Path) -> None:
    """Tiles around the vehicle, with a line from it in the direction of its nose."""
    west, north = tile_place()
    first = (math.floor(west) - AROUND, math.floor(north) - AROUND)
    count = 2 * AROUND + 1
    picture = numpy.full((count * TILE_PX, count * TILE_PX, 3), SEA, numpy.uint8)
    metres = 2 * math.pi * RADIUS_M * math.cos(math.radians(LATITUDE)) / 2**ZOOM / TILE_PX
    start = [TILE_PX * (place - tile) for place, tile in zip((west, north), first, strict=True)]
    heading = math.radians(HEADING_DEG)
    ahead = (math.sin(heading) * LINE_M / metres, -math.cos(heading) * LINE_M / metres)
    end = [place + way for place, way in zip(start, ahead, strict=True)]
    cv2.line(picture, list(map(round, start)), list(map(round, end)), LINE, round(1.5 / metres))
    with sqlite3.connect(path) as file:
        file.execute("CREATE TABLE metadata (name text, value text)")
        file.execute("INSERT INTO metadata VALUES ('attribution', ?)", [ATTRIBUTION])
        file.execute(
            "CREATE TABLE tiles (zoom_level integer, tile_column integer, tile_row integer, tile_data blob)"
        )
        for x in range(count):
            for y in range(count):
                rows, columns = (slice(TILE_PX * at, TILE_PX * (at + 1)) for at in (y, x))
                png = cv2.imencode(".png", picture[rows, columns])[1].tobytes()
                row = 2**ZOOM - 1 - (first[1] + y)
                file.execute("INSERT INTO tiles VALUES (?, ?, ?, ?)", [ZOOM, first[0] + x, row, png])


@pytest.fixture
def gimbal() -> Iterator[LocatedGimbal]:
    gimbal = LocatedGimbal()
    yield gimbal
    gimbal.close()


def test_map_lies_under_the_boat_with_ahead_up(
    barrelman: pathlib.Path,
    tmp_path: pathlib.Path,
    gimbal: LocatedGimbal,
    check: Check,
    pytestconfig: pytest.Config,
) -> None:
    path = tmp_path / "map.mbtiles"
    make_map(path)
    options = ["--no-record", "--video", WORLD, "--profile", "mavlink-gimbal", "--link", gimbal.url]
    with Program(barrelman, "run", *options, "--vessel", "sim:", "--map", path) as program:
        program.wait(lambda status: status["water_on_earth"], "the place of the water on Earth")
        west, north = map(math.floor, tile_place())
        tile = f"/api/v1/map/{ZOOM}/{west}/{north}"
        code, body, headers = program.ask("GET", tile)
        check("a tile is served", code == 200 and body.startswith(b"\x89PNG"), code)
        check("with its type", headers["Content-Type"] == "image/png", headers)
        check("nothing is served without a token", program.ask("GET", tile, token=None)[0] == 401)
        check("the end of the map is no error", program.ask("GET", f"/api/v1/map/{ZOOM}/0/0")[0] == 204)
        with Page(program.url, tmp_path) as page:
            page.ready()
            found = wait_until(lambda: line_of(page), "the line of the tiles on the map", pause=0.1)
            page.screenshot(pytestconfig.getoption("--screenshots"), "map")
            width, height = found
            check("what is ahead is up", height > 5 * width, found)
            complaints = page.complaints()
            check("the browser has nothing to complain about", not complaints, complaints)


def line_of(page: Page) -> tuple[int, int] | None:
    """Width and height of the line on the page, pixels, once there is one."""
    png = page.element("picture").screenshot_as_png
    picture = cv2.imdecode(numpy.frombuffer(png, numpy.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    rows, columns = numpy.nonzero((numpy.abs(picture.astype(int) - LINE) < 8).all(axis=2))
    if len(rows) < 20:
        return None
    return (int(columns.max() - columns.min()) + 1, int(rows.max() - rows.min()) + 1)


def test_map_that_is_none_is_refused(barrelman: pathlib.Path, tmp_path: pathlib.Path, check: Check) -> None:
    (tmp_path / "empty").mkdir()
    for name, reason in [("missing", "there is no map"), ("empty", "17/69000/42000.png")]:
        refused = run([barrelman, "demo", "--listen", "127.0.0.1:0", "--map", tmp_path / name])
        check(f"{name}: the run does not begin", refused.returncode == 1, refused.returncode)
        check(f"{name}: the error says why", reason in refused.stderr, refused.stderr)
