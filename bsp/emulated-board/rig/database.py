"""What the flights left in their databases, compared: everything but times of computation and of sending."""
import os
import re
import sqlite3

import images

NUMBERS_OF_A_LIFE = 100_000_000  # fsw/records/store_epoch_ids.hpp
STATUSES = os.path.join(images.ROOT, "fsw/base/status_list.inc")
# What the images became. Blobs are deleted on board once they are used or confirmed; CRC-32 and size of products stay.
RESULTS = ("camera", "strip", "keyframe", "overlap", "pose", "depth", "mask", "richness", "product", "calibration_check")
# What does not follow from random numbers, which follow from the numbers of keyframes.
CHOSEN = ("camera", "strip", "keyframe", "overlap")
# How far a product has come down; what ended a strip, a telecommand or the end of the images. The checksum of a record
# goes over these too.
FATE = {"strip": {"end", "record_checksum"},
        "product": {"state", "layers_sent", "layers_held", "data_bytes", "record_checksum"},
        "depth": {"values_bytes", "sigma_bytes", "record_checksum"},
        "mask": {"code_bytes", "record_checksum"}}


def open_database(path):
    return sqlite3.connect(f"file:{path}?mode=ro", uri=True)


def columns(database, table):
    names = [row[1] for row in database.execute(f"PRAGMA table_info('{table}')")]
    return [name for name in names if name not in FATE.get(table, ())]


def first_number(database):
    """Of keyframes, frames and what is named after them, in the present store epoch."""
    return database.execute("SELECT keyframe_base FROM identity").fetchone()[0] + 1


def results(database, since=0):
    """All rows of the tables of results, as {(table, id): row}. With `since`: of the life whose numbers begin with it, as
    if it were the first, and only what follows from the pictures alone."""
    rows = {}
    for table in CHOSEN if since else RESULTS:
        names = [name for name in columns(database, table) if not (since and name == "record_checksum")]
        chosen = ", ".join(f'"{name}"' for name in names)
        for row in database.execute(f"SELECT {chosen} FROM \"{table}\" ORDER BY id"):
            if table != "camera" and row[0] < since:
                continue
            if since:
                is_id = [name == "id" or name.endswith("_id") for name in names]
                row = tuple(value % NUMBERS_OF_A_LIFE if known else value for known, value in zip(is_id, row))
            rows[(table, row[0])] = row
    return rows


def differences(one, other, since=0):
    """Lines that say in which rows two databases differ; empty when they agree."""
    a, b = results(one, since), results(other, min(since, 1))
    lines = [f"{table} {key}: only in the first" for table, key in a.keys() - b.keys()]
    lines += [f"{table} {key}: only in the second" for table, key in b.keys() - a.keys()]
    for at in sorted(a.keys() & b.keys()):
        if a[at] != b[at]:
            names = [name for name in columns(one, at[0]) if not (since and name == "record_checksum")]
            fields = [name for name, x, y in zip(names, a[at], b[at]) if x != y]
            lines.append(f"{at[0]} {at[1]}: {', '.join(fields)} differ")
    return lines


def products_on_ground(database):
    """States other than acknowledged, counted: empty when the ground holds everything."""
    return dict(database.execute("SELECT state, count(*) FROM product WHERE state <> 2 GROUP BY state"))


def status_number(name):
    """The code of an event: its place in the list."""
    with open(STATUSES, encoding="utf-8") as file:
        rows = re.findall(r"^ILP_STATUS\((\d+), (\w+),", file.read(), re.M)
    return {row: int(number) for number, row in rows}[name]


def frames(database):
    return list(database.execute("SELECT id, time_ns, name FROM frame ORDER BY id"))


def kept_images(database):
    """Raw images that are still on board, by the id of their frame."""
    return dict(database.execute("SELECT id, data FROM frame_image"))


def products_on_board(database):
    """Whole products in the store, by the names that their files get."""
    kinds = ("depth", "image")
    rows = database.execute("SELECT keyframe_id, kind, data FROM product JOIN product_data USING (id)")
    return {f"product-{keyframe:06d}-{kinds[kind]}.jp2": data for keyframe, kind, data in rows}


def settings(database):
    return list(database.execute("SELECT name, value FROM setting ORDER BY id"))


def commanded_exposures(database):
    """Times of the frames that were asked for by telecommand."""
    telecommand, exposed = 4, 1
    return [row[0] for row in database.execute("SELECT exposed_ns FROM capture WHERE source = ? AND state = ? "
                                               "ORDER BY exposed_ns", (telecommand, exposed))]


def mission_epoch_unix(database):
    """UTC when mission time was 0, in seconds since 1970."""
    days_1958_to_1970 = 4383
    return int(dict(settings(database))["link.mission_epoch_s"]) - days_1958_to_1970 * 86400
