"""Campaigns in tasks: the same report as from one run, and a task that dies is repeated alone.

campaign_tasks_test.py SUITE [ILP_SIL ILP_SCORE]. Slices needs nothing, Hosts needs GNU parallel, Sshd runs inside with_sshd, Slurm
and RealFlights run inside with_slurm. Stand-ins fly and score, except in RealFlights."""

import filecmp
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.path.join(ROOT, "sim", "tools", "campaign", "campaign.py")
SKIPPED = 77

FLIGHTS = "[campaign]\ncolumns = completeness\n[grid]\nscenario = a | b | c\nseed = 1..4\n[plot p]\nx = seed\ny = completeness\n"
# Fails scenario b with seed 3; the file `mishap` is run where there is one.
SIL = """#!/bin/bash
while [ $# -gt 0 ]; do case $1 in --out) out=$2 ;; --seed) seed=$2 ;; --scenario) scenario=$2 ;; esac; shift 2; done
echo "$scenario $seed" >>"$HERE/calls"
# A flight has none of its task's environment.
tr '\\0' '\\n' </proc/$PPID/environ | sed -n 's/^SLURMD_NODENAME=//p; s/^SSH_CONNECTION=[^ ]* [^ ]* \\([^ ]*\\) .*/\\1/p' >>"$HERE/places"
[ ! -e "$HERE/mishap" ] || . "$HERE/mishap"
mkdir "$out"
echo "$seed" >"$out/seed"
[ "$scenario$seed" != b3 ] || { echo "too low"; exit 4; }
"""
SCORE = """#!/bin/bash
echo "{\\"version\\": 1, \\"complete\\": true, \\"summary\\": {\\"completeness\\": 0.$(cat "$1/seed")}}" >"$1/score.json"
"""


def report_files(out):
    """All that a campaign says: tables, plots and the page. Times are in result.json of the flights only."""
    found = [os.path.join(folder, name) for folder, _, names in os.walk(out) for name in names]
    names = [os.path.relpath(path, out) for path in found]
    return sorted(name for name in names if name.split(os.sep)[0] in ("plots", "table.csv", "table.md", "report.html"))


class CampaignInTasks(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="campaign tasks ")  # with a blank, which commands have to quote
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.campaign = self.write("c.ini", FLIGHTS)
        self.sil = self.write("sil", SIL.replace("$HERE", self.folder), 0o755)
        self.score = self.write("score", SCORE, 0o755)

    def path(self, *parts):
        return os.path.join(self.folder, *parts)

    def write(self, name, text, mode=0o644):
        with open(self.path(name), "w", encoding="utf-8") as stream:
            stream.write(text)
        os.chmod(self.path(name), mode)
        return self.path(name)

    def command(self, out, *more):
        return [PROGRAM, self.campaign, "--out", self.path(out), "--sil", self.sil, "--score", self.score, *more]

    def run_campaign(self, out, *more, environment=None):
        done = subprocess.run(self.command(out, *more), capture_output=True, text=True, env={**os.environ, **(environment or {})})
        return done.returncode, done.stdout + done.stderr

    def calls(self):
        """The flights that were begun since the last time, sorted."""
        if not os.path.exists(self.path("calls")):
            return []
        with open(self.path("calls"), encoding="utf-8") as stream:
            lines = sorted(stream.read().split("\n")[:-1])
        os.remove(self.path("calls"))
        return lines

    def places(self):
        """Where flights were flown: the addresses of hosts, or the names of nodes."""
        with open(self.path("places"), encoding="utf-8") as stream:
            return set(stream.read().split())

    def fly_whole(self, status=1):
        end, messages = self.run_campaign("whole")
        self.assertEqual(end, status, messages)
        self.assertGreaterEqual(len(report_files(self.path("whole"))), 4)
        return self.calls()

    def assert_same_report(self, out):
        names = report_files(self.path("whole"))
        self.assertEqual(report_files(self.path(out)), names)
        _, different, unreadable = filecmp.cmpfiles(self.path("whole"), self.path(out), names, shallow=False)
        self.assertEqual((different, unreadable), ([], []))

    def comes_true(self, condition):
        for _ in range(600):
            if condition():
                return True
            time.sleep(0.1)
        return False


class Slices(CampaignInTasks):
    def begin(self, out):
        """A campaign's folder without any result."""
        os.makedirs(self.path(out, "jobs"))
        self.write(os.path.join(out, "campaign-name.txt"), "c\n")

    def test_slices_one_after_the_other_give_the_report_of_one_run(self):
        flights = self.fly_whole()
        for count in (1, 5, 12):
            out = f"of {count}"
            self.begin(out)
            for number in range(count, 0, -1):
                self.assertEqual(self.run_campaign(out, "--slice", f"{number}/{count}")[0], 0)
            self.assertEqual(self.calls(), flights)
            self.assertEqual(self.run_campaign(out, "--report")[0], 1)
            self.assertEqual(self.calls(), [])
            self.assert_same_report(out)

    def test_report_names_what_no_slice_has_flown(self):
        self.begin("part")
        self.assertEqual(self.run_campaign("part", "--slice", "2/3")[0], 0)
        status, messages = self.run_campaign("part", "--report")
        self.assertEqual(status, 1)
        self.assertIn("8 of 12 flights have no result", messages)

    def test_killed_slice_goes_on_with_the_flights_that_it_has_not_ended(self):
        self.begin("killed")
        self.write("mishap", f'[ "$seed" != 3 ] || kill -KILL $PPID\n')
        self.assertEqual(self.run_campaign("killed", "--slice", "1/2", "--jobs", "1")[0], -signal.SIGKILL)
        self.assertEqual(self.calls(), ["a 1", "a 3"])
        os.remove(self.path("mishap"))
        self.assertEqual(self.run_campaign("killed", "--slice", "1/2")[0], 0)
        self.assertEqual(self.calls(), ["a 3", "b 1", "b 3", "c 1", "c 3"])

    def test_what_is_no_slice_is_refused(self):
        for text in ("0/3", "4/3", "1", "1/0", "1/1001", "x/y"):
            self.assertEqual(self.run_campaign("bad", "--slice", text)[0], 2, text)


class Hosts(CampaignInTasks):
    def setUp(self):
        super().setUp()
        if not shutil.which("parallel"):
            self.skipTest("GNU parallel is not installed (Debian package parallel)")
        # Instead of ssh HOST COMMAND: `gone` answers as a host that is off, and the user's shell on the others runs nothing.
        ssh = self.write("ssh", '#!/bin/bash\nwhile [[ $1 = -* ]]; do shift; done\nhost=$1; shift; [ "$1" != -- ] || shift\n'
                         f'echo "$host" >>"{self.folder}/asked"\n[ "$host" != gone ] || exit 255\nexport SHELL=/bin/false\n'
                         'exec bash -c "$*"\n', 0o755)
        self.ssh = {"PARALLEL_SSH": f"'{ssh}'"}

    def test_hosts_give_the_report_of_one_run(self):
        flights = self.fly_whole()
        status, messages = self.run_campaign("hosts", "--hosts", "one,two", "--tasks", "5", environment=self.ssh)
        self.assertEqual(status, 1, messages)
        self.assertEqual(self.calls(), flights)
        self.assert_same_report("hosts")
        with open(self.path("asked"), encoding="utf-8") as stream:
            self.assertLessEqual({"one", "two"}, set(stream.read().split()))

    def test_other_hosts_fly_what_a_host_that_is_gone_should_have_flown(self):
        flights = self.fly_whole()
        status, messages = self.run_campaign("hosts", "--hosts", "gone,two", "--tasks", "4", environment=self.ssh)
        self.assertEqual(status, 1, messages)
        self.assertEqual(self.calls(), flights)
        self.assert_same_report("hosts")


class Sshd(CampaignInTasks):
    """GNU parallel over a real ssh."""

    def test_hosts_give_the_report_of_one_run(self):
        flights = self.fly_whole()
        self.write("mishap", "sleep 0.2\n")  # long enough for both hosts to get some
        status, messages = self.run_campaign("hosts", "--hosts", "127.0.0.2,127.0.0.3", "--tasks", "6")
        self.assertEqual(status, 1, messages)
        self.assertEqual(self.calls(), flights)
        self.assertEqual(self.places(), {"127.0.0.2", "127.0.0.3"})
        self.assert_same_report("hosts")

    def test_other_hosts_fly_what_a_host_that_does_not_answer_should_have_flown(self):
        flights = self.fly_whole()
        status, messages = self.run_campaign("hosts", "--hosts", "127.0.0.4,127.0.0.2", "--tasks", "4")
        self.assertEqual(status, 1, messages)
        self.assertEqual(self.calls(), flights)
        self.assertEqual(self.places(), {"127.0.0.2"})
        self.assert_same_report("hosts")


class Slurm(CampaignInTasks):
    def test_every_node_flies(self):
        nodes = int(os.environ.get("ILP_SLURM_NODES", "1"))
        flights = self.fly_whole()
        self.write("mishap", "sleep 0.5\n")
        status, messages = self.run_campaign("nodes", "--slurm", "--tasks", "6")
        self.assertEqual(status, 1, messages)
        self.assertEqual(self.calls(), flights)
        self.assertEqual(self.places(), {f"node{number + 1}" for number in range(nodes)})
        self.assert_same_report("nodes")

    def queue(self):
        return subprocess.run(["squeue", "--noheader"], capture_output=True, text=True, check=True).stdout.split("\n")[:-1]

    def test_any_number_of_tasks_gives_the_report_of_one_run(self):
        flights = self.fly_whole()
        for count in (1, 3, 7):
            status, messages = self.run_campaign(f"of {count}", "--slurm", "--tasks", str(count))
            self.assertEqual(status, 1, messages)
            self.assertEqual(self.calls(), flights)
            self.assert_same_report(f"of {count}")

    def test_task_that_dies_is_named_and_repeated_alone(self):
        self.fly_whole()
        self.write("mishap", '[ "$scenario$seed" != c2 ] || kill -KILL $PPID\n')
        status, messages = self.run_campaign("killed", "--slurm", "--tasks", "4", "--jobs", "1")
        self.assertEqual(status, 1)
        self.assertIn("task 2 of 4 did not end", messages)
        self.assertIn("without a result: c_seed=2.", messages)
        self.assertIn("1 of 12 flights have no result", messages)
        self.calls()
        os.remove(self.path("mishap"))
        status, messages = self.run_campaign("killed", "--slurm", "--tasks", "4", "--jobs", "1")
        self.assertIn("has 1 task\n", messages)
        self.assertEqual(self.calls(), ["c 2"])
        self.assert_same_report("killed")

    def test_failed_flights_alone_are_flown_again_on_request(self):
        self.fly_whole()
        self.run_campaign("again", "--slurm", "--tasks", "3")
        self.calls()
        self.run_campaign("again", "--slurm", "--tasks", "3", "--retry-failed")
        self.assertEqual(self.calls(), ["b 3"])
        self.assert_same_report("again")

    def test_interrupted_command_leaves_no_job(self):
        self.write("mishap", "sleep 1000\n")
        command = subprocess.Popen(self.command("out", "--slurm", "--tasks", "2"), stderr=subprocess.DEVNULL)
        self.assertTrue(self.comes_true(lambda: os.path.exists(self.path("calls")) and len(self.queue()) >= 2))
        command.send_signal(signal.SIGTERM)
        self.assertEqual(command.wait(), 128 + signal.SIGTERM)
        self.assertTrue(self.comes_true(lambda: not self.queue()))

    def test_second_command_waits_for_the_jobs_of_the_first(self):
        self.write("mishap", "sleep 1000\n")
        command = subprocess.Popen(self.command("out", "--slurm", "--tasks", "1"), stderr=subprocess.DEVNULL)
        self.assertTrue(self.comes_true(lambda: os.path.exists(self.path("calls"))))
        command.kill()
        command.wait()
        status, messages = self.run_campaign("out", "--slurm", "--tasks", "1")
        subprocess.run(["scancel", "--user=root"], check=True)
        self.assertEqual(status, 2, messages)
        self.assertIn("of an earlier command still works here", messages)
        self.assertTrue(self.comes_true(lambda: not self.queue()))

    def test_what_slurm_refuses_is_said(self):
        status, messages = self.run_campaign("out", "--slurm", "--slurm-options=--partition=none")
        self.assertEqual(status, 2)
        self.assertIn("sbatch: ", messages)


class RealFlights(CampaignInTasks):
    def setUp(self):
        super().setUp()
        self.campaign = os.path.join(ROOT, "sim", "campaigns", "smoke.ini")
        self.sil, self.score = sys.argv[2:4]

    def test_flights_on_slurm_score_as_on_this_machine(self):
        self.assertEqual(self.run_campaign("whole")[0], 0)
        status, messages = self.run_campaign("slurm", "--slurm", "--tasks", "2")
        self.assertEqual(status, 0, messages)
        self.assert_same_report("slurm")
        for name in os.listdir(self.path("whole", "jobs")):
            scores = [self.path(out, "jobs", name, "score.json") for out in ("whole", "slurm")]
            self.assertTrue(filecmp.cmp(*scores, shallow=False), name)


if __name__ == "__main__":
    suite = unittest.defaultTestLoader.loadTestsFromTestCase(globals()[sys.argv[1]])
    result = unittest.TextTestRunner(verbosity=2).run(suite)
    nothing_ran = len(result.skipped) == result.testsRun
    sys.exit(SKIPPED if result.wasSuccessful() and nothing_ran else not result.wasSuccessful())
