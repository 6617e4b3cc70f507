#!/usr/bin/python3 -B
"""Merges a downlink in tasks: the results are those of ilp-ground, byte by byte, in any number of tasks.

One process at a time keeps the catalogue: it plans the work, tasks do it from files and leave files, and the next plan takes
these in. What a task has not done is done by the process that follows. Further options are ilp-ground's.

Exit status: 0 merged, 2 something failed or wrong call, 128 + signal when interrupted."""

import argparse
import fcntl
import glob
import os
import shutil
import sys
import time

from command_line import Help
from tasks import Interrupted, Interruptible, Place, Slurm, TasksError, add_place_options, last_line, run_tasks, shell_line, unfinished

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__)))))
KINDS = ("looks", "tiles", "finish")
ATTEMPTS = 3
TASKS_OF_A_HOST, TASKS_ON_SLURM = 4, 16


def cores():
    return os.cpu_count() or 1


class Merge:
    def __init__(self, options, more):
        self.options, self.more = options, more
        self.out, self.folder = options.out, os.path.join(options.out, "tasks")
        self.count = options.tasks or self.usual_count()
        self.place = Place(options.slurm, options.slurm_options, options.hosts, max(1, cores() // options.threads))
        self.slurm = None

    def usual_count(self):
        if self.options.hosts:
            return TASKS_OF_A_HOST * len(self.options.hosts.split(","))
        return TASKS_ON_SLURM if self.options.slurm else cores()

    def ground(self, more):
        return [self.options.ground, self.options.outbox, "--out", self.out, *self.more, *more]

    def alone(self, name, command):
        """One process, which keeps the catalogue; on Slurm a job."""
        if self.slurm:
            self.slurm.run(shell_line(command, self.folder, name), [])
        else:
            run_tasks(lambda _: command, [name], self.folder, Place())
        if unfinished(self.folder, [name]):
            raise TasksError(f"{name} failed: {last_line(self.folder, name)}")

    def work(self, kind):
        numbers = list(range(1, 1 + len(glob.glob(os.path.join(glob.escape(self.out), "work", kind + "-*.work")))))
        folder = os.path.join(self.folder, kind)

        def command_of(number):
            return [self.options.ground, "work", os.path.join(self.out, "work", f"{kind}-{number}.work"), "--out", self.out,
                    "--threads", str(self.options.threads)]

        left = run_tasks(command_of, numbers, folder, self.place, self.slurm, ATTEMPTS)
        for number in left:
            print(f"task {number} of {kind} failed {ATTEMPTS} times ({last_line(folder, number)}): "
                  "the next step does what it has left", file=sys.stderr)
        return len(numbers)

    def run(self):
        for kind in KINDS:
            begin = time.monotonic()
            afresh = ["--afresh"] if self.options.afresh and kind == KINDS[0] else []
            self.alone(f"plan of {kind}", self.ground(["--plan", kind, "--tasks", str(self.count), *afresh]))
            planned = time.monotonic()
            tasks = self.work(kind)
            print(f"{kind}: {planned - begin:.1f} s to plan, {time.monotonic() - planned:.1f} s in {tasks} tasks", file=sys.stderr)
        begin = time.monotonic()
        self.alone("report", self.ground([]))
        print(f"report: {time.monotonic() - begin:.1f} s", file=sys.stderr)
        with open(os.path.join(self.folder, "report.txt"), encoding="utf-8", errors="replace") as stream:
            print(stream.read(), end="")


def merge(options, more):
    work = Merge(options, more)
    work.place.check()
    os.makedirs(work.folder, exist_ok=True)
    with open(os.path.join(work.folder, "lock"), "w", encoding="utf-8") as lock, Interruptible():
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise TasksError(f"another merge works in {options.out}") from None
        if options.slurm:
            with Slurm("merge-" + os.path.basename(options.out), work.folder, options.slurm_options) as work.slurm:
                work.run()
        else:
            work.run()
    shutil.rmtree(work.folder)


def thread_count(text):
    count = int(text)
    if not 1 <= count <= 1024:
        raise ValueError
    return count


def joined(words):
    """--slurm-options and its value in one word, because the value may begin with a dash."""
    words = list(words)
    while "--slurm-options" in words[:-1]:
        at = words.index("--slurm-options")
        words[at:at + 2] = ["--slurm-options=" + words[at + 1]]
    return words


def parse():
    # Options of ilp-ground are no mistakes here.
    parser = argparse.ArgumentParser(prog="ilp-ground merge", description=__doc__, formatter_class=Help, allow_abbrev=False,
                                     epilog="Example: ilp-ground merge flight/outbox --out ground --tasks 4")
    parser.add_argument("outbox", help="folder with the files that came down")
    parser.add_argument("--out", required=True, help="folder for the results")
    parser.add_argument("--afresh", action="store_true", help="forget everything that earlier runs read and computed there")
    parser.add_argument("--threads", type=thread_count, default=1, help="threads of a task")
    parser.add_argument("--ground", default=os.path.join(ROOT, "build", "host", "bin", "ilp-ground"), help="path of ilp-ground")
    add_place_options(parser)
    options, more = parser.parse_known_args(joined(sys.argv[1:]))
    options.outbox, options.out, options.ground = map(os.path.abspath, (options.outbox, options.out, options.ground))
    return options, more


def main():
    try:
        merge(*parse())
        return 0
    except Interrupted as interrupted:
        print("Interrupted: the same command goes on where this one stopped", file=sys.stderr)
        return interrupted.status
    except (TasksError, OSError) as error:
        print(f"merge: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
