"""Flies on the board with troubles of its disk and with a flight that hangs, and compares with the same flight on the host.

Each case is a flight of its own: what was computed must be what an undisturbed flight on the host computes, every
product must come down, and the board must say what the case is about."""
import os
import sys
import time

import board as rig
import database
import fly
import images

WATCHDOG_S = 10
WITHOUT_ROOM_S = 10  # five until there is room, five until it is looked for again; a picture each
READ_ONLY_FOR_S = 10  # of the host's time, before the power goes
MEMORY_BUDGET_MIB = 8  # what a flight without a disk keeps, docs/onboard.md
FIRST, BOARD_RESET, WATCHDOG = 0, 3, 4  # reasons of a start


class Undisturbed(fly.Comparison):
    """With the database that the flight ends with; `may_miss` pictures may have found no room, or are of an earlier life."""

    def __init__(self, flight, may_miss=0, new_store_epoch=False):
        self.may_miss, self.new_store_epoch = may_miss, new_store_epoch
        super().__init__(flight)

    def expect(self, reasons, events):
        """Why the software had to start, and what it must have reported."""
        found = [row[0] for row in self.board.execute("SELECT reason FROM start ORDER BY id")]
        if found != reasons:
            self.problems.append(f"reasons of the starts: {found} instead of {reasons}")
        reported = {row[0] for row in self.board.execute("SELECT code FROM event")}
        self.problems += [f"no event {name}" for name in events if database.status_number(name) not in reported]
        return self


class Troubled(fly.Flight):
    # Small pictures: what is kept counts, not what is computed.
    scenario = fly.SMALL_PICTURES


class FullDisk(Troubled):
    """Others fill the disk to its last block, for a while."""

    before = "with trouble 6 full /data 5\n"

    def operate(self, board, port):
        while not board.lines("^trouble: .* full$"):
            self.listen(board, port)
        self.station.note_news()
        super().operate(board, port)

    def compare(self):
        return Undisturbed(self, may_miss=WITHOUT_ROOM_S).expect([FIRST], ["events_lost"]).run()


class ReadOnlyFromTheStart(Troubled):
    """A disk that cannot be written to: the records are kept in memory, with numbers by the calendar."""

    more_options = "--fly-on"

    def machine(self, life):
        return {"disk_read_only": True}

    def compare(self):
        """No database is left; on the host the same storage budget makes products of the same keyframes, with other random
        numbers."""
        problems = []
        if os.path.exists(self.path("disk/flight.db")):
            problems.append("there is a database on a disk for reading only")
        mission = self.path("host-mission.ini")
        with open(mission, "w", encoding="utf-8") as file:
            file.write(self.mission + f"\n[storage]\nstorage_budget_mib = {MEMORY_BUDGET_MIB}\n")
        out = fly.fly_host(self, self.strip.folder, mission)
        return problems + fly.compare_products(self, os.path.join(out, "outbox"), same_bytes=False)


class ReadOnlyInFlight(Troubled):
    """The kernel makes the disk one for reading only, as after an error; the next power cut heals it."""

    before = "with trouble 8 read-only\n"

    def __init__(self, options):
        super().__init__(options)
        self.kills = 1

    def be_killed(self, board, port, _):
        seen = None
        while seen is None or time.monotonic() - seen < READ_ONLY_FOR_S:
            self.listen(board, port)
            if seen is None and board.lines("^trouble: .* read-only$"):
                seen = time.monotonic()
        if board.lines("^board: .* ilp-onboard ended"):
            raise rig.BoardError(f"the flight ended:\n{board.tail()}")
        board.kill()

    def listen(self, board, port):
        if not board.lines(fly.LISTENS):
            board.listen(0.2)
            return
        super().listen(board, port)

    def compare(self):
        return Undisturbed(self).expect([FIRST, BOARD_RESET], ["started"]).run()


class DamagedDatabase(Troubled):
    """The database is overwritten in flight: the software ends, is started again, saves what there is and goes on."""

    DAMAGED_AT_S = 18
    before = f"with trouble {DAMAGED_AT_S} damage /data/flight.db\n"
    # More than the store keeps in its memory.
    scenario = ["flight.interval_s=1", "flight.drift_m_s=5"]
    more_options = "--fly-on"
    starts_again = True

    def compare(self):
        problems = [] if os.path.exists(self.path("disk/flight.db.aside-1")) else ["no database was quarantined"]
        return problems + Undisturbed(self, may_miss=self.options.frames, new_store_epoch=True).expect(
            [FIRST], ["store_salvaged"]).run()


class HangingFlight(Troubled):
    """The flight software stands still; the watchdog resets the board."""

    before = "with trouble 8 hang ilp-onboard\n"
    more_options = f"--watchdog /dev/watchdog:{WATCHDOG_S}"
    starts_again = True

    def machine(self, life):
        return {"watchdog": True}

    def compare(self):
        return Undisturbed(self).expect([FIRST, WATCHDOG], ["started"]).run()


CASES = {"full": FullDisk, "read-only": ReadOnlyFromTheStart, "turned-read-only": ReadOnlyInFlight,
         "damaged": DamagedDatabase, "hang": HangingFlight}


def parse():
    made = fly.parser("faults", __doc__)
    made.add_argument("--only", choices=CASES, help="one case instead of all")
    made.set_defaults(frames=20, disk_mib=64)
    return made.parse_args()


def main():
    options = parse()
    out, chosen, problems = options.out, options.set, []
    for name, case in CASES.items():
        if options.only not in (None, name):
            continue
        print(f"== {name}: {case.__doc__}", flush=True)
        options.out = os.path.join(out, name)
        options.set = chosen or case.scenario
        try:
            flight = case(options)
            flight.fly()
            found = flight.compare()
        except rig.BoardError as error:
            found = [str(error)]
        for problem in found[:20]:
            print(f"PROBLEM: {problem}", flush=True)
        problems += found
    print(f"{len(problems)} problems")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
