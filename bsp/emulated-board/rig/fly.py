"""Flies a strip on the emulated board, takes its products on the ground, and compares with the same flight on the host."""
import argparse
import filecmp
import os
import random
import re
import shutil
import subprocess
import tempfile
import time

import board as rig
import database
import images
import station as ground
import strip as strips

HOST = os.path.join(images.ROOT, "build/host/bin")
BOOT_S = 300  # a loaded host boots slowly
LEAD_S = 20   # between the feeder's start and the first picture of the strip: the flight software starts in it
CAPTURE_S = 2  # until the last picture that was commanded is taken
PATIENCE_S = 180  # without any news
SETTLE_S = 10  # without news when nothing is left on board
DATA_DISK_MIB = 512
KILL_AFTER_S = (0.5, 20)  # of the start of the board
FEEDER_BEGINS = r"^feeder: .* UTC (\d+) ns"
LISTENS = "packets over TCP at"
PING_MS = 331  # no multiple of the minor frame, so that pings meet all of it
# For flights of which not the computation matters but what is kept.
SMALL_PICTURES = ["camera.width=320", "camera.height=240", "camera.fx=275", "camera.fy=275", "camera.cx=-1",
                  "camera.cy=-1", "flight.interval_s=1", "flight.drift_m_s=5"]


def host_program(name):
    return os.path.join(HOST, name)


def parser(name, text):
    """The options of every flight on the board."""
    made = argparse.ArgumentParser(prog=f"bsp/emulated-board/{name}", description=text)
    made.add_argument("--out", required=True, help="new folder for everything that the flight leaves")
    made.add_argument("--frames", type=int, default=60, help="number of frames of the simulated flight (60)")
    made.add_argument("--strip", help="folder with index.txt, cameras.txt and images that takes the place of a simulated flight")
    made.add_argument("--set", action="append", default=[], help="section.name=value: changes the scenario, as ilp-sil --set does")
    made.add_argument("--mission", help="mission parameters, an .ini file")
    made.add_argument("--images", help="folder of kernel and initramfs (build/board)",
                      default=images.BUILT)
    made.add_argument("--seed", type=int, default=1, help="seed of the instants at which the power fails")
    made.set_defaults(recorded=True, kills=0, write_log=False, ping=False, disk_mib=DATA_DISK_MIB)
    return made


def parse():
    made = parser("fly", __doc__)
    made.add_argument("--recorded", action="store_true", default=False,
                      help="read the strip from the disk, not through the camera")
    made.add_argument("--kills", type=int, default=0, help="number of times that the board is killed and started again (0)")
    made.add_argument("--ping", action="store_true",
                      help="ask the flight three times a second whether it is alive, and print the longest time to the answer")
    options = made.parse_args()
    if options.kills and not options.recorded:
        made.error("--kills wants --recorded: the camera does not wait for the board")
    return options


def mission_text(path, more):
    text = ""
    if path:
        with open(path, encoding="utf-8") as file:
            text = file.read()
    return text + more


def seconds(time_ns):
    """Exactly, in decimal digits."""
    return f"{time_ns // 10**9}.{time_ns % 10**9:09d}"


class Flight:
    """One flight on the board, from its start to the files that it leaves in `out`."""

    # The host's flight is one of full work, and has the time for it.
    executive = "\n[executive]\ndegraded_modes = 0\n"
    # Lines of /flight/run before that of the flight software, and more options of that.
    before = more_options = ""
    # The flight software may end and be started again within a life of the board.
    starts_again = False

    def __init__(self, options):
        self.options = options
        self.kills = options.kills
        self.out = os.path.abspath(options.out)
        os.makedirs(self.out)
        if options.strip:
            self.strip = strips.Strip(options.strip)
        else:
            self.strip = strips.render(host_program("ilp-sil"), self.path("simulated"), options.frames, options.set)
        # With the camera every picture is taken once, by telecommand.
        more = "" if options.recorded else "\n[acquisition]\ncapture_mode = 2\n"
        self.mission = mission_text(options.mission, self.executive + more)
        flight = {"run": self.commands().encode(), "mission.ini": self.mission.encode()}
        self.images = images.with_flight(images.built(options.images), flight, self.path("initramfs.cpio"))
        with tempfile.TemporaryDirectory() as folder:
            self.strip.copy_for_disk(os.path.join(folder, "strip"))
            size = sum(os.path.getsize(path) for _, path in self.strip.frames)
            images.make_disk(self.path("frames.img"), (size >> 20) * 11 // 10 + 16, os.path.join(folder, "strip"))
        images.make_disk(self.path("data.img"), options.disk_mib)
        self.held = []
        self.station, self.starts_met = None, 0

    def path(self, name):
        return os.path.join(self.out, name)

    def commands(self):
        feeder = "" if self.options.recorded else f"with feeder /dev/video0 /dev/video1 /frames/index.txt {LEAD_S}\n"
        pinger = f"with pinger 10.0.2.15 {rig.LINK_PORT} {PING_MS}\n" if self.options.ping else ""
        source = "--index /frames/index.txt" if self.options.recorded else "--v4l2 /dev/video0,format=GREY"
        return (f'{feeder}{pinger}{self.before}run ilp-onboard {source} --camera "{self.strip.camera()}" '
                f"--database /data/flight.db --mission /flight/mission.ini --link-tcp 10.0.2.15:{rig.LINK_PORT} "
                "--without-authentication "
                f"--trap-heap {self.more_options}\n")

    def interval_ns(self):
        times = [time_ns for time_ns, _ in self.strip.frames]
        return (times[-1] - times[0]) // max(len(times) - 1, 1)

    def fly(self):
        """Lives that end in a power cut at any instant, then one that ends well."""
        chance = random.Random(self.options.seed)
        self.begin = time.monotonic()
        for life in range(self.kills):
            self.live(life, chance.uniform(*KILL_AFTER_S))
        self.live(self.kills, None)
        images.read_disk(self.path("data.img"), self.path("disk"))

    def machine(self, life):
        """What is special about the board in that life (rig.Board)."""
        return {}

    def live(self, life, kill_after_s):
        port = rig.free_port()
        log = "console.log" if self.kills == 0 else f"console-{life + 1}.log"
        write_log = self.path("write.log") if self.options.write_log else None
        with rig.Board(self.images, self.path(log), self.path("data.img"), self.path("frames.img"), port,
                       write_log, **self.machine(life)) as board:
            try:
                if kill_after_s is None:
                    self.end_well(board, port)
                else:
                    self.be_killed(board, port, kill_after_s)
            finally:
                self.leave_station()

    def meet_board(self, board, port):
        """A station for each start of the flight software, as soon as that listens."""
        starts = len(board.lines(LISTENS))
        if starts == self.starts_met:
            return
        self.leave_station()
        self.starts_met = starts
        self.station = ground.Station(host_program("ilp-board-station"), port, self.path("ground"),
                                      self.path("station.log"),
                                      self.path("write.log") if self.options.write_log else None)

    def leave_station(self):
        if self.station is not None:
            self.station.end()
            self.held += self.station.held
        self.station, self.starts_met = None, 0

    def be_killed(self, board, port, kill_after_s):
        while time.monotonic() - board.begin < kill_after_s and board.listen(0.02):
            self.meet_board(board, port)
        board.kill()

    def end_well(self, board, port):
        board.wait_for("^board: .* ready$", BOOT_S)
        print(f"board ready after {time.monotonic() - board.begin:.1f} s", flush=True)
        board.wait_for(LISTENS, BOOT_S)
        self.meet_board(board, port)
        self.operate(board, port)
        self.leave_station()
        board.stop()
        ended = board.lines(r"^board: .* ilp-onboard ended (.*)$")
        if not ended or ended[-1][1] != "with 0":
            raise rig.BoardError(f"ilp-onboard did not end well:\n{board.tail()}")
        if board.lines("there is no worker"):
            raise rig.BoardError("products were coded in steps, because the worker's thread could not be started")
        self.strip_begin_ns = [int(match[1]) for match in board.lines(FEEDER_BEGINS)]
        pings = board.lines(r"^pings (\d+) lost (\d+) longest_ms (\S+) ")
        if pings:
            print(f"{pings[-1][1]} pings, {pings[-1][2]} without an answer, the longest took {pings[-1][3]} ms", flush=True)
        names = {name for name, _, _, _ in self.held}
        print(f"flown in {time.monotonic() - self.begin:.0f} s; {len(names)} files on the ground", flush=True)

    def operate(self, board, port):
        if self.options.recorded:
            # Of the board's clock, which may be slower than the host's.
            end_s = (self.strip.frames[-1][0] + self.interval_ns()) // 10**9 + 1
            while self.station.seconds() < end_s:
                self.listen(board, port)
        else:
            self.take_pictures(board, port)
        while not self.station.quiet(SETTLE_S):
            self.listen(board, port)

    def take_pictures(self, board, port):
        """Each in the middle of the time for which it is shown."""
        first_ns = int(board.wait_for(FEEDER_BEGINS, BOOT_S)[1]) + self.interval_ns() // 2
        self.station.tell(f"captures {first_ns} {self.interval_ns()} {len(self.strip.frames)}")
        while not board.lines("^feeder: .* pictures shown"):
            self.listen(board, port)
        last_s = self.station.seconds() + self.interval_ns() // 10**9 + CAPTURE_S
        while self.station.seconds() < last_s:
            self.listen(board, port)
        self.station.tell("end-strip")

    def listen(self, board, port):
        if not board.listen(0.2):
            raise rig.BoardError(f"the board went off; it said:\n{board.tail()}")
        self.meet_board(board, port)
        self.station.listen()
        if "refused" in self.station.answers:
            raise rig.BoardError(f"a telecommand was not carried out; the board said:\n{board.tail()}")
        if self.station.process.poll() is not None and not self.starts_again:
            raise rig.BoardError("the ground station ended: see station.log")
        if time.monotonic() - self.station.news > PATIENCE_S:
            raise rig.BoardError(f"the flight does not go on; the board said:\n{board.tail()}")


def fly_host(flight, folder, mission, more=()):
    """ilp-sil over a recorded strip with the flight's camera; the folder that it leaves."""
    out = flight.path("host")
    words = [host_program("ilp-sil"), "--images", folder, "--camera", os.path.join(flight.strip.folder, "cameras.txt"),
             "--mission", mission, "--out", out, *more]
    flown = subprocess.run(words, capture_output=True, text=True)
    if flown.returncode != 0:
        raise rig.BoardError(f"ilp-sil: {flown.stderr[-500:]}")
    return out


PRODUCT = re.compile(r"product-(\d+)(-.*)")


def product_names(names, since):
    """{(keyframe, counted from the first one; rest of the name): name} of products of keyframes from `since` on."""
    found = [(int(match[1]), match[2], match[0]) for match in map(PRODUCT.fullmatch, names) if match]
    found = [name for name in found if name[0] >= since]
    first = min((name[0] for name in found), default=0)
    return {(number - first, rest): name for number, rest, name in found}


def compare_products(flight, outbox, since=0, same_bytes=True):
    """Problems with the files of products: on the ground and in the host's outbox."""
    same, problems = 0, []
    ground = product_names((held[0] for held in flight.held), since)
    host = product_names(os.listdir(outbox), 0)
    for key in sorted(ground.keys() | host.keys()):
        if key not in ground or key not in host:
            missing = os.path.join(outbox, ground[key]) if key in ground else flight.path(f"ground/{host[key]}")
            problems.append(f"{missing} is missing")
            continue
        paths = flight.path(f"ground/{ground[key]}"), os.path.join(outbox, host[key])
        if same_bytes and not filecmp.cmp(*paths, shallow=False):
            problems.append(f"{ground[key]} differs")
            continue
        same += 1
    print(f"{same} files of products are " + ("the same, byte for byte" if same_bytes else "of the same keyframes"))
    return problems


class Comparison:
    """The frames of the board as a recorded strip, flown by the host in virtual time."""

    may_miss = 0  # pictures that the board did not take
    new_store_epoch = False  # only what the present store epoch has is compared, by its own numbers

    def __init__(self, flight):
        self.flight = flight
        self.board = database.open_database(flight.path("disk/flight.db"))
        self.problems = []
        self.first_number = database.first_number(self.board) if self.new_store_epoch else 0

    def shown(self, time_ns):
        """The picture that the camera saw at that mission time."""
        frames = self.flight.strip.frames
        if self.flight.options.recorded:
            return next((path for at, path in frames if at == time_ns), None)
        begin_ns = self.flight.strip_begin_ns[0] - database.mission_epoch_unix(self.board) * 10**9
        due = [path for at, path in frames if begin_ns + at <= time_ns]
        return due[-1] if due else frames[0][1]

    def write_strip(self):
        """Index and images as the board says that it took them."""
        folder = self.flight.path("as-taken")
        os.makedirs(folder)
        kept = database.kept_images(self.board)
        pictures, lines = set(), []
        for frame_id, time_ns, name in database.frames(self.board):
            if frame_id < self.first_number:
                continue
            path = self.shown(time_ns)
            if path is None:
                self.problems.append(f"frame {frame_id}: no picture has its time")
                continue
            pictures.add(path)
            os.makedirs(os.path.join(folder, str(frame_id)))
            shutil.copyfile(path, os.path.join(folder, str(frame_id), name))
            lines.append((time_ns, f"{frame_id}/{name}"))
            with open(path, "rb") as file:
                if frame_id in kept and not file.read().endswith(kept[frame_id]):
                    self.problems.append(f"frame {frame_id} is not the picture {os.path.basename(path)}")
        missed = [(time_ns, "not-taken.pgm") for time_ns, path in self.flight.strip.frames if path not in pictures]
        if len(missed) > self.may_miss:
            self.problems.append(f"{len(missed)} pictures were never taken")
        if self.flight.options.recorded:
            # The gap in the count of frames is the host's too.
            lines = sorted(lines + missed)
        with open(os.path.join(folder, "index.txt"), "w", encoding="utf-8") as index:
            index.writelines(f"{time_ns} {name}\n" for time_ns, name in lines)
        print(f"{len(pictures)} of {len(self.flight.strip.frames)} pictures taken")
        return folder

    def mission(self):
        """As on board: the file's parameters, then what was set there."""
        text = self.flight.mission
        for name, value in database.settings(self.board):
            section, key = name.split(".")
            text += f"\n[{section}]\n{key} = {value!r}\n"
        return text

    def fly_host(self, folder):
        """What was captured by telecommand is commanded for the time of its exposure."""
        mission, telecommands = self.flight.path("host-mission.ini"), self.flight.path("host-telecommands.txt")
        with open(mission, "w", encoding="utf-8") as file:
            file.write(self.mission())
        with open(telecommands, "w", encoding="utf-8") as file:
            for at_ns in database.commanded_exposures(self.board):
                file.write(f"{seconds(at_ns - 10**9)} capture {seconds(at_ns)}\n")
        return fly_host(self.flight, folder, mission, ["--telecommands", telecommands])

    def run(self):
        outstanding = database.products_on_ground(self.board)
        if outstanding:
            self.problems.append(f"products that the ground does not hold, by state: {outstanding}")
        out = self.fly_host(self.write_strip())
        host = database.open_database(os.path.join(out, "flight.db"))
        different = database.differences(self.board, host, self.first_number)
        self.problems += different
        keyframes = self.board.execute("SELECT count(*) FROM keyframe").fetchone()[0]
        print(f"{keyframes} keyframes; {len(database.results(self.board, self.first_number))} records compared, {len(different)} differ")
        return self.problems + compare_products(self.flight, os.path.join(out, "outbox"), self.first_number,
                                                same_bytes=not self.new_store_epoch)


def main():
    options = parse()
    flight = Flight(options)
    flight.fly()
    return rig.report(Comparison(flight).run(), 20, "the board's flight is the host's flight")


if __name__ == "__main__":
    rig.run(main, "fly")
