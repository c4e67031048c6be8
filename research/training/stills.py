"""Targets and pictures that are made from photographs and cut-out objects, for compose_clips.py.

Recordings are few. Photographs and objects are many: each gives a thing, or a place, that no recording shows. An object,
or a piece of a photograph with a smooth outline, turns, is foreshortened, bends and changes its light. A virtual camera
moves over a photograph, in which other objects lie and which may ripple like water.
"""
import pathlib

import cv2
import numpy as np

# Sides of the squares that targets are drawn in, and of objects in them, pixels.
CANVAS, OBJECT = 224, 130
CUTS = 40
# Heights of pictures.
HEIGHTS = (352, 360, 360, 480)
# Pixels of the photograph for a pixel of the picture.
SCALES = (0.4, 2.0)
SUFFIXES = (".jpg", ".jpeg", ".png", ".webp")
# Photographs have at least this short side, pixels, and this mean difference of neighbours in a picture of
# 160 x 100.
MIN_PHOTOGRAPH, MIN_DETAIL = 250, 2.0
# Objects have at least this short side, cover at least this share of their box, and are at most so elongated.
MIN_OBJECT, MIN_SOLID, MAX_ASPECT = 30, 0.25, 6


class StillClip:
    """A clip as compose_clips.py takes it: pictures of a photograph, or cuts of a target."""

    def __init__(self, pictures=(), cuts=()):
        self.pictures, self.cuts = list(pictures), list(cuts)


def smooth_steps(random, count, speed, frames=12):
    """Steps of a smooth random walk with this root mean square, correlated over some frames."""
    keep, step, steps = np.exp(-1 / frames), random.randn() * speed, []
    for _ in range(count):
        step = keep * step + np.sqrt(1 - keep * keep) * speed * random.randn()
        steps.append(step)
    return np.array(steps)


def walk(random, count, speed):
    """A smooth random walk from 0."""
    steps = smooth_steps(random, count, speed)
    return np.cumsum(steps) - steps[0]


def scaled(picture, factor):
    how = cv2.INTER_AREA if factor < 1 else cv2.INTER_LINEAR
    return cv2.resize(picture, None, fx=factor, fy=factor, interpolation=how)


def cosine_and_sine(angle, factor=1.0):
    """Both times a factor, as the maps of `cv2.remap` take them."""
    return np.float32(factor * np.cos(angle)), np.float32(factor * np.sin(angle))


def rotation(angle):
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def smooth_noise(random, cells, side):
    """Noise that is smooth over a cell, -1 to 1 at most, as a square with this side."""
    grid = random.uniform(-1, 1, (cells + 3, cells + 3)).astype(np.float32)
    large = cv2.resize(grid, None, fx=side / cells, fy=side / cells, interpolation=cv2.INTER_CUBIC)
    return large[side // cells:side // cells + side, side // cells:side // cells + side]


def photograph_of(picture):
    small = cv2.resize(picture, (160, 100), interpolation=cv2.INTER_AREA).astype(np.float32)
    is_used = min(picture.shape[:2]) >= MIN_PHOTOGRAPH and np.abs(np.diff(small, axis=1)).mean() >= MIN_DETAIL
    return picture if is_used else None


def object_of(picture):
    """The part of the picture that is not transparent."""
    opaque = picture[..., 3] > 128
    rows, columns = np.nonzero(opaque)
    if not len(rows):
        return None
    box = slice(rows.min(), rows.max() + 1), slice(columns.min(), columns.max() + 1)
    short, long = sorted(opaque[box].shape)
    is_used = short >= MIN_OBJECT and long <= MAX_ASPECT * short and opaque[box].mean() >= MIN_SOLID
    return picture[box] if is_used else None


class Stills:
    def __init__(self, photographs, objects, random):
        self.random = random
        self.photographs, self.objects = [self.files(folder) for folder in (photographs, objects)]

    @staticmethod
    def files(folder):
        files = sorted(path for path in pathlib.Path(folder).rglob("*") if path.suffix.lower() in SUFFIXES)
        if not files:
            raise SystemExit(f"{folder}: no pictures ({', '.join(SUFFIXES)})")
        return files

    def read(self, files, channels, usable):
        """One of the files, with this many channels, as `usable` gives it; files that it gives None for are skipped."""
        for _ in range(1000):
            picture = cv2.imread(str(self.choose(files)), cv2.IMREAD_UNCHANGED)
            if picture is not None and picture.ndim == 3 and picture.shape[2] >= channels:
                if (used := usable(picture[..., :channels])) is not None:
                    return used
        raise SystemExit(f"{files[0].parent}: none of 1000 pictures can be used ({channels} channels, size, detail)")

    def choose(self, values):
        return values[self.random.randint(len(values))]

    def photograph(self):
        picture = self.read(self.photographs, 3, photograph_of)
        gamma, gain = np.exp(self.random.uniform(-0.4, 0.4)), self.random.uniform(0.6, 1.1)
        table = np.clip(255 * gain * (np.arange(256) / 255) ** gamma, 0, 255).astype(np.uint8)
        return self.faded(cv2.LUT(picture, table).astype(np.float32), 0.7)

    def faded(self, picture, most):
        """With less colour, up to this share."""
        grey = picture.mean(2, keepdims=True)
        return picture + self.random.uniform(0, most) * (grey - picture)

    def shape(self):
        """A picture with 4 channels: an object, or a piece of a photograph."""
        if self.random.rand() < 0.65:
            shape = self.read(self.objects, 4, object_of).astype(np.float32)
            return np.dstack([self.faded(shape[..., :3], 0.7), shape[..., 3] / 255])
        picture = self.photograph()
        factor = max(OBJECT / min(picture.shape[:2]), self.random.uniform(0.2, 1.0))
        picture = scaled(picture, factor)
        y, x = [self.random.randint(side - OBJECT + 1) for side in picture.shape[:2]]
        angles = np.linspace(0, 2 * np.pi, 90, endpoint=False)
        radius = np.ones_like(angles)
        for order in range(2, 7):
            radius += self.random.uniform(0, 0.5) / order * np.cos(order * angles + self.random.uniform(0, 2 * np.pi))
        aspect = np.exp(self.random.uniform(0, 1.1))
        outline = np.stack([np.cos(angles) * radius, np.sin(angles) * radius / aspect], 1)
        outline *= OBJECT / 2 * 0.95 / np.abs(outline).max()
        mask = np.zeros((OBJECT, OBJECT), np.float32)
        cv2.fillPoly(mask, [np.round(outline + OBJECT / 2).astype(np.int32)], 1.0)
        return np.dstack([picture[y:y + OBJECT, x:x + OBJECT], mask])

    def target(self, around):
        """A clip with the cuts of a target; `around` is the mean colour of the pictures that it will move through."""
        shape = self.shape()
        factor = OBJECT / max(shape.shape[:2])
        shape = scaled(shape, factor)
        colours, shares = shape[..., :3], np.clip(shape[..., 3:], 0, 1)
        if self.random.rand() < 0.5:
            colours = colours + self.random.uniform(0, 0.7) * (around - colours)
        shape = np.dstack([colours * shares, shares])
        slant, bend = self.random.choice([0, 0.01, 0.03], 2), self.random.choice([0, 0, 0.04, 0.1]) * OBJECT
        turn, light = self.random.choice([0, 0.01, 0.03, 0.06]), self.random.choice([0, 0, 0.02])
        first_turn = self.random.uniform(0, 2 * np.pi) if self.random.rand() < 0.6 else 0
        turns = first_turn + walk(self.random, CUTS, turn)
        axes = np.exp(np.clip([walk(self.random, CUTS, value) for value in slant], -0.7, 0.7))
        lights = np.exp(np.clip(walk(self.random, CUTS, light), -0.4, 0.4))
        fields = [smooth_noise(self.random, 3, CANVAS) * np.float32(bend) for _ in range(4)]
        phases = walk(self.random, CUTS, self.random.uniform(0.05, 0.3))
        tilt = self.random.uniform(0, np.pi)
        place = np.mgrid[:CANVAS, :CANVAS].astype(np.float32)
        cuts = []
        for index in range(CUTS):
            linear = rotation(turns[index]) @ rotation(tilt) @ np.diag(np.minimum(axes[:, index], 1.3)) @ rotation(-tilt)
            middle = np.array(shape.shape[1::-1]) / 2
            affine = np.column_stack([linear, CANVAS / 2 - linear @ middle])
            drawn = cv2.warpAffine(shape, affine, (CANVAS, CANVAS), flags=cv2.INTER_LINEAR)
            if bend:
                cos, sin = cosine_and_sine(phases[index])
                drawn = cv2.remap(drawn, place[1] + cos * fields[0] + sin * fields[1],
                                  place[0] + cos * fields[2] + sin * fields[3], cv2.INTER_LINEAR)
            cut = self.cut(drawn, lights[index])
            if cut:
                cuts.append(cut)
        return StillClip(cuts=cuts)

    @staticmethod
    def cut(drawn, light):
        """As `cut_out` of compose_clips.py: the picture, the target's share of each pixel, and its size."""
        shares = drawn[..., 3]
        rows, columns = np.nonzero(shares > 0.4)
        if len(rows) < 40:
            return None
        rows = slice(max(0, rows.min() - 3), rows.max() + 4)
        columns = slice(max(0, columns.min() - 3), columns.max() + 4)
        drawn, shares = drawn[rows, columns], shares[rows, columns]
        mean = drawn[..., :3].sum((0, 1)) / shares.sum()
        known = shares[..., None] > 0.02
        colours = np.where(known, drawn[..., :3] / np.maximum(shares[..., None], 0.02), mean) * light
        size = np.sqrt(max(1, shares.shape[0] - 6) * max(1, shares.shape[1] - 6))
        return np.clip(colours, 0, 255).astype(np.uint8), shares.copy(), size

    def background(self, width, frames):
        """A clip with the pictures of a virtual camera that moves over a photograph."""
        photograph, height = self.photograph(), self.choose(HEIGHTS)
        for _ in range(self.random.choice([0, 0, 2, 5, 10])):
            self.lay(photograph, self.shape())
        scale = np.exp(self.random.uniform(*np.log(SCALES)))
        scale = min(scale, 1.5 * photograph.shape[1] / width)
        if scale > 1:
            photograph = cv2.GaussianBlur(photograph, (0, 0), 0.4 * scale)
        speed, spin, zoom = [self.random.choice(values) for values in ([0, 0.5, 2, 5], [0, 0, 0.003, 0.012], [0, 0, 0.003])]
        shake = self.random.choice([0, 0, 0.7, 2.0])
        x, y = [self.random.uniform(0.2, 0.8) * side + scale * walk(self.random, frames, speed) for side in photograph.shape[1::-1]]
        turns, zooms = walk(self.random, frames, spin), scale * np.exp(np.clip(walk(self.random, frames, zoom), -0.7, 0.7))
        ripple = self.random.choice([0, 0, 1.5, 4.0])
        fields = [cv2.resize(smooth_noise(self.random, self.random.randint(6, 40), 320), (width, height)) * np.float32(ripple) for _ in range(4)]
        phases = np.arange(frames) * self.random.uniform(0.1, 0.6)
        place = np.mgrid[:height, :width].astype(np.float32)
        pictures = []
        for index in range(frames):
            cos, sin = cosine_and_sine(turns[index], zooms[index])
            middle = (np.array([x[index], y[index]]) + self.random.randn(2) * shake * scale).astype(np.float32)
            across, down = place[1] - np.float32(width / 2), place[0] - np.float32(height / 2)
            if ripple:
                c, s = cosine_and_sine(phases[index])
                across, down = across + c * fields[0] + s * fields[1], down + c * fields[2] + s * fields[3]
            picture = cv2.remap(photograph, cos * across - sin * down + middle[0],
                                sin * across + cos * down + middle[1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT_101)
            pictures.append(cv2.imencode(".jpg", np.clip(picture, 0, 255).astype(np.uint8), [cv2.IMWRITE_JPEG_QUALITY, 95])[1])
        return StillClip(pictures=pictures)

    def lay(self, photograph, shape):
        """Draws a shape somewhere into a photograph."""
        factor = self.random.uniform(0.03, 0.15) * min(photograph.shape[:2]) / max(shape.shape[:2])
        shape = scaled(shape, factor)
        height, width = shape.shape[:2]
        y, x = [self.random.randint(max(1, side - own)) for side, own in zip(photograph.shape[:2], (height, width))]
        under, share = photograph[y:y + height, x:x + width], shape[..., 3:]
        under += share * (shape[..., :3] - under)
