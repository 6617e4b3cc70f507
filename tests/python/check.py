#!/usr/bin/python3 -B
"""The lines of docs/python.md and the files of sim/tools/python/formats, on a flight that ilp-ground has merged.

    check.py page|formats --ground ilp-ground --flight FOLDER --work FOLDER; status 77 without numpy or GDAL"""

import argparse
import json
import os
import re
import shutil
import struct
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

TOP = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(TOP, "sim", "tools", "python"))
try:
    import numpy
    from osgeo import gdal, ogr
except ImportError as missing:
    print(f"skipped: {missing}; apt-get install python3-numpy python3-gdal")
    sys.exit(77)
from aerobot import Flight  # noqa: E402


def check(condition, message):
    if not condition:
        raise AssertionError(message)


def check_page(work, ground):
    with open(os.path.join(TOP, "docs", "python.md"), encoding="utf-8") as page:
        lines = re.search(r"```python\n(.*?)```", page.read(), re.S)[1]
    check(len(lines.splitlines()) <= 10, "the page promises ten lines")
    place = os.path.join(work, "out")
    os.makedirs(place)
    os.symlink(ground, os.path.join(place, "flight"))
    script = os.path.join(work, "page.py")
    with open(script, "w", encoding="utf-8") as file:
        file.write(lines)
    subprocess.run([sys.executable, script], cwd=work, check=True,
                   env={**os.environ, "PYTHONPATH": os.path.join(TOP, "sim", "tools", "python")})
    picture = ElementTree.parse(os.path.join(work, "profile.svg")).getroot()
    check(picture.findall(".//{*}polyline"), "the picture has no line")


def check_values(ground):
    """Against what GDAL's own program and the table say."""
    flight = Flight(ground)
    height = flight.height
    row, column = (index[len(index) // 2] for index in numpy.nonzero(numpy.isfinite(height.values)))
    told = subprocess.run(["gdallocationinfo", "-valonly", "-geoloc", height.path, repr(float(height.x[column])),
                           repr(float(height.y[row]))], capture_output=True, text=True, check=True).stdout
    check(abs(float(told) - height.at(height.x[column], height.y[row])) < 1e-6, "a cell is not where GDAL has it")
    check(numpy.isnan(height.at(height.x[0] - 1, height.y[0])), "there is a height beside the map")
    keyframes = flight.keyframes
    check(list(keyframes["keyframe"]) == list(range(1, len(keyframes) + 1)), "keyframes are missing")
    profile = flight.profile((height.x[0], height.y[row]), (height.x[-1], height.y[row]), height.x.size)
    good = numpy.isfinite(profile.height)
    check(good.any() and numpy.allclose(profile.height[good], height.values[row][good], atol=1e-5),
          "a profile along a row is not the row")


def check_formats(work, ground):
    out = os.path.join(work, "formats")
    subprocess.run([os.path.join(TOP, "sim", "tools", "python", "formats"), ground, "--out", out], check=True)
    flight = Flight(ground)
    for name in ("height", "sigma", "count", "ortho"):
        label = os.path.join(out, "pds4", name + ".xml")
        data = gdal.Open(label)
        check(data.GetDriver().ShortName == "PDS4", f"{label} is no PDS4 label")
        band, values = data.GetRasterBand(1), flight.map(name).values
        cells = band.ReadAsArray().astype(float)
        known = numpy.isfinite(values)
        check(numpy.array_equal(cells[known], values[known]), f"{name} has other cells")
        if not known.all():
            check((cells[~known] == band.GetNoDataValue()).all(), f"{name} has cells where there is no data")
        text = open(label, encoding="utf-8").read()
        check("${" not in text and "2026-01-01T00:00:0" in text, f"{label} has fields that are not filled in")
    for name, wanted in (("strip", ("stac_version", "id", "type", "geometry", "properties", "links", "assets")),
                         ("collection", ("stac_version", "id", "type", "description", "license", "extent", "links"))):
        with open(os.path.join(out, "stac", name + ".json"), encoding="utf-8") as file:
            content = json.load(file)
        check(all(key in content for key in wanted), f"{name}.json lacks a member that STAC demands")
        for asset in content.get("assets", {}).values():
            check(os.path.exists(os.path.join(out, "stac", asset["href"])), f"{asset['href']} is not there")
    check_las(os.path.join(out, "points.las"), os.path.join(flight.folder, "points.ply"))
    check_qgis(out)


def check_las(path, ply):
    """By the tables of the LAS 1.4 specification (R15)."""
    content = open(path, "rb").read()
    check(content[:4] == b"LASF" and content[24:26] == b"\x01\x04", "no LAS 1.4")
    header, first = struct.unpack_from("<HI", content, 94)
    kind, length = struct.unpack_from("<BH", content, 104)
    count = struct.unpack_from("<Q", content, 247)[0]
    scale, offset = struct.unpack_from("<3d", content, 131), struct.unpack_from("<3d", content, 155)
    limits = struct.unpack_from("<6d", content, 179)
    check(header == 375 and kind == 7 and length == 36 and len(content) == first + count * length, "its lengths do not fit")
    head, _, body = open(ply, "rb").read().partition(b"end_header\n")
    check(f"element vertex {count}\n".encode() in head, "points are missing")
    step = len(body) // count
    for i in range(count):
        stored = struct.unpack_from("<3i", content, first + i * length)
        point = [s * a + o for s, a, o in zip(stored, scale, offset)]
        wanted = struct.unpack_from("<3d", body, i * step)
        check(all(abs(p - w) <= s for p, w, s in zip(point, wanted, scale)), f"point {i} is elsewhere")
        check(all(limits[2 * k + 1] - scale[k] <= point[k] <= limits[2 * k] + scale[k] for k in range(3)), "outside its limits")
        colour = struct.unpack_from("<3H", content, first + i * length + 30)
        check([c // 257 for c in colour] == list(body[i * step + 24:i * step + 27]), f"point {i} has another colour")


def check_qgis(out):
    project = ElementTree.parse(os.path.join(out, "flight.qgs")).getroot()
    layers = project.findall("./projectlayers/maplayer")
    check({layer.findtext("id") for layer in layers} ==
          {node.get("id") for node in project.iter("layer-tree-layer")} == {"footprints", "contours", "hillshade", "orthoimage"},
          "layers are missing")
    for layer in layers:
        source = os.path.join(out, layer.findtext("datasource").split("|")[0])
        opened = gdal.OpenEx(source)
        check(opened is not None and (opened.RasterCount or opened.GetLayer(0).GetFeatureCount()), f"{source} is empty")
    contours = ogr.Open(os.path.join(out, "contours.gpkg"))
    heights = {feature.GetField("height") for feature in contours.GetLayer(0)}
    check(5 <= len(heights) <= 20, f"{len(heights)} contours")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("what", choices=("page", "formats"))
    for name in ("ground", "flight", "work"):
        parser.add_argument("--" + name, required=True)
    options = parser.parse_args()
    shutil.rmtree(options.work, ignore_errors=True)
    os.makedirs(options.work)
    ground = os.path.join(os.path.abspath(options.work), "ground")
    subprocess.run([options.ground, os.path.join(options.flight, "outbox"), "--out", ground], check=True,
                   stdout=subprocess.DEVNULL)
    if options.what == "page":
        check_page(os.path.abspath(options.work), ground)
        check_values(ground)
    else:
        check_formats(os.path.abspath(options.work), ground)


if __name__ == "__main__":
    main()
