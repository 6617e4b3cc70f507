#!/usr/bin/env python3
"""The XTCE database of ilp-xtce in hostile hands: databases and packets that hold anything give an XtceError that names the
place, and ilp-xtce refuses mission files that hold anything with their line. Nothing hangs, crashes or takes much memory.

    hostile.py --xtce ilp-xtce --folder FOLDER [--number N]      N seeded changes of each kind (default 300)
"""

import argparse
import os
import random
import resource
import shutil
import struct
import subprocess
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import xtce_reader  # noqa: E402

ROOT = "/ILP"
MEMORY = 2 << 30
HEAD = '<?xml version="1.0"?><SpaceSystem xmlns="http://www.omg.org/spec/XTCE/20180204" name="ILP">'


def check(condition, message):
    if not condition:
        raise AssertionError(message)


def refused(what, action, *texts):
    try:
        action()
    except xtce_reader.XtceError as fault:
        for text in texts:
            check(text in str(fault), "%s: the error does not say %r: %s" % (what, text, fault))
        return
    raise AssertionError(what + " is not refused")


def telemetry(parameters="", containers="", types=""):
    return (HEAD + "<TelemetryMetaData><ParameterTypeSet>" + types + "</ParameterTypeSet><ParameterSet>" + parameters +
            "</ParameterSet><ContainerSet>" + containers + "</ContainerSet></TelemetryMetaData></SpaceSystem>")


def container(name, entries="", base=""):
    return ('<SequenceContainer name="%s"><EntryList>%s</EntryList>%s</SequenceContainer>' % (
        name, entries, base and '<BaseContainer containerRef="%s"/>' % base))


def integer(size, more=""):
    return '<IntegerParameterType name="t"><IntegerDataEncoding sizeInBits="%s">%s</IntegerDataEncoding></IntegerParameterType>' % (
        size, more)


def polynomial(coefficient, exponent):
    return ('<DefaultCalibrator><PolynomialCalibrator><Term coefficient="%s" exponent="%s"/></PolynomialCalibrator>'
            "</DefaultCalibrator>" % (coefficient, exponent))


ONE = '<Parameter name="p" parameterTypeRef="t"/>'
ENTRY = '<ParameterRefEntry parameterRef="p"/>'


class Files:
    def __init__(self, folder):
        self.path = os.path.join(folder, "hostile.xml")

    def read(self, text):
        with open(self.path, "wb") as file:
            file.write(text if isinstance(text, bytes) else text.encode())
        return xtce_reader.Database(self.path)

    def decode(self, text, packet=bytes(8)):
        database = self.read(text)
        return xtce_reader.Decoder(database, packet).decode(database.items["container"][ROOT + "/packet"])


def directed(files):
    """By hand; how many."""
    databases = {
        "nothing": (b"", "no element found"),
        "no XML": (b"\x00\xff" * 100, "ParseError"),
        "half a file": (HEAD, "no element found"),
        "bad UTF-8": (HEAD.encode() + b"\xff\xfe</SpaceSystem>", "not well-formed (invalid token): line 1"),
        # A billion laughs: ten entities, each of ten times the one before.
        "entities that multiply": ('<?xml version="1.0"?><!DOCTYPE x [<!ENTITY a "%s">%s]>' % ("x" * 1000, "".join(
            '<!ENTITY %s "%s">' % (b, ("&%s;" % a) * 100) for a, b in zip("abcdefgh", "bcdefghi"))) +
            HEAD.split("?>")[1] + "&i;</SpaceSystem>", "limit on input amplification"),
        "an external entity": ('<?xml version="1.0"?><!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/passwd">]>' +
                               HEAD.split("?>")[1] + "&a;</SpaceSystem>", "undefined entity"),
        "systems within systems": (HEAD + '<SpaceSystem name="x">' * 5000 + "</SpaceSystem>" * 5001, "recursion"),
        "a system without a name": (HEAD + "<SpaceSystem/></SpaceSystem>", "TypeError"),
        "another namespace": ('<SpaceSystem name="ILP"><TelemetryMetaData/></SpaceSystem>', None),
        "a parameter without a name": (telemetry("<Parameter/>"), "TypeError"),
        "a name twice": (telemetry(ONE + ONE), "/ILP/p is defined twice"),
        "a base that is not there": (telemetry("", container("packet", "", "x")), "container x is not defined"),
        "a base that is itself": (telemetry("", container("packet", "", "packet")), "/ILP/packet is based on itself"),
        "bases in a circle": (telemetry("", container("packet", "", "b") + container("b", "", "packet")), "is based on itself"),
    }
    for what, (text, why) in databases.items():
        if why is None:
            files.read(text)
        else:
            refused(what, lambda: files.read(text), files.path, why)
    reference = '<ContainerRefEntry containerRef="%s">%s</ContainerRefEntry>'
    repeat = "<RepeatEntry><Count><FixedValue>%s</FixedValue></Count></RepeatEntry>"
    packets = {
        "containers in a circle": (telemetry("", container("packet", reference % ("b", "")) + container(
            "b", reference % ("packet", ""))), "recursion"),
        "a billion empty entries": (telemetry("", container("packet", reference % ("b", repeat % 10**9)) + container("b")),
                                    "has more than 100000 entries"),
        "entries that multiply": (telemetry("", container("packet", reference % ("b", repeat % 10**4)) + container(
            "b", reference % ("c", repeat % 10**4)) + container("c")), "has more than 100000 entries"),
        "a negative size": (telemetry(ONE, container("packet", ENTRY), integer(-8)), "ends -"),
        "a vast size": (telemetry(ONE, container("packet", ENTRY), integer(10**12)), "bits too early"),
        "a size that is none": (telemetry(ONE, container("packet", ENTRY), integer("x")), "/ILP/p: ValueError"),
        "a vast coefficient": (telemetry(ONE, container("packet", ENTRY), integer(8, polynomial("1e999999999", 1))),
                               "1e999999999 is no number"),
        "a vast exponent": (telemetry(ONE, container("packet", ENTRY), integer(8, polynomial("3", 999999999))),
                            "/ILP/p has an exponent"),
        "a coefficient of NaN": (telemetry(ONE, container("packet", ENTRY), integer(8, polynomial("nan", 1))), "nan is no number"),
        "a type that is not there": (telemetry(ONE, container("packet", ENTRY)), "type t is not defined"),
        "no entries": (telemetry("", '<SequenceContainer name="packet"/>'), "/ILP/packet: TypeError"),
        "bits that are left": (telemetry(ONE, container("packet", ENTRY), integer(8)), "/ILP/packet leaves 56 bits"),
    }
    for what, (text, why) in packets.items():
        refused(what, lambda: files.decode(text), why)
    with open(files.path, "wb") as file:
        file.truncate(1 << 40)
    refused("a file of a terabyte", lambda: xtce_reader.Database(files.path), files.path, "more than 64 MiB")
    return len(databases) + len(packets) + 1


def changed(content, generator):
    octets = bytearray(content)
    for _ in range(generator.choice((1, 2, 8))):
        at = generator.randrange(len(octets))
        what = generator.randrange(6)
        if what == 0:
            octets[at] ^= 1 << generator.randrange(8)
        elif what == 1:
            octets[at:at + 1] = generator.choice((b"-1", b"0", b"99999999999", b"1e999", b"nan", b"<", b'"', b"\xff", b"/"))
        elif what == 2 and generator.randrange(10) == 0:
            del octets[max(at, 1):]
        elif what == 3:
            del octets[at:min(at + generator.randrange(1, 60), len(octets) - 1)]
        else:
            octets[at:at] = octets[generator.randrange(len(octets)):][:generator.randrange(1, 400)]
    return bytes(octets)


def numbers_changed(text, generator, count=40):
    """Some digits, so that many of the changed files are read."""
    octets = bytearray(text)
    digits = [i for i in range(len(octets)) if octets[i] in b"0123456789" and octets[i - 1] in b'" .0123456789>']
    for at in generator.sample(digits, count):
        octets[at] = generator.choice(b"0123456789")
    return bytes(octets)


def some_packet(generator):
    """A report with a good CRC and anything else, or nothing good at all."""
    body = generator.randbytes(generator.choice((0, 1, 12, 40, 300)))
    if generator.randrange(5) == 0:
        return body
    service, subtype = generator.randrange(1, 25), generator.randrange(1, 30)
    packet = bytearray(struct.pack(">HHH", 0x0800 | generator.choice((0xEF, 0x7FD, 0, 0x7FF)), 0xC000 | generator.randrange(1 << 14), 0))
    packet += bytes([generator.choice((0x20, 0x10, 0x2F)), service, subtype]) + body
    packet[4:6] = struct.pack(">H", len(packet) + 2 - 7)
    return bytes(packet) + struct.pack(">H", xtce_reader.crc16(packet, 0x1021, 0xFFFF))


def decoded(database, packet):
    root = database.items["container"].get(ROOT + "/packet")
    if root is None:
        return False
    try:
        xtce_reader.Decoder(database, packet).decode(root)
        return True
    except xtce_reader.XtceError as fault:
        check(str(fault), "an error without words")
        return False


def encoded(database, generator):
    command = generator.choice(list(database.items["command"]) or ["/none"])
    values = ["0", "1", "-1", "nan", "1e999", "99999999999999999999", "x", "", "ff", 1, None, 2.5]
    names = ["keyframe", "value", "at", "length", "interval", "telecommand", "telecommand_octets", "SID", "release_time"]
    try:
        check(len(xtce_reader.Encoder(database).encode(command, {n: generator.choice(values) for n in names})) <= 65542, command)
        return True
    except xtce_reader.XtceError:
        return False


def tried(files, text, number):
    """Counts of databases that are read, packets that are decoded and commands that are encoded, of so many."""
    counts = {"databases": 0, "packets": 0, "commands": 0}
    sound = files.read(text)
    for seed in range(number):
        generator = random.Random(seed)
        database = sound
        if seed % 10 == 0:
            try:
                database = files.read((changed if seed % 20 == 0 else numbers_changed)(text, generator))
                counts["databases"] += 1
            except xtce_reader.XtceError as fault:
                check(files.path in str(fault), "the error names no file: %s" % fault)
        for _ in range(10):
            counts["packets"] += decoded(database, some_packet(generator))
            counts["commands"] += encoded(database, generator)
    return "%d of %d changed databases were read, %d of %d packets decoded, %d of %d commands encoded" % (
        counts["databases"], -(-number // 10), counts["packets"], 10 * number, counts["commands"], 10 * number)


def missions(options, mission, number):
    """ilp-xtce over changed mission files."""
    taken = 0
    path = os.path.join(options.folder, "mission.ini")
    fixed = [b"[link]\ntailoring = 99\n", b"[link]\ntailoring = nan\n", b"[nothing]\nx = 1\n", b"[link\n", b"\xff\xfe\n",
             b"[link]\n" + b"x" * 100000 + b" = 1\n", b"[link]\napid = " + b"9" * 5000 + b"\n", b"\0" * 1000]
    for seed in range(number + len(fixed)):
        with open(path, "wb") as file:
            generator = random.Random(seed)
            file.write(fixed[seed] if seed < len(fixed) else changed(mission, generator) if seed % 2 else
                       numbers_changed(mission, generator, 1))
        run = subprocess.run([options.xtce, "--mission", path], capture_output=True, timeout=60)
        check(run.returncode in (0, 1, 2), "mission %d: ilp-xtce ended with %d: %s" % (seed, run.returncode, run.stderr[-300:]))
        check(seed >= len(fixed) or run.returncode != 0, "mission %d is taken" % seed)
        if run.returncode != 0:
            check(path.encode() in run.stderr, "mission %d: the error names no file: %s" % (seed, run.stderr[-300:]))
        taken += run.returncode == 0
    return "%d of %d mission files were taken" % (taken, number + len(fixed))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--xtce", required=True)
    parser.add_argument("--folder", required=True)
    parser.add_argument("--number", type=int, default=300)
    options = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    shutil.rmtree(options.folder, ignore_errors=True)
    os.makedirs(options.folder)
    files = Files(options.folder)
    text = subprocess.run([options.xtce], stdout=subprocess.PIPE, check=True).stdout
    print("%d files by hand are refused by name" % directed(files))
    print(tried(files, text, options.number))
    mission = (b"[acquisition]\ncapture_mode = telecommanded\n[link]\ntailoring = 1\napid = 239\n[overlap]\ntarget_overlap = 0.81\n"
               b"[downlink]\nlink_bytes_per_s = 12345.5\n")
    print(missions(options, mission, options.number // 5))


if __name__ == "__main__":
    main()
