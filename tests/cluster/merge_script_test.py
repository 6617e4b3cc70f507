"""ilp-ground merge finds its script beside the program, then where a package installs it, then in the sources.

merge_script_test.py ILP_GROUND"""

import os
import shutil
import subprocess
import sys
import tempfile
import unittest

GROUND = sys.argv[1]
SCRIPT = "sim/tools/cluster/merge.py"


class SearchOrder(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="merge script ")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.program = os.path.join(self.folder, "build", "host", "bin", "ilp-ground")
        os.makedirs(os.path.dirname(self.program))
        shutil.copy(GROUND, self.program)

    def put(self, place):
        """A script that says where it lies and what it was given."""
        path = os.path.join(self.folder, place)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8") as stream:
            stream.write(f"import sys\nprint({place!r}, *sys.argv[1:], sep='|')\n")

    def merge(self):
        done = subprocess.run([self.program, "merge", "a box", "--out", "x"], capture_output=True, text=True, check=False)
        return done.returncode, done.stdout.strip(), done.stderr

    def test_the_nearest_place_is_used(self):
        sources, installed, beside = SCRIPT, "build/host/share/aerobot-ilp-ground/" + SCRIPT, "build/host/bin/merge.py"
        for place in (sources, installed, beside):
            self.put(place)
            self.assertEqual(self.merge(), (0, f"{place}|--ground|{self.program}|a box|--out|x", ""))

    def test_all_places_are_named_when_the_script_is_in_none(self):
        status, _, message = self.merge()
        self.assertEqual(status, 2)
        for place in ("build/host/bin/merge.py", "build/host/share/aerobot-ilp-ground/" + SCRIPT, SCRIPT):
            self.assertIn(os.path.join(self.folder, place), message)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
