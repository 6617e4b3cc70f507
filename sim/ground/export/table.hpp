// Tables and shapes as GDAL's vector drivers (OGR) write them: CSV and GeoJSON.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "fsw/vision/geometry/types.hpp"
#include "sim/ground/export/georeference.hpp"

namespace ilp::exports {

/// Empty, or of its column's type.
using Cell = std::variant<std::monostate, std::int64_t, double, std::string>;

enum class ColumnType : std::uint8_t { integer, real, text };

struct Column {
  std::string name;
  ColumnType type = ColumnType::text;
};

struct Table {
  std::vector<Column> columns;
  std::vector<std::vector<Cell>> rows;
};

/// Writes a line of names and the rows in UTF-8, quoted where needed (RFC 4180), with empty cells for unknown values.
/// The file appears when it is complete. Throws std::runtime_error.
void write_csv(const Table& table, const std::filesystem::path& path);

enum class ShapeKind : std::uint8_t { point, line, polygon };

struct Shape {
  ShapeKind kind = ShapeKind::point;
  std::vector<Vec3> points;  ///< of the strip's world; the ring of a polygon without its last point again
};

/// One feature for each row with its shape: longitude, latitude and height on a body (on the Earth as RFC 7946 wants
/// it), else the strip's own axes; the member `description` says which, after `title`. Throws std::runtime_error.
void write_geojson(const Table& table, const std::vector<Shape>& shapes, const Georeference& place,
                   const std::string& title, const std::filesystem::path& path);

}  // namespace ilp::exports
