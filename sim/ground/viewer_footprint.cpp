#include <cmath>

#include "sim/ground/export/footprint.hpp"
#include "sim/ground/viewer_data.hpp"

namespace ilp::ground {
namespace {

double relief_at(const StripResult& strip, double x, double y) {
  const GroundGrid& grid = *strip.grid;
  const double column = std::floor(grid.column_of(x) + 0.5), row = std::floor(grid.row_of(y) + 0.5);
  if (!(column >= 0) || !(row >= 0) || column >= grid.height.width || row >= grid.height.height) return 0;
  const float z = grid.height.at(static_cast<std::int32_t>(column), static_cast<std::int32_t>(row));
  return std::isfinite(z) ? z - strip.plane.at(x, y) : 0;
}

}  // namespace

std::vector<double> viewer_footprint(const Keyframe& keyframe, const StripResult& strip) {
  std::vector<double> outline;
  if (!strip.grid || !keyframe.posed()) return outline;
  const auto relief = [&](double x, double y) { return relief_at(strip, x, y); };
  for (const Vec3& point : footprint(keyframe.camera, pose_of(*keyframe.pose), strip.plane, relief)) {
    outline.insert(outline.end(), {point.x(), point.y(), point.z()});
  }
  return outline;
}

}  // namespace ilp::ground
