"""Tests a new user's mistakes: each ends with one message that names the cause and the remedy, and without a panic.

The messages are printed, so that people can judge them. Root may open every file, so cases that depend on
permissions run as `nobody` where this script runs as root.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

import common
from common import Emulator, Table

NOBODY = 65534
ROOT_USER = os.geteuid() == 0
FIXTURES = common.ROOT / "fixtures" / "video"


class Bench:
    def __init__(self, args, folder, table, clip, truth):
        self.folder, self.table = folder, table
        self.clip, self.selection = clip, common.selection(truth)
        self.program = pathlib.Path(args.barrelman)
        os.chmod(folder, 0o755)
        if ROOT_USER:
            # Where an ordinary user can reach it.
            guard = pathlib.Path(args.barrelman).with_name("barrelman-guard")
            for program in (guard, args.barrelman):
                self.program = pathlib.Path(shutil.copy(program, folder / pathlib.Path(program).name))
                os.chmod(self.program, 0o755)
        self.said = []

    def file(self, name, content=""):
        path = self.folder / name
        path.write_text(content)
        return path

    def pictures(self, name, colour, count=10):
        import cv2
        import numpy

        where = self.folder / name
        where.mkdir()
        picture = numpy.full((240, 320, 3), colour, numpy.uint8)
        for frame in range(count):
            cv2.imwrite(str(where / f"{frame}.png"), picture)
        return where

    def refuse(self, name, words, *named, code=1, out=None, user=None, timeout=15):
        """Requires that a command is refused. `named`: patterns in the message, first the cause, then the remedy."""
        keywords = {"user": user, "group": user, "extra_groups": []} if user is not None and ROOT_USER else {}
        if user is not None and ROOT_USER:
            os.chmod(self.folder, 0o777)
        # With a console, a refused selection does not end a run: the operator can select again.
        words = [words[0], "--headless", *words[1:]] if words[0] == "run" else words
        try:
            done = common.run([self.program, *words], timeout=timeout, cwd=self.folder, **keywords)
        except subprocess.TimeoutExpired as error:
            said = (error.stderr or b"").decode()
            self.table.require(name, False, "still running", said.strip())
            self.said.append({"name": name, "message": said, "exit": None})
            return
        said = done.stderr.strip()
        errors = [line for line in said.splitlines() if re.match(r"(ERROR|error:)", line.strip())]
        faults = []
        if done.returncode != code:
            faults.append(f"exit {done.returncode} instead of {code}")
        if len(errors) != 1:
            faults.append(f"{len(errors)} messages instead of one")
        faults += [f"nothing of {pattern!r} in the message" for pattern in named if not re.search(pattern, said)]
        faults += [f"{word!r} in the message" for word in ("panicked", "RUST_BACKTRACE") if word in said]
        if any(re.search(r"(.{60,}).*\1", line) for line in said.splitlines()):
            faults.append("it says the same twice")
        if out is not None and not out(done.stdout):
            faults.append(f"standard output is not as it should be: {done.stdout[:100]!r} ...")
        self.table.require(name, not faults, f"exit {done.returncode}", "; ".join(faults))
        for line in said.splitlines():
            print(f"         | {line}")
        self.said.append({"name": name, "command": [str(word) for word in words], "message": said, "exit": done.returncode})


def video(bench):
    track = ["track", "--select", bench.selection]
    bench.refuse("video: a missing file", ["track", "nowhere.mp4", *track[1:]], "nowhere.mp4", "check the path|is there")
    bench.refuse("video: a missing file, in run", ["run", "--video", "file:nowhere.mp4"], "nowhere.mp4", "check the path|is there")
    bench.refuse("video: a text file", ["track", bench.file("notes.txt", "not a video\n" * 20), *track[1:]], "notes.txt", r"MP4|mp4")
    bench.refuse("video: a text file that is called .mp4", ["track", bench.file("notes.mp4", "not a video\n" * 20), *track[1:]], "notes.mp4", r"MP4|mp4|ffmpeg")
    bench.refuse("video: an empty file", ["track", bench.file("empty.mp4"), *track[1:]], "empty.mp4", "empty|ends|no ")
    (bench.folder / "no-pictures").mkdir()
    bench.refuse("video: a folder without pictures", ["track", "no-pictures", *track[1:]], "no-pictures", "PNG|JPEG")
    bench.refuse("video: no source at all", ["run"], "--video", code=2)
    bench.refuse("video: an unknown scheme", ["run", "--video", "http://example.org/live"], "http", "rtsp")
    for name, what in (("clip.mkv", "mkv|MKV|Matroska"), ("motion_jpeg.avi", "avi|AVI"), ("hevc.mp4", "H.265|HEVC"), ("interlaced.mp4", "interlaced"), ("ten_bit.mp4", "10"), ("chroma_422.mp4", "4:2:2")):
        bench.refuse(f"video: {name}", ["track", FIXTURES / name, "--select", "10,10,40,40"], name, what, "ffmpeg|record|H.264")


def selections(bench):
    grey = bench.pictures("grey", (128, 128, 128))
    orange = bench.pictures("orange", (20, 120, 240))
    bench.refuse("selection: outside the picture", ["track", orange, "--select", "900,10,40,40"], "900,10,40,40", "320x240")
    bench.refuse("selection: outside the picture, leaves nothing behind", ["track", orange, "--select", "900,10,40,40", "--output", "outside.csv"], "900,10,40,40")
    bench.table.require("  no half output", not (bench.folder / "outside.csv").exists(), "", "outside.csv is there" if (bench.folder / "outside.csv").exists() else "")
    bench.refuse("selection: outside the picture, in run", ["run", "--video", f"file:{orange}?fps=30", "--select", "900,10,40,40", "--engage"], "900,10,40,40", "320x240")
    bench.refuse("selection: of zero size", ["track", orange, "--select", "10,10,0,20"], "10,10,0,20", "width", code=2)
    bench.refuse("selection: of zero size, in run", ["run", "--video", f"file:{orange}", "--select", "10,10,20,0"], "10,10,20,0", "height", code=2)
    bench.refuse("selection: three numbers", ["track", orange, "--select", "10,10,20"], "10,10,20", "X,Y,W,H|four", code=2)
    bench.refuse("selection: words", ["track", orange, "--select", "left,top,w,h"], "left", code=2)
    bench.refuse("selection: not a number", ["track", orange, "--select", "NaN,10,20,20"], "NaN", code=2)
    # CamShift goes by hue alone; the fused tracker takes what is grey, too.
    bench.refuse("selection: no saturated pixel", ["track", grey, "--select", "10,10,40,40", "--tracker", "camshift"], "10,10,40,40", "satur|colour")
    bench.refuse("selection: no saturated pixel, in run", ["run", "--video", f"file:{grey}?fps=30", "--select", "10,10,40,40", "--engage", "--tracker", "camshift"], "10,10,40,40", "satur|colour")
    bench.refuse("selection: start frame behind the end", ["track", orange, "--select", "10,10,40,40", "--start-frame", "99"], "99", "10")


def logs(bench):
    rows = ["-78,17,0,0,0.185109,0.000000,1493598415"] * 5
    header = "x_val,y_val,pitch,yaw,val,time"
    cut = bench.file("arena1_99.csv", header + "\n".join(rows) + "\n-77,14,0,0,0.17")
    bench.refuse("log: cut in the middle of a row, in law", ["law", cut], "arena1_99.csv", "line 6", out=lambda text: len(text.splitlines()) == 6)
    bench.refuse("log: cut in the middle of a row, in metrics", ["metrics", cut], "arena1_99.csv", "line 6", out=lambda text: "arena1_99" in text)
    bench.refuse("log: a missing file", ["law", "nowhere.csv"], "nowhere.csv", "check|path")
    bench.refuse("log: a text file", ["law", bench.file("letter.csv", "Dear Sir,\nI write to you\n")], "letter.csv", "x_val|laboratory|header")
    bench.refuse("log: an empty file", ["metrics", bench.file("empty.csv")], "empty.csv")
    bench.refuse("log: a word for a number", ["law", bench.file("word.csv", header + "\n".join([*rows[:2], "left,17,0,0,0.1,0,1493598415", *rows[:2]]) + "\n")], "word.csv", "line 3")
    bench.refuse("recording: a text file", ["replay", bench.file("notes.mcap", "not a recording\n")], "notes.mcap", "recording|MCAP")
    bench.refuse("recording: an empty file", ["export", bench.file("nothing.mcap"), "--output", "nothing"], "nothing.mcap")
    bench.refuse("recording: a missing file", ["replay", "nowhere.mcap"], "nowhere.mcap", "check|path")


def configurations(bench):
    bench.refuse("configuration: an unknown key", ["run", bench.file("key.toml", "[vehicle]\nregoin_half_width = 0.6\n")], "regoin_half_width", "key.toml", "region_half_width|expected")
    bench.refuse("configuration: an unknown table", ["run", bench.file("table.toml", "[vehicel]\nprofile = \"fotokite-pro\"\n")], "vehicel", "table.toml")
    bench.refuse("configuration: a value out of its range", ["run", bench.file("range.toml", "[vehicle]\nregion_half_width = 7\n")], "region_half_width", "range.toml", "0.01|1")
    bench.refuse("configuration: a word for a number", ["run", bench.file("type.toml", "[vehicle]\nregion_half_width = \"wide\"\n")], "region_half_width|wide", "type.toml")
    bench.refuse("configuration: not a number", ["run", bench.file("nan.toml", "[vehicle]\nschema_pan_rad_per_s = nan\n")], "schema_pan_rad_per_s", "nan.toml")
    bench.refuse("configuration: an unknown word", ["run", bench.file("word.toml", "[vehicle]\nyaw_sign = \"left\"\n")], "yaw_sign|left", "opposite", "word.toml")
    bench.refuse("configuration: an unknown tracker", ["run", bench.file("tracker.toml", "[tracker]\nname = \"csrt\"\n")], "csrt", "fused", "camshift", "tracker.toml")
    bench.refuse("configuration: an unknown key of the tracker", ["run", bench.file("fused.toml", "[tracker.fused]\ncoast = 0.4\n")], "`coast`", "coast_s", "fused.toml")
    bench.refuse("configuration: a tracker's value out of its range", ["run", bench.file("coast.toml", "[tracker.fused]\ncoast_s = 9\n")], r"tracker\.fused\.coast_s = 9", "0 to 2", "coast.toml")
    bench.refuse("configuration: a tracker's value that is no number", ["run", bench.file("padding.toml", "[tracker.fused]\npadding = nan\n")], r"tracker\.fused\.padding = NaN", "2.5 to 6", "padding.toml")
    bench.refuse("configuration: a tracker's count that is no count", ["run", bench.file("confirm.toml", "[tracker.fused]\nconfirm = 1.5\n")], "1.5", "whole number", "confirm.toml")
    bench.refuse("an unknown tracker, in track", ["track", bench.clip, "--select", bench.selection, "--tracker", "csrt"], "csrt", "fused", "camshift", code=2)
    bench.refuse("an unknown tracker, in run", ["run", "--video", f"file:{bench.clip}", "--tracker", "csrt"], "csrt", "fused", "camshift", code=2)
    bench.refuse("an unknown tracker, in demo", ["demo", "--tracker", "csrt"], "csrt", "fused", "camshift", code=2)
    bench.refuse("configuration: not TOML", ["run", bench.file("broken.toml", "[vehicle\n")], "broken.toml", "line 1|1:")
    bench.refuse("configuration: a missing file", ["run", "nowhere.toml"], "nowhere.toml", "check|path|config example")
    bench.refuse("an unknown profile", ["run", "--video", f"file:{bench.clip}", "--profile", "fotokite-amateur"], "fotokite-amateur", "fotokite-pro")
    bench.refuse("an unknown profile, in law", ["law", "nowhere.csv", "--profile", "fotokite-amateur"], "fotokite-amateur", "fotokite-pro")


def wait_for_port(path):
    common.wait_until(path.exists, 10, str(path))


def ports(bench):
    run = ["run", "--video", f"file:{bench.clip}", "--link"]
    bench.refuse("port: does not exist", [*run, "serial:/dev/ttyNOWHERE"], "/dev/ttyNOWHERE", "plugged|ls ")
    bench.refuse("port: a folder", [*run, f"serial:{bench.folder}"], str(bench.folder), "/dev/tty|--pty|ls ")
    bench.refuse("port: a plain file", [*run, f"serial:{bench.file('plain')}"], "plain", "/dev/tty|--pty|ls ")
    bench.refuse("port: a device that is no serial port", [*run, "serial:/dev/null"], "/dev/null", "/dev/tty|--pty|ls ")
    bench.refuse("port: an unknown scheme", [*run, "bluetooth:fotokite"], "bluetooth", "serial:", "tcp:")
    bench.refuse("port: an impossible baud rate", [*run, "serial:/dev/ttyNOWHERE?baud=fast"], "fast|baud")
    bench.refuse("port: an unknown option", [*run, "serial:/dev/ttyNOWHERE?speed=9600"], "speed", "baud")
    bench.refuse("port: nobody listens there", [*run, "tcp://127.0.0.1:9"], "127.0.0.1:9", "pass-through|listen|run|reach")
    bench.refuse("port: a misspelt fault", [*run, "serial:/dev/ttyNOWHERE?fault=explode@3"], "explode", "stall")
    with Emulator(str(bench.program), bench.folder, "taken") as emulator:
        device = emulator.port.resolve()
        os.chmod(device, 0o600)
        if ROOT_USER:
            bench.refuse("port: may not be opened, as an ordinary user", [*run, emulator.url, "--no-record"], "taken", "dialout", user=NOBODY)
        else:
            bench.table.show("port: may not be opened", "not tried: it takes root to make one that an ordinary user may not open")
        os.chmod(device, 0o666)
        holder = common.spawn([bench.program, *run, emulator.url], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        emulator.wait_for(lambda row: row.direction == "in", 10, "the first line")
        who = "as root" if ROOT_USER else "as an ordinary user"
        bench.refuse(f"port: taken, {who}", [*run, emulator.url], "taken", "other|another|fuser|lsof")
        if ROOT_USER:
            bench.refuse("port: taken, as an ordinary user", [*run, emulator.url, "--no-record"], "taken", "other|another|fuser|lsof", user=NOBODY)
        before = len(emulator.heard())
        time.sleep(0.2)
        bench.table.require("  whoever has it keeps it", holder.poll() is None and len(emulator.heard()) >= before)
        holder.terminate()
        holder.wait(timeout=10)


def outputs(bench):
    # The name of a film, which every output may have.
    there = bench.file("there.mp4", "precious\n")
    orange = bench.folder / "orange"
    for name, words in (
        ("a recording", ["run", "--video", f"file:{bench.clip}", "--record", there]),
        ("an annotated video", ["run", "--video", f"file:{bench.clip}", "--overlay", there]),
        ("a track", ["track", orange, "--select", "10,10,40,40", "--output", there]),
        ("the law's rows", ["law", bench.file("whole.csv", "x_val,y_val,pitch,yaw,val,time-78,17,0,0,0.185109,0.000000,1493598415\n"), "--output", there]),
        ("an emulator's log", ["emulate", "fotokite-pro", "--pty", bench.folder / "pty", "--log", there]),
        ("an emulator's port", ["emulate", "fotokite-pro", "--pty", there]),
    ):
        # For the port --force would be the wrong advice: what is there is not ours.
        remedy = "--force" if "port" not in name else "there"
        bench.refuse(f"output: {name} that exists", words, "there", remedy)
        bench.table.require("  it is left as it was", there.read_text() == "precious\n")
    bench.refuse("output: in a folder that is not there", ["track", orange, "--select", "10,10,40,40", "--output", "nowhere/track.csv"], "nowhere/track.csv", "folder|check|make")
    if ROOT_USER:
        locked = bench.folder / "locked"
        locked.mkdir(mode=0o755)
        bench.refuse("output: where an ordinary user may not write", ["track", orange, "--select", "10,10,40,40", "--output", locked / "track.csv"], "locked/track.csv", "denied|may not|rights", user=NOBODY)
        os.chmod(there, 0o600)
        bench.refuse("video: may not be read, as an ordinary user", ["track", there, "--select", "10,10,40,40"], "there", "denied|may not|rights", user=NOBODY)


def main():
    args = common.arguments(__doc__, clip=common.CLIP)
    folder = common.temporary_folder()
    clip, truth = common.practice_clip(args, folder)
    if ROOT_USER and clip.parent != folder / "practice":
        clip = pathlib.Path(shutil.copy(clip, folder / "practice.mp4"))
    table = Table("What a first user gets wrong")
    bench = Bench(args, folder, table, clip, truth)
    for group in (video, selections, logs, configurations, ports, outputs):
        group(bench)
    return table.finish(args, messages=bench.said)


if __name__ == "__main__":
    sys.exit(main())
