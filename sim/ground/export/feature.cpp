#include "sim/ground/export/feature.hpp"

#include <cmath>

namespace ilp::exports {
namespace {

void set_field(OGRFeature& feature, int column, const Cell& cell) {
  const auto* real = std::get_if<double>(&cell);
  if (const auto* integer = std::get_if<std::int64_t>(&cell)) {
    feature.SetField(column, static_cast<GIntBig>(*integer));
  } else if (const auto* text = std::get_if<std::string>(&cell)) {
    feature.SetField(column, text->c_str());
  } else if (real && std::isfinite(*real)) {
    feature.SetField(column, *real);
  } else {
    feature.SetFieldNull(column);
  }
}

}  // namespace

OGRFieldType type_of(ColumnType type) {
  switch (type) {
    case ColumnType::integer:
      return OFTInteger64;
    case ColumnType::real:
      return OFTReal;
    case ColumnType::text:
      break;
  }
  return OFTString;
}

void set_fields(OGRFeature& feature, const std::vector<Cell>& cells, int first) {
  for (std::size_t i = 0; i < cells.size(); ++i) set_field(feature, first + static_cast<int>(i), cells[i]);
}

Placement::Placement(const Georeference& place) : place_(place) {
  if (place.on_a_body()) geographic_.emplace(place);
}

OGRPoint Placement::operator()(const Vec3& world) const {
  const Vec3 map = place_.map_from_world(world);
  if (!geographic_) return {map.x(), map.y(), map.z()};
  const std::array<double, 2> degrees = (*geographic_)(map.x(), map.y());
  return {degrees[0], degrees[1], map.z()};
}

Geometry geometry_of(const Shape& shape, const Placement& placed) {
  if (shape.kind == ShapeKind::point) return std::make_unique<OGRPoint>(placed(shape.points.at(0)));
  auto line = shape.kind == ShapeKind::polygon ? std::make_unique<OGRLinearRing>() : std::make_unique<OGRLineString>();
  for (const Vec3& point : shape.points) {
    const OGRPoint p = placed(point);
    line->addPoint(&p);
  }
  if (shape.kind == ShapeKind::line) return line;
  auto polygon = std::make_unique<OGRPolygon>();
  line->closeRings();
  auto* ring = static_cast<OGRLinearRing*>(line.release());
  if (ring->isClockwise()) ring->reversePoints();
  polygon->addRingDirectly(ring);
  return polygon;
}

}  // namespace ilp::exports
