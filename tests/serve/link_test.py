#!/usr/bin/env python3
"""A flight in real time over UDP that loses packets appears on the page: link_test.py ILP_SIL ILP_GROUND WORK

A relay between flight and console drops every tenth packet in both directions (seed 1). In the middle of it the server of
the page is killed and started again."""
import os
import random
import shutil
import socket
import subprocess
import sys
import threading

import served
from served import Server, Stream, wait_for

sil, ground, work = sys.argv[1:4]
served.patience_s = 400


class LossyRelay:
    def __init__(self, flight_port):
        self.flight = ("127.0.0.1", flight_port)
        self.random, self.passed, self.lost = random.Random(1), 0, 0
        self.near = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.near.bind(("127.0.0.1", 0))
        self.far = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.far.connect(self.flight)
        self.station = None
        for work_ in (self.up, self.down):
            threading.Thread(target=work_, daemon=True).start()

    def port(self):
        return self.near.getsockname()[1]

    def loses(self):
        lost = self.random.random() < 0.1
        self.lost, self.passed = self.lost + lost, self.passed + (not lost)
        return lost

    def up(self):
        while True:
            packet, self.station = self.near.recvfrom(65536)
            try:
                if not self.loses():
                    self.far.send(packet)
            except OSError:
                pass  # the flight does not listen yet

    def down(self):
        while True:
            try:
                packet = self.far.recv(65536)
            except OSError:
                continue
            if self.station and not self.loses():
                self.near.sendto(packet, self.station)


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


shutil.rmtree(work, ignore_errors=True)
received = os.path.join(work, "received")
os.makedirs(received)
port = free_port()
relay = LossyRelay(port)
quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
processes = []
try:
    processes.append(subprocess.Popen(
        [sil, "--real-time", "--scenario", "mars-plains", "--out", os.path.join(work, "flight"), "--link-udp",
         f"127.0.0.1:{port}"], **quiet))
    processes.append(subprocess.Popen(
        [ground, "console", f"127.0.0.1:{relay.port()}", "--out", received], stdin=subprocess.PIPE, **quiet))
    server = Server(ground, received, "--listen", "127.0.0.1:0")
    processes.append(server.process)
    stream = Stream(server)
    for posed in (2, 4):
        wait_for(f"{posed} posed keyframes",
                 lambda: stream.items.get("totals", {}).get("final_poses", 0) >= posed and stream.items["run"]["problem"] == "")
        before = stream.keyframes()
        server.end()
        server = Server(ground, received, "--listen", "127.0.0.1:0")
        processes.append(server.process)
        stream = Stream(server, stream.place)
        wait_for("the same keyframes", lambda: set(before) <= set(stream.keyframes()))
        print(f"{posed} posed keyframes came, and were there after a restart of the server", flush=True)
    wait_for("a map", lambda: any("image" in stream.items[n] for n in list(stream.items) if n.startswith("map/")))
    assert relay.lost > 20, relay.lost
    print(f"{relay.passed} packets passed, {relay.lost} were lost; {len(stream.keyframes())} keyframes on the page")
finally:
    for process in processes:
        process.kill()
        process.wait()
