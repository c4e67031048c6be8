"""The camera law and the metrics on the laboratory's 30 trials: the authors' rates, from the positions
alone."""

import concurrent.futures
import csv
import io
import json
import pathlib
from typing import Any

import pytest

from conftest import Check, shared
from process import run

ROWS = 71_914
P_TOLERANCE = 1e-5
SENSITIVITY_TOLERANCE = 0.0003
HEADER = "x_val,y_val,pitch,yaw,val,time"


def recorded(path: pathlib.Path) -> list[list[str]]:
    """The rows of a trial. The file has no line break between the header and the first row."""
    text = path.read_text()
    assert text.startswith(HEADER), path
    return [line.split(",") for line in text[len(HEADER) :].splitlines()]


@pytest.fixture(scope="module")
def trials() -> list[pathlib.Path]:
    return sorted(shared("data", "trials").glob("arena*.csv"))


def test_law_gives_the_recorded_rates_from_the_positions_alone(
    barrelman: pathlib.Path, trials: list[pathlib.Path], tmp_path: pathlib.Path, check: Check
) -> None:
    def law(path: pathlib.Path) -> str:
        done = run([barrelman, "law", path])
        assert done.returncode == 0, f"law {path.name}: {done.stderr}"
        return done.stdout

    def blanked(path: pathlib.Path) -> pathlib.Path:
        """The same trial with zeros in place of the rates and P of the authors' program."""
        rows = [",".join([row[0], row[1], "0", "0", "0", *row[5:]]) for row in recorded(path)]
        (tmp_path / path.name).write_text(HEADER + "\n".join(rows) + "\n")
        return tmp_path / path.name

    rows, worst, mismatches, differing = 0, 0.0, [], []
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        for path, output, blind in zip(
            trials, pool.map(law, trials), pool.map(lambda path: law(blanked(path)), trials), strict=True
        ):
            differing += [path.name] if output != blind else []
            given, computed = recorded(path), list(csv.DictReader(io.StringIO(output)))
            mismatches += (
                [f"{path.name}: {len(computed)} rows of {len(given)}"] if len(computed) != len(given) else []
            )
            for number, (was, now) in enumerate(zip(given, computed, strict=False)):
                rows += 1
                if float(was[2]) != float(now["pitch_rate"]) or float(was[3]) != float(now["yaw_rate"]):
                    mismatches.append(
                        f"{path.name} row {number}: {was[2:4]}, {now['pitch_rate']}, {now['yaw_rate']}"
                    )
                p = float(was[4])
                worst = max(worst, abs(float(now["p"]) - p) / max(1.0, p))
    check("there are 30 trials", len(trials) == 30, len(trials))
    check("every row is computed", rows == ROWS, f"{rows} of {ROWS}")
    check("pitch and yaw rates equal the recorded ones", not mismatches, "; ".join(mismatches[:3]))
    check("|P - recorded| / max(1, P) is small", worst <= P_TOLERANCE, f"{worst:.2e}, at most {P_TOLERANCE}")
    check("the output is the same with pitch, yaw and P blanked", not differing, " ".join(differing))


@pytest.fixture(scope="module")
def arenas(barrelman: pathlib.Path, trials: list[pathlib.Path]) -> Any:
    done = run([barrelman, "metrics", "--json", *trials])
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)["arenas"]


@pytest.mark.parametrize(("arena", "published"), [("1", 0.6055), ("2", 0.4535)])
def test_mean_sensitivity_is_the_published_one(arenas: Any, arena: str, published: float) -> None:
    assert arenas[arena]["mean_sensitivity"] == pytest.approx(published, abs=SENSITIVITY_TOLERANCE)
