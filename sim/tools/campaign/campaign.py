#!/usr/bin/python3 -B
"""Flies a campaign: a grid of simulated flights in parallel processes, each scored; resumable. The flights run on this machine,
as an array of Slurm, or on several hosts."""

import argparse
import fcntl
import os
import subprocess
import sys

from campaign_file import CampaignError, expand, read_campaign
from flights import Scheduler, bytes_of, counted, write_file
from metrics import SIM
from report import write_report
from slices import Interrupted, TasksError, add_place_options, fly_in_tasks, fly_slice, slice_of
from command_line import Parser


def take_folder(campaign, out):
    """Creates the folder and keeps a copy of the campaign file there. Refuses a folder that is another campaign's, somebody
    else's, or not writable."""
    name_file = os.path.join(out, "campaign-name.txt")
    if os.path.lexists(out) and not (os.path.isdir(out) and not os.listdir(out)):
        if not os.path.isfile(name_file):
            raise CampaignError(f"{out} holds other things: expected a new or empty folder, or this campaign's")
        owner = bytes_of(name_file).decode("utf-8", "surrogateescape").rstrip("\n")
        if owner != campaign.name:
            raise CampaignError(f'{out} holds the campaign "{owner}", not "{campaign.name}"')
    os.makedirs(os.path.join(out, "jobs"), exist_ok=True)
    write_file(name_file, campaign.name + "\n")


def open_folder(campaign, out):
    """Takes the folder and locks it until the file that is returned is closed. Refuses a folder that is locked."""
    try:
        take_folder(campaign, out)
        lock = open(os.path.join(out, ".lock"), "w", encoding="utf-8")
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise CampaignError(f"another run of this campaign works in {out}") from None
        write_file(os.path.join(out, "campaign.ini"), bytes_of(campaign.file).decode("utf-8", "surrogateescape"))
        return lock
    except OSError as error:
        raise CampaignError(f"cannot work in {out}: {error.strerror}") from error


def tell_end(results):
    """The exit status of a campaign that was not interrupted."""
    failed = sum(result is not None and bool(result.failure) for result in results)
    not_run = sum(result is None for result in results)
    if failed:
        print(failed, "of", counted(len(results), "flight"), "failed", file=sys.stderr)
    if not_run:
        print(not_run, "of", counted(len(results), "flight"), "have no result", file=sys.stderr)
    return 1 if failed or not_run else 0


def fly_here(campaign, jobs, options):
    scheduler = Scheduler(campaign, jobs, options)
    scheduler.name_strangers()
    ended_by = scheduler.run()
    write_report(campaign, jobs, scheduler.results, options.out)
    if ended_by:
        print("Interrupted: the same command goes on where this one stopped", file=sys.stderr)
        return 128 + ended_by
    return tell_end(scheduler.results)


def report_only(campaign, jobs, options):
    """The report of the flights that have a result; also what a campaign in tasks ends with."""
    options.retry_failed = False
    scheduler = Scheduler(campaign, jobs, options)
    scheduler.take_earlier_results()
    write_report(campaign, jobs, scheduler.results, options.out)
    return tell_end(scheduler.results)


def fly(campaign, jobs, options):
    if options.slice:
        return fly_slice(campaign, jobs, options)
    if options.report:
        return report_only(campaign, jobs, options)
    with open_folder(campaign, options.out):
        if options.slurm or options.hosts:
            fly_in_tasks(campaign, jobs, options)
            status = report_only(campaign, jobs, options)
        else:
            status = fly_here(campaign, jobs, options)
        print("Report:", os.path.join(options.out, "report.html"), flush=True)
        return status


def at_a_time(text):
    count = int(text)
    if not 1 <= count <= 1024:
        raise ValueError
    return count


class Version(argparse.Action):
    """Says the version: of the sources that this file is a part of, or of the simulator that is installed with it."""

    def __call__(self, parser, namespace, values, option_string=None):
        of_sources = os.path.join(os.path.dirname(SIM), "bsp", "version", "of-sources")
        command = [of_sources, "campaign.py"] if os.path.exists(of_sources) else [namespace.sil, "--version"]
        try:
            sys.exit(subprocess.run(command, check=False).returncode)
        except OSError as error:
            parser.error(f"the version is unknown: {command[0]}: {error.strerror}; name the simulator with --sil first")


def parse():
    programs = os.path.join(os.path.dirname(SIM), "build", "host", "bin")
    parser = Parser(__doc__, "sim/campaign sim/campaigns/smoke.ini --out campaign",
                    "0 every flight has a score, 1 some failed or have no result, 2 the campaign cannot be flown,\n128 + signal interrupted")
    parser.add_argument("file", help="campaign file (sim/tools/campaign/campaign_file.py describes its form)")
    parser.add_argument("--out", help="folder of the campaign; an interrupted campaign continues there")
    parser.add_argument("--jobs", type=at_a_time, help="flights at a time (default: the number in the campaign file, or one per core)")
    parser.add_argument("--sil", default=os.path.join(programs, "ilp-sil"), help="path of ilp-sil")
    parser.add_argument("--score", default=os.path.join(programs, "ilp-score"), help="path of ilp-score")
    parser.add_argument("--lab", default=os.path.join(programs, "ilp-lab"), help="path of ilp-lab, which makes the maps of flights")
    parser.add_argument("--keep", action="store_true", help="keep images, truth, database and outbox of every flight")
    parser.add_argument("--retry-failed", action="store_true", help="run failed flights again")
    parser.add_argument("--list", action="store_true", help="print the flights and their arguments, and exit")
    parser.add_argument("--version", action=Version, nargs=0, help="say the version, and exit")
    add_place_options(parser)
    parser.add_argument("--slice", type=slice_of, metavar="K/N",
                        help="fly only every Nth flight from the Kth on, and write no report: what a task does")
    parser.add_argument("--report", action="store_true", help="fly nothing; write the report of the flights that have a result")
    return parser.parse_args()


def main():
    options = parse()
    try:
        campaign = read_campaign(options.file)
        jobs = expand(campaign)
        if options.list:
            for job in jobs:
                print(f"{job.name}: {' '.join(job.arguments())}" +
                      (f"; map: {' '.join(job.map_arguments())}" if job.map else ""))
            return 0
        if not options.out:
            raise CampaignError("--out DIR is needed: where the campaign leaves its results")
        options.out = os.path.abspath(options.out)
        return fly(campaign, jobs, options)
    except Interrupted as interrupted:
        print("Interrupted: the same command goes on where this one stopped", file=sys.stderr)
        return interrupted.status
    except (CampaignError, TasksError, OSError) as error:
        print(f"campaign: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
