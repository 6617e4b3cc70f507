"""Opens what ilp-ground wrote about a flight: maps as arrays, keyframes as a table, profiles. docs/python.md has examples.

It needs Debian's python3-numpy and python3-gdal."""

import csv
import json
import os
from dataclasses import dataclass

import numpy
from osgeo import gdal

gdal.UseExceptions()


@dataclass
class Map:
    """A map of one strip. `values` has rows from north to south, or, on a body, across the strip; cells without data are
    NaN. `transform` gives coordinates from columns and rows as GDAL does, in the unit of the file (metres where the flight
    is anchored). `x` and `y` are the coordinates of the cells' centres: one for each column and row where rows run east,
    else one for each cell."""
    values: numpy.ndarray
    transform: tuple
    unit: str
    crs: str  # WKT
    path: str

    @property
    def is_turned(self):
        return self.transform[2] != 0 or self.transform[4] != 0

    @property
    def cell(self):
        """Length of a cell's side."""
        return float(numpy.hypot(self.transform[1], self.transform[4]))

    def place(self, columns, rows):
        """Coordinates; the centre of the first cell has column and row 0."""
        left, a, b, top, c, d = self.transform
        return left + a * (columns + 0.5) + b * (rows + 0.5), top + c * (columns + 0.5) + d * (rows + 0.5)

    @property
    def x(self):
        rows, columns = numpy.indices(self.values.shape) if self.is_turned else (0, numpy.arange(self.values.shape[1]))
        return self.place(columns, rows)[0]

    @property
    def y(self):
        rows, columns = numpy.indices(self.values.shape) if self.is_turned else (numpy.arange(self.values.shape[0]), 0)
        return self.place(columns, rows)[1]

    def at(self, x, y):
        """The values between the four nearest cells; NaN beside the map, and where one of the four has no data."""
        left, a, b, top, c, d = self.transform
        east, north, area = numpy.asarray(x) - left, numpy.asarray(y) - top, a * d - b * c
        column, row = (d * east - b * north) / area - 0.5, (a * north - c * east) / area - 0.5
        height, width = self.values.shape
        # A cell's own centre is found in spite of rounding.
        inside = (column > -1e-6) & (row > -1e-6) & (column < width - 1 + 1e-6) & (row < height - 1 + 1e-6)
        c0 = numpy.clip(numpy.where(inside, column, 0).astype(int), 0, width - 2)
        r0 = numpy.clip(numpy.where(inside, row, 0).astype(int), 0, height - 2)
        u, v = numpy.clip(column - c0, 0, 1), numpy.clip(row - r0, 0, 1)
        z = self.values
        value = ((1 - v) * ((1 - u) * z[r0, c0] + u * z[r0, c0 + 1]) + v * ((1 - u) * z[r0 + 1, c0] + u * z[r0 + 1, c0 + 1]))
        return numpy.where(inside, value, numpy.nan)


@dataclass
class Profile:
    distance: numpy.ndarray
    height: numpy.ndarray
    sigma: numpy.ndarray
    unit: str

    def plot(self, path, width=800, height=300):
        """Writes a picture (SVG): the height, and one sigma around it."""
        good = numpy.isfinite(self.height) & numpy.isfinite(self.sigma)
        if not good.any():
            raise ValueError("the profile crosses no ground of the map")
        d, z, s = self.distance[good], self.height[good], self.sigma[good]
        low, high = (z - s).min(), (z + s).max()
        span, reach = max(high - low, 1e-9), max(self.distance.max(), 1e-9)
        def line(heights):
            return [f"{60 + (width - 70) * a / reach:.1f},{10 + (height - 50) * (high - b) / span:.1f}" for a, b in zip(d, heights)]
        band = " ".join(line(z + s) + line(z - s)[::-1])
        # A gap in the data is a gap in the line.
        cuts = numpy.flatnonzero(numpy.diff(numpy.flatnonzero(good)) > 1) + 1
        lines = "".join(f'<polyline points="{" ".join(part)}" fill="none" stroke="#124"/>'
                        for part in numpy.split(numpy.array(line(z)), cuts))
        with open(path, "w", encoding="utf-8") as file:
            file.write(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" '
                       f'font-size="12"><rect width="{width}" height="{height}" fill="#fff"/>'
                       f'<polygon points="{band}" fill="#cde"/>{lines}'
                       f'<text x="4" y="20">{high:.4g}</text><text x="4" y="{height - 42}">{low:.4g}</text>'
                       f'<text x="60" y="{height - 8}">distance 0 to {reach:.4g}, height, in {self.unit}</text></svg>\n')


class Flight:
    """The folder of ilp-ground, or that of sim/fly, which has it in `ground`."""

    def __init__(self, folder):
        inner = os.path.join(folder, "ground")
        self.folder = inner if os.path.isfile(os.path.join(inner, "report.json")) else folder
        report = os.path.join(self.folder, "report.json")
        if not os.path.isfile(report):
            raise FileNotFoundError(f"{folder} has no report.json: give the folder that ilp-ground --out or sim/fly --out wrote")
        with open(report, encoding="utf-8") as file:
            self.report = json.load(file)
        found = [name for name in sorted(os.listdir(self.folder)) if os.path.isfile(os.path.join(self.folder, name, "height.tif"))]
        # The only strip, or the model that joins all, is in the folder itself.
        self.maps = ([""] if os.path.isfile(os.path.join(self.folder, "height.tif")) else []) + found

    def map(self, name, strip=None):
        """`name`: height, sigma, count or ortho. `strip`: one of `maps`, the first one unless given."""
        if not self.maps:
            raise FileNotFoundError(f"{self.folder} has no map: the flight has no strip with depth")
        path = os.path.join(self.folder, self.maps[0] if strip is None else strip, name + ".tif")
        data = gdal.Open(path)
        band = data.GetRasterBand(1)
        values = band.ReadAsArray().astype(float)
        if band.GetNoDataValue() is not None:
            values[values == band.GetNoDataValue()] = numpy.nan
        return Map(values, data.GetGeoTransform(), band.GetUnitType(), data.GetProjection(), path)

    @property
    def height(self):
        return self.map("height")

    @property
    def sigma(self):
        return self.map("sigma")

    @property
    def keyframes(self):
        """A structured array: a column for each of keyframes.csv, numbers as float (NaN where there is none)."""
        with open(os.path.join(self.folder, "keyframes.csv"), encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        names = list(rows[0]) if rows else []
        texts = {"name", "state", "depth", "products", "unit"}
        types = [(name, "U64" if name in texts else float) for name in names]
        cells = [tuple(row[n] if n in texts else float(row[n] or "nan") for n in names) for row in rows]
        return numpy.array(cells, dtype=types)

    def profile(self, begin, end, points=200, strip=None):
        """Heights along a line between two points (x, y) of the map."""
        height, sigma = self.map("height", strip), self.map("sigma", strip)
        share = numpy.linspace(0, 1, points)
        x, y = (begin[i] + share * (end[i] - begin[i]) for i in (0, 1))
        return Profile(share * float(numpy.hypot(end[0] - begin[0], end[1] - begin[1])), height.at(x, y), sigma.at(x, y), height.unit)
