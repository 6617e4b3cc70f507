#!/usr/bin/python3 -B
"""3D Tiles of sim/tools/python/tiles3d, read back by the tables of the standards (3D Tiles 1.1, glTF 2.0) alone.

    tiles_test.py WORK; status 77 without numpy or GDAL"""

import filecmp
import json
import math
import os
import shutil
import struct
import subprocess
import sys
import unittest

TOP = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
try:
    import numpy
    from osgeo import gdal, osr
except ImportError as missing:
    print(f"skipped: {missing}; apt-get install python3-numpy python3-gdal")
    sys.exit(77)

gdal.UseExceptions()
WORK = sys.argv[1]
COLUMNS, ROWS, CELL = 300, 200, 0.5  # cells: two levels above the finest one, and tiles cut off by the map's edges
MARS = ('PROJCS["about a place",GEOGCS["Mars 2000",DATUM["D_Mars_2000",SPHEROID["Mars_2000_IAU_IAG",3396190,169.894447223612]],'
        'PRIMEM["Reference_Meridian",0],UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],'
        'PARAMETER["latitude_of_origin",-4.6],PARAMETER["central_meridian",137.4],PARAMETER["scale_factor",1],'
        'PARAMETER["false_easting",0],PARAMETER["false_northing",0],UNIT["metre",1]]')


def heights_of_world():
    """Waves, a cliff and a hole in which nothing was seen."""
    x, y = numpy.meshgrid(numpy.arange(COLUMNS), numpy.arange(ROWS))
    z = -4400 + 6 * numpy.sin(x / 17) + 4 * numpy.cos(y / 11) + numpy.where(x > 220, 60, 0)
    z[60:90, 100:140] = numpy.nan
    z[:3, :50] = numpy.nan
    return z.astype(numpy.float32)


# GDAL's six numbers of a map that lies 30 degrees across its axes.
TURNED = [-70.0, CELL * math.cos(0.5), -CELL * math.sin(0.5), 55.0, -CELL * math.sin(0.5), -CELL * math.cos(0.5)]
STRAIGHT = [-70.0, CELL, 0, 55.0, 0, -CELL]


def grey_at(column, row):
    """Of the orthoimage; it grows to the east by another measure than to the south."""
    return 1 + (column * 150) // COLUMNS + (row * 100) // ROWS


def write_map(folder, crs):
    os.makedirs(folder)
    with open(os.path.join(folder, "report.json"), "w", encoding="utf-8") as file:
        file.write("{}")
    z = heights_of_world()
    grey = numpy.where(numpy.isfinite(z), grey_at(*numpy.meshgrid(numpy.arange(COLUMNS), numpy.arange(ROWS))), 0).astype(numpy.uint8)
    for name, values, kind, missing in (("height", z, gdal.GDT_Float32, math.nan), ("ortho", grey, gdal.GDT_Byte, 0)):
        data = gdal.GetDriverByName("GTiff").Create(os.path.join(folder, name + ".tif"), COLUMNS, ROWS, 1, kind)
        data.SetGeoTransform(TURNED if crs else STRAIGHT)
        if crs:
            data.SetProjection(crs)
        data.GetRasterBand(1).SetNoDataValue(missing)
        data.GetRasterBand(1).WriteArray(values)
    return z


def read_glb(path):
    """Points with y up as they are in the node's parent, texture places, triangles of each primitive, and the picture."""
    with open(path, "rb") as file:
        content = file.read()
    magic, version, length = struct.unpack_from("<4sII", content)
    assert (magic, version, length) == (b"glTF", 2, len(content)), path
    size, kind = struct.unpack_from("<I4s", content, 12)
    assert kind == b"JSON" and size % 4 == 0
    model, start = json.loads(content[20:20 + size]), 20 + size
    size, kind = struct.unpack_from("<I4s", content, start)
    assert kind == b"BIN\0" and start + 8 + size == len(content)
    body = content[start + 8:]

    def values(number):
        accessor = model["accessors"][number]
        view = model["bufferViews"][accessor["bufferView"]]
        kind, bytes_ = {5126: ("<f4", 4), 5123: ("<u2", 2)}[accessor["componentType"]]
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}[accessor["type"]]
        assert view["byteOffset"] % 4 == 0 and view["byteLength"] == accessor["count"] * width * bytes_
        array = numpy.frombuffer(body, kind, accessor["count"] * width, view["byteOffset"]).reshape(-1, width)
        if "min" in accessor:
            assert array.min(axis=0).tolist() == accessor["min"] and array.max(axis=0).tolist() == accessor["max"]
        return array

    primitives = model["meshes"][0]["primitives"]
    attributes = primitives[0]["attributes"]
    points = values(attributes["POSITION"]).astype(float) + model["nodes"][0]["translation"]
    faces = [values(p["indices"]).reshape(-1, 3).astype(int) for p in primitives]
    assert max(f.max() for f in faces) < len(points)
    view = model["bufferViews"][model["images"][0]["bufferView"]]
    gdal.FileFromMemBuffer("/vsimem/read.png", body[view["byteOffset"]:view["byteOffset"] + view["byteLength"]])
    picture = gdal.Open("/vsimem/read.png").ReadAsArray()
    gdal.Unlink("/vsimem/read.png")
    return points, values(attributes["TEXCOORD_0"]), faces, picture


def map_from_geocentric(points):
    """East and north of the map and height, by Bowring's way back to longitude and latitude."""
    projected = osr.SpatialReference(MARS)
    degrees = projected.CloneGeogCS()
    for each in (projected, degrees):
        each.SetAxisMappingStrategy(osr.OAMS_TRADITIONAL_GIS_ORDER)
    a = 3396190.0
    f = 1 / 169.894447223612
    b, e2 = a * (1 - f), f * (2 - f)
    out = []
    for x, y, z in points:
        p = math.hypot(x, y)
        latitude = math.atan2(z, p * (1 - e2))
        for _ in range(10):
            n = a / math.sqrt(1 - e2 * math.sin(latitude) ** 2)
            height = p / math.cos(latitude) - n
            latitude = math.atan2(z, p * (1 - e2 * n / (n + height)))
        n = a / math.sqrt(1 - e2 * math.sin(latitude) ** 2)
        out.append((math.degrees(math.atan2(y, x)), math.degrees(latitude), p / math.cos(latitude) - n))
    return numpy.array(osr.CoordinateTransformation(degrees, projected).TransformPoints(out))


class Tiles(unittest.TestCase):
    def setUp(self):
        self.folder = os.path.join(WORK, self.id().rsplit(".", 1)[1])
        shutil.rmtree(self.folder, ignore_errors=True)
        os.makedirs(self.folder)

    def write(self, crs, name="tiles"):
        flight, out = os.path.join(self.folder, "flight"), os.path.join(self.folder, name)
        if not os.path.exists(flight):
            self.z = write_map(flight, crs)
        subprocess.run([os.path.join(TOP, "sim", "tools", "python", "tiles3d"), flight, "--out", out], check=True)
        with open(os.path.join(out, "tileset.json"), encoding="utf-8") as file:
            return out, json.load(file)

    def places_of(self, out, root, tile):
        """The tile's points as columns and rows of the map and heights; those of the tileset; and the rest of its glTF."""
        points, texture, faces, picture = read_glb(os.path.join(out, tile["content"]["uri"]))
        points = numpy.stack([points[:, 0], -points[:, 2], points[:, 1]], axis=1)  # y up to z up
        there = points
        if "transform" in root:
            matrix = numpy.array(root["transform"]).reshape(4, 4).T
            self.assertEqual(matrix[3].tolist(), [0, 0, 0, 1])
            numpy.testing.assert_allclose(matrix[:3, :3] @ matrix[:3, :3].T, numpy.eye(3), atol=1e-12)
            there = map_from_geocentric(points @ matrix[:3, :3].T + matrix[:3, 3])
        affine = TURNED if "transform" in root else STRAIGHT
        to_map = numpy.array([[affine[1], affine[2]], [affine[4], affine[5]]])
        index = numpy.linalg.solve(to_map, (there[:, :2] - [affine[0], affine[3]]).T).T - 0.5
        cells = numpy.column_stack([index, there[:, 2]])
        return cells, points, texture, faces, picture

    def inside(self, points, box, what):
        centre, half = numpy.array(box[:3]), numpy.array([box[3], box[7], box[11]])
        self.assertTrue((numpy.abs(points - centre) <= half + 1e-9).all(), what)

    def check_tileset(self, crs):
        out, tileset = self.write(crs)
        root, z = tileset["root"], self.z
        self.assertEqual(tileset["asset"]["version"], "1.1")
        self.assertGreaterEqual(tileset["geometricError"], root["geometricError"])
        self.assertEqual("transform" in root, crs is not None)
        files, covered, levels = {"tileset.json"}, set(), set()

        def check(tile, above, boxes, depth):
            self.assertEqual(tile["refine"], "REPLACE")
            self.assertEqual(len(tile["boundingVolume"]["box"]), 12)
            self.assertLess(tile["geometricError"], above)
            boxes = [*boxes, tile["boundingVolume"]["box"]]
            uri = tile["content"]["uri"]
            files.add(uri)
            cells, points, texture, (faces, skirt), picture = self.places_of(out, root, tile)
            for box in boxes:
                self.inside(points, box, uri)
            top = numpy.unique(faces)
            index = numpy.round(cells[top, :2]).astype(int)
            numpy.testing.assert_allclose(cells[top, :2], index, atol=2e-3, err_msg=uri + " has points between cells")
            true = z[index[:, 1], index[:, 0]]
            numpy.testing.assert_allclose(cells[top, 2], true, atol=2e-3, err_msg=uri + " has other heights")
            # Every triangle faces up, and the skirt lies below the border.
            a, b, c = (points[faces[:, k]] for k in range(3))
            self.assertTrue((numpy.cross(b - a, c - a)[:, 2] > 0).all(), uri)
            self.assertTrue(set(range(len(points))) == set(top) | set(skirt.ravel()), uri)
            below = numpy.setdiff1d(skirt, top)
            under = numpy.round(cells[below, :2]).astype(int)
            self.assertTrue((cells[below, 2] < z[under[:, 1], under[:, 0]] - 0.4 * CELL).all(), uri)
            # The texture at a point is the orthoimage there; a pixel of a coarse tile is a mean.
            at = texture[top] * [picture.shape[1], picture.shape[0]]
            grey = picture[numpy.minimum(at[:, 1].astype(int), picture.shape[0] - 1),
                           numpy.minimum(at[:, 0].astype(int), picture.shape[1] - 1)]
            wanted = grey_at(index[:, 0], index[:, 1])
            self.assertLess(numpy.median(numpy.abs(grey.astype(int) - wanted)), 3, uri)
            if depth:
                levels.add(depth)
            children = tile.get("children", [])
            self.assertEqual(tile["geometricError"] == 0, not children)
            if not children:
                for face in numpy.round(cells[faces.ravel(), :2]).astype(int).reshape(-1, 3, 2):
                    covered.add((tuple(face.min(axis=0)), tuple(map(tuple, face))))
            else:
                self.check_error(cells[top], tile, z, uri)
            for child in children:
                check(child, tile["geometricError"], boxes, depth + 1)

        check(root, math.inf, [], 0)
        self.assertEqual(levels, {1, 2})
        found = {os.path.relpath(os.path.join(at, name), out) for at, _, names in os.walk(out) for name in names}
        self.assertEqual(found, files, "a file that no tile names, or a tile without a file")
        known = numpy.isfinite(z)
        squares = {(int(c), int(r)) for r, c in numpy.argwhere(known[:-1, :-1] & known[1:, :-1] & known[:-1, 1:] & known[1:, 1:])}
        self.assertEqual({corner for corner, _ in covered}, squares, "the finest tiles are not all of the map")
        self.assertEqual(len(covered), 2 * len(squares), "two triangles a square, none twice")

    def check_error(self, cells, tile, z, uri):
        """No cell that the tile covers lies farther from its surface than it says."""
        columns, rows = (numpy.unique(numpy.round(cells[:, k]).astype(int)) for k in (0, 1))
        grid = numpy.where(numpy.isfinite(z[numpy.ix_(rows, columns)]), z[numpy.ix_(rows, columns)], numpy.nan)
        all_columns, all_rows = (numpy.arange(side[0], side[-1] + 1) for side in (columns, rows))
        along = numpy.stack([numpy.interp(all_columns, columns, line) for line in grid])
        surface = numpy.stack([numpy.interp(all_rows, rows, line) for line in along.T], axis=1)
        apart = numpy.abs(z[numpy.ix_(all_rows, all_columns)] - surface)
        self.assertLessEqual(numpy.nanmax(apart), tile["geometricError"], uri)

    def test_on_a_body_every_point_is_where_the_map_has_it(self):
        self.check_tileset(MARS)

    def test_in_the_strips_own_axes_too(self):
        self.check_tileset(None)

    def test_an_island_that_touches_no_border_of_its_tile_has_no_skirt_there(self):
        """glTF demands that every buffer and accessor has something in it."""
        for crs in (None, MARS):
            with self.subTest(crs=crs):
                shutil.rmtree(self.folder)
                flight = os.path.join(self.folder, "flight")
                write_map(flight, crs)
                data = gdal.Open(os.path.join(flight, "height.tif"), gdal.GA_Update)
                z = data.GetRasterBand(1).ReadAsArray()
                z[:20], z[100:], z[:, :20], z[:, 100:] = (numpy.nan,) * 4
                data.GetRasterBand(1).WriteArray(z)
                data = None
                out, tileset = self.write(crs)
                tile = tileset["root"]
                while "content" not in tile:
                    tile = tile["children"][0]
                points, _, faces, _ = read_glb(os.path.join(out, tile["content"]["uri"]))
                self.assertEqual(len(faces), 1, "a skirt without a border")
                self.assertEqual(set(range(len(points))), set(faces[0].ravel()))

    def test_the_same_map_gives_the_same_bytes(self):
        first, _ = self.write(MARS)
        second, _ = self.write(MARS, "again")
        names = [os.path.relpath(os.path.join(at, name), first) for at, _, found in os.walk(first) for name in found]
        self.assertGreater(len(names), 5)
        self.assertEqual(filecmp.cmpfiles(first, second, names, shallow=False)[1:], ([], []))

    def test_a_folder_with_other_files_is_left_alone(self):
        write_map(os.path.join(self.folder, "flight"), None)
        run = subprocess.run([os.path.join(TOP, "sim", "tools", "python", "tiles3d"), os.path.join(self.folder, "flight"), "--out",
                              os.path.join(self.folder, "flight")], capture_output=True, text=True)
        self.assertEqual(run.returncode, 1)
        self.assertIn("name another folder", run.stderr)
        self.assertTrue(os.path.exists(os.path.join(self.folder, "flight", "height.tif")))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
