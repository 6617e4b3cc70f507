"""A campaign in slices: each task of a cluster flies every Nth flight into the flights' own folders, and one report follows.

What a flight gives depends on its arguments and the programs alone, so that a campaign has the same results in any number of
tasks. A task that dies leaves some of its flights without a result, and the same command submits only such tasks again."""

import fcntl
import os
import sys

from campaign_file import CampaignError
from flights import Scheduler, counted
from metrics import SIM

sys.path.insert(0, os.path.join(SIM, "tools", "cluster"))
from tasks import (MOST_TASKS, Interrupted, Interruptible, Place, Slurm, TasksError, add_place_options, array_line,  # noqa: E402
                   array_option, forget, last_line, run_tasks, shell_line, unfinished)

FLIGHTS_OF_A_TASK = 8  # starting a task takes about a second, a flight some seconds to minutes
TASKS_OF_A_HOST = 4  # a fast host takes over from a slow one


def slice_of(text):
    """(K, N) of "K/N"."""
    number, _, count = text.partition("/")
    if not 1 <= int(number) <= int(count) <= MOST_TASKS:
        raise ValueError
    return int(number), int(count)


def flights_of(jobs, number, count):
    return jobs[number - 1::count]


def fly_slice(campaign, jobs, options):
    """0 when each flight of the slice has a result, be it a failure."""
    number, count = options.slice
    if not os.path.isdir(os.path.join(options.out, "jobs")):
        raise CampaignError(f"{options.out} is no campaign's folder: the command without --slice creates it")
    with open(os.path.join(options.out, f".lock-{number}-of-{count}"), "w", encoding="utf-8") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise CampaignError(f"another process flies slice {number} of {count} in {options.out}") from None
        ended_by = Scheduler(campaign, flights_of(jobs, number, count), options).run()
        return 128 + ended_by if ended_by else 0


def task_number(jobs, options):
    if options.tasks:
        return min(options.tasks, len(jobs))
    if options.hosts:
        return min(TASKS_OF_A_HOST * len(options.hosts.split(",")), len(jobs), MOST_TASKS)
    return min(-(-len(jobs) // FLIGHTS_OF_A_TASK), MOST_TASKS)


def own_command(options, more):
    """This program as another machine starts it."""
    words = [sys.executable, "-B", os.path.abspath(sys.argv[0]), os.path.abspath(options.file), "--out", options.out,
             "--sil", os.path.abspath(options.sil), "--score", os.path.abspath(options.score),
             "--lab", os.path.abspath(options.lab), *more]
    words += ["--jobs", str(options.jobs)] if options.jobs else []
    words += ["--keep"] if options.keep else []
    return words


class TasksOfCampaign:
    def __init__(self, campaign, jobs, options):
        self.campaign, self.jobs, self.options = campaign, jobs, options
        self.count = task_number(jobs, options)
        self.folder = os.path.join(options.out, "tasks")
        os.makedirs(self.folder, exist_ok=True)

    def slice_command(self, number):
        return own_command(self.options, ["--slice", f"{number}/{self.count}"] + ["--retry-failed"] * self.options.retry_failed)

    def report_command(self):
        return own_command(self.options, ["--report"])

    def without_result(self):
        """Numbers of the tasks that have something to fly."""
        scheduler = Scheduler(self.campaign, self.jobs, self.options)
        scheduler.name_strangers()
        return sorted({i % self.count + 1 for i in scheduler.take_earlier_results()})

    def run_on_slurm(self, numbers, slurm):
        """The array, and the report as a job that waits for it."""
        after = []
        forget(self.folder, [*numbers, "report"])
        if numbers:
            array = slurm.submit(array_line(self.slice_command, self.folder), [array_option(numbers)])
            after = [f"--dependency=afterany:{array}"]
            print(f"Slurm job {array} has {counted(len(numbers), 'task')}", file=sys.stderr)
        slurm.run(shell_line(self.report_command(), self.folder, "report"), after)
        if not os.path.exists(os.path.join(self.options.out, "report.html")):
            raise CampaignError("the job that writes the report failed: " + last_line(self.folder, "report"))

    def name_unfinished(self, numbers):
        for number in unfinished(self.folder, numbers):
            names = [job.name for job in flights_of(self.jobs, number, self.count)
                     if not os.path.exists(os.path.join(self.options.out, "jobs", job.name, "result.json"))]
            print(f"task {number} of {self.count} did not end ({last_line(self.folder, number)}); without a result: "
                  f"{', '.join(names) or 'no flight'}. The same command repeats it alone.", file=sys.stderr)


def fly_in_tasks(campaign, jobs, options):
    """Leaves the results of the flights in their folders, and names the tasks that died. On Slurm a job writes the report too,
    so that it is written even if this process does not live until then."""
    place = Place(options.slurm, options.slurm_options, options.hosts)
    place.check()
    tasks = TasksOfCampaign(campaign, jobs, options)
    numbers = tasks.without_result()
    print(f"{counted(len(jobs), 'flight')} in {counted(tasks.count, 'task')}, {tasks.count - len(numbers)} of them done before",
          file=sys.stderr)
    with Interruptible():
        if options.slurm:
            with Slurm("campaign-" + campaign.name, tasks.folder, place.slurm_options) as slurm:
                tasks.run_on_slurm(numbers, slurm)
        else:
            run_tasks(tasks.slice_command, numbers, tasks.folder, place)
    tasks.name_unfinished(numbers)
