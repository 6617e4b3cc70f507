"""A server of ilp-ground serve under test, a stream of its events, files that arrive, and tests side by side."""
import concurrent.futures
import http.client
import io
import json
import os
import shutil
import socket
import subprocess
import sys
import threading
import time
import unittest

patience_s = 120
# A program that ends with the test, however the test ends. One that outlived a killed run would work on in the folder of
# the next one.
with_the_test = ["setpriv", "--pdeathsig", "KILL"]


def wait_for(what, condition):
    end = time.monotonic() + patience_s
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.05)
    raise AssertionError("waited in vain for " + what)


class Server:
    def __init__(self, ground, box, *options, **more):
        self.process = subprocess.Popen([*with_the_test, ground, "serve", box, *options], stdout=subprocess.PIPE, text=True, **more)
        first = self.process.stdout.readline()
        assert first.startswith("The flight is at http://"), first
        self.address = first.split("//")[1].strip()
        self.host, port = self.address.split(":")
        self.port = int(port)

    def get(self, path, method="GET", headers=None, body=None):
        connection = http.client.HTTPConnection(self.host, self.port, timeout=patience_s)
        try:
            connection.request(method, path, body=body, headers=headers or {})
            answer = connection.getresponse()
            return answer.status, dict(answer.getheaders()), answer.read()
        finally:
            connection.close()

    def state(self):
        return json.loads(self.get("/state")[2])["set"]

    def end(self):
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()


def own_hosts(server):
    """Names by which a server at 127.0.0.1 is served."""
    return [f"{name}:{server.port}" for name in ("localhost", "127.0.0.1", "[::1]")]


def foreign_hosts(server):
    port = str(server.port)
    other = str(server.port % 65535 + 1)
    return ["evil.example", "evil.example:" + port, "1.2.3.4:" + port, "192.168.0.1:" + port, "127.0.0.2:" + port, "127.0.0.1",
            "localhost", "localhost:" + other, "127.0.0.1:" + other, "[::1]:" + other, "localhost." + ":" + port,
            "127.0.0.1.evil.example:" + port, "[::2]:" + port, "", ":" + port, "127.0.0.1:" + port + "@evil.example"]


class SlowConnections:
    """Connections that begin a request and never end it, but say something again and again."""

    def __init__(self, server, beginnings):
        self.server, self.beginnings, self.open_ones = server, beginnings, []

    def open(self, count):
        for i in range(count):
            peer = socket.create_connection((self.server.host, self.server.port), timeout=patience_s)
            peer.sendall(self.beginnings[i % len(self.beginnings)])
            peer.setblocking(False)
            self.open_ones.append(peer)

    def drip(self):
        """An octet more from each; how many are open."""
        still = []
        for peer in self.open_ones:
            try:
                peer.send(b"x")
                # Nothing but its end comes from the server.
                peer.recv(1)
                peer.close()
            except BlockingIOError:
                still.append(peer)
            except OSError:
                peer.close()
        self.open_ones = still
        return len(still)


class Flood:
    """A thread that makes connections as fast as it can, the latest 100 of which stay open."""

    def __init__(self, server):
        self.server, self.made, self.going = server, 0, True
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def run(self):
        peers = []
        while self.going:
            try:
                peers.append(socket.create_connection((self.server.host, self.server.port), timeout=patience_s))
                self.made += 1
            except OSError:
                time.sleep(0.01)
            while len(peers) > 100:
                peers.pop(0).close()
        for peer in peers:
            peer.close()

    def end(self):
        self.going = False
        self.thread.join()
        return self.made


class Stream:
    """Follows /events as a page does: keeps the items and the place."""

    def __init__(self, server, place=None):
        self.items, self.place, self.updates, self.alive = {}, place, [], 0
        self.connection = http.client.HTTPConnection(server.host, server.port, timeout=patience_s)
        self.connection.request("GET", "/events", headers={"Last-Event-ID": place} if place else {})
        self.socket = self.connection.sock
        self.answer = self.connection.getresponse()
        self.thread = threading.Thread(target=self.follow, daemon=True)
        self.thread.start()

    def close(self):
        self.socket.shutdown(socket.SHUT_RDWR)

    def follow(self):
        event = {}
        try:
            for line in self.answer:
                name, _, value = line.decode().rstrip("\n").partition(": ")
                if name:
                    event[name] = value
                    continue
                if "data" in event and "id" in event:
                    self.take(event)
                elif event.get("event") == "alive":
                    self.alive += 1
                event = {}
        except (OSError, http.client.HTTPException, ValueError, AttributeError):
            pass  # the server or the test has ended the connection

    def take(self, event):
        update = json.loads(event["data"])
        if update["full"]:
            self.items = {}
        self.items = {**self.items, **update["set"]}
        for name in update["gone"]:
            del self.items[name]
        self.updates.append((update, len(event["data"])))
        self.place = event["id"]

    def keyframes(self):
        return sorted(int(name[10:]) for name in list(self.items) if name.startswith("keyframes/"))


def deliver(source, box, names):
    """Files arrive whole, under their names, as a station leaves them."""
    for name in names:
        part = os.path.join(box, "." + name + ".part")
        shutil.copyfile(os.path.join(source, name), part)
        os.rename(part, os.path.join(box, name))


def of_keyframes(source, first, last):
    """Names of the files of these keyframes, such as records-000003.ilp and product-000003-image.jp2."""
    return [name for name in sorted(os.listdir(source))
            if name.startswith(("records-", "product-")) and first <= int(name.split("-")[1][:6]) <= last]


def run_side_by_side(case, names, at_once=6):
    """Runs the tests of a class in threads, since most of them wait for a clock, and ends the process."""
    def run(name):
        told = io.StringIO()
        begin = time.monotonic()
        result = unittest.TextTestRunner(told, verbosity=2, warnings="ignore").run(case(name))
        return result.wasSuccessful(), f"{time.monotonic() - begin:.1f} s\n{told.getvalue()}"

    names = names or unittest.defaultTestLoader.getTestCaseNames(case)
    case.setUpClass()
    with concurrent.futures.ThreadPoolExecutor(at_once) as threads:
        results = list(threads.map(run, names))
    for _, told in results:
        print(told)
    failed = [name for name, (passed, _) in zip(names, results) if not passed]
    sys.exit("failed: " + ", ".join(failed) if failed else 0)
