#!/usr/bin/env python3
"""A ground station that knows a flight from its XTCE database alone: it sends every command of the database to
ilp-sil, and decodes all that comes back. Each value must be that of the project's own decoder.

    agree.py --xtce ilp-xtce --sil ilp-sil --decode decode_packets --folder FOLDER [--schema FILE]
"""

import argparse
import concurrent.futures
import json
import math
import os
import shutil
import socket
import subprocess
import sys
import time
from fractions import Fraction

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import xtce_reader  # noqa: E402

ROOT = "/ILP"
# Seconds from 1958-01-01 to 1970-01-01.
UNIX_IN_1958 = 4383 * 86400
# What the flight must have sent, besides every report of housekeeping.
WANTED = ["TM_1_1", "TM_1_2", "TM_1_3", "TM_1_4", "TM_1_5", "TM_1_7", "TM_5_1", "TM_5_8", "TM_11_10",
          "TM_11_13", "TM_17_2", "TM_17_4", "TM_20_2", "cfdp"]
SILENCING = "PASSEND"


def check(condition, message):
    if not condition:
        raise AssertionError(message)


class Flight:
    """ilp-sil in real time, and a socket to it."""

    def __init__(self, options, mission):
        self.log = os.path.join(options.folder, "log")
        command = [options.sil, "--real-time", "--mission", mission, "--out", os.path.join(options.folder, "flight"),
                   "--link-udp", "127.0.0.1:0"]
        for setting in ("camera.width=192", "camera.height=144", "camera.fx=165", "camera.fy=165", "camera.cx=-1",
                        "camera.cy=-1", "flight.drift_m_s=12"):
            command += ["--set", setting]
        self.process = subprocess.Popen(command, stdout=open(self.log, "w"), stderr=subprocess.STDOUT)
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.settimeout(0.02)
        self.address = self._address()
        self.packets = []

    def _address(self):
        for _ in range(600):
            for line in open(self.log):
                if "packets over UDP" in line:
                    host, port = line.split()[-1].rsplit(":", 1)
                    return host, int(port)
            check(self.process.poll() is None, "the flight does not start: " + open(self.log).read())
            time.sleep(0.1)
        raise AssertionError("the flight does not say its address")

    def send(self, packet):
        self.socket.sendto(packet, self.address)

    def listen(self, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            try:
                octets = self.socket.recv(65536)
            except socket.timeout:
                continue
            while octets:
                length = 7 + int.from_bytes(octets[4:6], "big")
                self.packets.append(octets[:length])
                octets = octets[length:]

    def stop(self):
        self.process.terminate()
        self.process.wait(60)


class Station:
    """Decodes what comes, and finds the answers to its commands."""

    def __init__(self, flight, database):
        self.flight, self.database = flight, database
        self.encoder = xtce_reader.Encoder(database)
        self.decoded, self.outcome, self.sent = [], {}, []

    def decode(self):
        for packet in self.flight.packets[len(self.decoded):]:
            root = self.database.items["container"][ROOT + "/packet"]
            container, values = xtce_reader.Decoder(self.database, packet).decode(root)
            self.decoded.append((container, values))
            if container.startswith(ROOT + "/TM_1_"):
                by_name = {value.name: value.raw for value in values}
                self.outcome.setdefault(by_name[ROOT + "/request_ID"], []).append(container)

    def seen(self):
        return {container for container, _ in self.decoded}

    def send(self, path, arguments=None):
        count = self.encoder.count
        packet = self.encoder.encode(path, arguments or {})
        self.sent.append((path, arguments or {}, count, packet))
        self.flight.send(packet)
        return int.from_bytes(packet[:4], "big")

    def wait(self, missing):
        """Until nothing of what `missing` lists is missing, a minute at most."""
        for _ in range(600):
            self.flight.listen(0.1)
            self.decode()
            if not missing():
                return
        raise AssertionError("the flight does not send %s" % sorted(missing()))

    def values(self, prefix):
        return {value.name: value for container, values in self.decoded for value in values
                if value.name.startswith(prefix)}


def arguments_of(command, now):
    """Some arguments for each command that is no setting."""
    later = {"at": now + 2, "release_time": now + 3600}
    plain = {"SID": "status", "event": "capture_missed", "parameter": "acquisition_capture_mode", "interval": 5000,
             "number": 2, "mode": 2, "keyframe": 1, "kind": 0, "length": 600, "on": 0, "u8": 1, "transaction": 0,
             "offset": 1000, "APID": 239, "request_source": 1, "request_apid": 239, "request_count": 9000,
             "sub_schedule": 0, "group": 0, "longitude": 137.4, "latitude": -4.5, "distance": 25, "limit": 600}
    names = [a.get("name") for a in command.element.iter(xtce_reader.NAMESPACE + "Argument")]
    given = {name: later.get(name, plain.get(name)) for name in names if name in later or name in plain}
    if command.path.endswith("/CAPTSER"):
        given["interval"] = 1000
    return given


def operate(station):
    """Every command of the database, and every kind of report."""
    database = station.database
    space = ROOT + "/"
    station.send(space + "are_you_alive_test")
    station.wait(lambda: {space + "TM_17_2"} - station.seen())
    now = int(time.time())
    inner = xtce_reader.Encoder(database)
    inner.count = 9000
    request = inner.encode(space + "CAPTURE", {})
    for sid in database.items["type"][space + "SID"].element.iter(xtce_reader.NAMESPACE + "Enumeration"):
        station.send(space + "one_shot_reports", {"SID": sid.get("label")})
        station.flight.listen(0.02)
    for name in database.items["parameter"]:
        if name.startswith(space + "parameters/"):
            station.send(space + "report_parameter_values", {"parameter": name.rpartition("/")[2]})
            station.flight.listen(0.02)
    settings = {name for name in database.items["parameter"] if name.startswith(space + "parameters/")}
    station.wait(lambda: settings - set(station.values(space + "parameters/")))

    requests = {}
    insert = {"release_time": now + 3600, "telecommand": request.hex(), "telecommand_octets": len(request),
              "sub_schedule": 0}
    requests["insert"] = station.send(space + "insert_telecommands", insert)
    values = station.values(space + "parameters/")
    for path, command in database.items["command"].items():
        if command.element.get("abstract") == "true" or path.endswith((SILENCING, "insert_telecommands")):
            continue
        arguments = arguments_of(command, int(time.time()))
        if path.startswith(space + "parameters/set_"):
            value = values[path.replace("/set_", "/")]
            arguments = {"value": value.value if isinstance(value.value, str) else value.raw}
        requests[path] = station.send(path, arguments)
        # Deleting the schedule would leave nothing for the reports that follow.
        if path.endswith(("reset_the_schedule", "delete_by_request_ID")):
            station.send(space + "insert_telecommands", insert)
        # In some tailorings it disables all events.
        if path.endswith("/disable_events"):
            station.send(space + "enable_events", arguments)
        station.flight.listen(0.03)
    requests["unknown service"] = station.send(space + "telecommand", {"service": 99, "subtype": 1})
    requests["no keyframe"] = station.send(space + "REFINE", {"keyframe": 999})
    wanted = {space + name for name in WANTED} | {
        name for name in database.items["container"] if name.endswith("/report")}
    station.wait(lambda: wanted - station.seen() | {
        path for path, request in requests.items() if request not in station.outcome})
    refused = {path for path, request in requests.items() if station.outcome[request][0] != space + "TM_1_1"}
    check(refused == {"unknown service"}, "refused: %s" % sorted(refused))
    requests[SILENCING] = station.send(space + SILENCING)
    station.wait(lambda: {SILENCING} if requests[SILENCING] not in station.outcome else set())
    return len(requests)


def same(decoded, own):
    """A value of the database's reader and [name, value, unit, label, values per unit] of the project's decoder."""
    name, value, unit, label, *scale = own
    if unit == "utc":
        # The project keeps nanoseconds.
        return decoded.name == ROOT + "/" + name and abs(decoded.value - value * 1e-9 + UNIX_IN_1958) < 1e-6
    in_ns = unit == "ns"
    if in_ns and name.endswith("_ns"):
        name = name[:-3]
    if decoded.name != ROOT + "/" + name or decoded.unit != ("s" if in_ns else unit):
        return False
    if label and decoded.value != label:
        return False
    if isinstance(decoded.raw, bytes):
        return value in (decoded.raw.hex(), decoded.value)
    # Values of events: so many of the packet are one of the unit.
    if scale and not in_ns and isinstance(decoded.value, (int, float, Fraction)):
        return decoded.raw == value and decoded.value * scale[0] == value
    if value == "nan":
        return math.isnan(decoded.raw)
    if in_ns and abs(float(decoded.value) - value * 1e-9) > 1e-9:
        return False
    return float(decoded.raw) == float(value)


def compare(station, options):
    """The number of values that were compared. Headers of which the own decoder keeps nothing are left out."""
    left_out = {ROOT + "/" + name for name in (
        "packet_version", "packet_type", "secondary_header", "apid", "sequence_flags", "packet_length", "pus_version",
        "time_status", "packet_crc")}
    reports = [i for i, (container, _) in enumerate(station.decoded) if container != ROOT + "/cfdp"]
    lines = "".join(station.flight.packets[i].hex() + "\n" for i in reports)
    result = subprocess.run([options.decode, str(options.tailoring)], input=lines, stdout=subprocess.PIPE, text=True,
                            check=True)
    compared = 0
    for i, line in zip(reports, result.stdout.splitlines(), strict=True):
        container, values = station.decoded[i]
        values = [v for v in values if v.name not in left_out and not v.name.endswith(("_p_field", "_day"))]
        own = json.loads(line)
        check(len(values) == len(own), "%s has %d values instead of %d" % (container, len(values), len(own)))
        for decoded, expected in zip(values, own):
            check(same(decoded, expected), "%s: %s is %r, %r %s, instead of %r" % (
                container, decoded.name, decoded.raw, decoded.value, decoded.unit, expected))
            compared += 1
    for packet, (container, values) in zip(station.flight.packets, station.decoded):
        if container == ROOT + "/cfdp":
            check(values[-1].raw == packet[6:], "the PDU is not what the packet holds")
    return compared


class FlatDatabase(xtce_reader.Database):
    """As readers have it that know one SpaceSystem: everything is found by its bare name, and by nothing else."""

    def __init__(self, file):
        super().__init__(file)
        spaces = {item.space for items in self.items.values() for item in items.values()}
        check(spaces == {ROOT}, "%s has the SpaceSystems %s" % (file, sorted(spaces)))

    def find(self, kind, reference, space):
        return self.items[kind][ROOT + "/" + reference]


def flattened(path):
    return ROOT + "/" + path[len(ROOT) + 1:].replace("/", "_")


def compare_flat(station, flat):
    """The same commands and packets by the database with one SpaceSystem."""
    nested = station.database
    for kind in ("parameter", "container", "command"):
        names = [flattened(path) for path in nested.items[kind]]
        check(len(set(names)) == len(names) and set(names) == set(flat.items[kind]),
              "%s: %s" % (kind, sorted(set(names) ^ set(flat.items[kind]))))
    encoder = xtce_reader.Encoder(flat)
    for path, arguments, encoder.count, packet in station.sent:
        check(encoder.encode(flattened(path), arguments) == packet, "the flat %s is another packet" % path)
    root = flat.items["container"][ROOT + "/packet"]
    for packet, (container, values) in zip(station.flight.packets, station.decoded):
        flat_container, flat_values = xtce_reader.Decoder(flat, packet).decode(root)
        check(flat_container == flattened(container), "%s is %s" % (container, flat_container))
        # repr: a value that is not a number equals nothing.
        check([(v.name, repr(v.raw), v.value if v.value == v.value else "nan", v.unit) for v in flat_values] ==
              [(flattened(v.name), repr(v.raw), v.value if v.value == v.value else "nan", v.unit) for v in values],
              "%s differs in the flat database" % container)


def write_database(options, mission, file, *flags):
    with open(file, "w") as out:
        subprocess.run([options.xtce, "--mission", mission, *flags], stdout=out, check=True)
    text = open(file).read()
    check("Made by ilp-xtce " in text, "%s does not say which program has made it" % file)
    if os.path.exists(options.schema) and shutil.which("xmllint"):
        subprocess.run(["xmllint", "--noout", "--nonet", "--schema", options.schema, file], check=True)
    else:
        print("not validated: no xmllint, or no schema at '%s'" % options.schema)


def fly(options):
    os.makedirs(options.folder)
    mission = os.path.join(options.folder, "mission.ini")
    with open(mission, "w") as file:
        file.write("[acquisition]\ncapture_mode = 1\n[link]\ntailoring = %d\n" % options.tailoring)
    database_file = os.path.join(options.folder, "ilp.xml")
    flat_file = os.path.join(options.folder, "ilp-flat.xml")
    write_database(options, mission, database_file)
    write_database(options, mission, flat_file, "--flat")
    flight = Flight(options, mission)
    station = Station(flight, xtce_reader.Database(database_file))
    try:
        commands = operate(station)
        compared = compare(station, options)
        compare_flat(station, FlatDatabase(flat_file))
    finally:
        flight.stop()
    print("tailoring %d: %d telecommands, %d packets of %d kinds, %d values: all agree" % (
        options.tailoring, commands, len(station.decoded), len(station.seen()), compared))


def main():
    parser = argparse.ArgumentParser()
    for name in ("xtce", "sil", "decode", "folder"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("--schema", default="")
    options = parser.parse_args()
    shutil.rmtree(options.folder, ignore_errors=True)
    # The flights are in real time and mostly wait: one process each, side by side.
    with concurrent.futures.ProcessPoolExecutor(3) as processes:
        flights = [processes.submit(fly, argparse.Namespace(**{
            **vars(options), "tailoring": tailoring, "folder": os.path.join(options.folder, str(tailoring))}))
            for tailoring in range(3)]
        for flight in flights:
            flight.result()


if __name__ == "__main__":
    main()
