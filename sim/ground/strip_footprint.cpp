#include <cmath>

#include "sim/ground/export/footprint.hpp"
#include "sim/ground/report.hpp"

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

std::vector<Vec3> footprint_of(const Keyframe& keyframe, const StripResult& strip) {
  if (!strip.grid || !keyframe.posed()) return {};
  const auto relief = [&](double x, double y) { return relief_at(strip, x, y); };
  return footprint(keyframe.camera, pose_of(*keyframe.pose), strip.plane, relief);
}

}  // namespace ilp::ground
