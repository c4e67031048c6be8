"""Tests the camera law and the metrics on the laboratory's 30 trials: the authors' rates, from the positions alone."""
import concurrent.futures
import csv
import io
import json
import sys

import common
from common import Table

ROWS = 71_914
P_TOLERANCE = 1e-5
PUBLISHED = {"1": 0.6055, "2": 0.4535}
SENSITIVITY_TOLERANCE = 0.0003
HEADER = "x_val,y_val,pitch,yaw,val,time"


def recorded(path):
    """The rows of a trial. The file has no line break between the header and the first row."""
    text = path.read_text()
    assert text.startswith(HEADER), path
    return [line.split(",") for line in text[len(HEADER) :].splitlines()]


def blanked(path, folder):
    """The same trial with zeros in place of the rates and P of the authors' program."""
    copy = folder / path.name
    rows = [[row[0], row[1], "0", "0", "0", *row[5:]] for row in recorded(path)]
    copy.write_text(HEADER + "\n".join(",".join(row) for row in rows) + "\n")
    return copy


def law(args, path):
    done = common.run([args.barrelman, "law", path])
    if done.returncode:
        raise RuntimeError(f"law {path.name}: exit {done.returncode}: {done.stderr}")
    return done.stdout


def main():
    args = common.arguments(__doc__)
    trials = sorted(common.shared_or_skip("data", "trials").glob("arena*.csv"))
    folder = common.temporary_folder()
    table = Table("`barrelman law` and `metrics` on the laboratory's trials")
    table.require("trials", len(trials) == 30, len(trials), "30")
    rows = mismatches = 0
    worst = 0.0
    differing = []
    where = []
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        outputs = zip(trials, pool.map(lambda path: law(args, path), trials), pool.map(lambda path: law(args, blanked(path, folder)), trials))
        for path, output, blind in outputs:
            if output != blind:
                differing.append(path.name)
            given = recorded(path)
            computed = list(csv.DictReader(io.StringIO(output)))
            if len(computed) != len(given):
                where.append(f"{path.name}: {len(computed)} rows of {len(given)}")
            for number, (was, now) in enumerate(zip(given, computed)):
                rows += 1
                if float(was[2]) != float(now["pitch_rate"]) or float(was[3]) != float(now["yaw_rate"]):
                    mismatches += 1
                    where.append(f"{path.name} row {number}: {was[2:4]}, {now['pitch_rate']}, {now['yaw_rate']}")
                p = float(was[4])
                worst = max(worst, abs(float(now["p"]) - p) / max(1.0, p))
    table.require("rows", rows == ROWS, rows, ROWS)
    table.require("rows whose pitch or yaw differs from the recorded one", mismatches == 0, mismatches, "; ".join(where[:3]) or "none")
    table.require("largest |P - recorded| / max(1, P)", worst <= P_TOLERANCE, f"{worst:.2e}", f"at most {P_TOLERANCE}")
    table.require("the same output with pitch, yaw and P blanked", not differing, f"{30 - len(differing)} of 30", " ".join(differing))
    done = common.run([args.barrelman, "metrics", "--json", *trials])
    table.require("metrics --json", done.returncode == 0, f"exit {done.returncode}", done.stderr)
    arenas = json.loads(done.stdout)["arenas"]
    for arena, wanted in PUBLISHED.items():
        figure = arenas[arena]["mean_sensitivity"]
        table.require(f"mean sensitivity of arena {arena}", abs(figure - wanted) <= SENSITIVITY_TOLERANCE, f"{figure:.5f}", f"{wanted} +- {SENSITIVITY_TOLERANCE}")
        table.show(f"success rate of arena {arena}", f"{arenas[arena]['success_rate']:.3f}", "the paper claims 1")
    return table.finish(args, rows=rows, mismatches=mismatches, worst_p=worst, arenas=arenas)


if __name__ == "__main__":
    sys.exit(main())
