"""The ground station of the board (sim/board), a process that is driven by lines."""
import os
import re
import subprocess
import time


class Station:
    """`held` has (name, bytes, CRC-32, position in the write log) of every file, in the order of arrival."""

    def __init__(self, program, port, folder, log_path, write_log=None):
        words = [program, f"127.0.0.1:{port}", folder] + ([write_log] if write_log else [])
        self._log_path = log_path
        self._log = open(log_path, "ab")
        self.process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=self._log, stderr=subprocess.STDOUT)
        self._read = os.path.getsize(log_path)
        self.held = []
        self.answers = []
        self.progress = {}
        self.news = time.monotonic()
        self._news_s = 0

    def listen(self):
        """Reads what the station has printed so far."""
        with open(self._log_path, "rb") as log:
            log.seek(self._read)
            text = log.read()
        whole = text.rfind(b"\n") + 1
        self._read += whole
        for line in text[:whole].decode().splitlines():
            held = re.match(r"held (\S+) (\d+) (\d+) (\d+)$", line)
            progress = re.match(r"(seconds|products|steps) (\d+)$", line)
            if held:
                self.held.append((held[1], int(held[2]), int(held[3]), int(held[4])))
                self.note_news()
            elif progress:
                what, number = progress[1], int(progress[2])
                news = what != "seconds" and self.progress.get(what) != number
                self.progress[what] = number
                if news:
                    self.note_news()
            else:
                self.answers.append(line)

    def seconds(self):
        """Mission time in the last report of the board."""
        return self.progress.get("seconds", 0)

    def note_news(self):
        """Quiet is counted from here on."""
        self.news = time.monotonic()
        self._news_s = self.seconds()

    def tell(self, line):
        self.process.stdin.write(line.encode() + b"\n")
        self.process.stdin.flush()

    def quiet(self, seconds):
        """Whether no product is on board and no component has worked on an image for this time, by the board's clock."""
        self.listen()
        return self.progress.get("products") == 0 and self.seconds() - self._news_s > seconds

    def end(self):
        if self.process.poll() is None:
            try:
                self.tell("quit")
                self.process.wait(10)
            except (OSError, subprocess.TimeoutExpired):
                self.process.kill()
                self.process.wait()
        self.listen()
        self._log.close()
