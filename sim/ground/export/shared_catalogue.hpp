// Writes the keyframes' footprints of several missions into one PostgreSQL database with PostGIS, so that one query
// finds the keyframes of all missions that saw a point.
#pragma once

#include <string>
#include <vector>

#include "sim/ground/export/strip_exports.hpp"
#include "sim/ground/intake/flight_model.hpp"

namespace ilp::exports {

// The schema `aerobot` has the table `keyframe`: a row for each keyframe, with the columns of keyframe_columns
// (flight_tables.hpp), and
//
//   mission    text      name of the flight
//   body       text      body on which the strip is anchored; null: the strip's own axes
//   footprint  geometry  polygon, longitude (east) and latitude in degrees and height in metres on a body, else in the
//                        strip's own axes and unit; SRID 0, because PostGIS knows the Earth's systems only; null where
//                        the image does not show the mapped ground
//
// and the function aerobot.seen(body, longitude, latitude), which returns mission, keyframe, strip and name of every
// keyframe that saw the point. The address has no password: libpq takes it from ~/.pgpass or PGPASSWORD.

/// Connects, and creates schema and extension if they are missing. Throws std::runtime_error if `address` is no URL
/// postgresql://..., contains a password, or does not answer, or if the server has no PostGIS.
void prepare_shared_catalogue(const std::string& address);

/// Replaces the mission's rows in one transaction: readers see either the earlier rows or the new ones. If it throws
/// std::runtime_error, the earlier rows stay.
void write_shared_catalogue(const std::string& address, const std::string& mission, const intake::Flight& flight,
                            const std::vector<const ExportedStrip*>& strips, const Anchors* anchors);

}  // namespace ilp::exports
