"""All flights of a campaign in parallel processes, each scored, resumable."""

import ctypes
import hashlib
import json
import math
import os
import re
import resource
import shlex
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, field

from campaign_file import CampaignError, is_scenario_file

VERSION = 1
LARGEST_SCORE = 64 << 20
ENDING_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
HELD_SIGNALS = (signal.SIGCHLD, *ENDING_SIGNALS)
# The machine shuts down, or somebody ran out of patience or memory: no property of the flight.
SIGNALS_FROM_OUTSIDE = (*ENDING_SIGNALS, signal.SIGKILL)
INHERITED_VARIABLES = ("PATH", "HOME", "TMPDIR", "LD_LIBRARY_PATH", "ASAN_OPTIONS", "UBSAN_OPTIONS")
PR_SET_PDEATHSIG = 1
libc = ctypes.CDLL(None, use_errno=True)


@dataclass
class Result:
    failure: str = ""  # empty: the job has a score
    complete: bool = False
    summary: dict = field(default_factory=dict)  # None: not known
    remarks: list = field(default_factory=list)
    digest: str = ""  # of all that the result depends on; empty: not to be relied on, run again
    seconds: float = 0  # wall clock, of flight and score together


def write_file(path, text):
    """Whole or not at all."""
    try:
        with open(path + ".part", "w", encoding="utf-8", errors="surrogateescape") as stream:
            stream.write(text)
        os.replace(path + ".part", path)
    except OSError as error:
        raise CampaignError(f"cannot write {path}: {error.strerror}") from error


def bytes_of(path):
    with open(path, "rb") as stream:
        return stream.read()


def tail_of(path, size):
    """The last lines of a file, at most `size` bytes of them; empty when there is none."""
    text = bytes_of(path) if os.path.exists(path) else b""
    tail = text[-size:].partition(b"\n")[2] if len(text) > size else text
    return tail.decode("utf-8", "surrogateescape")


def parsed(path):
    """The JSON object in a file; ValueError says what is wrong with it."""
    name = os.path.basename(path)
    if not os.path.isfile(path):
        raise ValueError(f"no {name}")
    if os.path.getsize(path) > LARGEST_SCORE:
        raise ValueError(f"{name} is larger than 64 MiB")
    try:
        content = json.loads(bytes_of(path))
    except (ValueError, RecursionError):
        raise ValueError(f"{name} is not JSON") from None
    if not isinstance(content, dict):
        raise ValueError(f"{name} is not a JSON object")
    if content.get("version") != VERSION:
        raise ValueError(f'{name}: expected "version": {VERSION}')
    return content


def take_score(content, name, result):
    """Fills a result from a score; ValueError says what is wrong with it."""
    def member(key, kind, expected):
        if not isinstance(content.get(key), kind):
            raise ValueError(f'{name}: expected "{key}" to be {expected}')
        return content[key]

    result.complete = member("complete", bool, "true or false")
    for key, value in member("summary", dict, "an object").items():
        if value is not None and (isinstance(value, bool) or not isinstance(value, (int, float))):
            raise ValueError(f'{name}: expected "summary" "{key}" to be a number or null')
        result.summary[key] = float(value) if value is not None and math.isfinite(value) else None
    if "remarks" in content:
        result.remarks = [r if isinstance(r, str) else json.dumps(r) for r in member("remarks", list, "a list")]


def earlier_result(path):
    """None where there is no file or not a whole one."""
    try:
        content = parsed(path)
        result = Result(content["failure"], digest=content["digest"], seconds=float(content["seconds"]))
        take_score(content, "result.json", result)
        return result
    except (ValueError, KeyError, TypeError, OSError):
        return None


def cores():
    """That this process may use: what Slurm has given to a job, otherwise all of the machine."""
    granted = os.environ.get("SLURM_CPUS_ON_NODE", "")
    return int(granted) if granted.isdigit() and int(granted) > 0 else os.cpu_count() or 1


def remove_folder(folder):
    # Programs of a campaign that was killed may need a moment to die, and write meanwhile.
    for attempt in range(20):
        shutil.rmtree(folder, ignore_errors=True)
        if not os.path.lexists(folder):
            return
        time.sleep(0.1)
    raise CampaignError(f"cannot remove {folder}")


def start_program(command, folder, log):
    """A process group of its own that dies with this process. It inherits no open files, no blocked signals, and of the
    environment only where programs, libraries and temporary files are; it leaves no core file."""
    parent = os.getpid()

    def before_exec():
        signal.pthread_sigmask(signal.SIG_SETMASK, ())
        os.setpgid(0, 0)
        libc.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if os.getppid() != parent:
            os._exit(127)

    environment = {name: os.environ[name] for name in INHERITED_VARIABLES if name in os.environ}
    try:
        with open(log, "ab") as stream:
            return subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=stream, stderr=subprocess.STDOUT, cwd=folder,
                                    env={**environment, "LC_ALL": "C"}, preexec_fn=before_exec)
    except (OSError, subprocess.SubprocessError) as error:
        raise CampaignError(f"cannot start {command[0]}: {getattr(error, 'strerror', None) or error}") from error


def kill_program(process):
    """Kills the whole group, whether or not the program itself has ended, and waits for the program."""
    try:
        os.killpg(process.pid, signal.SIGKILL)
    except ProcessLookupError:
        pass
    return process.wait()


# Of ilp-sil: a flight in which no keyframe has a pose. It is scored all the same.
WITHOUT_POSES = 3


class JobRun:
    """One job from its empty folder to its result: the map that it carries, if any, the flight, then its score, each a
    process of its own.

    The folder holds command.txt, log.txt, and in the end result.json, written last; of a scored flight also score.json and
    flight-info.json. The flight's own folder is `run` below it: removed once scored, there for inspection if not."""

    def __init__(self, job, folder, scheduler, digest):
        self.folder, self.scheduler, self.digest = folder, scheduler, digest
        self.begin = time.monotonic()
        self.deadline = self.begin + scheduler.campaign.timeout_s
        self.log, self.run = os.path.join(folder, "log.txt"), os.path.join(folder, "run")
        self.result = None
        remove_folder(folder)
        os.makedirs(folder)
        fly = [scheduler.sil, *job.arguments(), "--out", self.run, "--threads", str(scheduler.threads)]
        self.commands = [fly, [scheduler.score, self.run]]
        if job.map:
            chart = os.path.join(folder, "map")
            self.commands.insert(0, [scheduler.lab, *job.map_arguments(), "--out", chart])
            fly += ["--map", chart]
        write_file(os.path.join(folder, "command.txt"), "".join(shlex.join(words) + "\n" for words in self.commands))
        self.start()

    def start(self):
        self.command = self.commands.pop(0)
        try:
            self.process = start_program(self.command, self.scheduler.campaign.folder(), self.log)
        except CampaignError as error:
            self.finish(Result(str(error)))

    def step(self):
        """Never waits. The result, or None while the job runs."""
        if self.result:
            return self.result
        program = os.path.basename(self.command[0])
        ended = os.waitid(os.P_PID, self.process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT)
        if not ended and time.monotonic() < self.deadline:
            return None
        status = kill_program(self.process)
        if not ended:
            limit = duration_text(self.scheduler.campaign.timeout_s)
            self.finish(Result(f"{program} ran past the limit of {limit}"))
        elif status < 0:
            if -status in SIGNALS_FROM_OUTSIDE:
                self.digest = ""
            self.finish(Result(f"{program} killed by signal {-status} ({signal.strsignal(-status) or 'unknown'})"))
        elif status > 0 and not (status == WITHOUT_POSES and len(self.commands) == 1):
            last = tail_of(self.log, 1000).rstrip().rpartition("\n")[2]
            reason = re.sub(r"[^ -~]", "?", last)[:400]
            self.finish(Result(f"{program} ended with status {status}" + (f": {reason}" if reason else "")))
        elif self.commands:
            self.start()
        else:
            self.collect(program)
        return self.result

    def collect(self, program):
        result = Result()
        try:
            take_score(parsed(os.path.join(self.run, "score.json")), "score.json", result)
        except ValueError as error:
            return self.finish(Result(f"{program} left a bad score: {error}"))
        for name in ("score.json", "flight-info.json"):
            if os.path.isfile(os.path.join(self.run, name)):
                shutil.copyfile(os.path.join(self.run, name), os.path.join(self.folder, name))
        if not self.scheduler.keep:
            remove_folder(self.run)
            remove_folder(os.path.join(self.folder, "map"))
        return self.finish(result)

    def finish(self, result):
        result.digest, result.seconds = self.digest, time.monotonic() - self.begin
        content = {"version": VERSION, **vars(result)}
        write_file(os.path.join(self.folder, "result.json"), json.dumps(content, indent=2) + "\n")
        self.result = result


def duration_text(seconds):
    return f"{seconds:.1f} s" if seconds < 120 else f"{seconds / 60:.1f} min"


def counted(count, noun):
    return f"{count} {noun}" + ("" if count == 1 else "s")


class Progress:
    """Where a campaign stands: one line that is overwritten on a terminal, elsewhere a line for each tenth of the work."""

    def __init__(self, total, before, parallel):
        self.total, self.before, self.done, self.failed = total, before, 0, 0
        self.terminal, self.begin = sys.stderr.isatty(), time.monotonic()
        self.say(counted(total, "flight") + (f", {before} done before" if before else "") + f", {parallel} at a time")

    def say(self, text, end="\n"):
        print(("\r\033[K" if self.terminal else "") + text, end=end, file=sys.stderr, flush=True)

    def text(self):
        line = f"{self.before + self.done}/{self.total} done" + (f", {self.failed} failed" if self.failed else "")
        left = self.total - self.before - self.done
        if not self.done or not left:
            return line
        return line + f", about {duration_text((time.monotonic() - self.begin) / self.done * left)} left"

    def ended(self, job, failure):
        tenths = (self.before + self.done) * 10 // self.total
        self.done += 1
        if failure:
            self.failed += 1
            self.say(f"failed: {job}: {failure}")
        if not self.terminal and (self.before + self.done) * 10 // self.total > tenths:
            self.say(self.text())

    def tick(self, running):
        if self.terminal:
            self.say(f"{self.text()} ({running} running)", end="")

    def close(self):
        if self.terminal:
            self.say("", end="")


class Scheduler:
    """Runs the flights that have no result with the same inputs: arguments, the files that they name, and both programs.
    SIGINT, SIGTERM and SIGHUP stop it within moments, and no process is left running."""

    def __init__(self, campaign, jobs, options):
        self.campaign, self.jobs, self.folder = campaign, jobs, os.path.join(options.out, "jobs")
        # A slice is alone on its cores, so the file's number of flights at a time, which is a machine's, is only a limit.
        self.parallel = options.jobs or (min(campaign.jobs or cores(), cores()) if options.slice else campaign.jobs or cores())
        self.threads = max(1, cores() // self.parallel)
        self.sil, self.score, self.keep = self.program(options.sil), self.program(options.score), options.keep
        self.lab = self.program(options.lab) if any(job.map for job in jobs) else ""
        self.retry_failed = options.retry_failed
        programs = hashlib.sha256(bytes_of(self.sil) + bytes_of(self.score) + (bytes_of(self.lab) if self.lab else b""))
        self.digests = [self.inputs_digest(job, programs.copy()) for job in jobs]
        self.results = [None] * len(jobs)

    @staticmethod
    def program(path):
        if not os.path.isfile(path):
            raise CampaignError(f"there is no program {path}")
        return os.path.realpath(path)

    def inputs_digest(self, job, state):
        """Everything that a job's numbers depend on; the time limit, plots and columns are no part of it. Of a file that is
        named, the bytes."""
        state.update("\0".join(job.arguments() + job.map_arguments()).encode("utf-8", "surrogateescape"))
        named = ([job.scenario] if is_scenario_file(job.scenario) else []) + list(job.settings.values())
        for path in (os.path.join(self.campaign.folder(), name) for name in named):
            if os.path.isfile(path):
                state.update(bytes_of(path))
        return state.hexdigest()[:16]

    def take_earlier_results(self):
        pending, changed = [], 0
        for i, job in enumerate(self.jobs):
            earlier = earlier_result(os.path.join(self.folder, job.name, "result.json"))
            same = earlier is not None and earlier.digest == self.digests[i]
            changed += earlier is not None and not same and earlier.digest != ""
            if same and not (earlier.failure and self.retry_failed):
                self.results[i] = earlier
            else:
                pending.append(i)
        if changed:
            print(counted(changed, "earlier result"), "had other parameters or programs: run again", file=sys.stderr)
        return pending

    def name_strangers(self):
        strangers = len(set(os.listdir(self.folder)) - {job.name for job in self.jobs})
        if strangers:
            print(counted(strangers, "folder"), "in", self.folder, "of no flight of this campaign: left alone",
                  file=sys.stderr)

    def run(self):
        """The signal that ended it, or 0. `results` has None for what was not run."""
        pending, running, ended_by = self.take_earlier_results(), {}, 0
        progress = Progress(len(self.jobs), len(self.jobs) - len(pending), self.parallel)
        signal.pthread_sigmask(signal.SIG_BLOCK, HELD_SIGNALS)
        try:
            while not ended_by and (pending or running):
                while pending and len(running) < self.parallel:
                    i = pending.pop(0)
                    folder = os.path.join(self.folder, self.jobs[i].name)
                    running[i] = JobRun(self.jobs[i], folder, self, self.digests[i])
                progress.tick(len(running))
                wake = min([time.monotonic() + 1] + [0 if run.result else run.deadline for run in running.values()])
                caught = signal.sigtimedwait(HELD_SIGNALS, max(0, wake - time.monotonic()))
                ended_by = caught.si_signo if caught and caught.si_signo != signal.SIGCHLD else 0
                for i in [i for i, run in running.items() if run.step()]:
                    self.results[i] = running.pop(i).result
                    progress.ended(self.jobs[i].name, self.results[i].failure)
        finally:
            for run in running.values():
                if not run.result:
                    kill_program(run.process)
            progress.close()
        return ended_by
