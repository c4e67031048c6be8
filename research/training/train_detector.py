"""Trains a small detector of people and boats on the pictures of `barrelman-eval detector-scenes`.

    barrelman-eval detector-scenes --output SCENES
    python3 research/training/train_detector.py SCENES --output MODEL.onnx [--minutes 25] [--start MODEL.pt]

Writes MODEL.onnx, MODEL.pt (the weights, to go on from) and MODEL.toml (the settings for `barrelman run
--detector`). The model takes a picture of 512x288 pixels in letterbox, and answers [1, 6, N]: centre, width and
height of N boxes in pixels of the input, and the scores of `person` and `boat`.

The network has residual blocks of 3x3 convolutions with strides 4 to 32, and one head for the strides 8, 16 and
32, which share the boxes by size (Tian et al., FCOS, 2019). The loss is 1 - generalised IoU of the boxes and the
varifocal loss of the scores (Zhang et al., 2021). Pictures are cropped, scaled, mirrored, and changed in colour,
haze, sharpness, noise and compression, and parts are covered by textures, as rendered pictures differ from real
ones in all of these.

Needs numpy, torch and opencv; none is a part of the project's setup. Takes one thread for training, one for the
pictures, and 0.7 MB of memory a picture.
"""
import argparse
import collections
import csv
import math
import pathlib
import time

import cv2
import numpy as np
import torch
from torch import nn
from torch.nn import functional

CLASSES = ["person", "boat"]
INPUT = (512, 288)
CROP = (384, 224)
STRIDES = (8, 16, 32)
# The longer side of the boxes of each stride, pixels of the input.
SIZES = ((0, 40), (40, 110), (110, 1e9))
# Boxes with a shorter side below this are neither learned nor counted as water.
LEAST_SIDE = 3.0
# So much of a box must be in the crop.
LEAST_VISIBLE = 0.4
SETTINGS = """classes = ["person", "boat"]
input = { width = 512, height = 288 }
output = { format = "yolo" }
thresholds = { score = 0.5, iou = 0.5 }
"""


def layer(before, after, stride=1):
    return nn.Sequential(nn.Conv2d(before, after, 3, stride, 1, bias=False), nn.BatchNorm2d(after), nn.ReLU())


class Block(nn.Module):
    def __init__(self, channels):
        super().__init__()
        self.first, self.second = layer(channels, channels // 2), layer(channels // 2, channels)

    def forward(self, x):
        return x + self.second(self.first(x))


class Network(nn.Module):
    def __init__(self, width=48):
        super().__init__()
        self.stem = nn.Sequential(layer(3, 16, 2), layer(16, 24, 2), Block(24))
        self.eighth = nn.Sequential(layer(24, 40, 2), Block(40), Block(40))
        self.sixteenth = nn.Sequential(layer(40, 56, 2), Block(56), Block(56))
        self.last = nn.Sequential(layer(56, 72, 2), Block(72), Block(72), Block(72))
        self.sides = nn.ModuleList([nn.Conv2d(channels, width, 1) for channels in (40, 56, 72)])
        self.merge = nn.ModuleList([layer(width, width) for _ in STRIDES])
        self.head = nn.Sequential(layer(width, width), layer(width, width))
        self.answer = nn.Conv2d(width, 4 + len(CLASSES), 1)
        self.scale = nn.Parameter(torch.ones(len(STRIDES)))
        nn.init.zeros_(self.answer.bias)
        nn.init.constant_(self.answer.bias[4:], -4.0)

    def forward(self, x):
        """The boxes [N, 4, cells] in pixels, and the logits of the classes [N, C, cells]."""
        eighth = self.eighth(self.stem(x))
        sixteenth = self.sixteenth(eighth)
        maps = [side(m) for side, m in zip(self.sides, (eighth, sixteenth, self.last(sixteenth)))]
        for level in (1, 0):
            maps[level] = maps[level] + functional.interpolate(maps[level + 1], scale_factor=2, mode="nearest")
        boxes, logits = [], []
        for level, stride in enumerate(STRIDES):
            answer = self.answer(self.head(self.merge[level](maps[level]))).float()
            centres = grid(x.shape[3] // stride, x.shape[2] // stride, stride)
            place = answer[:, :2].flatten(2) * stride + centres
            sides = (answer[:, 2:4].flatten(2) * self.scale[level]).clamp(-4, 4).exp() * (2 * stride)
            boxes.append(torch.cat([place, sides], 1))
            logits.append(answer[:, 4:].flatten(2))
        return torch.cat(boxes, 2), torch.cat(logits, 2)


class Exported(nn.Module):
    def __init__(self, network):
        super().__init__()
        self.network = network

    def forward(self, x):
        boxes, logits = self.network(x)
        return torch.cat([boxes, logits.sigmoid()], 1)


def grid(columns, rows, stride):
    v, u = torch.meshgrid(torch.arange(rows), torch.arange(columns), indexing="ij")
    return (torch.stack([u, v]).flatten(1) + 0.5) * stride


class Scenes(torch.utils.data.IterableDataset):
    """Endless changed crops; labels are class, left, top, right, bottom."""

    def __init__(self, folders):
        self.pictures, self.boxes = [], []
        for folder in folders:
            rows = collections.defaultdict(list)
            for row in csv.DictReader((folder / "boxes.csv").open()):
                x, y, w, h = (float(row[key]) for key in "xywh")
                rows[row["picture"]].append([CLASSES.index(row["class"]), x, y, x + w, y + h])
            for path in sorted(folder.glob("*.png")):
                self.pictures.append(cv2.cvtColor(cv2.imread(str(path)), cv2.COLOR_BGR2RGB))
                self.boxes.append(np.array(rows[path.stem], np.float32).reshape(-1, 5))

    def __iter__(self):
        cv2.setNumThreads(0)
        random = np.random.default_rng(int(time.time()))
        while True:
            yield self.sample(random)

    def sample(self, random):
        index = random.integers(len(self.pictures))
        picture, boxes = self.pictures[index], self.boxes[index].copy()
        scale = INPUT[0] / picture.shape[1] * math.exp(random.uniform(-0.7, 0.7))
        size = np.array(CROP) / scale
        spare = np.array(picture.shape[1::-1]) - size
        corner = random.uniform(0, 1, 2) * spare
        if len(boxes) and random.random() < 0.6:
            box = boxes[random.integers(len(boxes))]
            corner = (box[1:3] + box[3:5]) / 2 - random.uniform(0.1, 0.9, 2) * size
        corner = np.clip(corner, np.minimum(0, spare) - 0.05 * size, np.maximum(0, spare) + 0.05 * size)
        matrix = np.array([[scale, 0, -scale * corner[0]], [0, scale, -scale * corner[1]]])
        way = cv2.INTER_AREA if scale < 0.6 else cv2.INTER_LINEAR
        picture = cv2.warpAffine(picture, matrix, CROP, flags=way, borderValue=(114, 114, 114))
        boxes[:, 1:] = (boxes[:, 1:] - np.tile(corner, 2)) * scale
        whole = areas(boxes)
        boxes[:, 1:] = np.clip(boxes[:, 1:], 0, np.tile(CROP, 2))
        boxes[areas(boxes) < LEAST_VISIBLE * whole, 0] = -1
        boxes = boxes[areas(boxes) > 0]
        if random.random() < 0.5:
            picture = picture[:, ::-1]
            boxes[:, [1, 3]] = CROP[0] - boxes[:, [3, 1]]
        if random.random() < 0.3:
            picture = cover(picture, boxes, random)
        picture = changed(np.ascontiguousarray(picture), random)
        sides = np.minimum(boxes[:, 3] - boxes[:, 1], boxes[:, 4] - boxes[:, 2])
        boxes[sides < LEAST_SIDE, 0] = -1
        return torch.from_numpy(picture), torch.from_numpy(boxes)


def areas(boxes):
    return (boxes[:, 3] - boxes[:, 1]).clip(0) * (boxes[:, 4] - boxes[:, 2]).clip(0)


def texture(width, height, random):
    """Clouds of random colours, with rectangles: neither water nor an object."""
    total = np.zeros((height, width, 3), np.float32)
    for step in (64, 24, 8, 3):
        small = random.normal(size=(height // step + 2, width // step + 2, 3)) * [1.0, 0.9, 1.0]
        small = 0.7 * small.mean(2, keepdims=True) + 0.3 * small
        total += cv2.resize(small.astype(np.float32), (width, height)) * random.uniform(5, 35)
    total += random.uniform(40, 190, 3)
    for _ in range(random.integers(0, 12)):
        x, y = random.integers(width), random.integers(height)
        corner = (int(x + random.integers(2, 60)), int(y + random.integers(2, 40)))
        cv2.rectangle(total, (int(x), int(y)), corner, random.uniform(20, 235, 3).tolist(), -1)
    return total.clip(0, 255)


def cover(picture, boxes, random):
    """Covers a part in which no box is."""
    height, width = picture.shape[:2]
    side = random.integers(4)
    free = [boxes[:, 2].min(initial=height), height - boxes[:, 4].max(initial=0),
            boxes[:, 1].min(initial=width), width - boxes[:, 3].max(initial=0)][side]
    depth = int(free * random.uniform(0.3, 1))
    if depth < 4:
        return picture
    picture = picture.copy()
    part = [np.s_[:depth], np.s_[height - depth:], np.s_[:, :depth], np.s_[:, width - depth:]][side]
    picture[part] = texture(width, height, random)[part]
    return picture


def changed(picture, random):
    """Colours, haze, sharpness, noise and compression at random."""
    height, width = picture.shape[:2]
    hsv = cv2.cvtColor(picture, cv2.COLOR_RGB2HSV).astype(np.float32)
    hsv[..., 0] = (hsv[..., 0] + random.normal() * 12) % 180
    hsv[..., 1] *= random.uniform(0.2, 1.5)
    picture = cv2.cvtColor(hsv.clip(0, [179, 255, 255]).astype(np.uint8), cv2.COLOR_HSV2RGB)
    table = np.linspace(0, 1, 256) ** math.exp(random.normal() * 0.4)
    gain = math.exp(random.normal() * 0.2) * (1 + random.normal(size=3) * 0.06)
    haze = random.uniform(0, 0.5) if random.random() < 0.3 else 0
    for channel in range(3):
        curve = (255 * table * gain[channel] * (1 - haze) + haze * random.uniform(140, 240)).clip(0, 255)
        picture[..., channel] = cv2.LUT(picture[..., channel], curve.astype(np.uint8))
    if random.random() < 0.3:
        picture = cv2.GaussianBlur(picture, (0, 0), random.uniform(0.3, 1.5))
    if random.random() < 0.15:
        kernel = np.zeros((9, 9), np.float32)
        angle, half = random.uniform(0, math.pi), random.uniform(1, 4)
        end = (round(4 + half * math.cos(angle)), round(4 + half * math.sin(angle)))
        cv2.line(kernel, (8 - end[0], 8 - end[1]), end, 1.0)
        picture = cv2.filter2D(picture, -1, kernel / kernel.sum())
    elif random.random() < 0.3:
        blurred = cv2.GaussianBlur(picture, (0, 0), 1.2)
        picture = cv2.addWeighted(picture, 1 + (strength := random.uniform(0.3, 1.5)), blurred, -strength, 0)
    if random.random() < 0.5:
        noise = random.normal(size=(height, width, 1)) * random.uniform(1, 10)
        picture = (picture + noise).clip(0, 255).astype(np.uint8)
    if random.random() < 0.6:
        quality = [cv2.IMWRITE_JPEG_QUALITY, int(random.integers(15, 90))]
        picture = cv2.imdecode(cv2.imencode(".jpg", picture, quality)[1], cv2.IMREAD_COLOR)
    return picture


def collate(samples):
    pictures, boxes = zip(*samples)
    return torch.stack(pictures).permute(0, 3, 1, 2), list(boxes)


def targets(boxes, centres, strides, levels):
    """Of each cell: the class (-1: water, -2: not learned) and the box."""
    classes = torch.full((centres.shape[1],), -1)
    found = torch.zeros(centres.shape[1], 4)
    order = ((boxes[:, 3] - boxes[:, 1]) * (boxes[:, 4] - boxes[:, 2])).argsort(descending=True)
    for kind, left, top, right, bottom in boxes[order].tolist():
        if kind < 0:
            reach = ((centres[0] > left - 8) & (centres[0] < right + 8)
                     & (centres[1] > top - 8) & (centres[1] < bottom + 8))
            classes[reach & (classes == -1)] = -2
            continue
        longer = max(right - left, bottom - top)
        level = next(level for level, (_, high) in enumerate(SIZES) if longer < high)
        du, dv = (centres[0] - (left + right) / 2).abs(), (centres[1] - (top + bottom) / 2).abs()
        near = (levels == level) & (du < strides) & (dv < strides)
        classes[near] = int(kind)
        found[near] = torch.tensor([left, top, right, bottom])
    return classes, found


def corners(boxes):
    return torch.cat([boxes[:, :2] - boxes[:, 2:] / 2, boxes[:, :2] + boxes[:, 2:] / 2], 1)


def iou_and_generalised(a, b):
    def area(box):
        return (box[:, 2] - box[:, 0]).clamp(min=1e-3) * (box[:, 3] - box[:, 1]).clamp(min=1e-3)

    common = (torch.minimum(a[:, 2:], b[:, 2:]) - torch.maximum(a[:, :2], b[:, :2])).clamp(min=0).prod(1)
    union = area(a) + area(b) - common
    around = area(torch.cat([torch.minimum(a[:, :2], b[:, :2]), torch.maximum(a[:, 2:], b[:, 2:])], 1))
    return common / union, common / union - (around - union) / around


def loss_of(network, pictures, labels, cells):
    with torch.autocast("cpu", torch.bfloat16):
        boxes, logits = network(pictures.float() / 255)
    boxes, logits = boxes.float(), logits.float()
    made = [targets(label, *cells) for label in labels]
    classes, wanted = torch.stack([one for one, _ in made]), torch.stack([one for _, one in made])
    learned = classes >= 0
    count = learned.sum().clamp(min=1)
    overlap, generalised = iou_and_generalised(corners(boxes.permute(0, 2, 1)[learned]), wanted[learned])
    quality = torch.zeros_like(logits)
    where = learned.nonzero(as_tuple=True)
    quality[where[0], classes[learned], where[1]] = overlap.detach().clamp(min=0.05)
    probability = logits.detach().sigmoid()
    weight = torch.where(quality > 0, quality, 0.75 * probability ** 2) * (classes != -2)[:, None]
    score = functional.binary_cross_entropy_with_logits(logits, quality, weight, reduction="sum")
    return (2 * (1 - generalised).sum() + score) / count


def fit(network, scenes, minutes, rate, batch=16):
    centres = torch.cat([grid(CROP[0] // stride, CROP[1] // stride, stride) for stride in STRIDES], 1)
    counts = [(CROP[0] // stride) * (CROP[1] // stride) for stride in STRIDES]
    strides = torch.cat([torch.full((count,), stride) for count, stride in zip(counts, STRIDES)])
    levels = torch.cat([torch.full((count,), level) for level, count in enumerate(counts)])
    loader = torch.utils.data.DataLoader(scenes, batch, num_workers=1, collate_fn=collate, prefetch_factor=8)
    optimiser = torch.optim.AdamW(network.parameters(), rate, weight_decay=1e-2)
    average = {name: value.clone() for name, value in network.state_dict().items()}
    began, losses = time.time(), []
    for step, (pictures, labels) in enumerate(loader):
        done = (time.time() - began) / (60 * minutes)
        if done >= 1:
            break
        fall = 0.01 + 0.99 * (1 + math.cos(math.pi * done)) / 2
        optimiser.param_groups[0]["lr"] = rate * min(1, (step + 1) / 200) * fall
        loss = loss_of(network, pictures, labels, (centres, strides, levels))
        optimiser.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(network.parameters(), 5.0)
        optimiser.step()
        keep = min(0.998, step / (step + 10))
        for name, value in network.state_dict().items():
            average[name] = keep * average[name] + (1 - keep) * value if value.is_floating_point() else value
        losses.append(loss.item())
        if step % 200 == 199:
            print(f"step {step + 1}, {100 * done:.0f} %: loss {np.mean(losses[-200:]):.3f}", flush=True)
    network.load_state_dict(average)
    return network.eval()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", type=pathlib.Path)
    parser.add_argument("--output", required=True, type=pathlib.Path)
    parser.add_argument("--minutes", type=float, default=25)
    parser.add_argument("--rate", type=float, default=2e-3)
    parser.add_argument("--start", type=pathlib.Path, help="weights to go on from")
    options = parser.parse_args()
    torch.set_num_threads(1)
    torch.manual_seed(0)
    network = Network()
    if options.start:
        network.load_state_dict(torch.load(options.start))
    print(f"{sum(value.numel() for value in network.parameters())} weights", flush=True)
    network = fit(network, Scenes(options.scenes), options.minutes, options.rate)
    torch.save(network.state_dict(), options.output.with_suffix(".pt"))
    options.output.with_suffix(".toml").write_text(SETTINGS)
    picture = torch.zeros(1, 3, INPUT[1], INPUT[0])
    torch.onnx.export(Exported(network), picture, str(options.output), opset_version=13,
                      input_names=["picture"], output_names=["objects"])


if __name__ == "__main__":
    main()
