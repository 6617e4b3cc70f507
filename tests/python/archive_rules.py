"""What a PDS4 label and a STAC catalogue must be, written from the standards: the PDS4 Information Model 1.16 (elements of
Product_Observational, their order and number, permitted values) and STAC 1.0.0 (item-spec, collection-spec). The schemas
themselves are not at hand. `faults` names what is wrong."""

import datetime
import json
import os
import re
import xml.etree.ElementTree as ElementTree

PDS = "{http://pds.nasa.gov/pds4/pds/v1}"
ANY = object()  # of a dictionary with rules of its own: not looked into
MANY = 1 << 30

# Element: its children in their order as (name, fewest, most).
CHILDREN = {
    "Product_Observational": [("Identification_Area", 1, 1), ("Observation_Area", 1, 1), ("Reference_List", 0, 1),
                              ("File_Area_Observational", 1, MANY)],
    "Identification_Area": [("logical_identifier", 1, 1), ("version_id", 1, 1), ("title", 1, 1),
                            ("information_model_version", 1, 1), ("product_class", 1, 1), ("Alias_List", 0, 1),
                            ("Citation_Information", 0, 1), ("Modification_History", 0, 1)],
    "Observation_Area": [("comment", 0, 1), ("Time_Coordinates", 1, 1), ("Primary_Result_Summary", 0, 1),
                         ("Investigation_Area", 1, MANY), ("Observing_System", 1, MANY), ("Target_Identification", 1, MANY),
                         ("Mission_Area", 0, 1), ("Discipline_Area", 0, 1)],
    "Time_Coordinates": [("start_date_time", 1, 1), ("stop_date_time", 1, 1), ("local_mean_solar_time", 0, 1),
                         ("local_true_solar_time", 0, 1), ("solar_longitude", 0, 1)],
    "Primary_Result_Summary": [("type", 0, MANY), ("purpose", 1, MANY), ("data_regime", 0, MANY), ("processing_level", 1, MANY),
                               ("processing_level_id", 0, 1), ("description", 0, 1), ("Science_Facets", 0, MANY)],
    "Investigation_Area": [("name", 1, 1), ("type", 1, 1), ("Internal_Reference", 1, MANY)],
    "Observing_System": [("name", 0, 1), ("description", 0, 1), ("Observing_System_Component", 1, MANY)],
    "Observing_System_Component": [("name", 1, 1), ("type", 1, 1), ("description", 0, 1), ("Internal_Reference", 0, MANY),
                                   ("External_Reference", 0, MANY)],
    "Target_Identification": [("name", 1, 1), ("alternate_designation", 0, MANY), ("type", 1, MANY), ("description", 0, 1),
                              ("Internal_Reference", 0, MANY)],
    "Internal_Reference": [("lid_reference", 1, 1), ("reference_type", 1, 1), ("comment", 0, 1)],
    "Discipline_Area": ANY,
    "File_Area_Observational": [("File", 1, 1), ("Array_2D_Image", 1, MANY)],
    "File": [("file_name", 1, 1), ("local_identifier", 0, 1), ("creation_date_time", 0, 1), ("file_size", 0, 1),
             ("records", 0, 1), ("md5_checksum", 0, 1), ("comment", 0, 1)],
    "Array_2D_Image": [("name", 0, 1), ("local_identifier", 0, 1), ("md5_checksum", 0, 1), ("offset", 1, 1), ("axes", 1, 1),
                       ("axis_index_order", 1, 1), ("description", 0, 1), ("Element_Array", 1, 1), ("Axis_Array", 2, 2),
                       ("Special_Constants", 0, 1), ("Object_Statistics", 0, 1), ("Local_Internal_Reference", 0, MANY)],
    "Element_Array": [("data_type", 1, 1), ("unit", 0, 1), ("scaling_factor", 0, 1), ("value_offset", 0, 1)],
    "Axis_Array": [("axis_name", 1, 1), ("local_identifier", 0, 1), ("unit", 0, 1), ("elements", 1, 1),
                   ("sequence_number", 1, 1), ("Band_Bin_Set", 0, 1)],
    "Special_Constants": [("saturated_constant", 0, 1), ("missing_constant", 0, 1), ("error_constant", 0, 1),
                          ("invalid_constant", 0, 1), ("unknown_constant", 0, 1), ("not_applicable_constant", 0, 1),
                          ("valid_maximum", 0, 1), ("high_instrument_saturation", 0, 1),
                          ("high_representation_saturation", 0, 1), ("valid_minimum", 0, 1),
                          ("low_instrument_saturation", 0, 1), ("low_representation_saturation", 0, 1)],
}
# Form of the text of an element, by its path from the end.
FORMS = {
    "logical_identifier": r"urn:[a-z]+:[a-z]+(:[a-z0-9._-]+){3}", "version_id": r"[1-9][0-9]*\.[0-9]+",
    "information_model_version": r"1\.16\.0\.0", "product_class": "Product_Observational",
    "lid_reference": r"urn:[a-z]+:[a-z]+(:[a-z0-9._-]+){1,3}",
    "start_date_time": r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d{1,6})?Z", "stop_date_time": r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d{1,6})?Z",
    "Investigation_Area/type": "Field Campaign|Individual Investigation|Mission|Observing Campaign|Other Investigation",
    "Investigation_Area/Internal_Reference/reference_type": "data_to_investigation",
    "Target_Identification/Internal_Reference/reference_type": "data_to_target",
    "Target_Identification/type": "Asteroid|Calibration|Comet|Dwarf Planet|Planet|Satellite|Star|Sun|Terrestrial Sample",
    "purpose": "Calibration|Checkout|Engineering|Navigation|Observation Geometry|Science|Supporting Observation",
    "processing_level": "Telemetry|Raw|Partially Processed|Calibrated|Derived", "axes": "2",
    "axis_index_order": "Last Index Fastest", "axis_name": "Line|Sample", "elements": "[1-9][0-9]*", "sequence_number": "[12]",
    "data_type": "IEEE754LSBSingle|UnsignedByte|UnsignedLSB2", "file_name": r"[A-Za-z0-9][A-Za-z0-9._-]*\.img", "offset": "0",
    "unit": "m",
}
SIZES = {"IEEE754LSBSingle": 4, "UnsignedByte": 1, "UnsignedLSB2": 2}


def pds4_faults(path):
    """Of a label with its data file beside it."""
    faults = []
    root = ElementTree.parse(path).getroot()

    def look(element, above):
        name = element.tag.replace(PDS, "")
        here = [*above, name]
        children = [child.tag.replace(PDS, "") for child in element]
        rules = CHILDREN.get(name)
        if rules is None and children:
            faults.append(f"{'/'.join(here)} has elements that the model does not have there: {children}")
        if rules is None:
            text = element.text or ""
            forms = [form for end, form in FORMS.items() if here[-len(end.split("/")):] == end.split("/")]
            if not text.strip() or text != text.strip() or "${" in text:
                faults.append(f"{'/'.join(here)} is empty or has blanks: {text!r}")
            if any(not re.fullmatch(form, text) for form in forms):
                faults.append(f"{'/'.join(here)} must not be {text!r}")
        if rules is None or rules is ANY:
            return
        expected = [rule for rule, _, _ in rules]
        order = [expected.index(child) if child in expected else -1 for child in children]
        if -1 in order or order != sorted(order):
            faults.append(f"{'/'.join(here)} has {children}, in another order or with others than {expected}")
        for child, fewest, most in rules:
            if not fewest <= children.count(child) <= most:
                faults.append(f"{'/'.join(here)} has {children.count(child)} {child}")
        for child in element:
            look(child, here)

    if root.tag != PDS + "Product_Observational":
        return [f"{root.tag} is no product"]
    look(root, [])
    if faults:
        return faults
    text = lambda name: root.findtext(f".//{PDS}{name}")
    if text("start_date_time") > text("stop_date_time"):
        faults.append("it stops before it starts")
    axes = {axis.findtext(PDS + "axis_name"): (int(axis.findtext(PDS + "elements")), axis.findtext(PDS + "sequence_number"))
            for axis in root.iter(PDS + "Axis_Array")}
    if {name: order for name, (_, order) in axes.items()} != {"Line": "1", "Sample": "2"}:
        faults.append(f"axes are {axes}")
    data = os.path.join(os.path.dirname(path), text("file_name"))
    size = axes["Line"][0] * axes["Sample"][0] * SIZES[text("data_type")]
    if not os.path.isfile(data) or os.path.getsize(data) != size:
        faults.append(f"{data} has not the {size} bytes that the array takes")
    local = {e.text for e in root.iter(PDS + "local_identifier")}
    for reference in root.iter(PDS + "local_identifier_reference"):
        if reference.text not in local:
            faults.append(f"a reference to {reference.text}, which is nowhere")
    return faults


def is_instant(value):
    try:
        return value.endswith("Z") and datetime.datetime.fromisoformat(value[:-1] + "+00:00") is not None
    except (AttributeError, ValueError):
        return False


def is_box(box):
    return (isinstance(box, list) and len(box) == 4 and all(isinstance(v, (int, float)) for v in box) and
            -180 <= box[0] <= 180 and -180 <= box[2] <= 180 and -90 <= box[1] <= box[3] <= 90)


def common_faults(content, kind, where):
    faults = [f"{where}: {key} is missing" for key in ("type", "stac_version", "id", "links") if key not in content]
    if content.get("type") != kind or content.get("stac_version") != "1.0.0" or not content.get("id"):
        faults.append(f"{where}: type, stac_version or id")
    for link in content.get("links", []):
        if not (isinstance(link.get("href"), str) and link["href"] and isinstance(link.get("rel"), str)):
            faults.append(f"{where}: a link needs href and rel: {link}")
    extensions = content.get("stac_extensions", [])
    if len(set(extensions)) != len(extensions) or any(not e.startswith("https://") for e in extensions):
        faults.append(f"{where}: stac_extensions are distinct addresses")
    return faults


def item_faults(item, where):
    faults = common_faults(item, "Feature", where)
    faults += [f"{where}: {key} is missing" for key in ("geometry", "properties", "assets") if key not in item]
    if item.get("geometry") is None:
        if "bbox" in item:
            faults.append(f"{where}: a bbox without a geometry")
    else:
        geometry = item["geometry"]
        cut = geometry["type"] == "MultiPolygon"
        rings = [part[0] for part in geometry["coordinates"]] if cut else [geometry["coordinates"][0]]
        for ring in rings:
            turn = sum((b[0] - a[0]) * (b[1] + a[1]) for a, b in zip(ring, ring[1:]))
            if geometry["type"] not in ("Polygon", "MultiPolygon") or ring[0] != ring[-1] or len(ring) < 4 or turn >= 0:
                faults.append(f"{where}: the outline is no closed polygon, counter-clockwise")
            if max(p[0] for p in ring) - min(p[0] for p in ring) > 180 or not all(-180 <= p[0] <= 180 for p in ring):
                faults.append(f"{where}: the outline crosses the map (RFC 7946, 3.1.9)")
        xs, ys = [p[0] for ring in rings for p in ring], [p[1] for ring in rings for p in ring]
        west, east = (min(x for x in xs if x > 0), max(x for x in xs if x < 0)) if cut else (min(xs), max(xs))
        wanted = [west, min(ys), east, max(ys)]
        if not is_box(item.get("bbox")) or any(abs(a - b) > 1e-12 for a, b in zip(item["bbox"], wanted)):
            faults.append(f"{where}: bbox is not that of the geometry")
    properties = item.get("properties", {})
    if "datetime" not in properties:
        faults.append(f"{where}: datetime is missing")
    elif properties["datetime"] is None:
        if not all(is_instant(properties.get(key)) for key in ("start_datetime", "end_datetime")):
            faults.append(f"{where}: without a datetime, start_datetime and end_datetime are instants")
    if "gsd" in properties and not properties["gsd"] > 0:
        faults.append(f"{where}: gsd")
    wkt = properties.get("proj:wkt2")
    if wkt is not None and not wkt.startswith(("PROJCRS[", "GEOGCRS[", "ENGCRS[", "BOUNDCRS[")):
        faults.append(f"{where}: proj:wkt2 is no WKT 2: {wkt[:20]}")
    for name, asset in item.get("assets", {}).items():
        if not asset.get("href"):
            faults.append(f"{where}: asset {name} has no href")
    if any(link.get("rel") == "collection" for link in item.get("links", [])) != ("collection" in item):
        faults.append(f"{where}: a link to a collection goes with its id")
    return faults


def collection_faults(content, where):
    faults = common_faults(content, "Collection", where)
    faults += [f"{where}: {key} is missing" for key in ("description", "license", "extent") if not content.get(key)]
    extent = content.get("extent", {})
    boxes, intervals = extent.get("spatial", {}).get("bbox", []), extent.get("temporal", {}).get("interval", [])
    if not boxes or not all(is_box(box) for box in boxes):
        faults.append(f"{where}: extent.spatial.bbox")
    if not intervals or not all(len(i) == 2 and all(v is None or is_instant(v) for v in i) for i in intervals):
        faults.append(f"{where}: extent.temporal.interval")
    return faults


def stac_faults(folder):
    """Of a collection, the items that it links to, and the files that these name."""
    def read(name):
        with open(os.path.join(folder, name), encoding="utf-8") as file:
            return json.load(file)

    collection = read("collection.json")
    faults = collection_faults(collection, "collection.json")
    for link in collection["links"]:
        if link["rel"] != "item":
            continue
        item = read(link["href"])
        faults += item_faults(item, link["href"])
        if item.get("collection") != collection["id"]:
            faults.append(f"{link['href']}: it belongs to another collection")
        for linked in [one["href"] for one in item["links"]] + [one["href"] for one in item["assets"].values()]:
            if not os.path.exists(os.path.join(folder, linked)):
                faults.append(f"{linked} is not there")
    return faults
