// Converts table cells and shapes to features of GDAL's vector drivers (OGR).
#pragma once

#include <ogr_geometry.h>
#include <ogrsf_frmts.h>

#include <memory>
#include <optional>
#include <vector>

#include "sim/ground/export/table.hpp"

namespace ilp::exports {

using Geometry = std::unique_ptr<OGRGeometry>;

[[nodiscard]] OGRFieldType type_of(ColumnType type);
/// Sets the feature's fields from index `first` on. Empty cells, and reals that are not finite, become null.
void set_fields(OGRFeature& feature, const std::vector<Cell>& cells, int first = 0);

/// Converts points of the strip's world to the coordinates of a file: longitude, latitude and height on a body, else
/// the strip's own axes.
class Placement {
 public:
  explicit Placement(const Georeference& place);
  [[nodiscard]] OGRPoint operator()(const Vec3& world) const;

 private:
  const Georeference& place_;
  std::optional<GeographicFromMap> geographic_;
};

/// The geometry of a shape in the file's coordinates. Outer rings of polygons are counter-clockwise.
[[nodiscard]] Geometry geometry_of(const Shape& shape, const Placement& placed);

}  // namespace ilp::exports
