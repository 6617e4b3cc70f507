"""Depths and positions of the guest's programs against those of the simulator: TRUTH_FOLDER depth.pfm poses.txt"""
import math
import struct
import sys


def read_pfm(name):
    with open(name, "rb") as file:
        assert file.readline() == b"Pf\n", name
        width, height = map(int, file.readline().split())
        order = "<" if float(file.readline()) < 0 else ">"
        return struct.unpack(f"{order}{width * height}f", file.read())


def true_positions(name):
    lines = [line.split() for line in open(name) if not line.startswith("#")]
    return [[float(x) for x in line[-3:]] for line in lines]


truth, depth_file, poses_file = sys.argv[1:]
positions = true_positions(f"{truth}/poses.txt")
baseline = math.dist(positions[0], positions[1])

pairs = [(f * baseline, t) for f, t in zip(read_pfm(depth_file), read_pfm(f"{truth}/depth/0001.pfm")) if f > 0]
share = len(pairs) / (640 * 480)
error = sorted(abs(f / t - 1) for f, t in pairs)[len(pairs) // 2]
print(f"depth: {share:.2f} of the pixels, median error {100 * error:.2f} %")

found = [[float(x) for x in line.split()[1:]] for line in open(poses_file)]
assert len(found) == len(positions), f"{len(found)} of {len(positions)} images have a pose"
# Distances do not depend on the frame, and the scale is that of the first two cameras.
scale = baseline / math.dist(found[0], found[1])
worst = max(abs(scale * math.dist(f, found[0]) - math.dist(t, positions[0])) for f, t in zip(found, positions))
print(f"poses: distances from the first camera are at most {100 * worst / baseline:.1f} % of the baseline off")

# Two images at an overlap of four fifths give depths to a few per mille; a mistake in units or pairs gives much more.
sys.exit(0 if share > 0.6 and error < 0.01 and worst < 0.1 * baseline else 1)
