"""Draws docs/drawings/optimal-timeline.svg: one excursion under the optimal law, beside the same seconds under the paper's.

    trial="barrelman trials lab2 --perception truth --trials 1 --seed 3"
    $trial --law schema --record schema
    $trial --law optimal --mode minimum-energy --record optimal
    for law in schema optimal; do barrelman export $law/lab2-3.mcap --output $law-3; done
    scripts/drawings/optimal_timeline.py schema-3/trial.csv optimal-3/trial.csv > docs/drawings/optimal-timeline.svg
"""
import csv
import math
import sys

FROM, TO = 21.0, 26.0
LEFT, RIGHT = 92, 852
# The two lanes: top and bottom on the paper, and the values there.
DISTANCE = (66, 262, 1.4, 0.4)
RATES = (308, 420, 0.4, -0.1)
INK, DIM, REGION, BOAT, PAN, TILT = "#1f2937", "#4b5563", "#0f766e", "#1d4ed8", "#c2410c", "#7c3aed"
# What happens, and when: seconds, and the number of the line below the figure.
EVENTS = ((22.00, 1), (22.33, 2), (22.60, 3), (22.87, 4), (23.25, 5), (23.67, 6))


def read(path):
    """Times, distances in semi-axes, pan and tilt rates within the window."""
    rows = [row for row in csv.DictReader(open(path, encoding="utf-8")) if row["p"]]
    rows = [row for row in rows if FROM - 0.1 <= float(row["time_s"]) <= TO + 0.1]
    return [(float(row["time_s"]), math.sqrt(float(row["p"])), float(row["pan_rate"]), float(row["tilt_rate"])) for row in rows]


def x_of(seconds):
    return LEFT + (min(max(seconds, FROM), TO) - FROM) / (TO - FROM) * (RIGHT - LEFT)


def y_of(lane, value):
    top, bottom, high, low = lane
    return bottom - (min(max(value, low), high) - low) / (high - low) * (bottom - top)


def line(x1, y1, x2, y2, colour, more=""):
    return f'  <path d="M{x1:.1f},{y1:.1f} L{x2:.1f},{y2:.1f}" fill="none" stroke="{colour}" {more}/>'


def text(x, y, words, more='class="small"'):
    return f'  <text x="{x:.1f}" y="{y:.1f}" {more}>{words}</text>'


def curve(points, colour, more):
    path = " ".join(f"{'M' if index == 0 else 'L'}{x:.1f},{y:.1f}" for index, (x, y) in enumerate(points))
    return f'  <path d="{path}" fill="none" stroke="{colour}" {more}/>'


def steps(rows, column):
    """A rate holds until the next row."""
    points = []
    for (start, *_), row, following in zip(rows, rows, rows[1:] + rows[-1:]):
        y = y_of(RATES, row[column])
        points += [(x_of(start), y), (x_of(following[0]), y)]
    return points


def main():
    schema, optimal = read(sys.argv[1]), read(sys.argv[2])
    out = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 880 470" width="880" height="470" role="img" aria-labelledby="title desc">']
    out.append('  <title id="title">One excursion under the optimal law</title>')
    out.append('  <desc id="desc">Distance of the boat from the centre in semi-axes of the region over five seconds, and the commanded pan and tilt. The boat speeds up to the right at 22.1 seconds; pan rises to its largest rate within a sixth of a second; the boat leaves the region at 22.6, turns back at 22.9, and is inside again at 23.3 seconds. Under the paper\'s law the same boat is outside from 22.6 to 23.7 seconds and goes farther out.</desc>')
    out.append("  <style>\n    text { font-family: Helvetica, Arial, \"DejaVu Sans\", sans-serif; font-size: 13px; fill: #1f2937; }\n    .head { font-size: 15px; font-weight: bold; }\n    .small { font-size: 12px; fill: #4b5563; }\n    .number { font-size: 12px; font-weight: bold; fill: #ffffff; }\n  </style>")
    out.append('  <rect x="1" y="1" width="878" height="468" rx="14" fill="#ffffff" stroke="#d1d5db"/>')
    out.append(text(28, 34, "One excursion: lab2, seed 3", 'class="head"'))
    for seconds in range(int(FROM), int(TO) + 1):
        out.append(line(x_of(seconds), DISTANCE[0], x_of(seconds), RATES[1], "#e5e7eb"))
        out.append(text(x_of(seconds), RATES[1] + 18, f"{seconds} s", 'class="small" text-anchor="middle"'))
    for value, words, colour in ((1.0, "region", REGION), (0.85, "start", DIM), (0.704, "aim", DIM)):
        y = y_of(DISTANCE, value)
        out.append(line(LEFT, y, RIGHT, y, colour, 'stroke-width="1.2" stroke-dasharray="6 4"'))
        out.append(text(LEFT - 8, y + 4, f"{words} {value:g}", f'class="small" text-anchor="end" style="fill:{colour}"'))
    out.append(text(LEFT, DISTANCE[0] - 10, "distance from the centre, in semi-axes of the region"))
    out.append(curve([(x_of(row[0]), y_of(DISTANCE, row[1])) for row in schema], "#9ca3af", 'stroke-width="1.6" stroke-dasharray="4 3"'))
    out.append(curve([(x_of(row[0]), y_of(DISTANCE, row[1])) for row in optimal], BOAT, 'stroke-width="2.5"'))
    top = max(schema, key=lambda row: row[1] if 22 < row[0] < 24 else 0)
    out.append(text(x_of(top[0]) + 8, y_of(DISTANCE, top[1]) - 6, "the paper\u2019s law, same boat"))
    out.append(text(RIGHT, RATES[0] - 10, "commanded rates, rad/s (pan + right, tilt + up)", 'class="small" text-anchor="end"'))
    for value in (0.34, 0.0):
        y = y_of(RATES, value)
        out.append(line(LEFT, y, RIGHT, y, "#d1d5db"))
        out.append(text(LEFT - 8, y + 4, f"{value:g}", 'class="small" text-anchor="end"'))
    out.append(curve(steps(optimal, 2), PAN, 'stroke-width="2"'))
    out.append(curve(steps(optimal, 3), TILT, 'stroke-width="2"'))
    out.append(text(x_of(22.95), y_of(RATES, 0.33), "pan", f'style="fill:{PAN}"'))
    out.append(text(x_of(23.62), y_of(RATES, -0.1) - 2, "tilt", f'style="fill:{TILT}"'))
    for seconds, number in EVENTS:
        x = x_of(seconds)
        out.append(line(x, DISTANCE[1] - 4, x, RATES[1], DIM, 'stroke-width="0.8" stroke-dasharray="2 3"'))
        out.append(f'  <circle cx="{x:.1f}" cy="{DISTANCE[1] + 6}" r="9" fill="{INK}"/>')
        out.append(text(x, DISTANCE[1] + 10, str(number), 'class="number" text-anchor="middle"'))
    print("\n".join(out + ["</svg>"]))


if __name__ == "__main__":
    main()
