"""Opens what ilp-ground wrote about a flight: maps as arrays, keyframes as a table, profiles. docs/python.md has examples.

It needs Debian's python3-numpy and python3-gdal."""

import csv
import io
import json
import os
from dataclasses import dataclass

import numpy
from osgeo import gdal

gdal.UseExceptions()

# A file that says that it is larger than these is refused before memory is taken for it.
MOST_CELLS = 1 << 28
MOST_TEXT_BYTES = 64 << 20
MOST_METRES = 1e9
TEXTS = {"name", "state", "depth", "products", "unit"}  # columns of keyframes.csv; all others are numbers


class BadResult(ValueError):
    """A file is not what ilp-ground writes. The text names the file, and the place in it."""


def read_text(path):
    """A text of the results, UTF-8."""
    if os.path.getsize(path) > MOST_TEXT_BYTES:
        raise BadResult(f"{path}: has more than {MOST_TEXT_BYTES >> 20} MiB")
    with open(path, "rb") as file:
        octets = file.read(MOST_TEXT_BYTES + 1)
    try:
        return octets.decode("utf-8")
    except UnicodeDecodeError as fault:
        raise BadResult(f"{path}, octet {fault.start}: is no UTF-8") from fault


def read_report(path):
    try:
        report = json.loads(read_text(path))
    except json.JSONDecodeError as fault:
        raise BadResult(f"{path}, line {fault.lineno}, column {fault.colno}: {fault.msg}") from fault
    except RecursionError as fault:
        raise BadResult(f"{path}: is nested too deeply") from fault
    except ValueError as fault:
        # Such as a number of more digits than Python reads.
        raise fault if isinstance(fault, BadResult) else BadResult(f"{path}: {fault}") from fault
    if not isinstance(report, dict):
        raise BadResult(f"{path}: is no report, which is an object")
    return report


def read_table(path):
    """A table with a line of names: a structured array, numbers as float (NaN where there is none)."""
    rows = csv.reader(io.StringIO(read_text(path), newline=""), strict=True)
    cells = []
    try:
        names = next(rows, [])
        if len(set(names)) != len(names) or not all(names):
            raise BadResult(f"{path}, line 1: two columns have one name, or a column has none")
        for row in rows:
            if len(row) != len(names):
                raise BadResult(f"{path}, line {rows.line_num}: has {len(row)} values for {len(names)} columns")
            cells.append(tuple(cell if name in TEXTS else number_of(path, rows.line_num, name, cell)
                               for name, cell in zip(names, row)))
    except csv.Error as fault:
        raise BadResult(f"{path}, line {rows.line_num}: {fault}") from fault
    return numpy.array(cells, dtype=[(name, "U64" if name in TEXTS else float) for name in names])


def number_of(path, line, name, cell):
    try:
        return float(cell or "nan")
    except ValueError as fault:
        raise BadResult(f"{path}, line {line}, column {name}: {cell[:40]!r} is no number") from fault


def longitude_arc(longitudes):
    """West and east end, from -180 to 180, of the shortest arc that holds all longitudes; west is larger than east where
    it crosses 180 (RFC 7946, 5.2)."""
    turned = numpy.sort((numpy.asarray(longitudes, float) + 180) % 360 - 180)
    gaps = numpy.diff(turned, append=turned[0] + 360)
    last = int(len(turned) - 1 - numpy.argmax(gaps[::-1]))
    return float(turned[(last + 1) % len(turned)]), float(turned[last])


def open_map(path):
    """A GeoTIFF of the results, opened by GDAL; no other kind of file, which might lead to further ones."""
    if not os.path.isfile(path):
        raise FileNotFoundError(f"there is no map {path}")
    try:
        data = gdal.OpenEx(path, gdal.OF_RASTER, allowed_drivers=["GTiff"])
    except RuntimeError as fault:
        raise BadResult(f"{path}: {fault}") from fault
    if data.RasterCount < 1 or data.RasterXSize * data.RasterYSize > MOST_CELLS:
        raise BadResult(f"{path}: has {data.RasterCount} bands of {data.RasterXSize} x {data.RasterYSize} cells")
    if gdal.DataTypeIsComplex(data.GetRasterBand(1).DataType):
        raise BadResult(f"{path}: its cells are complex numbers")
    left, a, b, top, c, d = transform = data.GetGeoTransform()
    if not numpy.isfinite(transform).all() or not abs(a * d - b * c) > 0:
        raise BadResult(f"{path}: its cells have no size, {transform}")
    return data


def read_cells(path, band):
    try:
        values = band.ReadAsArray().astype(float)
    except RuntimeError as fault:
        raise BadResult(f"{path}: {fault}") from fault
    if band.GetNoDataValue() is not None:
        values[values == band.GetNoDataValue()] = numpy.nan
    values[numpy.isinf(values)] = numpy.nan
    return values


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
class Place:
    text: str
    sigma_m: float | None
    map_sigma_m: float | None
    whole_sigma_m: float | None


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
        self.report = read_report(report)
        found = [name for name in sorted(os.listdir(self.folder)) if os.path.isfile(os.path.join(self.folder, name, "height.tif"))]
        # The only strip, or the model that joins all, is in the folder itself.
        self.maps = ([""] if os.path.isfile(os.path.join(self.folder, "height.tif")) else []) + found

    def map(self, name, strip=None):
        """`name`: height, sigma, count or ortho. `strip`: one of `maps`, the first one unless given."""
        if not self.maps:
            raise FileNotFoundError(f"{self.folder} has no map: the flight has no strip with depth")
        path = os.path.join(self.folder, self.maps[0] if strip is None else strip, name + ".tif")
        data = open_map(path)
        band = data.GetRasterBand(1)
        return Map(read_cells(path, band), data.GetGeoTransform(), band.GetUnitType(), data.GetProjection(), path)

    @property
    def height(self):
        return self.map("height")

    @property
    def sigma(self):
        return self.map("sigma")

    @property
    def keyframes(self):
        """A structured array: a column for each of keyframes.csv, numbers as float (NaN where there is none)."""
        return read_table(os.path.join(self.folder, "keyframes.csv"))

    @property
    def place(self):
        """Where the map of `height` is on its body, as report.json has it: a text, and one sigma to each side in metres or
        None where it is not known, with that of the orbiter's map on which it stands. None in the strip's own axes."""
        report = os.path.join(self.folder, "report.json")
        strips = self.report.get("strips")
        place = strips[0].get("place") if isinstance(strips, list) and strips and isinstance(strips[0], dict) else None
        if place is None:
            return None
        if not isinstance(place, dict) or not isinstance(place.get("text"), str):
            raise BadResult(f"{report}, place of the first strip: has no text")
        sigmas = [place.get(name) for name in ("sigma_m", "map_sigma_m", "whole_sigma_m")]
        for sigma in sigmas:
            if sigma is not None and not (isinstance(sigma, (int, float)) and 0 < sigma < MOST_METRES):
                raise BadResult(f"{report}, place of the first strip: {str(sigma)[:40]} is no error in metres")
        return Place(place["text"], *sigmas)

    def profile(self, begin, end, points=200, strip=None):
        """Heights along a line between two points (x, y) of the map."""
        height, sigma = self.map("height", strip), self.map("sigma", strip)
        share = numpy.linspace(0, 1, points)
        x, y = (begin[i] + share * (end[i] - begin[i]) for i in (0, 1))
        return Profile(share * float(numpy.hypot(end[0] - begin[0], end[1] - begin[1])), height.at(x, y), sigma.at(x, y), height.unit)
