// The footprints of many missions in one PostgreSQL database with PostGIS, so that one query says which keyframes of
// which mission saw a place.
#pragma once

#include <string>
#include <vector>

#include "sim/ground/export/strip_exports.hpp"
#include "sim/ground/intake/flight_model.hpp"

namespace ilp::exports {

// The schema `aerobot` has the table `keyframe`: a row for each keyframe, with the columns of keyframe_columns
// (flight_tables.hpp), and
//
//   mission    text      name under which a run writes
//   body       text      that the strip is anchored on; null: the strip's own axes
//   footprint  geometry  polygon, longitude (east) and latitude in degrees and height in metres on a body, else in the
//                        strip's own axes and unit; SRID 0, because PostGIS knows the Earth's systems only; null where
//                        the image does not show the mapped ground
//
// and the function aerobot.seen(body, longitude, latitude), which gives mission, keyframe, strip and name of every
// keyframe that saw the place. The caller names no password: libpq takes it from ~/.pgpass or PGPASSWORD.

/// Connects, and creates schema and extension where they are missing. Throws std::runtime_error when `address` is no
/// URL postgresql://..., holds a password, or does not answer, or when the server has no PostGIS.
void prepare_shared_catalogue(const std::string& address);

/// Replaces the mission's rows in one transaction: readers see the earlier rows or the new ones. The rows follow from
/// the flight alone. Throws std::runtime_error; the earlier rows stay then.
void write_shared_catalogue(const std::string& address, const std::string& mission, const intake::Flight& flight,
                            const std::vector<const ExportedStrip*>& strips, const Anchors* anchors);

}  // namespace ilp::exports
