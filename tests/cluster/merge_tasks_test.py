"""Merges in tasks: all results of one run, byte by byte, also when tasks are killed.

merge_tasks_test.py SUITE ILP_GROUND MAKE_DOWNLINK [ILP_SIL]. Here and Flight need nothing else, Hosts needs GNU parallel, Sshd runs
inside with_sshd, Slurm inside with_slurm."""

import filecmp
import json
import os
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
import unittest

GROUND, MAKE_DOWNLINK = sys.argv[2:4]
KEYFRAMES = 6


def files_of(folder):
    found = [os.path.relpath(os.path.join(at, name), folder) for at, _, names in os.walk(folder) for name in names]
    return sorted(name for name in found if name != "results.txt" and not name.startswith("catalogue.db"))


def rows_of(out):
    """What the catalogue holds, without the times of files and the order in which rows came."""
    database = sqlite3.connect(os.path.join(out, "catalogue.db"))
    tables = ("SELECT name, crc32, contents FROM file", "SELECT * FROM look", "SELECT * FROM result", "SELECT * FROM tile",
              "SELECT * FROM finished_tile")
    rows = [sorted(database.execute(table).fetchall()) for table in tables]
    database.close()
    return rows


class MergeInTasks(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.shared = tempfile.mkdtemp(prefix="merge tasks ")  # with a blank, which commands have to quote
        cls.addClassCleanup(shutil.rmtree, cls.shared, ignore_errors=True)
        cls.box, cls.whole = os.path.join(cls.shared, "box"), os.path.join(cls.shared, "whole")
        subprocess.run([MAKE_DOWNLINK, cls.box, str(KEYFRAMES)], check=True)
        subprocess.run([GROUND, cls.box, "--out", cls.whole], check=True, capture_output=True)

    def setUp(self):
        self.folder = tempfile.mkdtemp(dir=self.shared)
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.out = os.path.join(self.folder, "out")

    def merge(self, *more, ground=GROUND, environment=None):
        command = [GROUND, "merge", self.box, "--out", self.out, "--ground", ground, *more]
        done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, **(environment or {})})
        return done.returncode, done.stdout + done.stderr

    def mishap(self, body):
        """A stand-in for ilp-ground that first runs `body`, where $package is the package of a task or empty."""
        path = os.path.join(self.folder, "ground")
        with open(path, "w", encoding="utf-8") as stream:
            stream.write(f'#!/bin/bash\npackage=\n[ "$1" != work ] || package=$(basename "$2" .work)\nhere="{self.folder}"\n'
                         f'[ -z "$package" ] || echo "$package" >>"$here/calls"\n'
                         f'(set -- $SSH_CONNECTION; echo "$SLURMD_NODENAME$3") >>"$here/places"\n{body}\nexec "{GROUND}" "$@"\n')
        os.chmod(path, 0o755)
        return path

    def calls(self):
        with open(os.path.join(self.folder, "calls"), encoding="utf-8") as stream:
            return sorted(stream.read().split())

    def places(self):
        """Where tasks ran: the addresses of hosts, or the names of nodes."""
        with open(os.path.join(self.folder, "places"), encoding="utf-8") as stream:
            return set(stream.read().split())

    def assert_as_one_run(self):
        names = files_of(self.whole)
        self.assertGreater(len(names), 3 * KEYFRAMES)
        self.assertEqual(files_of(self.out), names)
        _, different, unreadable = filecmp.cmpfiles(self.whole, self.out, names, shallow=False)
        self.assertEqual((different, unreadable), ([], []))
        self.assertEqual(rows_of(self.out), rows_of(self.whole))


class Here(MergeInTasks):
    def plan(self, kind, count):
        subprocess.run([GROUND, self.box, "--out", self.out, "--plan", kind, "--tasks", str(count)], check=True, capture_output=True)

    def work(self, name):
        command = [GROUND, "work", os.path.join(self.out, "work", name + ".work"), "--out", self.out]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout

    def results(self):
        folder = os.path.join(self.out, "work", "results")
        return {name: open(os.path.join(folder, name), "rb").read() for name in sorted(os.listdir(folder))}

    def test_any_number_of_tasks_gives_the_files_of_one_run(self):
        for count in ("1", "4"):
            status, messages = self.merge("--tasks", count, "--afresh")
            self.assertEqual(status, 0, messages)
            self.assertIn(f"{KEYFRAMES} of {KEYFRAMES} keyframes posed", messages)
            self.assert_as_one_run()

    def test_merge_without_news_plans_no_work_and_writes_nothing(self):
        self.assertEqual(self.merge("--tasks", "2")[0], 0)
        before = {name: os.stat(os.path.join(self.out, name)).st_ctime_ns for name in files_of(self.out)}
        status, messages = self.merge("--tasks", "2", ground=self.mishap(""))
        self.assertEqual(status, 0, messages)
        self.assertIn(f"{KEYFRAMES} of {KEYFRAMES} keyframes posed", messages)
        self.assertFalse(os.path.exists(os.path.join(self.folder, "calls")))
        self.assertEqual({name: os.stat(os.path.join(self.out, name)).st_ctime_ns for name in files_of(self.out)}, before)

    def test_tasks_do_all_of_the_work(self):
        ground = self.mishap("")
        self.assertEqual(self.merge("--tasks", "3", ground=ground)[0], 0)
        self.assertEqual(self.calls(), [f"{kind}-{k}" for kind in ("finish", "looks", "tiles") for k in (1, 2, 3)])

    def test_killed_tasks_are_repeated_alone(self):
        ground = self.mishap('case "$package" in tiles-2|finish-1) [ $(grep -c "$package" "$here/calls") -gt 2 ] || kill -KILL $$ ;; esac')
        status, messages = self.merge("--tasks", "2", ground=ground)
        self.assertEqual(status, 0, messages)
        self.assertEqual(self.calls(), ["finish-1"] * 3 + ["finish-2", "looks-1", "looks-2", "tiles-1"] + ["tiles-2"] * 3)
        self.assert_as_one_run()

    def test_work_of_tasks_that_never_succeed_is_done_by_the_next_step(self):
        ground = self.mishap('case "$package" in *-2) exit 1 ;; esac')
        status, messages = self.merge("--tasks", "2", ground=ground)
        self.assertEqual(status, 0, messages)
        self.assertIn("task 2 of tiles failed 3 times", messages)
        self.assert_as_one_run()

    def test_repeated_task_keeps_what_it_has_done(self):
        self.plan("looks", 1)
        self.assertEqual(self.work("looks-1"), f"{KEYFRAMES} pieces of work done, 0 of them before\n")
        results = self.results()
        self.assertEqual(len(results), KEYFRAMES)
        for name in list(results)[::2]:
            os.remove(os.path.join(self.out, "work", "results", name))
        self.assertEqual(self.work("looks-1"), f"{KEYFRAMES} pieces of work done, {KEYFRAMES // 2} of them before\n")
        self.assertEqual(self.results(), results)

    def test_damaged_files_of_tasks_do_no_harm(self):
        self.plan("looks", 2)
        for name in ("looks-1", "looks-2"):
            self.work(name)
        for name, content in list(self.results().items())[:3]:
            for damaged in (content[:-1], content[:40] + bytes([content[40] ^ 4]) + content[41:], b""):
                with open(os.path.join(self.out, "work", "results", name), "wb") as stream:
                    stream.write(damaged)
                name += "x.result"  # one damage each
        package = os.path.join(self.out, "work", "looks-1.work")
        with open(package, "r+b") as stream:
            stream.seek(-1, os.SEEK_END)
            stream.write(b"\0")
        command = [GROUND, "work", package, "--out", self.out]
        self.assertEqual(subprocess.run(command, capture_output=True).returncode, 1)
        status, messages = self.merge("--tasks", "2")
        self.assertEqual(status, 0, messages)
        self.assert_as_one_run()

    def test_files_that_come_later_cost_only_what_they_change(self):
        part = os.path.join(self.folder, "part")
        shutil.copytree(self.box, part)
        for name in os.listdir(part):
            if f"{KEYFRAMES:06}" in name:
                os.remove(os.path.join(part, name))
        self.assertLess(len(os.listdir(part)), len(os.listdir(self.box)))
        subprocess.run([GROUND, "merge", part, "--out", self.out, "--ground", GROUND, "--title", "box", "--tasks", "2"], check=True,
                       capture_output=True)
        self.plan("looks", 9)
        self.assertLess(len([name for name in os.listdir(os.path.join(self.out, "work")) if name.startswith("looks")]), 3)
        self.assertEqual(self.merge("--tasks", "2")[0], 0)
        self.assert_as_one_run()

    def test_two_merges_do_not_share_a_folder(self):
        ground = self.mishap('[ -z "$package" ] || exec sleep 1000')
        first = subprocess.Popen([GROUND, "merge", self.box, "--out", self.out, "--ground", ground, "--tasks", "1"], stderr=subprocess.DEVNULL)
        for _ in range(600):
            if os.path.exists(os.path.join(self.folder, "calls")):
                break
            time.sleep(0.1)
        status, messages = self.merge("--tasks", "1")
        first.send_signal(signal.SIGTERM)
        self.assertEqual(first.wait(), 128 + signal.SIGTERM)
        self.assertEqual(status, 2)
        self.assertIn("another merge works in", messages)
        self.assertEqual(self.merge("--tasks", "1")[0], 0)
        self.assert_as_one_run()


class Flight(MergeInTasks):
    """Two passes over one place, apart by a cloud: strips that become one model, and images of different exposure."""

    @classmethod
    def setUpClass(cls):
        cls.shared = tempfile.mkdtemp(prefix="merge flight ")
        cls.addClassCleanup(shutil.rmtree, cls.shared, ignore_errors=True)
        flight, cls.whole = os.path.join(cls.shared, "flight"), os.path.join(cls.shared, "whole")
        cls.box = os.path.join(flight, "outbox")
        settings = {"flight.passes": 2, "flight.pass_yaw_rad": 1.5, "flight.interval_s": 4, "effects.cloud_from_s": 80,
                    "effects.cloud_for_s": 16, "camera.width": 320, "camera.height": 240, "camera.fx": 275, "camera.fy": 275,
                    "camera.cx": -1, "camera.cy": -1}
        changes = [word for key, value in settings.items() for word in ("--set", f"{key}={value}")]
        subprocess.run([sys.argv[4], "--scenario", "mars-plains", "--frames", "44", "--seed", "1", *changes, "--out", flight],
                       check=True, capture_output=True)
        subprocess.run([GROUND, cls.box, "--out", cls.whole], check=True, capture_output=True)

    def test_joined_strips_are_those_of_one_run(self):
        with open(os.path.join(self.whole, "report.json"), encoding="utf-8") as stream:
            self.assertEqual(json.load(stream)["joined"]["models"][0]["strips"], [1, 2])
        status, messages = self.merge("--tasks", "3")
        self.assertEqual(status, 0, messages)
        self.assert_as_one_run()


class Hosts(MergeInTasks):
    """GNU parallel over a stand-in for ssh."""

    def setUp(self):
        super().setUp()
        if not shutil.which("parallel"):
            self.skipTest("GNU parallel is not installed (Debian package parallel)")
        # Instead of ssh HOST COMMAND: `gone` answers as a host that is off, and the user's shell on the others runs nothing.
        ssh = os.path.join(self.folder, "ssh")
        with open(ssh, "w", encoding="utf-8") as stream:
            stream.write('#!/bin/bash\nwhile [[ $1 = -* ]]; do shift; done\nhost=$1; shift; [ "$1" != -- ] || shift\n'
                         f'echo "$host" >>"{self.folder}/asked"\n[ "$host" != gone ] || exit 255\nexport SHELL=/bin/false\n'
                         'exec bash -c "$*"\n')
        os.chmod(ssh, 0o755)
        self.ssh = {"PARALLEL_SSH": f"'{ssh}'"}

    def asked(self):
        with open(os.path.join(self.folder, "asked"), encoding="utf-8") as stream:
            return set(stream.read().split())

    def test_hosts_give_the_files_of_one_run(self):
        ground = self.mishap("")
        status, messages = self.merge("--hosts", "one,two", "--tasks", "4", ground=ground, environment=self.ssh)
        self.assertEqual(status, 0, messages)
        self.assertEqual(self.calls(), [f"{kind}-{k}" for kind in ("finish", "looks", "tiles") for k in (1, 2, 3, 4)])
        self.assertEqual(self.asked(), {"one", "two"})
        self.assert_as_one_run()

    def test_other_hosts_do_what_a_host_that_is_gone_should_have_done(self):
        status, messages = self.merge("--hosts", "gone,two", "--tasks", "3", environment=self.ssh)
        self.assertEqual(status, 0, messages)
        self.assertEqual(self.asked(), {"gone", "two"})
        self.assert_as_one_run()

    def test_task_that_dies_on_a_host_is_repeated(self):
        ground = self.mishap('case "$package" in tiles-2) [ $(grep -c "$package" "$here/calls") -gt 1 ] || kill -KILL $$ ;; esac')
        status, messages = self.merge("--hosts", "one,two", "--tasks", "3", ground=ground, environment=self.ssh)
        self.assertEqual(status, 0, messages)
        self.assertEqual(self.calls().count("tiles-2"), 2)
        self.assert_as_one_run()


class Sshd(MergeInTasks):
    """GNU parallel over a real ssh."""

    def test_hosts_give_the_files_of_one_run(self):
        ground = self.mishap("sleep 0.3")
        status, messages = self.merge("--hosts", "127.0.0.2,127.0.0.3", "--tasks", "4", ground=ground)
        self.assertEqual(status, 0, messages)
        self.assertEqual(self.calls(), [f"{kind}-{k}" for kind in ("finish", "looks", "tiles") for k in (1, 2, 3, 4)])
        self.assertEqual(self.places(), {"127.0.0.2", "127.0.0.3"})
        self.assert_as_one_run()

    def test_other_hosts_do_what_a_host_that_does_not_answer_should_have_done(self):
        status, messages = self.merge("--hosts", "127.0.0.4,127.0.0.2", "--tasks", "3", ground=self.mishap(""))
        self.assertEqual(status, 0, messages)
        self.assertEqual(self.places(), {"127.0.0.2"})
        self.assert_as_one_run()


class Slurm(MergeInTasks):
    def test_every_node_works(self):
        nodes = int(os.environ.get("ILP_SLURM_NODES", "1"))
        status, messages = self.merge("--slurm", "--tasks", "6", ground=self.mishap("sleep 0.5"))
        self.assertEqual(status, 0, messages)
        self.assertEqual(self.places(), {f"node{number + 1}" for number in range(nodes)})
        self.assert_as_one_run()

    def test_any_number_of_tasks_gives_the_files_of_one_run(self):
        for count in ("1", "3", "7"):
            status, messages = self.merge("--slurm", "--tasks", count, "--afresh")
            self.assertEqual(status, 0, messages)
            self.assert_as_one_run()

    def test_killed_tasks_are_repeated_alone(self):
        # The shell of the task dies with it, as if the node had killed the job.
        ground = self.mishap('case "$package" in tiles-2|looks-3) [ $(grep -c "$package" "$here/calls") -gt 1 ] || '
                             'kill -KILL $PPID $$ ;; esac')
        status, messages = self.merge("--slurm", "--tasks", "3", ground=ground)
        self.assertEqual(status, 0, messages)
        calls = self.calls()
        self.assertEqual([name for name in sorted(set(calls)) if calls.count(name) > 1], ["looks-3", "tiles-2"])
        self.assertIn("repeating 1 of 3 tasks: 3", messages)
        self.assert_as_one_run()

    def test_interrupted_merge_leaves_no_job_and_goes_on(self):
        ground = self.mishap('[ "$package" != tiles-1 ] || [ -e "$here/go" ] || exec sleep 1000')
        command = subprocess.Popen([GROUND, "merge", self.box, "--out", self.out, "--ground", ground, "--slurm", "--tasks", "2"],
                                   stderr=subprocess.DEVNULL)
        self.assertTrue(self.comes_true(lambda: os.path.exists(os.path.join(self.folder, "calls")) and "tiles-1" in self.calls()))
        command.send_signal(signal.SIGINT)
        self.assertEqual(command.wait(), 128 + signal.SIGINT)
        self.assertTrue(self.comes_true(lambda: not subprocess.run(["squeue", "--noheader"], capture_output=True).stdout))
        open(os.path.join(self.folder, "go"), "w", encoding="utf-8").close()
        self.assertEqual(self.merge("--slurm", "--tasks", "2", ground=ground)[0], 0)
        self.assertEqual([self.calls().count(f"looks-{k}") for k in (1, 2)], [1, 1])
        self.assert_as_one_run()

    def comes_true(self, condition):
        for _ in range(600):
            if condition():
                return True
            time.sleep(0.1)
        return False


if __name__ == "__main__":
    suite = unittest.defaultTestLoader.loadTestsFromTestCase(globals()[sys.argv[1]])
    result = unittest.TextTestRunner(verbosity=2).run(suite)
    nothing_ran = len(result.skipped) == result.testsRun
    sys.exit(77 if result.wasSuccessful() and nothing_ran else not result.wasSuccessful())
