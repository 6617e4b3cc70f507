#!/usr/bin/env python3
"""What thumbnails and exact images by rank bring (docs/products.md).

Renders each world once and flies it with every policy over links of 2, 5 and 10 % of the keyframes' raw bits. Prints
the mean of each figure, and the mean difference from the flight without ranks with its 95 % interval over the seeds.
Flights that are done are not flown again.

    sim/campaigns/ranks/run.py --out DIR [--worlds plains canyon] [--seeds 5] [--jobs 2]
"""
import argparse
import json
import math
import os
import subprocess
from concurrent.futures import ThreadPoolExecutor

PROJECT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
PROGRAMS = os.path.join(PROJECT, "build", "host", "bin")
FRAMES = 130
KEYFRAMES = 50  # about, with frames 4 s apart
RAW_BYTES = 640 * 480
PASSES = 4
PASS_S = 30
POLICIES = {"none": (0, 0), "ranks": (0.25, 0.1)}
LINKS = (2, 5, 10)
FIGURES = ("feature_share", "feature_well_share", "feature_psnr_db", "image_psnr_db", "terrain_coverage", "relief_known_share")
# 97.5 % of Student's distribution by degrees of freedom.
STUDENT = {1: 12.71, 2: 4.303, 3: 3.182, 4: 2.776, 5: 2.571, 6: 2.447, 7: 2.365, 8: 2.306, 9: 2.262}


def run(*command):
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


def mission(policy, link):
    thumbnails, exact = POLICIES[policy]
    rate = link / 100 * RAW_BYTES * KEYFRAMES / (PASSES * PASS_S)
    return (f"[products]\nquality_layers = 6\nthumbnail_share = {thumbnails}\nlossless_share = {exact}\n"
            f"[downlink]\nlink_bytes_per_s = {rate:.0f}\npass_period_s = {FRAMES * 4 // PASSES}\npass_length_s = {PASS_S}\n"
            f"pass_start_s = {FRAMES * 4 // PASSES}\npass_count = {PASSES}\n")


def render(out, world, seed):
    folder = os.path.join(out, f"{world}-{seed}")
    if not os.path.exists(os.path.join(folder, "flight", "index.txt")):
        run(os.path.join(PROGRAMS, "ilp-sil"), "--scenario", os.path.join(PROJECT, "sim/campaigns/value", world + ".ini"),
            "--seed", str(seed), "--frames", str(FRAMES), "--threads", "1", "--out", folder, "--render-only")
    with open(os.path.join(folder, "flight", "index.txt"), encoding="utf-8") as index:
        times = index.read().replace("images/", "")
    with open(os.path.join(folder, "flight", "images", "times.txt"), "w", encoding="utf-8") as file:
        file.write(times)


def fly(out, world, seed, policy, link):
    rendered = os.path.join(out, f"{world}-{seed}", "flight")
    name = os.path.join(out, f"{world}-{seed}-{policy}-{link}")
    if os.path.exists(name + ".json"):
        return
    with open(name + ".ini", "w", encoding="utf-8") as file:
        file.write(mission(policy, link))
    run("rm", "-rf", name)
    run(os.path.join(PROGRAMS, "ilp-sil"), "--images", os.path.join(rendered, "images"), "--camera",
        os.path.join(rendered, "cameras.txt"), "--mission", name + ".ini", "--seed", str(seed), "--out", name)
    run(os.path.join(PROGRAMS, "ilp-score"), name, "--truth", os.path.join(rendered, "truth"), "--out", name + ".part")
    os.rename(name + ".part", name + ".json")
    run("rm", "-rf", name)


def summary(out, world, seed, policy, link):
    with open(os.path.join(out, f"{world}-{seed}-{policy}-{link}.json"), encoding="utf-8") as file:
        return json.load(file)["summary"]


def interval(values):
    mean = sum(values) / len(values)
    if len(values) < 2:
        return mean, math.nan
    deviation = math.sqrt(sum((value - mean) ** 2 for value in values) / (len(values) - 1))
    return mean, STUDENT[len(values) - 1] * deviation / math.sqrt(len(values))


def print_tables(out, worlds, seeds):
    for world in worlds:
        print(f"\n{world}, {len(seeds)} seeds\n\n| link | policy | MB | " + " | ".join(FIGURES) + " |")
        print("|" + "---|" * (3 + len(FIGURES)))
        for link in LINKS:
            for policy in POLICIES:
                flights = [summary(out, world, seed, policy, link) for seed in seeds]
                bases = [summary(out, world, seed, "none", link) for seed in seeds]
                cells = [f"{sum(f['received_mb'] for f in flights) / len(flights):.3f}"]
                for figure in FIGURES:
                    if policy == "none":
                        cells.append(f"{sum(f[figure] for f in flights) / len(flights):.4f}")
                    else:
                        mean, half = interval([f[figure] - b[figure] for f, b in zip(flights, bases)])
                        cells.append(f"{mean:+.4f} ± {half:.4f}")
                print(f"| {link} % | {policy} | " + " | ".join(cells) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", required=True)
    parser.add_argument("--worlds", nargs="+", default=["plains"])
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    os.makedirs(arguments.out, exist_ok=True)
    seeds = range(1, arguments.seeds + 1)
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for world in arguments.worlds:
            list(pool.map(lambda seed, world=world: render(arguments.out, world, seed), seeds))
            flights = [(seed, policy, link) for seed in seeds for link in LINKS for policy in POLICIES]
            list(pool.map(lambda flight, world=world: fly(arguments.out, world, *flight), flights))
    print_tables(arguments.out, arguments.worlds, seeds)


if __name__ == "__main__":
    main()
