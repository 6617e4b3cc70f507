"""Merges in tasks: all results of one run, byte by byte, also when tasks are killed.

merge_tasks_test.py SUITE ILP_GROUND MAKE_DOWNLINK [ILP_SIL]. Here and Flight need nothing else, Hosts needs GNU parallel, Sshd runs
inside with_sshd, Slurm inside with_slurm."""

import filecmp
import json
import os
import shutil
import signal
import sqlite3
import struct
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


def read_depths(path):
    """Width and the depths of a PFM file, whose rows begin at the bottom."""
    with open(path, "rb") as file:
        content = file.read()
    _, width, height, scale = content[:100].split(maxsplit=4)[:4]
    count = int(width) * int(height)
    return int(width), int(height), struct.unpack(("<" if float(scale) < 0 else ">") + f"{count}f", content[-4 * count:])


class Camera:
    """A line of poses.txt (sim/host/reference_cameras.hpp) with the true depths of its image."""

    def __init__(self, line, truth):
        self.name, *numbers = line.split()
        self.width, self.height, self.fx, self.fy, self.cx, self.cy = map(float, numbers[:6])
        values = list(map(float, numbers[6:]))
        self.rows, self.centre = [values[0:3], values[3:6], values[6:9]], values[9:12]
        width, height, depths = read_depths(os.path.join(truth, "depth", self.name[:4] + ".pfm"))
        self.depth = lambda x, y: depths[(height - 1 - y) * width + x]

    def ground(self, x, y):
        depth = self.depth(x, y)
        ray = [(x - self.cx) / self.fx * depth, (y - self.cy) / self.fy * depth, depth]
        return [c + sum(self.rows[k][i] * ray[k] for k in range(3)) for i, c in enumerate(self.centre)]

    def mark(self, place):
        """Where the image shows the place; None where it does not."""
        at = [sum(r * (p - c) for r, p, c in zip(row, place, self.centre)) for row in self.rows]
        if at[2] <= 0:
            return None
        x, y = self.fx * at[0] / at[2] + self.cx, self.fy * at[1] / at[2] + self.cy
        if not (5 < x < self.width - 6 and 5 < y < self.height - 6):
            return None
        return (x, y) if abs(self.depth(round(x), round(y)) - at[2]) < 0.01 * at[2] else None


def write_control_points(truth, path):
    """Two points of every third image, marked in all images that show them. Those that images of both passes show are named both-N."""
    with open(os.path.join(truth, "poses.txt"), encoding="utf-8") as file:
        cameras = [Camera(line, truth) for line in file if line.strip() and not line.startswith("#")]
    with open(path, "w", encoding="utf-8") as file:
        file.write("name,x,y,height,sigma,role\n")
        for i in range(0, len(cameras), 3):
            for j, (x, y) in enumerate(((96, 60), (224, 180))):
                if cameras[i].depth(x, y) <= 0:
                    continue  # nothing but the cloud
                place = cameras[i].ground(x, y)
                marks = [(k, camera.name, *mark) for k, camera in enumerate(cameras) if (mark := camera.mark(place))]
                both = "both" if marks[0][0] < len(cameras) // 2 <= marks[-1][0] else "one"
                role = "check" if (i // 3 + j) % 3 == 0 else "control"
                file.write(f"{both}-{i}-{j},{place[0]!r},{place[1]!r},{place[2]!r},0.02,{role}" +
                           "".join(f",{name},{column!r},{row!r}" for _, name, column, row in marks) + "\n")


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
        self.assertEqual(self.work("looks-1"), f"{KEYFRAMES} pieces of work done, 0 of them by an earlier run\n")
        results = self.results()
        self.assertEqual(len(results), KEYFRAMES)
        for name in list(results)[::2]:
            os.remove(os.path.join(self.out, "work", "results", name))
        self.assertEqual(self.work("looks-1"), f"{KEYFRAMES} pieces of work done, {KEYFRAMES // 2} of them by an earlier run\n")
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


    def test_control_points_place_joined_strips_as_in_one_run(self):
        points = os.path.join(self.folder, "points.csv")
        write_control_points(os.path.join(self.shared, "flight", "flight", "truth"), points)
        whole = os.path.join(self.folder, "whole")
        subprocess.run([GROUND, self.box, "--out", whole, "--control-points", points], check=True, capture_output=True)
        with open(os.path.join(whole, "report.json"), encoding="utf-8") as stream:
            report = json.load(stream)
        placed, = report["control"]
        both = [point["name"] for point in placed["points"] if point["name"].startswith("both")]
        self.assertGreaterEqual(len(both), 4, "points that both strips see")
        self.assertGreaterEqual(placed["checked"], 3)
        # The marks are exact, the poses are not: a pixel is 0.35 m on the ground, and 0.5 to 1.5 m of height by these views.
        self.assertGreaterEqual(placed["used"], 12)
        self.assertLess(placed["used_rmse_m"], 0.5)
        self.assertLess(placed["check_rmse_m"], 1.0)
        for point in placed["points"]:
            self.assertEqual(point["used"], not point["check"], point["name"])
            for residual in point["residual_m"]:
                self.assertLess(abs(residual), 3 * point["expected_m"], point["name"])
        status, messages = self.merge("--tasks", "3", "--control-points", points)
        self.assertEqual(status, 0, messages)
        self.assertIn("check points, RMSE", messages)
        self.whole = whole
        self.assert_as_one_run()
        # The same merge without points goes back to the strips' own axes.
        self.assertEqual(self.merge("--tasks", "3")[0], 0)
        self.whole = type(self).whole
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
