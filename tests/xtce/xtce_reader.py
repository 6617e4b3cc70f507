"""A reader of XTCE 1.2 databases. It knows the standard and CCSDS packets, and nothing of any mission."""

import contextlib
import datetime
import os
import re
import struct
import xml.etree.ElementTree as ElementTree
from fractions import Fraction

NAMESPACE = "{http://www.omg.org/spec/XTCE/20180204}"
UNIX_DAY = datetime.date(1970, 1, 1)
# UTC days from which on TAI - UTC is 10 s, 11 s, ... (IERS Bulletin C).
LEAP_DAYS = [datetime.date(*day) for day in (
    (1972, 1, 1), (1972, 7, 1), (1973, 1, 1), (1974, 1, 1), (1975, 1, 1), (1976, 1, 1), (1977, 1, 1), (1978, 1, 1),
    (1979, 1, 1), (1980, 1, 1), (1981, 7, 1), (1982, 7, 1), (1983, 7, 1), (1985, 7, 1), (1988, 1, 1), (1990, 1, 1),
    (1991, 1, 1), (1992, 7, 1), (1993, 7, 1), (1994, 7, 1), (1996, 1, 1), (1997, 7, 1), (1999, 1, 1), (2006, 1, 1),
    (2009, 1, 1), (2012, 7, 1), (2015, 7, 1), (2017, 1, 1))]


MOST_FILE_BYTES = 64 << 20
MOST_ENTRIES = 100_000  # of a packet
# What an exact computation may be asked for: a Fraction of "1e999999999" would take all memory.
NUMBER = re.compile(r"[-+]?\d{1,30}(/\d{1,30}|(\.\d{0,30})?([eE][-+]?\d{1,2})?)")
MOST_EXPONENT = 16


class XtceError(Exception):
    """Says where in the database, or in which packet, something is not as the standard has it."""


@contextlib.contextmanager
def errors_at(place):
    """Whatever a database or a packet causes is an XtceError that names the place: `place()` at that time."""
    try:
        yield
    except XtceError as fault:
        raise XtceError("%s: %s" % (place(), fault)) from fault
    except (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError, struct.error,
            ElementTree.ParseError) as fault:
        raise XtceError("%s: %s: %s" % (place(), type(fault).__name__, fault)) from fault


def fraction(text):
    if not NUMBER.fullmatch(text):
        raise XtceError("%s is no number" % text[:40])
    return Fraction(text)


def leap_seconds(unix):
    """TAI - UTC at an instant of UTC; 0 before 1972, as CUC counts from 1958."""
    day = UNIX_DAY + datetime.timedelta(days=int(unix // 86400))
    number = sum(1 for leap in LEAP_DAYS if leap <= day)
    return number + 9 if number else 0


def unix_of_tai(tai):
    for offset in (leap_seconds(tai), leap_seconds(tai) - 1):
        if offset >= 0 and leap_seconds(tai - offset) == offset:
            return tai - offset
    return tai - leap_seconds(tai)


def crc16(octets, polynomial, start):
    crc = start
    for octet in octets:
        crc ^= octet << 8
        for _ in range(8):
            crc = ((crc << 1) ^ polynomial) & 0xFFFF if crc & 0x8000 else crc << 1
    return crc


def child(element, name):
    return element.find(NAMESPACE + name)


def kind_of(element):
    return element.tag[len(NAMESPACE):]


class Named:
    """An element, with the path of the SpaceSystem that it stands in."""

    def __init__(self, element, space):
        self.element, self.space = element, space
        self.path = space + "/" + element.get("name")


class Database:
    def __init__(self, file):
        self.items = {kind: {} for kind in ("type", "argument_type", "parameter", "container", "command")}
        self.children = {}
        self.place = ""
        with errors_at(lambda: "%s %s" % (file, self.place)):
            if os.path.getsize(file) > MOST_FILE_BYTES:
                raise XtceError("%s has more than %d MiB" % (file, MOST_FILE_BYTES >> 20))
            self._read_space(ElementTree.parse(file).getroot(), "")
            for container in self.items["container"].values():
                self.place = container.path
                for below in self.chain("container", container, "BaseContainer", "containerRef")[1:2]:
                    self.children.setdefault(below.path, []).append(container)

    def chain(self, kind, item, base_name, reference):
        """The item and what it is based on, one after the other."""
        chain = [item]
        while (base := child(chain[-1].element, base_name)) is not None:
            chain.append(self.find(kind, base.get(reference), chain[-1].space))
            if chain[-1] in chain[:-1]:
                raise XtceError("%s is based on itself" % chain[-1].path)
        return chain

    def _read_space(self, element, parent):
        self.place = space = parent + "/" + element.get("name")
        sets = {"ParameterTypeSet": "type", "ArgumentTypeSet": "argument_type", "ParameterSet": "parameter",
                "ContainerSet": "container", "MetaCommandSet": "command"}
        for part in element:
            if kind_of(part) == "SpaceSystem":
                self._read_space(part, space)
            elif kind_of(part) in ("TelemetryMetaData", "CommandMetaData"):
                for group in part:
                    for item in group:
                        named = Named(item, space)
                        self.place = named.path
                        if named.path in self.items[sets[kind_of(group)]]:
                            raise XtceError(named.path + " is defined twice")
                        self.items[sets[kind_of(group)]][named.path] = named

    def find(self, kind, reference, space):
        """A reference without a leading slash is searched upwards."""
        items = self.items[kind]
        while not reference.startswith("/"):
            if space + "/" + reference in items:
                return items[space + "/" + reference]
            if not space:
                raise XtceError("%s %s is not defined" % (kind, reference))
            space = space.rpartition("/")[0]
        return items[reference]

    def parameter_type(self, parameter):
        return self.find("type", parameter.element.get("parameterTypeRef"), parameter.space)


class Value:
    def __init__(self, parameter, raw, value, unit):
        self.name, self.raw, self.value, self.unit = parameter.path, raw, value, unit


class Bits:
    def __init__(self, octets):
        self.number, self.left, self.size = int.from_bytes(octets, "big"), 8 * len(octets), 8 * len(octets)

    def take(self, count):
        if count < 0 or count > self.left:
            raise XtceError("the packet ends %d bits too early" % (count - self.left))
        self.left -= count
        return self.number >> self.left & (1 << count) - 1


class Decoder:
    """Decodes one packet."""

    def __init__(self, database, octets):
        self.database, self.octets, self.bits = database, octets, Bits(octets)
        self.values, self.latest, self.entries, self.place = [], {}, 0, ""

    def decode(self, root):
        """Returns the path of the packet's container and its values, in the order of the packet."""
        with errors_at(lambda: "a packet of %d octets, %s" % (len(self.octets), self.place)):
            return self._decode_from(root)

    def _decode_from(self, root):
        container = root
        while True:
            self._check(container)
            self._entries(container)
            inherited = [c for c in self.database.children.get(container.path, []) if self._restricted(c)]
            if not inherited:
                break
            if len(inherited) > 1:
                raise XtceError("%s and %s fit" % (inherited[0].path, inherited[1].path))
            container = inherited[0]
        if container.element.get("abstract") == "true":
            raise XtceError("no container fits below " + container.path)
        if self.bits.left:
            raise XtceError("%s leaves %d bits" % (container.path, self.bits.left))
        return container.path, self.values

    def _check(self, container):
        self.place = container.path
        encoding = child(container.element, "BinaryEncoding")
        if encoding is None:
            return
        size = self._integer(child(encoding, "SizeInBits"), container.space)
        if size != 8 * len(self.octets):
            raise XtceError("the packet has %d bits instead of %d" % (8 * len(self.octets), size))
        crc = child(child(encoding, "ErrorDetectCorrect"), "CRC")
        start, polynomial = int(child(crc, "InitRemainder").text, 16), int(child(crc, "Polynomial").text, 16)
        if crc16(self.octets, polynomial, start) != 0:
            raise XtceError("the CRC is wrong")

    def _entries(self, container):
        for entry in child(container.element, "EntryList"):
            condition = child(entry, "IncludeCondition")
            if condition is not None and not self._match(condition, container.space):
                continue
            repeat = child(entry, "RepeatEntry")
            count = 1 if repeat is None else self._integer(child(repeat, "Count"), container.space)
            for _ in range(count):
                self.entries += 1
                if self.entries > MOST_ENTRIES:
                    raise XtceError("%s has more than %d entries" % (self.place, MOST_ENTRIES))
                if kind_of(entry) == "ContainerRefEntry":
                    self._entries(self.database.find("container", entry.get("containerRef"), container.space))
                else:
                    self._parameter(self.database.find("parameter", entry.get("parameterRef"), container.space))

    def _restricted(self, container):
        criteria = child(child(container.element, "BaseContainer"), "RestrictionCriteria")
        return criteria is None or self._match(criteria, container.space)

    def _match(self, criteria, space):
        return all(self._compare(c, space) for c in criteria.iter(NAMESPACE + "Comparison"))

    def _compare(self, comparison, space):
        value = self._value_of(comparison, space)
        raw = comparison.get("useCalibratedValue") == "false"
        wanted = comparison.get("value")
        return value.raw == int(wanted) if raw else str(value.value) == wanted

    def _value_of(self, reference, space):
        return self.latest[self.database.find("parameter", reference.get("parameterRef"), space).path]

    def _integer(self, element, space):
        fixed = child(element, "FixedValue")
        if fixed is not None:
            return int(fixed.text)
        dynamic = child(element, "DynamicValue")
        value = int(self._value_of(child(dynamic, "ParameterInstanceRef"), space).value)
        adjustment = child(dynamic, "LinearAdjustment")
        if adjustment is None:
            return value
        return int(fraction(adjustment.get("slope")) * value + fraction(adjustment.get("intercept")))

    def _parameter(self, parameter):
        self.place = parameter.path
        kind = self.database.parameter_type(parameter)
        unit = child(kind.element, "UnitSet")
        raw, value = self._decode(kind)
        decoded = Value(parameter, raw, value, "" if unit is None else child(unit, "Unit").text)
        self.values.append(decoded)
        self.latest[parameter.path] = decoded

    def _decode(self, kind):
        """The number of the packet and its meaning."""
        element = kind.element
        name = kind_of(element)
        if name == "AbsoluteTimeParameterType":
            return self._time(kind)
        if name == "BinaryParameterType":
            size = self._integer(child(child(element, "BinaryDataEncoding"), "SizeInBits"), kind.space)
            raw = self.bits.take(size).to_bytes(size // 8, "big")
            return raw, raw
        if name == "StringParameterType":
            size = self._integer(child(child(element, "StringDataEncoding"), "Variable"), kind.space)
            raw = self.bits.take(size).to_bytes(size // 8, "big")
            return raw, raw.decode("utf-8")
        raw, calibrated = self._number(element)
        if name == "EnumeratedParameterType":
            for item in child(element, "EnumerationList"):
                if int(item.get("value")) == raw:
                    return raw, item.get("label")
            return raw, None
        return raw, calibrated

    def _number(self, element):
        encoding = child(element, "IntegerDataEncoding")
        if encoding is None:
            encoding = child(element, "FloatDataEncoding")
            size = int(encoding.get("sizeInBits"))
            octets = self.bits.take(size).to_bytes(size // 8, "big")
            raw = struct.unpack(">f" if size == 32 else ">d", octets)[0]
        else:
            size = int(encoding.get("sizeInBits"))
            raw = self.bits.take(size)
            if encoding.get("encoding") == "twosComplement" and raw >> size - 1:
                raw -= 1 << size
        calibrator = child(encoding, "DefaultCalibrator")
        if calibrator is None:
            return raw, raw
        terms = child(calibrator, "PolynomialCalibrator")
        if any(not 0 <= int(term.get("exponent")) <= MOST_EXPONENT for term in terms):
            raise XtceError("%s has an exponent that is not from 0 to %d" % (self.place, MOST_EXPONENT))
        return raw, sum(fraction(t.get("coefficient")) * Fraction(raw) ** int(t.get("exponent")) for t in terms)

    def _time(self, kind):
        """UTC in seconds since 1970 without leap seconds, exactly."""
        encoding, reference = child(kind.element, "Encoding"), child(kind.element, "ReferenceTime")
        raw = self._number(encoding)[0]
        seconds = fraction(encoding.get("scale", "1")) * raw + fraction(encoding.get("offset", "0"))
        origin = child(reference, "OffsetFrom")
        if origin is not None:
            return raw, self._value_of(origin, kind.space).value + seconds
        epoch = child(reference, "Epoch").text
        if epoch == "UNIX":
            return raw, seconds
        # Elapsed seconds, leap seconds among them.
        return raw, unix_of_tai(tai_of_epoch(epoch) + seconds)


def tai_of_epoch(epoch):
    """TAI seconds since 1970 of 1958-01-01, or of a date."""
    if epoch == "TAI":
        return Fraction((datetime.date(1958, 1, 1) - UNIX_DAY).days * 86400)
    date = datetime.datetime.fromisoformat(epoch.replace("Z", "+00:00"))
    unix = Fraction(int(date.timestamp()))
    return unix + leap_seconds(unix)


class Encoder:
    """Makes telecommands: CCSDS space packets whose CRC is added here, as a ground system does."""

    def __init__(self, database):
        self.database, self.count = database, 0

    def encode(self, path, arguments):
        with errors_at(lambda: path):
            return self._encode(path, arguments)

    def _encode(self, path, arguments):
        command = self.database.items["command"][path]
        given = dict(arguments)
        chain = self.database.chain("command", command, "BaseMetaCommand", "metaCommandRef")[::-1]
        for part in chain[::-1]:
            for assignment in part.element.iter(NAMESPACE + "ArgumentAssignment"):
                given[assignment.get("argumentName")] = assignment.get("argumentValue")
        types = {}
        for part in chain:
            for argument in part.element.iter(NAMESPACE + "Argument"):
                types[argument.get("name")] = self.database.find("argument_type", argument.get("argumentTypeRef"),
                                                                  part.space)
                if argument.get("initialValue") is not None:
                    given.setdefault(argument.get("name"), argument.get("initialValue"))
        bits, size = 0, 0
        for part in chain:
            for entry in child(child(part.element, "CommandContainer"), "EntryList"):
                number, width = self._entry(entry, types, given)
                if not 0 <= width <= 8 * 65536 - size:
                    raise XtceError("%s is larger than a packet" % part.path)
                bits, size = bits << width | number, size + width
        packet = bytearray(bits.to_bytes(size // 8, "big"))
        packet[2:4] = struct.pack(">H", 0xC000 | self.count)
        packet[4:6] = struct.pack(">H", len(packet) + 2 - 7)
        self.count = (self.count + 1) % 16384
        return bytes(packet) + struct.pack(">H", crc16(packet, 0x1021, 0xFFFF))

    def _entry(self, entry, types, given):
        if kind_of(entry) == "FixedValueEntry":
            width = int(entry.get("sizeInBits"))
            return int(entry.get("binaryValue"), 16) & (1 << width) - 1, width
        name = entry.get("argumentRef")
        if name not in given:
            raise XtceError("the argument %s is missing" % name)
        return self._argument(types[name].element, given[name], given)

    def _argument(self, element, value, given):
        kind = kind_of(element)
        if kind == "BinaryArgumentType":
            octets = bytes.fromhex(value)
            size = child(child(element, "BinaryDataEncoding"), "SizeInBits")
            fixed = child(size, "FixedValue")
            wanted = int(fixed.text) if fixed is not None else 8 * int(given[child(
                child(size, "DynamicValue"), "ArgumentInstanceRef").get("argumentRef")])
            if wanted != 8 * len(octets):
                raise XtceError("%s takes %d bits" % (element.get("name"), wanted))
            return int.from_bytes(octets, "big"), wanted
        if kind == "AbsoluteTimeArgumentType":
            encoding = child(element, "Encoding")
            epoch = child(child(element, "ReferenceTime"), "Epoch").text
            tai = Fraction(value) + leap_seconds(value) - tai_of_epoch(epoch)
            return round(tai / Fraction(encoding.get("scale"))), int(child(encoding, "IntegerDataEncoding").get("sizeInBits"))
        for item in element.iter(NAMESPACE + "Enumeration"):
            if item.get("label") == value:
                value = item.get("value")
        for limits in element.iter(NAMESPACE + "ValidRange"):
            if not float(limits.get("minInclusive")) <= float(value) <= float(limits.get("maxInclusive")):
                raise XtceError("%s is out of range" % value)
        encoding = child(element, "IntegerDataEncoding")
        if encoding is None:
            size = int(child(element, "FloatDataEncoding").get("sizeInBits"))
            return int.from_bytes(struct.pack(">f" if size == 32 else ">d", float(value)), "big"), size
        size = int(encoding.get("sizeInBits"))
        return int(value) & (1 << size) - 1, size
