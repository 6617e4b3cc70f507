#!/usr/bin/python3 -B
"""The lines of docs/python.md and the files of sim/tools/python/formats, on a flight that ilp-ground has merged.

    check.py merge|page|formats --ground ilp-ground --flight FOLDER --merged FOLDER [--work FOLDER]
`merge` makes the folder that the others read. Status 77 without numpy or GDAL."""

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
import archive_rules  # noqa: E402


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


def check_turned_cell(ground):
    """On a body the map lies across the axes of its projection; GDAL's own program says what is where."""
    height = Flight(ground).height
    check(height.is_turned, "the anchor has an azimuth")
    row, column = (index[len(index) // 2] for index in numpy.nonzero(numpy.isfinite(height.values)))
    x, y = height.place(column, row)
    told = subprocess.run(["gdallocationinfo", "-valonly", "-geoloc", height.path, repr(float(x)), repr(float(y))],
                          capture_output=True, text=True, check=True).stdout
    check(abs(float(told) - height.values[row, column]) < 1e-6, "a cell is not where GDAL has it")
    check(abs(height.at(x, y) - height.values[row, column]) < 1e-4, "at() finds another cell")


def check_straightened(data, cells, map_, name):
    """Rows of a label run east: each cell is the nearest one of the map, which lies across."""
    left, width, _, top, _, height = data.GetGeoTransform()
    check(abs(width - map_.cell) < 1e-3 * map_.cell and abs(height + map_.cell) < 1e-3 * map_.cell, "its cells have another size")
    a, b, c, d = (map_.transform[i] for i in (1, 2, 4, 5))
    inverse = numpy.linalg.inv([[a, b], [c, d]])
    rows, columns = numpy.indices(cells.shape)
    places = numpy.stack([left + width * (columns + 0.5) - map_.transform[0], top + height * (rows + 0.5) - map_.transform[3]])
    column, row = numpy.tensordot(inverse, places, 1)
    # Where rounding decides which cell is nearest, either may be it.
    clear = (numpy.abs(column % 1 - 0.5) < 0.49) & (numpy.abs(row % 1 - 0.5) < 0.49)
    inside = clear & (column >= 0) & (row >= 0) & (column < map_.values.shape[1]) & (row < map_.values.shape[0])
    wanted = numpy.full(cells.shape, numpy.nan)
    wanted[inside] = map_.values[row[inside].astype(int), column[inside].astype(int)]
    known = numpy.isfinite(wanted)
    check(known.sum() > 0.7 * numpy.isfinite(map_.values).sum(), f"most of {name} is missing")
    wrong = (cells[known] != wanted[known]).mean()
    check(wrong < 1e-3, f"{100 * wrong:.2f} % of the cells of {name} are others than those of the map")


def check_pds4(out, flight, name):
    label = os.path.join(out, "pds4", name + ".xml")
    faults = archive_rules.pds4_faults(label)
    check(not faults, f"{label}: {faults}")
    data, source = gdal.Open(label), gdal.Open(flight.map(name).path)
    check(data.GetDriver().ShortName == "PDS4", f"{label} is no PDS4 label")
    band, map_ = data.GetRasterBand(1), flight.map(name)
    cells, missing = band.ReadAsArray().astype(float), band.GetNoDataValue()
    if map_.is_turned:
        check_straightened(data, cells, map_, name)
    else:
        known = numpy.isfinite(map_.values)
        check(numpy.array_equal(cells[known], map_.values[known]), f"{name} has other cells")
        check(known.all() or (cells[~known] == missing).all(), f"{name} has cells where there is no data")
    here, there = data.GetSpatialRef(), source.GetSpatialRef()
    check((here is not None and here.IsProjected()) == (there is not None and bool(there.IsProjected())), f"{label}: on a body, or not")
    if there is None or not there.IsProjected():
        return
    check(abs(here.GetSemiMajor() - there.GetSemiMajor()) < 1e-3, f"{label} has another body")
    for parameter in ("central_meridian", "latitude_of_origin", "scale_factor"):
        check(abs(here.GetProjParm(parameter) - there.GetProjParm(parameter)) < 1e-9, f"{label} has another {parameter}")


def check_formats(work, ground, more=()):
    out = os.path.join(work, "formats-" + os.path.basename(ground))
    subprocess.run([os.path.join(TOP, "sim", "tools", "python", "formats"), ground, "--out", out, *more], check=True)
    flight = Flight(ground)
    for name in ("height", "sigma", "count", "ortho"):
        check_pds4(out, flight, name)
    faults = archive_rules.stac_faults(os.path.join(out, "stac"))
    check(not faults, f"STAC: {faults}")
    check_las(os.path.join(out, "points.las"), os.path.join(flight.folder, "points.ply"))
    check_qgis(out)
    return out


def check_rules(out):
    """The rules themselves notice what they should."""
    label, collection = os.path.join(out, "pds4", "height.xml"), os.path.join(out, "stac", "strip.json")
    for path, faults, changes in (
            (label, lambda: archive_rules.pds4_faults(label),
             (("<title>", "<version_id>1.0</version_id><title>"), ("urn:nasa:pds:uninterrupted", "urn:nasa:pds:Aerobot"),
              ("<axes>2", "<axes>3"), ("Derived", "Cooked"), ("2026-01-01T00:00:00.000Z", "2027-01-01T00:00:00.000Z"),
              ("<type>Planet</type>", ""), (">image</local_identifier>", ">other</local_identifier>"))),
            (collection, lambda: archive_rules.stac_faults(os.path.dirname(collection)),
             (('"stac_version": "1.0.0"', '"stac_version": "0.9"'), ('"datetime": null,', ""), ('"collection": "uninterrupted",', ""),
              ('"end_datetime": "2026', '"end_datetime": "MMXXVI'), ('height.tif', 'none.tif')))):
        with open(path, encoding="utf-8") as file:
            good = file.read()
        for old, new in changes:
            check(old in good, f"{path} has no {old}")
            with open(path, "w", encoding="utf-8") as file:
                file.write(good.replace(old, new, 1))
            check(faults(), f"{path}: nobody notices {new!r} for {old!r}")
        with open(path, "w", encoding="utf-8") as file:
            file.write(good)


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


def merge(options, out, *more):
    subprocess.run([options.ground, os.path.join(options.flight, "outbox"), "--out", out, *more], check=True,
                   stdout=subprocess.DEVNULL)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("what", choices=("merge", "page", "formats"))
    for name in ("ground", "flight", "merged"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("--work", default="")
    options = parser.parse_args()
    ground = os.path.abspath(options.merged)
    if options.what == "merge":
        shutil.rmtree(ground, ignore_errors=True)
        merge(options, ground)
        return
    work = os.path.abspath(options.work)
    shutil.rmtree(work, ignore_errors=True)
    os.makedirs(work)
    if options.what == "page":
        check_page(work, ground)
        check_values(ground)
        return
    check_rules(check_formats(work, ground))
    out, anchored = check_anchored(options, work, ground, "mars", 137.4, -4.6)
    check_turned_cell(anchored)
    check(target_of(out) == ("Mars", "Planet"), f"the target is not that of the map: {target_of(out)}")
    box = item_of(out)["bbox"]
    check(box[0] < 137.4 < box[2] and box[1] < -4.6 < box[3], f"the item is not where the flight was: {box}")
    check_place(work, anchored)
    check_across_180(options, work, ground)
    check_latitudes(options, work, ground)


def check_anchored(options, work, ground, body, longitude, latitude):
    anchor, anchored = os.path.join(work, body + ".json"), os.path.join(work, "anchored-" + body)
    with open(anchor, "w", encoding="utf-8") as file:
        json.dump({"body": body, "strips": [{"strip": 1, "longitude": longitude, "latitude": latitude, "height": 400.0,
                                             "azimuth": 12.5, "metres_per_unit": 2.03}]}, file)
    # A copy, so that only the georeference is made again.
    shutil.copytree(ground, anchored)
    merge(options, anchored, "--anchor", anchor)
    return check_formats(work, anchored, ["--name", "Flight 3"]), anchored


def check_place(work, anchored):
    """The errors of the place come from the report; an anchor states none."""
    item = item_of(os.path.join(work, "formats-anchored-mars"))
    check("How far the whole map may be off is not known" in item["properties"]["description"], "an anchor has an error")
    check(not any(key.startswith("accuracy:") for key in item["properties"]), "an anchor has an error")
    placed = os.path.join(work, "placed")
    shutil.copytree(anchored, placed)
    path = os.path.join(placed, "report.json")
    with open(path, encoding="utf-8") as file:
        report = json.load(file)
    place = report["strips"][0]["place"]
    check(place["body"] == "mars" and place["whole_sigma_m"] is None, f"the report's place: {place}")
    place.update(sigma_m=3.0, map_sigma_m=40.0, whole_sigma_m=40.1123)
    with open(path, "w", encoding="utf-8") as file:
        json.dump(report, file)
    out = check_formats(work, placed)
    item = item_of(out)
    check([item["properties"][f"accuracy:geometric_{axis}_stddev"] for axis in "xy"] == [40.1123, 40.1123], "the item's error")
    check(any("/accuracy/" in extension for extension in item["stac_extensions"]), "the extension is not named")
    check("may be off by 40.1 m" in item["properties"]["description"], f"the item: {item['properties']['description']}")
    check("may be off by 40.1 m" in re.search("<comment>(.*?)</comment>", label_of(out))[1], "the label does not say the error")
    full = os.path.join(work, "full")
    os.makedirs(full)
    open(os.path.join(full, "letter.txt"), "w", encoding="utf-8").close()
    program = os.path.join(TOP, "sim", "tools", "python", "formats")
    run = subprocess.run([program, placed, "--out", full], capture_output=True, text=True)
    check(run.returncode == 1 and "letter.txt" in run.stderr and os.listdir(full) == ["letter.txt"], f"a full folder: {run.stderr}")


def item_of(out):
    with open(os.path.join(out, "stac", "strip.json"), encoding="utf-8") as file:
        return json.load(file)


def label_of(out):
    with open(os.path.join(out, "pds4", "height.xml"), encoding="utf-8") as file:
        return file.read()


def target_of(out):
    found = re.search(r"<Target_Identification>\s*<name>(.*?)</name>\s*<type>(.*?)</type>", label_of(out), re.S)
    return found.groups() if found else None


def bound_of(out, side):
    return float(re.search(rf"<cart:{side}_bounding_coordinate[^>]*>(.*?)<", label_of(out))[1])


def check_across_180(options, work, ground):
    out, _ = check_anchored(options, work, ground, "titan", -180.0, 40.0)
    check(target_of(out) == ("Titan", "Satellite"), f"the target is not that of the map: {target_of(out)}")
    item = item_of(out)
    box = item["bbox"]
    check(179 < box[0] < 180 and -180 < box[2] < -179, f"the box is a belt: {box}")
    check(item["geometry"]["type"] == "MultiPolygon" and len(item["geometry"]["coordinates"]) == 2, "it is not cut at 180")
    check(item["id"] == "flight-3-strip" and "urn:nasa:pds:flight-3:data:height" in label_of(out), "it has another name")
    for side, value in (("west", box[0]), ("east", box[2]), ("south", box[1]), ("north", box[3])):
        check(abs(bound_of(out, side) - value) < 1e-9, f"{side} is not that of the item")


def check_latitudes(options, work, ground):
    out, _ = check_anchored(options, work, ground, "earth", 4.4, 51.2)
    check(target_of(out) == ("Earth", "Planet") and item_of(out)["properties"]["ssys:targets"] == ["Earth"], "not the Earth")
    check("<cart:latitude_type>Planetographic</cart:latitude_type>" in label_of(out), "geodetic latitudes are planetographic")


if __name__ == "__main__":
    main()
