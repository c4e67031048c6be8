"""Fits the weights of the tracker's refinement network to the samples of `barrelman-eval training-samples`.

    barrelman-eval training-samples --clips DIR --output SAMPLES
    python3 research/training/train_refinement.py SAMPLES [SAMPLES ...] --output WEIGHTS [--folds 4]

WEIGHTS is a folder. `all.weights` is fitted to all clips, and goes to crates/vision/src/refinement/network.weights.
With --folds N the recordings are divided into N parts, and for each part a network is fitted to the others: the
file NAME.weights of each clip is that of a network which never saw the clip's recording, for `barrelman-eval tracker
--weights WEIGHTS`. Names tell which recordings a clip was made from (recordings.py): a composed clip
(compose_clips.py) is of two, and one of the simulator (a name that begins with `sim_`) of none.

The loss is that of the box (1 - generalised IoU) where the target lies in the window, the negative log-likelihood of
the edges' errors (Laplace distribution), the coverage of rows and columns by the box, and the cross entropy of
"the refined box has an IoU of at least 0.5". Samples are mirrored, transposed, inverted in brightness, rotated in
chroma, and robbed of single channels at random.

Needs numpy and torch; neither is a part of the project's setup. Takes a thread for each of --jobs, and 23 kB of memory a
sample while it loads.
"""
import argparse
import multiprocessing
import pathlib
import time

import numpy as np
import torch
from torch import nn
from torch.nn import functional

from recordings import COMPOSED, SIMULATED, is_recorded, recording_of, recordings_of

SIDE, CHANNELS, MEASUREMENTS = 32, 11, 12
CELL_SCALE = 60.0
BRIGHTNESS, PROBABILITY, MOTION, SELECTED, USUAL, CHROMA, SELECTED_PROBABILITY = 0, 2, 3, 5, 6, (8, 9), 10
RECORD = np.dtype([
    ("start", "<u4"), ("frame", "<u4"), ("state", "<u4"), ("kind", "<u4"), ("confidence", "<f4"),
    ("centre", "<f4", 2), ("sides", "<f4", 2), ("box", "<f4", 2), ("label", "<f4", 4), ("reported", "<f4", 4),
    ("picture", "<f4", 2), ("measurements", "<f4", MEASUREMENTS), ("cells", "i1", (CHANNELS, SIDE, SIDE)),
])
# An overlap with the label below which nothing is learned about the edges, and the probability has no right
# box.
MIN_NEAR_IOU = 0.1
EDGE_SCALE, ERROR_OFFSET = 0.4, -1.5
# The log-odds are divided by this on writing: on recordings that were left out, probabilities as fitted are
# too far from one half.
TEMPERATURE = 4 / 3
# Weight of a composed or simulated clip beside a recording of as many samples.
WEIGHTS = {COMPOSED: 0.3, SIMULATED: 0.5}


class Network(nn.Module):
    """The layers of crates/vision/src/refinement/weights.rs, in the order of its file."""

    def __init__(self, first=32, second=48, profile=24, edge=48, judge=32):
        super().__init__()
        half = SIDE // 2
        self.first = nn.Conv2d(CHANNELS, first, 3, stride=2, padding=1)
        self.second = nn.Conv2d(first, second, 3, padding=1)
        self.third = nn.Conv2d(second, second, 3, padding=2, dilation=2)
        self.fourth = nn.Conv2d(second, second, 3, padding=4, dilation=4)
        self.profile = nn.Conv1d(2 * second, profile, 3, padding=1)
        self.edge = nn.Linear(profile * half, edge)
        self.answer = nn.Linear(edge, 4)
        self.judge = nn.Linear(3 * second + 2 * edge + MEASUREMENTS, judge)
        self.odds = nn.Linear(judge, 1)
        # For training alone: the coverage of rows and columns.
        self.coverage = nn.Linear(profile, 1)
        nn.init.zeros_(self.answer.weight)
        nn.init.zeros_(self.answer.bias)

    def axis(self, maps, other):
        profile = functional.relu(self.profile(torch.cat([maps.amax(other), maps.mean(other)], 1)))
        edge = functional.relu(self.edge(profile.flatten(1)))
        return self.answer(edge), self.coverage(profile.transpose(1, 2))[:, :, 0], edge

    def forward(self, cells, measurements):
        # The convolutions take half the time of single precision; weights and everything else stay in it.
        with torch.autocast("cpu", torch.bfloat16, enabled=self.training):
            maps = functional.relu(self.first(cells))
            maps = functional.relu(self.second(maps))
            maps = functional.relu(maps + self.third(maps))
            maps = functional.relu(maps + self.fourth(maps))
        maps = maps.float()
        across, columns, edge_across = self.axis(maps, 2)
        down, rows, edge_down = self.axis(maps, 3)
        pooled = [maps.mean((2, 3)), maps.amax((2, 3)), maps[:, :, 5:11, 5:11].mean((2, 3))]
        judged = torch.cat([*pooled, edge_across, edge_down, measurements], 1)
        odds = self.odds(functional.relu(self.judge(judged)))[:, 0]
        return across, down, columns, rows, odds

    def write(self, path):
        layers = [self.first, self.second, self.third, self.fourth,
                  self.profile, self.edge, self.answer, self.judge, self.odds]
        values = [part.detach().numpy().ravel() for layer in layers for part in (layer.weight, layer.bias)]
        values[-2:] = [part / TEMPERATURE for part in values[-2:]]
        np.concatenate(values).astype("<f4").tofile(path)


class Samples:
    """Samples of all clips; boxes are left, top, right, bottom in sides of the window."""

    def __init__(self, folders):
        parts, self.clips = [], []
        for path in sorted(path for folder in folders for path in pathlib.Path(folder).glob("*.samples")):
            part = np.fromfile(path, dtype=RECORD)
            parts.append(part)
            self.clips += [path.stem] * len(part)
        records = np.concatenate(parts)
        del parts
        self.clips = np.array(self.clips)
        corner = records["centre"] - records["sides"] / 2
        begin = (records["label"][:, :2] - corner) / records["sides"]
        label = np.concatenate([begin, begin + records["label"][:, 2:] / records["sides"]], 1)
        half = records["box"] / records["sides"] / 2
        prior = np.concatenate([0.5 - half, 0.5 + half], 1)
        low, high = -corner / records["sides"], (records["picture"] - corner) / records["sides"]
        limits = np.concatenate([low, low, high, high], 1)
        self.limits = torch.from_numpy(limits.astype(np.float32))
        self.label = torch.from_numpy(label.astype(np.float32)).clamp(-1, 2)
        self.prior = torch.from_numpy(prior.astype(np.float32))
        visible = torch.from_numpy(records["label"][:, 2] > 0)
        overlap = iou_and_generalised(self.clipped(self.prior, slice(None)), self.label)[0] * visible
        self.near = (overlap > MIN_NEAR_IOU).float()
        self.visible = visible
        self.cells = torch.from_numpy(records["cells"].copy())
        measurements = np.clip(np.nan_to_num(records["measurements"]), -5, 5)
        self.measurements = torch.from_numpy(measurements.astype(np.float32))
        # A recording with many samples counts less for each.
        names, clip_of = np.unique(self.clips, return_inverse=True)
        groups, group_of = np.unique([recording_of(name) for name in names], return_inverse=True)
        counts = np.bincount(group_of[clip_of])
        factors = [next((factor for kind, factor in WEIGHTS.items() if group.startswith(kind)), 1.0) for group in groups]
        self.weights = (factors * counts ** -0.5)[group_of[clip_of]]

    def clipped(self, boxes, index):
        limits = self.limits[index]
        return torch.minimum(torch.maximum(boxes, limits[:, [0, 1, 0, 1]]), limits[:, [4, 5, 4, 5]])


def iou_and_generalised(a, b):
    def area(box):
        return (box[:, 2] - box[:, 0]).clamp(min=1e-3) * (box[:, 3] - box[:, 1]).clamp(min=1e-3)

    width = (torch.minimum(a[:, 2], b[:, 2]) - torch.maximum(a[:, 0], b[:, 0])).clamp(min=0)
    height = (torch.minimum(a[:, 3], b[:, 3]) - torch.maximum(a[:, 1], b[:, 1])).clamp(min=0)
    common = width * height
    union = (area(a) + area(b) - common).clamp(min=1e-6)
    around = torch.stack([torch.minimum(a[:, 0], b[:, 0]), torch.minimum(a[:, 1], b[:, 1]),
                          torch.maximum(a[:, 2], b[:, 2]), torch.maximum(a[:, 3], b[:, 3])], 1)
    around = area(around)
    return common / union, common / union - (around - union) / around


def augment(cells, boxes):
    """Changes a batch at random; `boxes` are changed with the cells."""
    count = len(cells)
    cells, boxes = cells.clone(), [box.clone() for box in boxes]

    def chosen(share):
        return torch.rand(count) < share

    for share, flip, order, sign in [
        (0.5, lambda x: x.flip(3), [2, 1, 0, 3], [1, 0, 1, 0]),
        (0.5, lambda x: x.flip(2), [0, 3, 2, 1], [0, 1, 0, 1]),
        (0.3, lambda x: x.transpose(2, 3), [1, 0, 3, 2], [0, 0, 0, 0]),
    ]:
        which = chosen(share)
        cells[which] = flip(cells[which])
        mirrored = torch.tensor(sign, dtype=torch.float32)
        for box in boxes:
            box[which] = mirrored + (1 - 2 * mirrored) * box[which][:, order]
    sign = torch.where(chosen(0.3), -1.0, 1.0)[:, None, None, None]
    cells[:, [BRIGHTNESS, SELECTED, USUAL]] *= sign
    for share, channels in [
        (0.2, [MOTION]), (0.1, [SELECTED, SELECTED_PROBABILITY]), (0.1, [USUAL]), (0.1, [PROBABILITY]),
    ]:
        which = chosen(share)
        for channel in channels:
            cells[which, channel] = 0
    angle, gain = torch.rand(count) * 2 * torch.pi, 0.5 + torch.rand(count)
    cos, sin = (gain * torch.cos(angle))[:, None, None], (gain * torch.sin(angle))[:, None, None]
    u, v = cells[:, CHROMA[0]].clone(), cells[:, CHROMA[1]].clone()
    cells[:, CHROMA[0]], cells[:, CHROMA[1]] = cos * u - sin * v, sin * u + cos * v
    return cells, boxes


def coverage(begin, end):
    edges = torch.arange(SIDE // 2 + 1) / (SIDE // 2)
    common = torch.minimum(end[:, None], edges[None, 1:]) - torch.maximum(begin[:, None], edges[None, :-1])
    return common.clamp(min=0) * (SIDE // 2)


def refined(across, down, prior):
    shifts = torch.stack([across[:, 0], down[:, 0], across[:, 1], down[:, 1]], 1)
    return prior + EDGE_SCALE * shifts


def loss_of(network, samples, index):
    cells = samples.cells[index].float() / CELL_SCALE
    cells, (label, prior) = augment(cells, [samples.label[index], samples.prior[index]])
    across, down, columns, rows, odds = network(cells, samples.measurements[index])
    box, near = refined(across, down, prior), samples.near[index]

    def mean_near(values):
        return (values * near).sum() / near.sum().clamp(min=1)

    overlap, generalised = iou_and_generalised(box, label)
    sides = (prior[:, 2:] - prior[:, :2]).repeat(1, 2)
    logarithm = torch.stack([across[:, 2], down[:, 2], across[:, 3], down[:, 3]], 1).clamp(-4, 3) + ERROR_OFFSET
    likelihood = ((box.detach() - label).abs() / sides * torch.exp(-logarithm) + logarithm).mean(1)
    bce = functional.binary_cross_entropy_with_logits
    covered = (bce(columns, coverage(label[:, 0], label[:, 2]), reduction="none").mean(1)
               + bce(rows, coverage(label[:, 1], label[:, 3]), reduction="none").mean(1))
    right = (overlap.detach() >= 0.5) & samples.visible[index]
    return (2 * mean_near(1 - generalised) + mean_near(covered) + 0.3 * mean_near(likelihood)
            + 0.5 * bce(odds, right.float()))


def fit(samples, chosen, epochs, batch=128, rate=4e-3):
    torch.manual_seed(0)
    random = np.random.RandomState(0)
    network = Network()
    optimiser = torch.optim.AdamW(network.parameters(), rate, weight_decay=1e-2)
    steps = int(epochs * (len(chosen) // batch))
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimiser, rate, total_steps=steps + 1)
    share = samples.weights[chosen] / samples.weights[chosen].sum()
    for _ in range(steps):
        index = torch.from_numpy(chosen[random.choice(len(chosen), batch, p=share)])
        loss = loss_of(network, samples, index)
        optimiser.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(network.parameters(), 2.0)
        optimiser.step()
        schedule.step()
    return network.eval()


def report(name, network, samples, chosen, seconds):
    """Prints how well boxes and probabilities are on recordings that the network was not fitted to."""
    before, after, odds_of = [], [], []
    with torch.no_grad():
        for part in np.array_split(chosen, max(1, len(chosen) // 2048)):
            index = torch.from_numpy(part)
            across, down, _, _, odds = network(samples.cells[index].float() / CELL_SCALE, samples.measurements[index])
            for boxes, out in [(samples.prior[index], before), (refined(across, down, samples.prior[index]), after)]:
                overlap = iou_and_generalised(samples.clipped(boxes, index), samples.label[index])[0]
                out.append(overlap * samples.visible[index])
            odds_of.append(odds)
    before, after, odds = torch.cat(before), torch.cat(after), torch.cat(odds_of)
    near = samples.near[torch.from_numpy(chosen)] > 0
    rank = odds.argsort().argsort().double() + 1
    right = after >= 0.5
    count, rights = len(right), right.sum()
    auroc = (rank[right].sum() - rights * (rights + 1) / 2) / (rights * (count - rights)).clamp(min=1)
    print(f"{name}: {seconds:.0f} s; held out {count}: mean IoU {before[near].mean():.3f} before, "
          f"{after[near].mean():.3f} after; AUROC {auroc:.3f}", flush=True)


def fit_fold(samples, options, fold, left_out):
    """Fits the network of a fold to all clips of which no recording is left out, and writes it; fold -1 is that of all."""
    clips = sorted(set(samples.clips))
    is_left_out = np.isin(samples.clips, [clip for clip in clips if recordings_of(clip) & left_out])
    began = time.time()
    network = fit(samples, np.flatnonzero(~is_left_out), options.epochs)
    if fold < 0:
        network.write(options.output / "all.weights")
        print(f"all: {time.time() - began:.0f} s", flush=True)
        return
    measured = [clip for clip in clips if is_recorded(clip) and recording_of(clip) in left_out]
    chosen = np.flatnonzero(np.isin(samples.clips, measured))
    report(f"fold {fold}", network, samples, chosen, time.time() - began)
    for clip in measured:
        network.write(options.output / f"{clip}.weights")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("samples", nargs="+")
    parser.add_argument("--output", required=True, type=pathlib.Path)
    parser.add_argument("--folds", type=int, default=0)
    parser.add_argument("--only", type=int, nargs="+", help="only these folds, from 0; -1: the network of all clips")
    parser.add_argument("--epochs", type=float, default=2.2)
    parser.add_argument("--jobs", type=int, default=1, help="networks that are fitted at the same time")
    options = parser.parse_args()
    folds = range(-1, options.folds)
    if unknown := set(options.only or ()) - set(folds):
        parser.error(f"--only {min(unknown)}: the folds are -1 to {options.folds - 1} (--folds)")
    torch.set_num_threads(1)
    options.output.mkdir(parents=True, exist_ok=True)
    samples = Samples(options.samples)
    recordings = sorted({recording_of(clip) for clip in set(samples.clips) if is_recorded(clip)})
    print(f"{len(samples.clips)} samples, {len(recordings)} recordings", flush=True)
    shuffled = np.random.RandomState(3).permutation(recordings)
    jobs = [(fold, set(shuffled[fold::options.folds]) if fold >= 0 else set()) for fold in options.only or folds]
    # Forked processes share the samples of this one: arguments of the initializer are not copied.
    with multiprocessing.get_context("fork").Pool(options.jobs, share, (samples, options)) as pool:
        pool.starmap(fit_shared, jobs, chunksize=1)


def share(samples, options):
    fit_shared.shared = samples, options


def fit_shared(fold, left_out):
    fit_fold(*fit_shared.shared, fold, left_out)


if __name__ == "__main__":
    main()
