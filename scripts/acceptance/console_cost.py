"""Measures the console: first paint, size, delay from capture to drawing, CPU by thread, accessibility.

An RTSP server draws CLOCK_MONOTONIC into every picture, 1280x720 at 30 frames a second. The delay is read from the
picture that the page draws, so that it covers the encoder, the network, the program, the decoder and the drawing. The
delays depend on the machine: the script fails over them only with --strict.
"""
import gzip
import json
import os
import pathlib
import sys
import time

import common
import live
from api import Socket, threads_of
from common import Emulator, Table
from console_page import Page, Program

# Records when a picture is drawn and the time code in it, before the page's own code runs.
HOOK = """
window.__codes = [];
const draw = CanvasRenderingContext2D.prototype.drawImage;
CanvasRenderingContext2D.prototype.drawImage = function (image, ...more) {
  draw.call(this, image, ...more);
  if (!(image instanceof HTMLCanvasElement) && window.__codes.length < 4000) {
    const at = performance.now();
    const width = this.canvas.width, row = this.getImageData(0, Math.round(this.canvas.height / 40), width, 1).data;
    let code = 0;
    for (let bit = 0; bit < 32; bit++) code = code * 2 + (row[4 * Math.round((bit + 0.5) * width / 32) + 1] > 128 ? 1 : 0);
    window.__codes.push([at, code]);
  }
};
"""


class HookedPage(Page):
    """A page that notes the time and the time code of each picture that it draws."""

    def __init__(self, url, folder, name):
        super().__init__("about:blank", folder, name)
        self.driver.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": HOOK})
        self.driver.get(url)

    def monotonic_offset(self):
        """CLOCK_MONOTONIC less the page's clock, milliseconds, from the sample with the shortest round trip."""
        samples = []
        for _ in range(40):
            before = time.monotonic()
            own = self.driver.execute_script("return performance.now()")
            after = time.monotonic()
            samples.append((after - before, (before + after) / 2 * 1e3 - own))
        return min(samples)[1]

    def delays(self):
        offset = self.monotonic_offset()
        codes = self.driver.execute_script("return window.__codes")
        return [(at + offset - code + 2**31) % 2**32 - 2**31 for at, code in codes]


def delays(table, args, folder, program):
    for path, name, limits in (("h264", "WebCodecs", (60, 120)), ("jpeg", "JPEG", (120, 250))):
        url = program.url if path == "h264" else program.url.replace("/#", "/?video=jpeg#")
        page = HookedPage(url, folder, path)
        page.ready()
        time.sleep(2)
        page.driver.execute_script("window.__codes = []")
        time.sleep(args.seconds)
        found = page.delays()
        median, worst = common.median(found), common.percentile(found, 0.95)
        table.require(f"{name} draws", page.data["path"] == path and len(found) > 10 * args.seconds, f"{len(found)} pictures in {args.seconds:.0f} s")
        text = f"median {median:.0f} ms, 95 % {worst:.0f} ms"
        if args.strict:
            table.require(f"  capture to drawing, {name}", median <= limits[0] and worst <= limits[1], text, f"{limits[0]} and {limits[1]} ms")
        else:
            table.show(f"  capture to drawing, {name}", text, f"wanted: {limits[0]} and {limits[1]} ms")
        page.end()


def cpu(table, args, program, emulator):
    """Measures CPU by thread, and the times of step and link, with 0, 1 and 3 viewers of the relayed H.264."""
    totals, steps, links = {}, {}, {}
    for viewers in (0, 1, 3):
        # Watchers, so that the requests below are not refused to a program without a page.
        sockets = [Socket(program, token=program.watch_token) for _ in range(viewers)]
        for viewer in sockets:
            viewer.send({"type": "video", "path": "h264"})
        readers = [reader(viewer) for viewer in sockets]
        time.sleep(1)
        before, begin = threads_of(program.child), time.monotonic()
        time.sleep(args.seconds)
        after, passed = threads_of(program.child), time.monotonic() - begin
        used = {name: (after[name] - before.get(name, 0)) / passed for name in after}
        totals[viewers] = used
        steps[viewers] = common.median([program.status()["video"]["step_ms"] for _ in range(3)])
        links[viewers] = reaction_ms(program, emulator)
        largest = sorted(used.items(), key=lambda item: -item[1])[:5]
        table.show(f"CPU with {viewers} viewers, share of a core", f"{sum(used.values()):.3f}", ", ".join(f"{name} {share:.3f}" for name, share in largest))
        for viewer in sockets:
            viewer.socket.close()
        for thread in readers:
            thread.join()
    for viewers, limit in ((1, 0.05), (3, 0.10)):
        more = totals[viewers].get("console", 0) - totals[0].get("console", 0)
        table.require(f"{viewers} viewer(s) of the stream: CPU of the thread console", more <= limit, f"{more:.3f} of a core", f"{limit:.2f}")
        for name, times in (("the pilot's step", steps), ("request to ground station", links)):
            excess_ms = times[viewers] - times[0]
            is_within = excess_ms <= max(0.05 * times[0], 0.02)
            text = f"{times[0]:.3f} and {times[viewers]:.3f} ms"
            if args.strict:
                table.require(f"  median of {name}, without and with", is_within, text, "within 5 % or 0.02 ms")
            else:
                table.show(f"  median of {name}, without and with", text, "wanted: within 5 % or 0.02 ms")


def reaction_ms(program, emulator):
    """Median time from a nudge's request until the ground station has the rate, milliseconds."""
    times = []
    for _ in range(21):
        begin = time.monotonic()
        answer = program.request("nudge", pan=1.0, tilt=0.0)
        assert answer["answer"] == "accepted", answer
        moved = emulator.wait_for(lambda row: row.at >= begin and row.moves, 2, "a rate").at
        times.append((moved - begin) * 1e3)
        emulator.wait_for(lambda row: row.at > moved and row.name == "Yaw" and row.is_zero, 2, "rest")
        time.sleep(0.2)
    return common.median(times)


def reader(viewer):
    import threading

    def read():
        last = time.monotonic()
        while viewer.read() is not None:
            if time.monotonic() - last > 2:
                last = time.monotonic()
                try:
                    viewer.send({"type": "ping", "sent_ms": 0})
                except OSError:
                    return

    thread = threading.Thread(target=read, daemon=True)
    thread.start()
    return thread


def size_and_paint(table, folder, program):
    files = [path for path in (common.ROOT / "console").iterdir() if path.suffix in (".js", ".css", ".html")]
    packed = sum(len(gzip.compress(path.read_bytes())) for path in files)
    table.require("the page's files, compressed", packed <= 200_000, f"{packed / 1e3:.0f} kB in {len(files)} files", "200 kB")
    page = Page(program.url, folder, "paint")
    page.ready()
    paint = page.driver.execute_script("return performance.getEntriesByName('first-contentful-paint').map((entry) => entry.startTime)[0] ?? null")
    table.require("first paint on loopback", paint is not None and paint < 1000, f"{paint:.0f} ms" if paint else "none", "under 1000 ms")
    hosts = page.driver.execute_script("return [...new Set(performance.getEntriesByType('resource').map((entry) => new URL(entry.name).host))]")
    table.require("no request leaves the machine", hosts == [program.host], ", ".join(hosts))
    return page


def accessibility(table, page):
    from axe_selenium_python import Axe

    for theme in ("day", "night"):
        if page.data["theme"] != theme:
            page.click("theme")
        axe = Axe(page.driver)
        # The page runs its own scripts alone; the driver's are not bound by that.
        axe.inject()
        found = [violation for violation in axe.run()["violations"] if violation["impact"] in ("serious", "critical")]
        table.require(f"axe-core, {theme}: nothing serious", not found, "; ".join(f"{item['id']} ({item['nodes'][0]['target']})" for item in found)[:300])
    # Everything is reached by Tab.
    names = page.driver.execute_script("return [...document.querySelectorAll('button, select, canvas[tabindex], summary, input')].filter((e) => e.offsetParent !== null && !e.disabled && !e.closest('details:not([open])')).map((e) => e.id || e.tagName)")
    page.driver.execute_script("document.activeElement.blur()")
    reached = set()
    for _ in range(60):
        page.type("\ue004")
        reached.add(page.driver.execute_script("const e = document.activeElement; return e.id || e.tagName"))
    missing = [name for name in names if name not in reached]
    table.require("every control is reached by the keyboard", not missing, f"{len(names)} controls" if not missing else f"not reached: {missing}")
    page.driver.execute_script("document.getElementById('picture').focus()")
    for key in ("enter", "left", "down", "enter"):
        page.type(key)
    page.wait(lambda data: data["track"] != "unseeded" or page.element("toast").text, 5, "the answer to a box by keyboard")
    table.require("a box is drawn by the keyboard alone", True, page.data["track"] + "; " + page.element("toast").text)
    page.type("space")
    page.wait(lambda data: data["mode"] == "stopped", 5, "the stop")
    table.require("and Stop by the space bar, whatever has the focus", True)


def main():
    args = common.arguments(__doc__, seconds={"type": float, "default": 6.0, "help": "how long each measurement lasts"}, strict={"action": "store_true", "help": "fail over the delays, too"})
    live.needs_server()
    folder = common.temporary_folder()
    table = Table("What the console costs")
    port = live.free_port()
    live.serve(port)
    emulator = Emulator(args.barrelman, folder)
    program = Program(args, "run", "--video", f"rtsp://127.0.0.1:{port}/video", "--link", emulator.url, "--select", live.SELECTION, "--record", folder / "run.mcap")
    program.wait(lambda status: status["track"]["state"] == "tracking", 30, "the track")
    page = size_and_paint(table, folder, program)
    accessibility(table, page)
    page.end()
    delays(table, args, folder, program)
    # The seat of the last page is kept for two seconds.
    common.wait_until(lambda: program.request("disengage")["answer"] == "accepted", 5, "the empty seat")
    program.wait(lambda status: status["link"]["state"] == "up", 30, "the link")
    cpu(table, args, program, emulator)
    table.require("SIGINT ends it with exit 0", program.end() == 0)
    return table.finish(args)


if __name__ == "__main__":
    sys.exit(main())
