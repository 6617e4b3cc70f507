// Writes tables as CSV and shapes as GeoJSON, by GDAL's vector drivers (OGR).
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "fsw/vision/geometry/types.hpp"
#include "sim/ground/export/georeference.hpp"

namespace ilp::exports {

/// A value of its column's type; empty: unknown.
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

/// Writes a line of names and the rows in UTF-8, quoted where needed (RFC 4180). Unknown values become empty cells. The
/// file appears when it is complete. Throws std::runtime_error.
void write_csv(const Table& table, const std::filesystem::path& path);

enum class ShapeKind : std::uint8_t { point, line, polygon };

struct Shape {
  ShapeKind kind = ShapeKind::point;
  std::vector<Vec3> points;  ///< in the strip's world; the ring of a polygon does not repeat its first point
};

/// Writes one feature for each row, with the shape of the same index. Coordinates are longitude, latitude and height on
/// a body (on the Earth as in RFC 7946), else the strip's own axes. The member `description` has `title` and says
/// which. Throws std::runtime_error.
void write_geojson(const Table& table, const std::vector<Shape>& shapes, const Georeference& place,
                   const std::string& title, const std::filesystem::path& path);

}  // namespace ilp::exports
