"""A run of the program with its console, for scripts that play the vehicle."""
import contextlib
import json
import signal
import subprocess
import urllib.request

import common
import live
from common import Lines

CONTROL_TOKEN = "control-token-of-the-test"
WORLD = "sim:arena1?seed=3&size=640x360"


class ConsoleRun:
    """A run with these options, engaged from the start, whose video is a simulated world's that nothing moves."""

    def __init__(self, args, folder, name, *options, video=WORLD):
        tokens = folder / f"{name}.console"
        tokens.write_text(f"{CONTROL_TOKEN}\nwatch-token-of-the-test\n")
        tokens.chmod(0o600)
        port = live.free_port()
        self.base = f"http://127.0.0.1:{port}/api/v1"
        command = [args.barrelman, "run", "--engage", "--no-record", "--listen", f"127.0.0.1:{port}", "--console-token-file", tokens, "--mode", common.HARDLY_RESTS, *options]
        command += ["--video", video] if video else []
        self.child = common.spawn(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.err = Lines(self.child.stderr)

    def ask(self, path, body=None):
        request = urllib.request.Request(f"{self.base}/{path}", headers={"Authorization": f"Bearer {CONTROL_TOKEN}", "Content-Type": "application/json"})
        request.data = None if body is None else json.dumps(body).encode()
        with urllib.request.urlopen(request, timeout=5) as answer:
            return json.load(answer)

    def request(self, kind):
        return self.ask("requests", {"request": {"kind": kind}})

    def link(self):
        with contextlib.suppress(OSError):
            return self.ask("status")["link"]
        return {}

    def end(self):
        if self.child.poll() is None:
            self.child.send_signal(signal.SIGCONT)
            self.child.terminate()
            try:
                self.child.wait(timeout=8)
            except subprocess.TimeoutExpired:
                self.child.kill()
                self.child.wait()
        self.err.join()
        return self.child.returncode

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end()
