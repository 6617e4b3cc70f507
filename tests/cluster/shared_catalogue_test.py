"""The catalogue that missions share: which keyframes of which mission saw a place, and all of its tables.

shared_catalogue_test.py ILP_GROUND MAKE_DOWNLINK SUITE, inside with_postgres. Exit status 77 where the server has no PostGIS."""

import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

GROUND, MAKE_DOWNLINK = sys.argv[1:3]
SERVER = os.environ["ILP_POSTGRES_SERVER"]
PLACE = dict(part.split("=", 1) for part in os.environ["ILP_POSTGRES_TCP"].split())
ADDRESS = f"postgresql://{PLACE['user']}@{PLACE['host']}:{PLACE['port']}/{PLACE['dbname']}"
KEYFRAMES = 8
# The made-up flight: keyframes this far apart in strip units, along x; each image shows 10.7 units of x.
STEP = 0.2 * 10 * 640 / 600
METRES_PER_UNIT = 100
MARS_M = 3396190


def sql(text):
    """Rows as the superuser of the server sees them, columns separated by |."""
    done = subprocess.run([SERVER, "sql"], input=text, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(done.stderr)
    return done.stdout.split("\n")[:-1]


class OnAServer(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.shared = tempfile.mkdtemp()
        cls.addClassCleanup(shutil.rmtree, cls.shared, ignore_errors=True)
        cls.box = os.path.join(cls.shared, "box")
        subprocess.run([MAKE_DOWNLINK, cls.box, str(KEYFRAMES)], check=True)

    def setUp(self):
        self.folder = tempfile.mkdtemp(dir=self.shared)
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        sql("DROP SCHEMA IF EXISTS aerobot CASCADE;")

    def anchor(self, longitude, latitude, body="mars"):
        """An option that puts the camera of the first keyframe there, with x to the east."""
        path = os.path.join(self.folder, f"anchor {longitude} {latitude}.json")
        strip = {"strip": 1, "keyframe": 1, "longitude": longitude, "latitude": latitude, "height": 1000, "azimuth": 0,
                 "metres_per_unit": METRES_PER_UNIT}
        with open(path, "w", encoding="utf-8") as stream:
            json.dump({"body": body, "strips": [strip]}, stream)
        return ["--anchor", path]

    def command(self, mission, *more, address=ADDRESS):
        return [GROUND, self.box, "--out", os.path.join(self.folder, "out " + mission.replace("/", "")), "--catalogue", address,
                "--mission", mission, *more]

    def run_ground(self, mission, *more, address=ADDRESS):
        done = subprocess.run(self.command(mission, *more, address=address), capture_output=True, text=True)
        return done.returncode, done.stdout + done.stderr

    def fly(self, mission, *more):
        self.assertEqual(self.run_ground(mission, *more)[0], 0)


class SharedCatalogue(OnAServer):
    def seen(self, longitude, latitude, body="mars"):
        rows = [row.split("|") for row in sql(f"SELECT mission, keyframe FROM aerobot.seen('{body}', {longitude}, {latitude});")]
        return [(mission, int(keyframe)) for mission, keyframe in rows]

    def east_of(self, longitude, latitude, keyframe):
        """The longitude below a keyframe of a flight that is anchored there."""
        metres = METRES_PER_UNIT * STEP * (keyframe - 1)
        return longitude + math.degrees(metres / (MARS_M * math.cos(math.radians(latitude))))

    def around(self, mission, keyframe):
        """80 % overlap: what is below a camera is also seen by the two before it and the two after it."""
        return [(mission, k) for k in range(max(1, keyframe - 2), min(KEYFRAMES, keyframe + 2) + 1)]

    def test_query_names_the_keyframes_of_all_missions_that_saw_a_place(self):
        self.fly("first", *self.anchor(137.4, -4.6))
        # The second mission begins where the first one's fifth keyframe is.
        begin = self.east_of(137.4, -4.6, 5)
        self.fly("second", *self.anchor(begin, -4.6))
        self.fly("elsewhere", *self.anchor(20, 50))
        self.fly("titan", *self.anchor(137.4, -4.6, body="titan"))
        self.assertEqual(self.seen(self.east_of(137.4, -4.6, 2), -4.6), self.around("first", 2))
        self.assertEqual(self.seen(begin, -4.6), self.around("first", 5) + self.around("second", 1))
        self.assertEqual(self.seen(begin, 4.6), [])

    def test_place_beyond_180_degrees_has_two_names(self):
        self.fly("wrap", *self.anchor(179.99, 10))
        beyond = self.east_of(179.99, 10, 6)
        self.assertGreater(beyond, 180)
        for longitude in (beyond, beyond - 360):
            self.assertEqual(self.seen(longitude, 10), self.around("wrap", 6))

    def test_mission_without_anchor_is_in_its_own_axes_and_at_no_place(self):
        self.fly("local")
        self.assertEqual(self.seen(0, 0), [])
        for keyframe in (1, 4, KEYFRAMES):
            rows = sql("SELECT keyframe FROM aerobot.keyframe WHERE mission = 'local' AND body IS NULL AND "
                       f"ST_Intersects(footprint, ST_MakePoint({STEP * (keyframe - 1)}, 0)) ORDER BY keyframe;")
            self.assertEqual([("local", int(row)) for row in rows], self.around("local", keyframe))

    def test_rows_follow_from_the_flight_alone_and_are_replaced(self):
        name = "O'Neill's \\ flight"
        dump = "SELECT mission, keyframe, strip, frame, name, state, ST_AsText(footprint) FROM aerobot.keyframe ORDER BY keyframe;"
        self.fly(name, *self.anchor(1, 2))
        first = sql(dump)
        self.assertEqual(len(first), KEYFRAMES)
        self.fly(name, *self.anchor(1, 2), "--afresh")
        self.assertEqual(sql(dump), first)
        self.fly(name, *self.anchor(1, 3))
        moved = sql(dump)
        self.assertEqual(len(moved), KEYFRAMES)
        self.assertTrue(set(moved).isdisjoint(first))

    def test_missions_that_begin_together_share_the_tables(self):
        names = ["one", "two", "three"]
        runs = [subprocess.Popen(self.command(name, *self.anchor(5, 5)), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                for name in names]
        self.assertEqual([run.wait() for run in runs], [0, 0, 0])
        self.assertEqual(self.seen(5, 5), [row for name in sorted(names) for row in self.around(name, 1)])

    def test_failed_run_leaves_the_rows_of_the_run_before(self):
        self.fly("kept", *self.anchor(7, 7))
        sql("ALTER TABLE aerobot.keyframe ADD CHECK (keyframe < 5) NOT VALID;")
        status, messages = self.run_ground("kept", *self.anchor(8, 8))
        self.assertEqual(status, 1)
        self.assertIn("the shared catalogue", messages)
        self.assertEqual(self.seen(7, 7), self.around("kept", 1))

    def test_bad_addresses_are_refused_before_any_work(self):
        for address, reason in ((ADDRESS.replace("@", ":secret@"), "must hold no password"),
                                (ADDRESS + "?password=secret", "must hold no password"),
                                ("mysql://x", "postgresql://USER@HOST/DATABASE"),
                                ("postgresql://ilp@127.0.0.1:1/ilp", "cannot be reached")):
            status, messages = self.run_ground("bad", address=address)
            self.assertEqual(status, 1)
            self.assertIn(reason, messages)
            self.assertNotIn("secret", messages)
            self.assertFalse(os.path.exists(os.path.join(self.folder, "out bad")))


class CatalogueOnAServer(OnAServer):
    """All tables of the catalogue, a part for each mission: results are those over a file."""

    def setUp(self):
        super().setUp()
        sql("DROP SCHEMA IF EXISTS aerobot_catalogue CASCADE;")

    def out(self, mission):
        return os.path.join(self.folder, "out " + mission)

    def contents(self, out):
        """All files of the results, without what a run knows of its own files."""
        found = [os.path.join(at, name) for at, _, names in os.walk(out) for name in names]
        names = {os.path.relpath(path, out): path for path in found}
        return {name: open(path, "rb").read() for name, path in names.items() if name not in ("catalogue.db", "results.txt")}

    def assert_contents(self, out, expected):
        found = self.contents(out)
        self.assertEqual(sorted(found), sorted(expected))
        self.assertEqual([name for name in sorted(found) if found[name] != expected[name]], [])

    def over_a_file(self, *more):
        out = os.path.join(self.folder, "over a file")
        subprocess.run([GROUND, self.box, "--out", out, *more], check=True, capture_output=True)
        return self.contents(out)

    def rows(self, mission, table="file"):
        return int(sql(f"SELECT count(*) FROM aerobot_catalogue.{table} WHERE mission = '{mission}';")[0])

    def test_results_are_those_over_a_file_and_missions_share_the_tables(self):
        expected = self.over_a_file("--title", "t")
        for mission in ("one", "two"):
            self.fly(mission, "--title", "t")
            self.assert_contents(self.out(mission), expected)
            self.assertFalse(os.path.exists(os.path.join(self.out(mission), "catalogue.db")))
        files = len(os.listdir(self.box))
        self.assertEqual((self.rows("one"), self.rows("two")), (files, files))
        self.fly("one", "--title", "t", "--afresh")
        self.assertEqual((self.rows("one"), self.rows("two")), (files, files))
        self.assert_contents(self.out("one"), expected)

    def test_another_folder_gets_the_results_without_the_received_files(self):
        expected = self.over_a_file("--title", "t")
        self.fly("kept", "--title", "t")
        empty, other = os.path.join(self.folder, "empty"), os.path.join(self.folder, "other")
        os.mkdir(empty)
        subprocess.run([GROUND, empty, "--out", other, "--catalogue", ADDRESS, "--mission", "kept", "--title", "t"], check=True,
                       capture_output=True)
        self.assert_contents(other, expected)

    def test_run_without_news_does_nothing_unless_another_run_used_the_mission(self):
        self.fly("again")
        self.assertIn("nothing has changed", self.run_ground("again")[1])
        other = os.path.join(self.folder, "elsewhere")
        subprocess.run([GROUND, self.box, "--out", other, "--catalogue", ADDRESS, "--mission", "again", "--title", "x"], check=True,
                       capture_output=True)
        status, messages = self.run_ground("again")
        self.assertEqual(status, 0)
        self.assertNotIn("nothing has changed", messages)
        self.assertIn("nothing has changed", self.run_ground("again")[1])

    def test_damaged_rows_are_taken_in_and_computed_again(self):
        expected = self.over_a_file("--title", "t")
        self.fly("hurt", "--title", "t")
        sql("UPDATE aerobot_catalogue.file SET contents = set_byte(contents, 20, 255 - get_byte(contents, 20)) WHERE rowid % 2 = 0;"
            "DELETE FROM aerobot_catalogue.tile WHERE strip = 1; UPDATE aerobot_catalogue.mission SET mark = 0;")
        self.assertIn("damaged in the catalogue", self.run_ground("hurt", "--title", "t")[1])
        self.fly("hurt", "--title", "t")
        self.assert_contents(self.out("hurt"), expected)

    def test_killed_run_goes_on(self):
        expected = self.over_a_file("--title", "t")
        for seconds in (0.1, 0.3, 0.6, 1):
            run = subprocess.Popen(self.command("killed", "--title", "t"), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            try:
                run.wait(seconds)
            except subprocess.TimeoutExpired:
                run.kill()
                run.wait()
        self.fly("killed", "--title", "t")
        self.assert_contents(self.out("killed"), expected)

    def test_merge_in_tasks_gives_the_same(self):
        expected = self.over_a_file("--title", "t")
        command = [GROUND, "merge", self.box, "--out", self.out("tasks"), "--catalogue", ADDRESS, "--mission", "it's",
                   "--title", "t", "--tasks", "3"]
        subprocess.run(command, check=True, capture_output=True)
        self.assert_contents(self.out("tasks"), expected)

    def test_mission_of_another_version_is_refused(self):
        self.fly("old")
        sql("UPDATE aerobot_catalogue.mission SET version = 99;")
        status, messages = self.run_ground("old")
        self.assertEqual(status, 1)
        self.assertIn("another version of ilp-ground", messages)


if __name__ == "__main__":
    if sql("SELECT count(*) FROM pg_available_extensions WHERE name = 'postgis';") != ["1"]:
        print("skipped: this PostgreSQL has no PostGIS (Debian package postgresql-15-postgis-3)", file=sys.stderr)
        sys.exit(77)
    # Only a superuser may do this.
    sql("CREATE EXTENSION postgis;")
    suite = unittest.defaultTestLoader.loadTestsFromTestCase(globals()[sys.argv[3]])
    result = unittest.TextTestRunner(verbosity=2).run(suite)
    sys.exit(not result.wasSuccessful())
