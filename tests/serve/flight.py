"""A small flight in real time, with its packet link at a port of its own."""
import os
import signal
import subprocess
import sys
import time

from served import with_the_test


class Flight:
    """ilp-sil with a camera of 192 x 144 pixels that takes images by telecommand only."""

    def __init__(self, sil, folder, *options, mission_lines=""):
        os.makedirs(folder, exist_ok=True)
        self.log, mission = os.path.join(folder, "log"), os.path.join(folder, "mission.ini")
        with open(mission, "w") as file:
            file.write("[acquisition]\ncapture_mode = 2\n" + mission_lines)
        command = [*with_the_test, sil, "--real-time", "--mission", mission, "--out", os.path.join(folder, "flight"), "--link-udp",
                   "127.0.0.1:0", *options]
        for setting in ("camera.width=192", "camera.height=144", "camera.fx=165", "camera.fy=165", "camera.cx=-1",
                        "camera.cy=-1", "flight.drift_m_s=12"):
            command += ["--set", setting]
        with open(self.log, "w") as log:
            self.process = subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT)
        self.address = self.find_address()

    def find_address(self):
        for _ in range(1200):
            with open(self.log) as log:
                lines = log.readlines()
            for line in lines:
                if "packets over UDP" in line:
                    return line.split()[-1]
            assert self.process.poll() is None, "the flight does not start: " + "".join(lines)
            time.sleep(0.1)
        raise AssertionError("the flight does not say its address")

    def end(self):
        self.process.kill()
        self.process.wait()


if __name__ == "__main__":
    flight = Flight(*sys.argv[1:])
    signal.signal(signal.SIGTERM, lambda *_: flight.process.kill())
    print(flight.address, flush=True)
    flight.process.wait()
