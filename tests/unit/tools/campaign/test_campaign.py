"""Campaign files, tables and plots: what files expand to, what is said of bad ones, numbers worked out by hand.

test_campaign.py [SUITE]"""

import os
import re
import sys
import tempfile
import unittest

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))))
sys.path.insert(0, os.path.join(ROOT, "sim", "tools", "campaign"))

from campaign_file import MOST_JOBS, Campaign, CampaignError, Job, Plot, expand, read_campaign
from flights import Result
from metrics import METRICS
from plots import svg_file, sweep_plot
from tables import cell_tables, table_csv, table_markdown


class CampaignFile(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def file(self, text, name="c.ini"):
        path = os.path.join(self.folder.name, name)
        with open(path, "w", encoding="utf-8") as stream:
            stream.write(text)
        return path

    def jobs(self, text):
        return expand(read_campaign(self.file(text)))

    def names(self, text):
        return [job.name for job in self.jobs(text)]

    def refuses(self, text, message):
        with self.subTest(text=text[:80]), self.assertRaises(CampaignError) as caught:
            self.jobs(text)
        self.assertIn(message, str(caught.exception))

    def test_grid_is_the_cartesian_product_with_the_last_axis_fastest(self):
        names = self.names("[grid]\nscenario = flat | mars-plains\nworld.ruggedness = 0 | 0.5\nseed = 1..2\n")
        self.assertEqual(names, ["flat_ruggedness=0_seed=1", "flat_ruggedness=0_seed=2", "flat_ruggedness=0.5_seed=1",
                                 "flat_ruggedness=0.5_seed=2", "mars-plains_ruggedness=0_seed=1",
                                 "mars-plains_ruggedness=0_seed=2", "mars-plains_ruggedness=0.5_seed=1",
                                 "mars-plains_ruggedness=0.5_seed=2"])

    def test_arguments_carry_scenario_settings_seed_and_frames(self):
        jobs = self.jobs("[campaign]\nframes = 12\n[grid]\nscenario = flat\nflight.kind = line\nseed = 7\n"
                         "[set]\neffects.haze = 0.1\nflight.kind = balloon\n")
        self.assertEqual([job.arguments() for job in jobs],
                         [["--scenario", "flat", "--set", "effects.haze=0.1", "--set", "flight.kind=line", "--seed", "7",
                           "--frames", "12"]])

    def test_a_flight_over_a_map_has_it_made_of_its_own_world(self):
        jobs = self.jobs("[grid]\nscenario = flat\nmap.sun-turn = 34 | 90\nseed = 7\n"
                         "[set]\nmap.area = -9,-8,7,6\nmap.pixel = 0.5\nworld.ruggedness = 0.1\ncamera.fx = 300\n")
        self.assertEqual([job.map_arguments() for job in jobs],
                         [["world-map", "flat", "--set", "world.ruggedness=0.1", "--set", "world.seed=7",
                           "--area=-9,-8,7,6", "--pixel=0.5", f"--sun-turn={turn}"] for turn in ("34", "90")])
        self.assertEqual(jobs[0].arguments(), ["--scenario", "flat", "--set", "camera.fx=300", "--set",
                                               "world.ruggedness=0.1", "--seed", "7"])
        self.assertEqual(self.jobs("[grid]\nscenario = flat\nseed = 7\n")[0].map_arguments(), [])

    def test_groups_are_grids_beside_each_other(self):
        self.assertEqual(self.names("[grid]\nseed = 1\n[group far]\nseed = 1 | 2\n[group b]\nscenario = flat\n"),
                         ["seed=1", "far+seed=1", "far+seed=2", "b+flat"])

    def test_indented_line_goes_on_with_the_value(self):
        self.assertEqual(self.names("[grid]\nscenario = flat |\n   mars-plains ; a comment\n # another\n"),
                         ["flat", "mars-plains"])

    def test_name_of_a_job_does_not_depend_on_the_other_jobs(self):
        few = self.names("[grid]\nscenario = flat\nseed = 2\n")
        many = self.names("[grid]\nscenario = mars-plains | flat\nseed = 1..3\n[group x]\nseed = 4\n")
        self.assertEqual(many.count(few[0]), 1)

    def test_names_are_distinct_and_fit_for_folders(self):
        longest = "x" * 90
        names = self.names(f"[grid]\nworld.map = a/b | a_b | a-b | ../..\n | {longest}1\n | {longest}2 | 'q' $x\n"
                           "[group p]\nscenario = x_seed=1\n[group p_x]\nseed = 1\n[group two]\na.m = 1\nb.m = 1\n"
                           "[group tricky]\nw.a = 1 | 1_b=2\nw.b = 2 | 2_b=2\n")
        self.assertEqual(len(set(names)), len(names))
        for name in names:
            self.assertIsNone(re.search(r"[/ '$\\]", name), name)
            self.assertNotEqual(name[0], ".", name)
            self.assertLess(len(name), 128)

    def test_scenario_file_is_found_beside_the_campaign(self):
        self.file("", "mine.ini")
        jobs = self.jobs("[grid]\nscenario = mine.ini | flat\n")
        self.assertEqual([job.scenario for job in jobs], [os.path.join(self.folder.name, "mine.ini"), "flat"])

    def test_too_many_flights_are_refused_before_they_are_made(self):
        self.assertEqual(len(self.jobs("[grid]\nseed = 1..100\nworld.a = 1..100\n")), MOST_JOBS)
        self.refuses("[grid]\nseed = 1..10000\nworld.a = 1..10000\nworld.b = 1..10000\nworld.c = 1..10000\n"
                     "world.d = 1..10000\n", "c.ini:3: with this axis there are more than 10000 flights")
        self.refuses("[grid]\nseed = 1..10000\n[group more]\nseed = 1\n", "c.ini:4:")
        self.refuses("[grid]\nseed = 0..18446744073709551615\n", "c.ini:2:")

    def test_bad_file_is_named_with_its_line(self):
        for text, message in (
                ("", ": no flights: expected a section [grid]"),
                ("[grid]\nseed = 1\nnonsense\n", ":3: neither a [section]"),
                ("[grid\nseed = 1\n", ":1: neither a [section]"),
                ("[grid]\nseed = 1\n[gird]\nseed = 1\n", ":4: section [gird]: expected campaign"),
                ("[group A/B]\nseed = 1\n", ":2: section [group A/B]"),
                ("seed = 1\n", ":1: section []"),
                ("[grid]\nseed = 1\n\nseed = 2\n", ":4: [grid] seed stands in line 2 already"),
                ("[grid]\nruggedness = 1\n", ":2: [grid] ruggedness: expected scenario, seed, frames or"),
                ("[grid]\nseed = 1 | | 2\n", ":2: [grid] seed = 1 | | 2: expected values separated by |"),
                ("[grid]\nseed = 1..3 | 2\n", ":2: [grid] seed = 1..3 | 2: expected each value once"),
                ("[grid]\nseed = 3..1\n", ":2: [grid] seed = 3..1: expected a range that rises"),
                ("[grid]\nseed = -1\n", ":2: [grid] seed = -1: expected whole numbers"),
                ("[grid]\nframes = 0\n", ":2: [grid] frames = 0: expected whole numbers from 1"),
                ("[grid]\nscenario = no/such.ini\n", ":2: [grid] scenario = no/such.ini: expected a preset"),
                ("[campaign]\nframes = many\n", ":2: [campaign] frames = many: expected a whole number"),
                ("[campaign]\ntimeout_s = nan\n", ":2: [campaign] timeout_s = nan: expected seconds"),
                ("[campaign]\nframe = 3\n", ":2: [campaign] frame: expected name, about, frames"),
                ("[campaign]\ncompare = world.b\n[grid]\nworld.a = 1\n", ": [campaign] compare = world.b: expected an axis"),
                ("[campaign]\ncolumns = completness\n", ":2: [campaign] columns = completness: expected a key"),
                ("[grid]\nseed = 1\n[set]\nworld.a =\n", ":4: [set] world.a = : expected a value"),
                ("[grid]\nseed = 1\n[plot p]\nx = seed\n", ":4: [plot p] expected both x and y"),
                ("[grid]\nseed = 1\n[plot p]\nx = world.a\ny = completeness\n", ":4: [plot p] x = world.a"),
                ("[grid]\nseed = 1\n[plot p]\ny = height\n", ":4: [plot p] y = height: expected a key"),
                ("[grid]\nseed = 1\n[plot p]\nx = seed\ny = completeness\nseries = world.a\n",
                 ":4: [plot p] series = world.a: expected axes"),
                ("[grid]\nseed = 1\0\n", ":2: not a text file")):
            self.refuses(text, "c.ini" + message)

    def test_long_lines_and_names_are_read_whole(self):
        values = " | ".join(str(n) for n in range(200))
        self.assertEqual(len(self.jobs(f"[grid]\nworld.{'a' * 60} = {values}\n")), 200)

    def test_missing_file_is_named(self):
        for path, message in (("no/such.ini", "no/such.ini"), ("/tmp", "folder")):
            with self.assertRaises(CampaignError) as caught:
                read_campaign(path)
            self.assertIn(message, str(caught.exception))

    def test_provided_campaigns_expand(self):
        """Every file that the project brings can be flown: paths, keys and plots are right."""
        folder = os.path.join(ROOT, "sim", "campaigns")
        files = [os.path.join(folder, name) for name in os.listdir(folder) if name.endswith(".ini")]
        self.assertGreaterEqual(len(files), 5)
        for file in files:
            campaign = read_campaign(file)
            self.assertTrue(expand(campaign), file)
            self.assertTrue(campaign.about, file)


def job(kind, x, seed):
    axes = {"flight.kind": kind, "world.x": x, "seed": str(seed)}
    return Job(f"{kind}{x}-{seed}", "", axes)


def scored(**summary):
    return Result(complete=True, summary=summary)


class ResultTable(unittest.TestCase):
    """line at x = 1: 1, 2, 6; balloon at x = 1: 4 and a failure; line at x = 0.5: no number, and not run."""

    def setUp(self):
        self.jobs = [job("line", "1", 1), job("line", "1", 2), job("line", "1", 3), job("balloon", "1", 1),
                     job("balloon", "1", 2), job("line", "0.5", 1), job("line", "0.5", 2)]
        self.results = [scored(position_mean_percent=1.0, completeness=0.9, drift_percent=0.25),
                        scored(position_mean_percent=2.0, completeness=0.7),
                        scored(position_mean_percent=6.0, completeness=0.8, depth_nes=0.1),
                        scored(position_mean_percent=4.0, new_number=1.0 / 3),
                        Result('ended with status 1, "so"'),
                        scored(position_mean_percent=None),
                        None]
        self.campaign = Campaign("c.ini", name="c", columns=["position_mean_percent", "completeness", "drift_percent"])

    def plot(self, **request):
        return sweep_plot(Plot("a <b> & c", 1, **request), self.jobs, self.results)

    def test_markdown_has_mean_and_worst_of_each_cell(self):
        self.assertEqual(table_markdown(self.campaign, self.jobs, self.results),
                         "# c\n\nMean over the seeds, and the worst in parentheses.\n\n"
                         "| flight.kind | world.x | flights | position_mean_percent | completeness | drift_percent |\n"
                         "| --- | --- | ---: | ---: | ---: | ---: |\n"
                         "| line | 1 | 3 | 3.00 (6.00) | 0.800 (0.700) | 0.250 of 1 |\n"
                         "| balloon | 1 | 1 of 2 | 4.00 | – | – |\n"
                         "| line | 0.5 | 1 of 2 | – | – | – |\n")

    def test_compared_cells_show_differences_seed_by_seed_with_their_interval(self):
        jobs = [job(kind, "1", seed) for kind in ("line", "balloon", "hover") for seed in (1, 2, 3)]
        results = [scored(position_mean_percent=value) for value in (1.0, 2.0, 6.0, 2.0, 4.0, 6.0, 1.5, None, None)]
        campaign = Campaign("c.ini", name="c", columns=["position_mean_percent"], compare="flight.kind")
        lines = table_markdown(campaign, jobs, results).splitlines()
        # Differences 1, 2, 0: their standard deviation is 1, and 4.303 is the quantile of two degrees of freedom.
        self.assertEqual(lines[6:], ["| line | 1 | 3 | 3.00 (6.00) |", "| balloon | 1 | 3 | +1.0 ± 2.5 |",
                                     "| hover | 1 | 3 | +0.5 |"])
        self.assertIn("the mean difference from it with its 95 % interval", lines[2])

    def test_csv_has_every_job_in_the_order_of_the_grid(self):
        lines = table_csv(self.jobs, self.results).splitlines()
        self.assertTrue(lines[0].startswith("job,grid,flight.kind,world.x,seed,result,complete,"))
        self.assertIn(",new_number,failure", lines[0])
        self.assertEqual([line.split(",")[0] for line in lines[1:]], [job.name for job in self.jobs])
        self.assertIn("done,true", lines[4])
        self.assertIn("0.3333333333333333", lines[4], "in full precision")
        self.assertIn("balloon,1,2,failed,,", lines[5])
        self.assertIn(',"ended with status 1, ""so"""', lines[5])
        self.assertIn("not run", lines[7])
        self.assertEqual(lines[1].count(","), lines[0].count(","))

    def test_grids_of_the_same_axes_share_a_table(self):
        for at, grid in enumerate("aaabbcc"):
            self.jobs[at].grid = grid
        for at in (5, 6):
            del self.jobs[at].axes["flight.kind"]
        tables = cell_tables(self.jobs, self.results)
        self.assertEqual([table.grids for table in tables], [["a", "b"], ["c"]])
        self.assertEqual(tables[0].cells[1].results, self.results[3:5])
        self.assertEqual(len(tables[0].cells), 2)
        self.assertEqual(tables[1].axes, ["world.x"])
        self.assertEqual(len(tables[1].cells), 1)

    def test_worst_value_depends_on_what_is_good(self):
        values = [0.9, 0.6, 0.7]
        self.assertEqual(METRICS["rotation_mean_deg"].worst(values), 0.9)
        self.assertEqual(METRICS["completeness"].worst(values), 0.6)
        self.assertEqual(METRICS["sigma1_share"].worst(values), 0.9, "0.683 is right")
        self.assertEqual(METRICS["height_bias_percent"].worst([0.5, -0.8, 0.7]), -0.8)
        self.assertIsNone(METRICS["frames"].worst(values))
        self.assertIsNone(METRICS["completeness"].worst([]))

    def test_plot_has_a_dot_for_each_flight_and_a_line_through_the_means(self):
        plot = self.plot(x="world.x", y="position_mean_percent", series=["flight.kind"])
        self.assertEqual([series.name for series in plot.series], ["line", "balloon"])
        self.assertEqual(plot.series[0].dots, [(1, 1), (1, 2), (1, 6)])
        self.assertEqual(plot.series[0].means, [(1, 3)])
        self.assertEqual(plot.series[1].dots, [(1, 4)])
        self.assertEqual(plot.without_number, 3, "the failure, the missing number, the one not run")

    def test_plot_names_what_is_no_number_and_scatters_scores(self):
        named = self.plot(x="flight.kind", y="position_mean_percent")
        self.assertEqual(named.x_names, ["line", "balloon"])
        self.assertEqual(named.series[0].means, [(0, 3), (1, 4)])
        scatter = self.plot(x="completeness", y="position_mean_percent")
        self.assertEqual(scatter.series[0].dots, [(0.9, 1), (0.7, 2), (0.8, 6)])
        self.assertEqual(scatter.series[0].means, [])

    def test_drawn_dots_stand_where_their_values_are(self):
        """Heights of the drawn dots follow the values: the picture is read back."""
        self.jobs, self.results = self.jobs[:3], self.results[:3]
        svg = svg_file(self.plot(x="seed", y="position_mean_percent", series=["flight.kind"]))
        self.assertIn("a &lt;b&gt; &amp; c", svg)
        dots = [(float(x), float(y)) for x, y in re.findall(r'cx="([\d.]+)" cy="([\d.]+)"', svg)]
        self.assertGreaterEqual(len(dots), 3)
        (x0, y0), (x1, y1), (x2, y2) = dots[:3]
        self.assertAlmostEqual(x2 - x1, x1 - x0, delta=0.11, msg="seeds 1, 2, 3")
        self.assertGreater(x1, x0)
        self.assertAlmostEqual((y1 - y2) / (y0 - y1), 4, delta=0.05, msg="values 1, 2, 6, upwards")


if __name__ == "__main__":
    unittest.main()
