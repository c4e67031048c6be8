"""Composes labelled clips: targets cut out of some recordings move through the pictures of others.

    python3 research/training/compose_clips.py CLIPS [CLIPS ...] --output COMPOSED [--count 180] [--seed 1] [--wakes 0]
        [--sizes 12 90] [--photographs DIR --objects DIR]

CLIPS are folders of labelled clips: a folder each with video.mp4 and gt.csv. COMPOSED gets a folder of the same form for
each composed clip, for `barrelman-eval training-samples`. Its name is `composed_TARGET+PICTURES+SEED_NUMBER`, with the
recordings that target and pictures come from: a network that is to be measured on either of them must not be fitted to it.

A target is cut out along its outline (GrabCut, started from an ellipse in the label's box); cuts that do not fill their
box are left out. It moves on a random path, at a random size that may change, mirrored or transposed, in other light,
over pictures that play forwards and backwards. Up to two other targets, most of them of the same recording, cross its
way, before or behind it. With --wakes SHARE, this share of the targets leaves foam behind, which is no part of the label.
Pictures are blurred, given noise, and compressed at random.

With --photographs and --objects, folders of photographs and of pictures with an alpha channel, two thirds of the targets
and half of the pictures are made of those (stills.py), and in each clip at least one of the two.

Needs numpy, OpenCV and imageio-ffmpeg; none of them is a part of the project's setup.
"""
import argparse
import csv
import pathlib
import subprocess

import cv2
import imageio_ffmpeg
import numpy as np

from recordings import COMPOSED, STILL, recording_of
from stills import Stills, smooth_steps

FRAMES, WIDTH, RATE = 80, 640, 30
# Frames of a recording that are used: every second one of a clip with many labels.
MAX_FRAMES, MANY_LABELS = 300, 150
MIN_LABEL_PX, MIN_CUTS = 6, 5
# A cut covers at least this share of its box, and of each of its sides.
MIN_COVERED, MIN_SPANNED = 0.2, 0.7
# Speeds of targets, sizes (root of the box's area) a frame.
SPEEDS = (0.01, 0.12)
# Those of targets that leave foam behind.
WAKE_SIZES, WAKE_SPEEDS = (18, 130), (0.03, 0.12)


def labels_of(folder):
    labels = {}
    with open(folder / "gt.csv", encoding="utf-8") as rows:
        for row in csv.DictReader(rows):
            if all(row[name] for name in "xywh"):
                box = [float(row[name]) for name in "xywh"]
                if min(box[2:]) >= MIN_LABEL_PX:
                    labels[int(row["frame"])] = box
    return labels


def cut_out(picture, box):
    """The picture around a box and the target's share of each pixel; None where no outline is found."""
    x, y, w, h = box
    height, width = picture.shape[:2]
    left, top = max(0, round(x - w / 4)), max(0, round(y - h / 4))
    right, bottom = min(width, round(x + 1.25 * w)), min(height, round(y + 1.25 * h))
    if right - left < 8 or bottom - top < 8:
        return None
    crop = picture[top:bottom, left:right]
    small = min(1.0, 150 / max(crop.shape[:2]))
    if small < 1:
        crop = cv2.resize(crop, None, fx=small, fy=small, interpolation=cv2.INTER_AREA)
    large = max(1.0, 60 / max(crop.shape[:2]))
    enlarged = cv2.resize(crop, None, fx=large, fy=large, interpolation=cv2.INTER_CUBIC)
    x, y, w, h = [value * small * large for value in (x - left, y - top, w, h)]
    mask = np.full(enlarged.shape[:2], cv2.GC_BGD, np.uint8)
    mask[max(0, round(y)):round(y + h), max(0, round(x)):round(x + w)] = cv2.GC_PR_BGD
    for share, kind in ((0.42, cv2.GC_PR_FGD), (0.12, cv2.GC_FGD)):
        axes = max(1, int(w * share)), max(1, int(h * share))
        cv2.ellipse(mask, (int(x + w / 2), int(y + h / 2)), axes, 0, 0, 360, int(kind), -1)
    try:
        cv2.grabCut(enlarged, mask, None, np.zeros((1, 65)), np.zeros((1, 65)), 4, cv2.GC_INIT_WITH_MASK)
    except cv2.error:
        return None
    target = ((mask == cv2.GC_FGD) | (mask == cv2.GC_PR_FGD)).astype(np.uint8)
    count, areas, figures, _ = cv2.connectedComponentsWithStats(target)
    large_areas = [k for k in range(1, count) if figures[k, 4] > 0.15 * figures[1:, 4].max()]
    target = np.isin(areas, large_areas).astype(np.uint8)
    rows, columns = np.nonzero(target)
    is_whole = (target.sum() > MIN_COVERED * w * h and np.ptp(columns) > MIN_SPANNED * w
                and np.ptp(rows) > MIN_SPANNED * h)
    if not is_whole:
        return None
    soft = cv2.GaussianBlur(target.astype(np.float32), (0, 0), 0.5 + 0.48 * large)
    return crop.copy(), cv2.resize(soft, crop.shape[1::-1], interpolation=cv2.INTER_AREA), np.sqrt(w * h) / large


class Clip:
    """Pictures of a clip, WIDTH pixels wide, and the cuts of its target."""

    def __init__(self, folder):
        self.pictures, self.cuts = [], []
        labels = labels_of(folder)
        video = cv2.VideoCapture(str(folder / "video.mp4"))
        for frame in range(MAX_FRAMES):
            is_read, picture = video.read()
            if not is_read:
                break
            if frame % 2 and len(labels) >= MANY_LABELS:
                continue
            height = 2 * round(picture.shape[0] * WIDTH / picture.shape[1] / 2)
            small = cv2.resize(picture, (WIDTH, height), interpolation=cv2.INTER_AREA)
            self.pictures.append(cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, 95])[1])
            cut = cut_out(picture, labels[frame]) if frame in labels else None
            if cut:
                self.cuts.append(cut)
        if not self.pictures:
            raise SystemExit(f"{folder / 'video.mp4'}: OpenCV reads no picture of it")


class Wake:
    """Foam that a target leaves along its path: patches that grow and fade."""

    def __init__(self, random, path, size, sides):
        self.life = random.randint(10, 45)
        breadth, per_frame = random.uniform(0.15, 0.45) * size, random.randint(2, 5)
        pace = (path[4] - path[0]) / 4
        # The way before the first picture.
        places = np.concatenate([path[0] - pace * np.arange(self.life, 0, -1)[:, None], path])
        self.patches = [(index - self.life, place + random.randn(2) * breadth * 0.7, breadth * random.uniform(0.3, 0.8))
                        for index, place in enumerate(places) for _ in range(per_frame)]
        self.strength, self.colour = random.uniform(0.5, 0.95), random.uniform(195, 245) + random.uniform(-12, 12, 3)
        grain = max(1, round(random.uniform(0.08, 0.25) * size))
        noise = random.rand(sides[1] // grain + 1, sides[0] // grain + 1).astype(np.float32)
        self.texture = np.clip(1.5 * cv2.resize(noise, sides, interpolation=cv2.INTER_CUBIC), 0, 1)
        self.blur = 0.15 * breadth + 0.4

    def draw(self, picture, frame):
        shares = np.zeros(picture.shape[:2], np.float32)
        for since, place, radius in self.patches:
            age = (frame - since) / self.life
            if 0 <= age < 1:
                centre = round(place[0]), round(place[1])
                cv2.circle(shares, centre, max(1, round(radius * (1 + age))), self.strength * (1 - age), -1)
        shares = cv2.GaussianBlur(shares, (0, 0), self.blur) * self.texture
        picture += shares[..., None] * (self.colour.astype(np.float32) - picture)


class Composer:
    def __init__(self, recordings, seed, sizes, wakes=0.0, photographs=None, objects=None):
        self.recordings, self.random, self.sizes = recordings, np.random.RandomState(seed), sizes
        self.stills = Stills(photographs, objects, self.random) if photographs else None
        # Wakes have random numbers of their own: without them the clips of a seed stay the same.
        self.wakes, self.wakes_random = wakes, np.random.RandomState(seed + 1_000_000)
        self.targets = [name for name, clips in recordings.items() if any(len(clip.cuts) >= MIN_CUTS for clip in clips)]

    def choose(self, values):
        return values[self.random.randint(len(values))]

    def choose_recordings(self):
        """The recordings of a clip's target and of its pictures; STILL is none."""
        if self.stills is None:
            name = self.choose(self.targets)
            return name, self.choose([recording for recording in self.recordings if recording != name])
        kinds = self.choose([(True, True), (True, False), (False, True)])
        name, behind = [STILL if is_still else None for is_still in kinds]
        name = name or self.choose(self.targets)
        return name, behind or self.choose([recording for recording in self.recordings if recording != name])

    def steps(self, speed):
        return smooth_steps(self.random, FRAMES, speed)

    def order(self, count, pace):
        """Numbers of pictures that are played forwards and backwards; a picture may be shown again."""
        place, step, order = self.random.randint(count), 1, []
        for _ in range(FRAMES):
            order.append(place)
            if self.random.rand() < pace:
                if not 0 <= place + step < count:
                    step = -step
                place = min(max(place + step, 0), count - 1)
        return order

    def cuts_of(self, name, around):
        """The cuts of a target of this recording, or of an object, that moves through pictures of this mean colour."""
        if name != STILL:
            return self.choose([clip for clip in self.recordings[name] if len(clip.cuts) >= MIN_CUTS]).cuts
        while len(cuts := self.stills.target(around).cuts) < MIN_CUTS:
            pass
        return cuts

    def sprites(self, cuts, size):
        """For each frame the picture of the target, its share of each pixel, and its box (left, top, width, height)."""
        order = self.order(len(cuts), self.random.uniform(0.3, 1))
        is_mirrored, is_transposed = self.random.rand() < 0.5, self.random.rand() < 0.15
        tint = self.random.uniform(-20, 20, 3) if self.random.rand() < 0.4 else 0
        gain = self.random.uniform(0.8, 1.2)
        growth = np.exp(np.cumsum(self.steps(self.choose([0, 0.004, 0.012]))))
        sprites = []
        for number, factor in zip(order, size / cuts[order[0]][2] * growth):
            picture, shares, own_size = cuts[number]
            factor = np.clip(factor, 6 / own_size, 260 / own_size)
            sides = [max(2, round(side * factor)) for side in shares.shape[::-1]]
            how = cv2.INTER_AREA if factor < 1 else cv2.INTER_LINEAR
            picture = np.clip(cv2.resize(picture, sides, interpolation=how).astype(np.float32) * gain + tint, 0, 255)
            shares = cv2.resize(shares, sides, interpolation=how)
            if is_mirrored:
                picture, shares = picture[:, ::-1], shares[:, ::-1]
            if is_transposed:
                picture, shares = picture.transpose(1, 0, 2), shares.T
            rows, columns = np.nonzero(shares > 0.4 * shares.max())
            sprites.append((picture, shares, (columns.min(), rows.min(), np.ptp(columns) + 1, np.ptp(rows) + 1)))
        return sprites

    def path(self, sides, size, speed):
        """A path that turns back at the borders of the picture."""
        margin, path = size * self.choose([0.2, 0.6]), []
        for side, share in zip(sides, (1, 0.7)):
            free = max(1.0, side - 2 * margin)
            places = side * self.random.uniform(0.2, 0.8) + np.cumsum(self.steps(share * speed))
            folded = (places - margin) % (2 * free)
            path.append(margin + np.where(folded > free, 2 * free - folded, folded))
        return np.array(path).T

    def crossing(self, path, size, speed):
        """A path that passes near another one at some time."""
        frame = self.random.randint(FRAMES)
        places = np.cumsum(np.array([self.steps(speed), self.steps(speed)]).T, 0)
        return places - places[frame] + path[frame] + self.random.uniform(-1.5, 1.5, 2) * size

    def compose(self, folder, name, behind):
        clip = self.stills.background(WIDTH, FRAMES) if behind == STILL else self.choose(self.recordings[behind])
        pictures, around = clip.pictures, cv2.imdecode(clip.pictures[0], 1).mean((0, 1))
        order, is_mirrored = self.order(len(pictures), self.random.uniform(0.5, 1)), self.random.rand() < 0.5
        sides = cv2.imdecode(pictures[0], 1).shape[1::-1]
        has_wake = self.wakes_random.rand() < self.wakes
        size = np.exp(self.random.uniform(*np.log(WAKE_SIZES if has_wake else self.sizes)))
        speed = np.exp(self.random.uniform(*np.log(WAKE_SPEEDS if has_wake else SPEEDS))) * size
        cuts = self.cuts_of(name, around)
        target = (self.sprites(cuts, size), self.path(sides, size, speed))
        others = []
        for _ in range(self.random.choice(3, p=[0.4, 0.4, 0.2])):
            of = self.choose([name] + [recording for recording in (name, behind) if recording in self.targets])
            other_size = size * self.random.uniform(0.7, 1.4)
            # An object is the same one again, or another one.
            own = cuts if of == name == STILL and self.random.rand() < 0.6 else self.cuts_of(of, around)
            sprites = self.sprites(own, other_size)
            others.append((sprites, self.crossing(target[1], size, speed)))
        place = 0 if self.random.rand() < 0.3 else len(others)
        layers = [*others[:place], target, *others[place:]]
        wake = Wake(self.wakes_random, target[1], size, sides) if has_wake else None
        blur, noise = self.choose([0, 0, 0.7, 1.2]), self.choose([0, 0, 3, 7])
        folder.mkdir(parents=True)
        encoder = subprocess.Popen(
            [imageio_ffmpeg.get_ffmpeg_exe(), "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "bgr24", "-s", "{}x{}".format(*sides),
             "-r", str(RATE), "-i", "-", "-c:v", "libx264", "-preset", "veryfast", "-pix_fmt", "yuv420p", "-bf", "0",
             "-crf", str(self.random.randint(18, 35)), str(folder / "video.mp4")], stdin=subprocess.PIPE)
        labels = ["frame,x,y,w,h"]
        for frame, number in enumerate(order):
            picture = cv2.imdecode(pictures[number], 1).astype(np.float32)
            picture = picture[:, ::-1].copy() if is_mirrored else picture
            if wake:
                wake.draw(picture, frame)
            boxes = [paste(picture, sprites[frame], path[frame]) for sprites, path in layers]
            labels.append(",".join(str(value) for value in (frame, *boxes[place])))
            picture = cv2.GaussianBlur(picture, (0, 0), blur) if blur else picture
            picture = picture + self.random.randn(*picture.shape) * noise if noise else picture
            encoder.stdin.write(np.clip(picture, 0, 255).astype(np.uint8).tobytes())
        encoder.stdin.close()
        if encoder.wait():
            raise SystemExit(f"{folder / 'video.mp4'}: the encoder failed")
        (folder / "gt.csv").write_text("\n".join(labels) + "\n", encoding="utf-8")


def paste(picture, sprite, centre):
    """Draws a target with the middle of its box at this place; its box in the picture."""
    drawn, shares, (left, top, width, height) = sprite
    x, y = round(centre[0] - left - width / 2), round(centre[1] - top - height / 2)
    rows = slice(max(0, y), max(0, min(picture.shape[0], y + shares.shape[0])))
    columns = slice(max(0, x), max(0, min(picture.shape[1], x + shares.shape[1])))
    within = slice(rows.start - y, rows.stop - y), slice(columns.start - x, columns.stop - x)
    if rows.start < rows.stop and columns.start < columns.stop:
        share = shares[within][..., None]
        picture[rows, columns] = (1 - share) * picture[rows, columns] + share * drawn[within]
    return x + left, y + top, width, height


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("clips", nargs="+", type=pathlib.Path)
    parser.add_argument("--output", required=True, type=pathlib.Path)
    parser.add_argument("--count", type=int, default=180)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--wakes", type=float, default=0.0, help="share of the targets that leave foam behind")
    parser.add_argument("--sizes", type=float, nargs=2, default=(12, 90), metavar="PX",
                        help="range of the targets' sizes, roots of the box's area, at least 6")
    parser.add_argument("--photographs", type=pathlib.Path, help="folder of photographs, searched with its subfolders")
    parser.add_argument("--objects", type=pathlib.Path, help="folder of pictures of objects with an alpha channel")
    options = parser.parse_args()
    if not 6 <= options.sizes[0] < options.sizes[1]:
        parser.error("--sizes takes two numbers, from 6 on, the smaller one first")
    if (options.photographs is None) != (options.objects is None):
        parser.error("--photographs and --objects go together")
    recordings = {}
    for folder in sorted(path.parent for clips in options.clips for path in clips.glob("*/gt.csv")):
        recordings.setdefault(recording_of(folder.name), []).append(Clip(folder))
    composer = Composer(recordings, options.seed, options.sizes, options.wakes, options.photographs, options.objects)
    print(f"{len(recordings)} recordings, targets of {len(composer.targets)}", flush=True)
    for number in range(options.count):
        name, behind = composer.choose_recordings()
        composer.compose(options.output / f"{COMPOSED}{name}+{behind}+{options.seed}_{number}", name, behind)


if __name__ == "__main__":
    main()
