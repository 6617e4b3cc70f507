"""Flies a strip on the deterministic board, where time is the number of instructions, and prints the instructions of each component.

The board has no disk and no network, because it would wait for their answers for as long as the host takes. The strip
is in its first file system, the database is in memory, and the flight runs in virtual time. Two runs print the same to
the last digit, whatever else the host does."""
import os
import re
import sys

import board as rig
import fly
import images
import strip as strips

NS_PER_INSTRUCTION = 4
LONGEST_RUN_S = 3600


def parse():
    made = fly.parser("instructions", __doc__)
    made.add_argument("--runs", type=int, default=2, help="number of runs that have to agree (2)")
    return made.parse_args()


def commands(strip):
    return ("run ilp-onboard --virtual-time --index /flight/index.txt "
            f'--camera "{strip.camera()}" --database /tmp/flight.db --outbox /flight/outbox '
            "--acknowledgements /flight/acknowledged --mission /flight/mission.ini --trap-heap\n"
            "run figures /tmp/flight.db\n")


def boot_images(options, strip):
    flight = {"run": commands(strip).encode(), "outbox/.keep": b"", "acknowledged/.keep": b"",
              "mission.ini": fly.mission_text(options.mission, "").encode()}
    index = ""
    for time_ns, path in strip.frames:
        name = "images/" + os.path.basename(path)
        flight[name] = path
        index += f"{time_ns} {name}\n"
    flight["index.txt"] = index.encode()
    return images.with_flight(images.built(options.images), flight, os.path.join(options.out, "initramfs.cpio"))


def run(boot, log):
    """What the console said, without the host's times."""
    with rig.Board(boot, log, deterministic=True) as board:
        board.wait_until_off(LONGEST_RUN_S)
        ended = [match[1] for match in board.lines(r"^board: .* ended (.*)$")]
        if ended != ["with 0", "with 0"]:
            raise rig.BoardError(f"the flight did not end well:\n{board.tail()}")
        return [text for _, text in board.console]


def table(console):
    text = "\n".join(console)
    keyframes = int(re.search(r"^frames \d+ keyframes (\d+)$", text, re.M)[1])
    rows = re.findall(r"^component (\S+) steps (\d+) busy_ns (\d+) longest_ns (\d+) overruns \d+$", text, re.M)
    total = sum(int(row[2]) for row in rows)
    print("| component | steps | instructions, millions | share | per keyframe, millions | longest step, millions |")
    print("|---|---|---|---|---|---|")
    for name, steps, busy, longest in rows:
        count, most = int(busy) / NS_PER_INSTRUCTION / 1e6, int(longest) / NS_PER_INSTRUCTION / 1e6
        print(f"| `{name}` | {steps} | {count:.1f} | {100 * int(busy) / total:.1f} % | {count / keyframes:.1f} "
              f"| {most:.1f} |")
    total_millions = total / NS_PER_INSTRUCTION / 1e6
    print(f"| **all** | | **{total_millions:.1f}** | | **{total_millions / keyframes:.1f}** | |")


def main():
    options = parse()
    os.makedirs(options.out)
    strip = strips.Strip(options.strip) if options.strip else strips.render(
        fly.host_program("ilp-sil"), os.path.join(options.out, "simulated"), options.frames, options.set)
    boot = boot_images(options, strip)
    consoles = [run(boot, os.path.join(options.out, f"console-{i + 1}.log")) for i in range(options.runs)]
    same = all(console == consoles[0] for console in consoles)
    table(consoles[0])
    print(f"{options.runs} runs, {len(consoles[0])} lines of console each: {'the same' if same else 'DIFFERENT'}")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
