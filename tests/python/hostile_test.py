#!/usr/bin/python3 -B
"""Results of ilp-ground that hold anything, in the hands of sim/tools/python: each is read, or refused with an error that
names the file. A child process reads each, with bounded memory and time, so that a crash is noticed.

    hostile_test.py WORK [NUMBER]; NUMBER seeded changes of each file (default 40). Status 77 without numpy or GDAL"""

import importlib.machinery
import importlib.util
import math
import os
import random
import resource
import shutil
import signal
import struct
import sys

TOP = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PYTHON = os.path.join(TOP, "sim", "tools", "python")
sys.path.insert(0, PYTHON)
try:
    import numpy
    from osgeo import gdal
except ImportError as missing:
    print(f"skipped: {missing}; apt-get install python3-numpy python3-gdal")
    sys.exit(77)
import aerobot  # noqa: E402

WORK = os.path.abspath(sys.argv[1])
NUMBER = int(sys.argv[2]) if len(sys.argv) > 2 else 40
MEMORY, SECONDS = 2 << 30, 60
COLUMNS, ROWS = 24, 16


def script(name):
    loader = importlib.machinery.SourceFileLoader(name, os.path.join(PYTHON, name))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    loader.exec_module(module)
    return module


formats, tiles3d = script("formats"), script("tiles3d")


def write_flight(folder):
    os.makedirs(folder)
    x, y = numpy.meshgrid(numpy.arange(COLUMNS), numpy.arange(ROWS))
    values = {"height": (numpy.sin(x / 3) + y / 5).astype(numpy.float32), "sigma": numpy.full((ROWS, COLUMNS), 0.1, numpy.float32),
              "count": numpy.full((ROWS, COLUMNS), 2, numpy.uint8), "ortho": (x * 5 + 1).astype(numpy.uint8)}
    for name, cells in values.items():
        kind = gdal.GDT_Float32 if cells.dtype == numpy.float32 else gdal.GDT_Byte
        data = gdal.GetDriverByName("GTiff").Create(os.path.join(folder, name + ".tif"), COLUMNS, ROWS, 1, kind, ["COMPRESS=DEFLATE"])
        data.SetGeoTransform([0, 1, 0, 0, 0, -1])
        data.GetRasterBand(1).WriteArray(cells)
        data.GetRasterBand(1).SetNoDataValue(math.nan if kind == gdal.GDT_Float32 else 0)
        data = None
    with open(os.path.join(folder, "report.json"), "w", encoding="utf-8") as file:
        file.write('{"flight": {"name": "a", "keyframes": [1, 2]}, "remarks": [], "strips": [{"place": {"text": "on Mars", '
                   '"sigma_m": 3.5, "map_sigma_m": 40, "whole_sigma_m": null}}]}\n')
    with open(os.path.join(folder, "keyframes.csv"), "w", encoding="utf-8") as file:
        file.write("keyframe,name,time_s,x,y,z,richness,state,depth,products,unit\n"
                   '1,"a.png",0.5,1,2,10,0.25,posed,yes,both,units\n2,b.png,1.5,2,2,10,,posed,yes,both,units\n')
    head = ("ply\nformat binary_little_endian 1.0\nelement vertex 3\n" + "".join(f"property double {c}\n" for c in "xyz") +
            "".join(f"property uchar {c}\n" for c in ("red", "green", "blue")) + "end_header\n")
    with open(os.path.join(folder, "points.ply"), "wb") as file:
        file.write(head.encode() + b"".join(struct.pack("<3d3B", i, 2 * i, 1, 10, 20, 30) for i in range(3)))
    with open(os.path.join(folder, "footprints.geojson"), "w", encoding="utf-8") as file:
        file.write('{"type": "FeatureCollection", "features": []}\n')


def use(folder, out):
    """All that the reader and the two programs read."""
    flight = aerobot.Flight(folder)
    for name in ("height", "sigma", "count", "ortho"):
        map_ = flight.map(name)
        map_.at(map_.x[:1] if not map_.is_turned else map_.x[0, :1], map_.y[:1] if not map_.is_turned else map_.y[0, :1])
    flight.keyframes
    flight.place
    flight.profile((0, 0), (5, -5), 10)
    for program, arguments in ((formats, []), (tiles3d, [])):
        sys.argv = [program.__name__, folder, "--out", os.path.join(out, program.__name__), *arguments]
        program.main()


def outcome(folder, out):
    """What a child process that uses the folder says: `read`, the text of a refusal, or how it failed."""
    receive, send = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(receive)
        signal.alarm(SECONDS)
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        os.dup2(1, 2)
        said = "read"
        try:
            use(folder, out)
        except (aerobot.BadResult, OSError, SystemExit) as fault:
            said = "refused: " + str(fault)
        except BaseException as fault:
            said = f"failed: {type(fault).__name__}: {fault}"
        os.write(send, said.encode("utf-8", "replace")[:4000])
        os._exit(0)
    os.close(send)
    with os.fdopen(receive, "rb") as pipe:
        said = pipe.read().decode("utf-8")
    status = os.waitpid(child, 0)[1]
    return said if status == 0 and said else f"failed: the process ended with status {status}"


counts = {"read": 0, "refused": 0}


def try_one(what, name, content, names_it=True):
    """Replaces one file of a good flight."""
    folder, out = os.path.join(WORK, "flight"), os.path.join(WORK, "out")
    for old in (folder, out):
        shutil.rmtree(old, ignore_errors=True)
    shutil.copytree(os.path.join(WORK, "good"), folder)
    path = os.path.join(folder, name)
    if callable(content):
        content(path)
    else:
        with open(path, "wb") as file:
            file.write(content)
    said = outcome(folder, out)
    kind = said.split(":")[0]
    assert kind in counts, f"{what} of {name}: {said}"
    if kind == "refused":
        assert folder in said, f"{what} of {name}: the error names no file: {said}"
        if names_it is True:
            assert name in said, f"{what} of {name}: the error names another file: {said}"
    counts[kind] += 1
    return said


def raster(columns, rows, kind, **more):
    def write(path):
        os.remove(path)
        data = gdal.GetDriverByName("GTiff").Create(path, columns, rows, more.get("bands", 1), kind,
                                                    ["SPARSE_OK=TRUE", "BIGTIFF=YES", *more.get("options", [])])
        if more.get("transform"):
            data.SetGeoTransform(more["transform"])
        if "fill" in more:
            data.GetRasterBand(1).Fill(more["fill"])
    return write


def refused(what, name, content, text):
    said = try_one(what, name, content)
    assert said.startswith("refused") and text in said, f"{what} of {name}: {said}"


def directed():
    refused("a list", "report.json", b"[1, 2]", "is no report")
    refused("nested", "report.json", b"[" * 200_000, "nested too deeply")
    refused("cut off", "report.json", b'{"flight":\n {"name"', "line 2")
    refused("Latin-1", "report.json", b'{"flight": "caf\xe9"}', "octet 15: is no UTF-8")
    refused("digits", "report.json", b'{"a": ' + b"9" * 10_000 + b"}", "report.json")
    refused("vast", "report.json", lambda path: os.truncate(path, 1 << 40), "more than 64 MiB")
    refused("a word for a number", "keyframes.csv", b"keyframe,time_s\n1,2\n2,soon\n", "line 3, column time_s: 'soon' is no number")
    refused("a row too short", "keyframes.csv", b"keyframe,time_s\n1\n", "line 2: has 1 values for 2 columns")
    refused("a row too long", "keyframes.csv", b"keyframe,time_s\n1,2,3\n", "line 2: has 3 values for 2 columns")
    refused("one name twice", "keyframes.csv", b"a,a\n1,2\n", "line 1: two columns")
    refused("an open quote", "keyframes.csv", b'keyframe,name\n1,"a\n', "keyframes.csv, line")
    refused("a vast cell", "keyframes.csv", b"keyframe,name\n1," + b"x" * 1_000_000 + b"\n", "field larger than field limit")
    refused("no UTF-8", "keyframes.csv", b"keyframe,name\n1,\xff\xfe\n", "octet 16: is no UTF-8")
    refused("vast", "keyframes.csv", lambda path: os.truncate(path, 1 << 40), "more than 64 MiB")
    refused("empty", "keyframes.csv", b"", "has no times")
    for time in (b"nan", b"inf", b"1e300", b"-1e18"):
        refused("a time of no calendar", "keyframes.csv", b"keyframe,time_s\n1," + time + b"\n", "column time_s")
    for name in ("height", "sigma", "count", "ortho"):
        file = name + ".tif"
        refused("empty", file, b"", file)
        refused("a sparse raster of a terabyte", file, raster(1 << 20, 1 << 20, gdal.GDT_Byte), "1048576 x 1048576 cells")
        refused("complex cells", file, raster(COLUMNS, ROWS, gdal.GDT_CFloat64), "complex")
        refused("cells without size", file, raster(COLUMNS, ROWS, gdal.GDT_Float32, transform=[0, 1, 1, 0, 1, 1]), "have no size")
        refused("cells of NaN", file, raster(COLUMNS, ROWS, gdal.GDT_Float32, transform=[0, math.nan, 0, 0, 0, -1]), "have no size")
        # GDAL would follow it to any file of this computer.
        refused("a virtual raster", file, b'<VRTDataset rasterXSize="1" rasterYSize="1"><VRTRasterBand dataType="Byte" band="1">'
                b"<SimpleSource><SourceFilename>/etc/passwd</SourceFilename></SimpleSource></VRTRasterBand></VRTDataset>", file)
    for fill in (math.nan, math.inf, -math.inf, 1e38):
        refused("no heights", "height.tif", raster(COLUMNS, ROWS, gdal.GDT_Float32, fill=fill, transform=[0, 1, 0, 0, 0, -1]), "height.tif")
    try_one("level ground", "height.tif", raster(COLUMNS, ROWS, gdal.GDT_Float32, fill=7, transform=[0, 1, 0, 0, 0, -1]))
    try_one("one cell", "height.tif", raster(1, 1, gdal.GDT_Float32, fill=7, transform=[0, 1, 0, 0, 0, -1]), names_it=False)
    for count in (b"0", b"-1", b"4", b"99999999999999999999", b"x"):
        refused("a count of vertices", "points.ply", open_good("points.ply").replace(b"vertex 3", b"vertex " + count), "points.ply")
    refused("no head", "points.ply", b"\xff" * 100, "points.ply")
    refused("an unknown type", "points.ply", open_good("points.ply").replace(b"double x", b"triple x"), "points.ply")
    refused("no x", "points.ply", open_good("points.ply").replace(b"double x", b"double w"), "points.ply")
    refused("a vertex of NaN", "points.ply", open_good("points.ply")[:-27] + struct.pack("<3d3B", math.nan, 0, 0, 1, 1, 1), "points.ply")
    refused("vast", "points.ply", lambda path: os.truncate(path, 1 << 40), "more than 1024 MiB")


def open_good(name):
    with open(os.path.join(WORK, "good", name), "rb") as file:
        return file.read()


def changed(content, generator):
    octets = bytearray(content)
    for _ in range(generator.choice((1, 1, 2, 8))):
        at = generator.randrange(len(octets)) if octets else 0
        what = generator.randrange(5)
        if what == 0:
            octets[at:at + 1] = bytes([octets[at] ^ 1 << generator.randrange(8)]) if octets else b"x"
        elif what == 1:
            octets[at:at + 4] = generator.choice((b"\xff" * 4, b"\0" * 4, b"\x7f\xff\xff\xff", b"nan", b"1e999", b"-1", b",", b'"', b"\n"))
        elif what == 2:
            del octets[at:]
        elif what == 3:
            del octets[at:at + generator.randrange(1, 40)]
        else:
            octets[at:at] = octets[generator.randrange(len(octets) or 1):][:generator.randrange(1, 200)]
        if not octets:
            break
    return bytes(octets)


def main():
    shutil.rmtree(WORK, ignore_errors=True)
    write_flight(os.path.join(WORK, "good"))
    os.makedirs(os.path.join(WORK, "out"))
    said = outcome(os.path.join(WORK, "good"), os.path.join(WORK, "out"))
    assert said == "read", "the good flight: " + said
    directed()
    told = dict(counts)
    for name in ("report.json", "keyframes.csv", "height.tif", "sigma.tif", "ortho.tif", "points.ply"):
        good = open_good(name)
        for seed in range(NUMBER):
            # What is wrong with one file may be noticed at another, such as maps of two sizes.
            try_one(f"change {seed}", name, changed(good, random.Random(f"{name} {seed}")), names_it=False)
    print(f"{sum(told.values())} files by hand, {sum(counts.values()) - sum(told.values())} changed ones: "
          f"{counts['read']} were read, {counts['refused']} refused by name; none crashed, hung or took more than {MEMORY >> 30} GiB")


if __name__ == "__main__":
    main()
