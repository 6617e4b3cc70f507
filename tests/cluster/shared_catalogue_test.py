"""The catalogue that missions share: which keyframes of which mission saw a place.

shared_catalogue_test.py ILP_GROUND MAKE_DOWNLINK, inside with_postgres. Exit status 77 where the server has no PostGIS."""

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


class SharedCatalogue(unittest.TestCase):
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


if __name__ == "__main__":
    if sql("SELECT count(*) FROM pg_available_extensions WHERE name = 'postgis';") != ["1"]:
        print("skipped: this PostgreSQL has no PostGIS (Debian package postgresql-15-postgis-3)", file=sys.stderr)
        sys.exit(77)
    # Only a superuser may do this.
    sql("CREATE EXTENSION postgis;")
    result = unittest.TextTestRunner(verbosity=2).run(unittest.defaultTestLoader.loadTestsFromTestCase(SharedCatalogue))
    sys.exit(not result.wasSuccessful())
