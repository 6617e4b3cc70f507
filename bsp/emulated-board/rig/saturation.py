"""Flies on a board that is too slow for its pictures: work has to be reduced by rule, and restored when the pictures end.

The table says when, and what the minor frames were like. It is a problem when no work was reduced, when it is not
restored, when an overrun was not reported, or when a picture or a product is missing."""
import board as rig
import database
import fly

RECOVERY_S = 130  # of two levels with the default windows (docs/parameters.md), and the one that was begun before
REASONS = {1: "overruns", 2: "frames wait", 3: "keyframes wait"}


class Saturated(fly.Flight):
    executive = ""  # with degraded modes, as by default

    def machine(self, life):
        return {"ns_per_instruction_shift": self.options.slow}

    def operate(self, board, port):
        super().operate(board, port)
        until_s = self.station.seconds() + RECOVERY_S
        while self.station.seconds() < until_s:
            self.listen(board, port)


def parse():
    made = fly.parser("saturation", __doc__)
    made.add_argument("--slow", type=int, default=2, help="log2 of the time of an instruction in ns (2: 4 ns, 250 MIPS)")
    made.set_defaults(frames=60)
    options = made.parse_args()
    if not options.strip and not options.set:
        options.set = ["flight.interval_s=1", "flight.drift_m_s=5"]
    return options


class Account:
    """What the flight's database tells about its load."""

    def __init__(self, flight):
        self.flight = flight
        self.rows = database.open_database(flight.path("disk/flight.db"))
        self.problems = []

    def events(self, name):
        return list(self.rows.execute("SELECT time_ns, a, b FROM event WHERE code = ? ORDER BY id",
                                      (database.status_number(name),)))

    def levels(self):
        changes = [(at, level, REASONS.get(why, why)) for at, level, why in self.events("work_reduced")]
        reduced = len(changes)
        changes += [(at, level, "") for at, level, _ in self.events("work_restored")]
        for at, level, why in sorted(changes):
            print(f"{at / 1e9:8.1f} s: level {level}{', ' + why if why else ''}")
        keyframes = self.rows.execute("SELECT degraded, count(*) FROM keyframe GROUP BY degraded ORDER BY degraded")
        print("keyframes by level:", ", ".join(f"{level}: {count}" for level, count in keyframes))
        level, count = self.rows.execute("SELECT degraded, degraded_changes FROM timing").fetchone()
        if not reduced:
            self.problems.append("work was never reduced")
        if level != 0:
            self.problems.append(f"work is still at level {level}")
        if count != len(changes):
            self.problems.append(f"{count} changes of the level, {len(changes)} of them reported")

    def overruns(self):
        frames, overruns, longest, latest = self.rows.execute(
            "SELECT frames, overruns, longest_ns, latest_ns FROM timing").fetchone()
        told = len(self.events("frame_overrun")) + sum(count for _, count, _ in self.events("frames_overran"))
        print(f"{frames} minor frames, {overruns} overran, {told} of them reported; the longest took "
              f"{longest / 1e6:.0f} ms, the latest began {latest / 1e6:.0f} ms late")
        if told < overruns:
            self.problems.append(f"{overruns - told} overruns were not reported")

    def pictures(self):
        wanted = [time_ns for time_ns, _ in self.flight.strip.frames]
        taken = {time_ns for _, time_ns, _ in database.frames(self.rows)}
        missing = [time_ns for time_ns in wanted if time_ns not in taken]
        keyframes = self.rows.execute("SELECT count(*) FROM keyframe").fetchone()[0]
        print(f"{len(wanted) - len(missing)} of {len(wanted)} pictures taken, {keyframes} keyframes")
        if missing:
            self.problems.append(f"{len(missing)} pictures were never taken")
        outstanding = database.products_on_ground(self.rows)
        if outstanding:
            self.problems.append(f"products that the ground does not hold, by state: {outstanding}")

    def tell(self):
        self.pictures()
        self.levels()
        self.overruns()
        return self.problems


def main():
    options = parse()
    flight = Saturated(options)
    flight.fly()
    return rig.report(Account(flight).tell())


if __name__ == "__main__":
    rig.run(main, "saturation")
