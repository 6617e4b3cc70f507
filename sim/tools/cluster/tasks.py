"""Runs the numbered tasks of a piece of work: as processes of this machine, as an array of Slurm, or over ssh by GNU parallel.

A task is a command. All machines see its programs and files under the same paths. A task that ends with status 0 leaves an
empty file NUMBER.done in the folder of the tasks, where NUMBER.txt is what it printed; nothing else says that it succeeded, so
that the three ways of running tasks are judged alike, and a killed task is known by the missing file."""

import os
import shlex
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, field

MOST_TASKS = 1000  # Slurm's MaxArraySize is 1001 where nobody has changed it
ARRAY_NUMBER = "{the number of the task}"


class TasksError(Exception):
    """What is wrong, for the person who started the tasks."""


@dataclass
class Place:
    """Where tasks run: on this machine, unless `slurm` or `hosts` says otherwise."""
    slurm: bool = False
    slurm_options: list = field(default_factory=list)  # for sbatch
    hosts: str = ""  # as GNU parallel takes them: a list with commas, or : for this machine
    at_a_time: int = 1  # on this machine

    def check(self):
        if self.slurm and self.hosts:
            raise TasksError("either --slurm or --hosts, not both")
        for wanted, program, package in ((self.slurm, "sbatch", "Slurm"), (self.hosts, "parallel", "GNU parallel")):
            if wanted and not shutil.which(program):
                raise TasksError(f"there is no program {program}: {package} is not installed on this machine")


def add_place_options(parser):
    parser.add_argument("--slurm", action="store_true", help="submit the tasks to Slurm as an array, and wait for them")
    parser.add_argument("--slurm-options", type=shlex.split, default=[], metavar="OPTIONS",
                        help='options for every sbatch, such as "--partition=long --cpus-per-task=4 --mem=2G"')
    parser.add_argument("--hosts", default="", help="run the tasks on these hosts by GNU parallel over ssh: A,B,C, or : for this machine")
    parser.add_argument("--tasks", type=task_count, help=f"number of tasks, 1 to {MOST_TASKS}")


def task_count(text):
    count = int(text)
    if not 1 <= count <= MOST_TASKS:
        raise ValueError
    return count


class Interrupted(BaseException):
    """By a signal; `status` is the exit status that says so."""

    def __init__(self, number):
        super().__init__()
        self.status = 128 + number


def raise_interrupted(number, _):
    raise Interrupted(number)


class Interruptible:
    """SIGINT, SIGTERM and SIGHUP raise Interrupted."""

    def __enter__(self):
        self.before = {number: signal.signal(number, raise_interrupted) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}

    def __exit__(self, *_):
        for number, handler in self.before.items():
            signal.signal(number, handler)


def quoted(word):
    """For the shell, which replaces ARRAY_NUMBER by the number of the task."""
    return '"$SLURM_ARRAY_TASK_ID"'.join(shlex.quote(part) if part else "" for part in word.split(ARRAY_NUMBER)) or "''"


def shell_line(command, folder, number):
    """The command as one line of shell that leaves the files of a task."""
    done, log = (quoted(os.path.join(folder, f"{number}.{kind}")) for kind in ("done", "txt"))
    return f"rm -f {done}; ({' '.join(map(quoted, command))}) </dev/null >{log} 2>&1 && : >{done}"


def unfinished(folder, numbers):
    return [number for number in numbers if not os.path.exists(os.path.join(folder, f"{number}.done"))]


def forget(folder, numbers):
    for number in numbers:
        if os.path.exists(os.path.join(folder, f"{number}.done")):
            os.remove(os.path.join(folder, f"{number}.done"))


def last_line(folder, number):
    """What a task said last, for people."""
    path = os.path.join(folder, f"{number}.txt")
    if not os.path.exists(path):
        return "it has printed nothing"
    with open(path, encoding="utf-8", errors="replace") as stream:
        lines = stream.read()[-2000:].strip().split("\n")
    return lines[-1] or "it has printed nothing"


class Slurm:
    """Submits jobs, waits for them, and cancels them when it is interrupted. `folder` remembers them, so that a later command
    does not begin the same work while they are still there."""

    def __init__(self, name, folder, options):
        self.name, self.options = name, options
        self.memory = os.path.join(folder, "slurm-jobs.txt")
        self.jobs = []
        self.refuse_running()

    def refuse_running(self):
        if not os.path.exists(self.memory):
            return
        with open(self.memory, encoding="utf-8") as stream:
            jobs = stream.read().split()
        for job in jobs:
            there = subprocess.run(["squeue", "--noheader", "--jobs", job], capture_output=True, text=True)
            if there.returncode == 0 and there.stdout.strip():
                raise TasksError(f"job {job} of an earlier command still works here: wait for it, or end it with scancel {job}")

    def command(self, line, more):
        return ["sbatch", "--parsable", f"--job-name={self.name}", "--output=/dev/null", *more, *self.options, f"--wrap={line}"]

    def remember(self, job):
        self.jobs.append(job)
        with open(self.memory, "w", encoding="utf-8") as stream:
            stream.write("".join(job + "\n" for job in self.jobs))

    def submit(self, line, more):
        """The job's number; does not wait."""
        done = subprocess.run(self.command(line, more), capture_output=True, text=True)
        if done.returncode:
            raise TasksError(f"sbatch: {done.stderr.strip()}")
        self.remember(done.stdout.strip().partition(";")[0])
        return self.jobs[-1]

    def run(self, line, more):
        """Waits for the job and all of its tasks; the exit status, the highest of all tasks."""
        process = subprocess.Popen(self.command(line, ["--wait", *more]), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        job = process.stdout.readline().strip().partition(";")[0]
        if job:
            self.remember(job)
        _, messages = process.communicate()
        if not job:
            raise TasksError(f"sbatch: {messages.strip()}")
        return process.returncode

    def cancel(self):
        if self.jobs:
            subprocess.run(["scancel", *self.jobs], capture_output=True)

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        if kind is not None:
            self.cancel()


def array_line(command_of, folder):
    """One line for all tasks of an array: Slurm puts the number of the task into the environment."""
    return shell_line(command_of(ARRAY_NUMBER), folder, ARRAY_NUMBER)


def array_option(numbers):
    return "--array=" + ",".join(map(str, numbers))


def run_hosts(command_of, numbers, folder, hosts):
    """Each host runs one task at a time; a task that fails, or whose host is gone, is tried again on another one."""
    lines = "".join(shell_line(command_of(number), folder, number) + "\n" for number in numbers)
    # The lines are for the shell of the standard, whatever shell the user has on a host or here.
    process = subprocess.Popen(["parallel", "--sshlogin", hosts, "--jobs", "1", "--retries", "3", "--will-cite"],
                               stdin=subprocess.PIPE, text=True, env={**os.environ, "PARALLEL_SHELL": "/bin/sh"})
    try:
        process.communicate(lines)
    except BaseException:
        for _ in range(2):  # the first lets running tasks end, the second ends them
            process.terminate()
            time.sleep(0.2)
        process.wait()
        raise


def run_here(command_of, numbers, folder, at_a_time):
    waiting, running = list(numbers), {}
    try:
        while waiting or running:
            while waiting and len(running) < at_a_time:
                number = waiting.pop(0)
                running[number] = subprocess.Popen(["bash", "-c", shell_line(command_of(number), folder, number)],
                                                   start_new_session=True)
            os.waitid(os.P_ALL, 0, os.WEXITED | os.WNOWAIT)
            running = {number: process for number, process in running.items() if process.poll() is None}
    finally:
        for process in running.values():
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def run_tasks(command_of, numbers, folder, place, slurm=None, attempts=1):
    """Runs command_of(number), a list of words, for each of the numbers. Tasks that fail are repeated, alone, until each has
    been tried `attempts` times. Returns the numbers of those that never succeeded."""
    os.makedirs(folder, exist_ok=True)
    left = list(numbers)
    forget(folder, left)
    for attempt in range(attempts):
        if not left:
            break
        if attempt:
            print(f"repeating {len(left)} of {len(numbers)} tasks: {', '.join(map(str, left))}", file=sys.stderr)
        if slurm:
            slurm.run(array_line(command_of, folder), [array_option(left)])
        elif place.hosts:
            run_hosts(command_of, left, folder, place.hosts)
        else:
            run_here(command_of, left, folder, place.at_a_time)
        left = unfinished(folder, left)
    return left
