"""Flies on the board with a log of every write and flush of its disk, then cuts the power at random places of the log.

Behind each cut the disk is checked, the database is read, and the host's ilp-onboard goes on with it to the end of the
strip. The database must be whole; nothing may count as confirmed that the ground did not hold by then; and every record
and every product must be that of the flight without a cut."""
import os
import random
import shutil
import sqlite3
import subprocess

import board as rig
import database
import fly
import images
import write_log

CONFIRMED = "SELECT name FROM downlink WHERE acknowledged_ns <> 0"
DATABASE_FILES = {"flight.db", "flight.db-wal", "flight.db-shm", "lost+found"}
LONGEST_RESUME_S = 600
# With the capacities of the board: checkpoints of another profile are none.
RESUMES = os.path.join(images.ROOT, "build/flight/bin/ilp-onboard")


def parse():
    made = fly.parser("power-cuts", __doc__)
    made.add_argument("--cuts", type=int, default=120, help="number of power cuts (120)")
    # Small pictures: what is written counts, not what is computed.
    made.set_defaults(frames=30, write_log=True, disk_mib=96)
    options = made.parse_args()
    if not options.strip and not options.set:
        options.set = fly.SMALL_PICTURES
    return options


class Undisturbed:
    """What the flight on the board came to without a cut."""

    def __init__(self, flight):
        self.flight = flight
        self.database = database.open_database(flight.path("disk/flight.db"))
        self.positions = {}
        for name, _, _, position in flight.held:
            self.positions.setdefault(name, position)
        self.products = {}
        for name in self.positions:
            if name.startswith("product-"):
                with open(flight.path(os.path.join("ground", name)), "rb") as file:
                    self.products[name] = file.read()
        self.mission = flight.path("resumed.ini")
        with open(self.mission, "w", encoding="utf-8") as file:
            file.write(flight.mission)
            for name, value in database.settings(self.database):
                section, key = name.split(".")
                file.write(f"\n[{section}]\n{key} = {value!r}\n")


class Cut:
    """One cut and what came of it: `problems` is empty when all is well."""

    def __init__(self, undisturbed, folder, end):
        self.undisturbed, self.folder, self.end = undisturbed, folder, end
        self.problems = []
        self.confirmed = set()

    def path(self, name):
        return os.path.join(self.folder, name)

    def examine(self, image):
        status = images.check_disk(image)
        if status > 1:
            self.problems.append(f"e2fsck ended with {status}")
        images.read_disk(image, self.path("disk"))
        if os.path.exists(self.path("disk/flight.db")):
            self.examine_database()
        self.resume()

    def examine_database(self):
        """On a copy: the flight software shall find the files as the cut left them."""
        shutil.copytree(self.path("disk"), self.path("examined"))
        try:
            found = sqlite3.connect(self.path("examined/flight.db"))
            verdict, = found.execute("PRAGMA integrity_check").fetchone()
            if verdict != "ok":
                self.problems.append(f"database: {verdict}")
            if found.execute("SELECT 1 FROM sqlite_master WHERE name = 'downlink'").fetchone():
                self.confirmed = {row[0] for row in found.execute(CONFIRMED)}
            found.close()
        except sqlite3.DatabaseError as error:
            self.problems.append(f"database: {error}")
        for name in sorted(self.confirmed):
            if self.undisturbed.positions.get(name, self.end) >= self.end:
                self.problems.append(f"{name} counts as confirmed, but the ground did not hold it yet")

    def resume(self):
        os.makedirs(self.path("disk"), exist_ok=True)
        for name in ("outbox", "acknowledged"):
            os.makedirs(self.path(name))
        flight = self.undisturbed.flight
        index = os.path.join(flight.strip.folder, "index.txt")
        words = [RESUMES, "--virtual-time", "--index", index, "--camera", flight.strip.camera(),
                 "--mission", self.undisturbed.mission, "--database", self.path("disk/flight.db"),
                 "--outbox", self.path("outbox"), "--acknowledgements", self.path("acknowledged")]
        flown = subprocess.run(words, capture_output=True, text=True, timeout=LONGEST_RESUME_S)
        if flown.returncode != 0:
            self.problems.append(f"does not resume: {flown.stderr.strip()[-300:]}")
            return
        aside = set(os.listdir(self.path("disk"))) - DATABASE_FILES
        if aside:
            self.problems.append(f"left beside the database: {', '.join(sorted(aside))}")
        resumed = database.open_database(self.path("disk/flight.db"))
        for line in database.differences(self.undisturbed.database, resumed):
            # Those that are confirmed leave the table.
            if not line.startswith("product "):
                self.problems.append(line)
        self.find_products(resumed)

    def find_products(self, resumed):
        """Each is in the outbox, still on board, or was confirmed before the cut; always the same bytes."""
        on_board = database.products_on_board(resumed)
        for name, content in self.undisturbed.products.items():
            places = [on_board[name]] if name in on_board else []
            if os.path.exists(self.path(os.path.join("outbox", name))):
                with open(self.path(os.path.join("outbox", name)), "rb") as file:
                    places.append(file.read())
            if not places and name not in self.confirmed:
                self.problems.append(f"{name} is lost")
            if any(place != content for place in places):
                self.problems.append(f"{name} is another one")


def places(log, count, chance):
    """Entries before which the power goes: every second one where several writes are on their way."""
    ends = list(range(1, len(log.entries) + 1))
    under_way = [len(log.writes(log.last_flush(end), end)) for end in ends]
    worst = [end for end, writes in zip(ends, under_way) if writes >= 2] or ends
    return sorted(chance.choice(worst if i % 2 else ends) for i in range(count))


def cut_all(flight, options):
    undisturbed = Undisturbed(flight)
    log = write_log.WriteLog(flight.path("write.log"))
    writes, flushes = log.count()
    print(f"{writes} writes and {flushes} flushes; {len(undisturbed.products)} products", flush=True)
    chance = random.Random(options.seed)
    disk = write_log.CutDisk(log, flight.path("base.img"), flight.path("durable.img"))
    lost = confirmed = torn_cuts = bad = 0
    for number, end in enumerate(places(log, options.cuts, chance)):
        folder = flight.path(f"cut-{number + 1}")
        os.makedirs(folder)
        torn = number % 2 == 1
        torn_cuts += torn
        lost += disk.cut(end, torn, chance, flight.path("cut.img"))
        cut = Cut(undisturbed, folder, end)
        cut.examine(flight.path("cut.img"))
        confirmed += len(cut.confirmed)
        if cut.problems:
            bad += 1
            print(f"PROBLEM: cut {number + 1} at entry {end}: {'; '.join(cut.problems[:5])}", flush=True)
        else:
            shutil.rmtree(folder)
    print(f"{options.cuts} cuts, {torn_cuts} of them with torn writes; {lost} writes lost or torn; "
          f"{confirmed} confirmed files found confirmed")
    print(f"{bad} cuts with problems")
    return bad


def main():
    options = parse()
    if not os.path.exists(RESUMES):
        raise rig.BoardError(f"{RESUMES} is not built: bsp/emulated-board/prepare flight")
    flight = fly.Flight(options)
    shutil.copyfile(flight.path("data.img"), flight.path("base.img"))
    flight.fly()
    return 1 if cut_all(flight, options) else 0


if __name__ == "__main__":
    rig.run(main, "power-cuts")
