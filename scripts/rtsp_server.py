#!/usr/bin/python3
"""An RTSP server for tests, or a sender of packets: a test pattern or a file, as H.264 or H.265.

    /usr/bin/python3 scripts/rtsp_server.py --port 8554 --pattern timecode --size 1280x720 --fps 30
    /usr/bin/python3 scripts/rtsp_server.py --file clip.mp4
    /usr/bin/python3 scripts/rtsp_server.py --send rtp --port 5600 --codec h265

Serves rtsp://127.0.0.1:PORT/video and prints that address when the server listens (--port 0: a free port).
With --send, packets go to udp://127.0.0.1:PORT instead: RTP, or MPEG-TS.
Needs gir1.2-gst-rtsp-server-1.0, python3-gi and GStreamer's good, bad and ugly plugins; --check only checks
that they are installed. The server ends when its standard input ends, so that it does not outlive the test
that started it.
"""
import argparse
import pathlib
import sys
import threading
import time

import gi

gi.require_version("Gst", "1.0")
gi.require_version("GstRtsp", "1.0")
gi.require_version("GstRtspServer", "1.0")
from gi.repository import GLib, Gst, GstRtsp, GstRtspServer  # noqa: E402

ENCODERS = {
    "h264": "x264enc tune=zerolatency speed-preset=ultrafast key-int-max={fps} bitrate=2000 "
            "! video/x-h264,profile=baseline",
    "h265": "x265enc tune=zerolatency speed-preset=ultrafast key-int-max={fps} bitrate=2000",
}
PACKETS = {
    "h264": "h264parse config-interval=-1 ! rtph264pay name=pay0 pt=96 config-interval=1",
    "h265": "h265parse config-interval=-1 ! rtph265pay name=pay0 pt=96 config-interval=1",
}


def pictures(args):
    """The first elements of the pipeline, up to the encoded video."""
    width, height = args.size.split("x")
    if args.file:
        path = str(pathlib.Path(args.file).absolute()).replace('"', '\\"')
        return f'filesrc location="{path}" ! qtdemux'
    encoder = ENCODERS[args.codec].format(fps=args.fps)
    caps = f"video/x-raw,format=I420,width={width},height={height},framerate={args.fps}/1"
    if args.pattern == "timecode":
        return f"appsrc name=source is-live=true format=time do-timestamp=true caps={caps} ! {encoder}"
    return f"videotestsrc is-live=true pattern={args.pattern} ! {caps} ! {encoder}"


def sender(args):
    """Sends packets to a port until standard input ends."""
    transport_stream = f"{args.codec}parse config-interval=-1 ! mpegtsmux alignment=7"
    packets = {"rtp": PACKETS[args.codec], "ts": transport_stream}
    sink = f"udpsink host=127.0.0.1 port={args.port} sync=false"
    playing = Gst.parse_launch(f"{pictures(args)} ! {packets[args.send]} ! {sink}")
    if args.pattern == "timecode" and not args.file:
        feed_timecode(playing, args)
    playing.set_state(Gst.State.PLAYING)
    print(f"udp://127.0.0.1:{args.port}", flush=True)
    return playing


def timecode(width, height):
    """A grey I420 picture. Its top rows show CLOCK_MONOTONIC in milliseconds.

    The 32 bits are black or white blocks, the highest bit on the left.
    """
    millis = int(time.monotonic() * 1000) & 0xFFFFFFFF
    block = width // 32
    row = b"".join((b"\xeb" if millis >> (31 - bit) & 1 else b"\x10") * block for bit in range(32))
    rows = max(height // 16, 8)
    row += b"\x80" * (width - len(row))
    return row * rows + b"\x80" * (width * (height - rows) + 2 * ((width + 1) // 2) * ((height + 1) // 2))


def feed_timecode(element, args):
    source = element.get_by_name("source")
    width, height = map(int, args.size.split("x"))

    def push():
        picture = Gst.Buffer.new_wrapped(timecode(width, height))
        return source.emit("push-buffer", picture) == Gst.FlowReturn.OK

    GLib.timeout_add(1000 // args.fps, push)


def main():
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("--port", default="8554")
    parser.add_argument("--file", help="MP4 file with video of the codec, served as it is")
    patterns = "timecode (blocks that show the time of the picture), or a pattern of videotestsrc"
    parser.add_argument("--pattern", default="timecode", help=patterns)
    parser.add_argument("--size", default="640x360")
    parser.add_argument("--fps", default=30, type=int)
    parser.add_argument("--codec", default="h264", choices=sorted(ENCODERS))
    parser.add_argument("--transport", choices=("tcp", "udp"), help="the one way of packets; default: both")
    parser.add_argument("--send", choices=("rtp", "ts"), help="send packets to the port")
    parser.add_argument("--check", action="store_true", help="only tell whether everything is there")
    args = parser.parse_args()
    Gst.init(None)
    needed = ("appsrc", "x264enc", "x265enc", "rtph264pay", "h264parse", "mpegtsmux", "udpsink")
    missing = [name for name in needed if not Gst.ElementFactory.find(name)]
    if missing:
        sys.exit(f"GStreamer lacks {', '.join(missing)}")
    if args.check:
        return
    loop = GLib.MainLoop()
    threading.Thread(target=lambda: (sys.stdin.read(), loop.quit()), daemon=True).start()
    # Kept until the loop ends.
    kept = sender(args) if args.send else serve(args)
    loop.run()
    del kept


def serve(args):
    server = GstRtspServer.RTSPServer()
    server.set_address("127.0.0.1")
    server.set_service(args.port)
    factory = GstRtspServer.RTSPMediaFactory()
    factory.set_launch(f"( {pictures(args)} ! {PACKETS[args.codec]} )")
    lower = {"tcp": GstRtsp.RTSPLowerTrans.TCP, "udp": GstRtsp.RTSPLowerTrans.UDP}
    if args.transport:
        factory.set_protocols(lower[args.transport])
    factory.set_shared(True)
    if args.pattern == "timecode" and not args.file:
        factory.connect("media-configure", lambda _, media: feed_timecode(media.get_element(), args))
    server.get_mount_points().add_factory("/video", factory)
    if not server.attach(None):
        sys.exit(f"cannot listen on port {args.port}")
    print(f"rtsp://127.0.0.1:{server.get_bound_port()}/video", flush=True)
    return server


if __name__ == "__main__":
    main()
