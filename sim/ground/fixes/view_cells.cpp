#include "sim/ground/fixes/view_cells.hpp"

#include <cmath>

#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/terrain/seen_cells.hpp"

namespace ilp::fixes {
namespace {

constexpr std::size_t keyframes_before = 12;
constexpr int least_pixels = 8;  // of a cell

RigidTransform camera_from_strip(const PoseRecord& pose) {
  RigidTransform out;
  out.rotation = rotation_from_quaternion(pose.q_cam_from_world);
  out.translation = -(out.rotation * Vec3(pose.centre[0], pose.centre[1], pose.centre[2]));
  return out;
}

class Cells {
 public:
  explicit Cells(const CameraModel& camera)
      : columns_(seen_cells_side(camera.width)),
        rows_(seen_cells_side(camera.height)),
        sum_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)),
        count_(sum_.size()) {}

  void add(double x, double y, double inverse_depth) {
    const double column = std::floor((x + 0.5) / seen_cell_px), row = std::floor((y + 0.5) / seen_cell_px);
    if (!(column >= 0 && row >= 0 && column < columns_ && row < rows_)) return;
    const std::size_t i =
        static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
    sum_[i] += inverse_depth;
    ++count_[i];
  }
  [[nodiscard]] std::vector<float> means(int least) const {
    std::vector<float> out(sum_.size());
    for (std::size_t i = 0; i < sum_.size(); ++i)
      out[i] = count_[i] >= least ? static_cast<float>(sum_[i] / count_[i]) : 0;
    return out;
  }
  [[nodiscard]] Vec2 centre(std::size_t i) const {
    const auto columns = static_cast<std::size_t>(columns_);
    const auto middle = [](std::size_t k) { return static_cast<double>(k) * seen_cell_px + 0.5 * (seen_cell_px - 1); };
    return {middle(i % columns), middle(i / columns)};
  }

 private:
  std::int32_t columns_, rows_;
  std::vector<double> sum_;
  std::vector<int> count_;
};

std::vector<float> own_cells(const intake::KeyframeRasters& rasters, const CameraModel& camera) {
  Cells cells(camera);
  const host::Raster<float>& depths = rasters.inverse_depth;
  for (std::int32_t y = 0; y < depths.height; ++y) {
    for (std::int32_t x = 0; x < depths.width; ++x) {
      if (depths.at(x, y) > 0) cells.add(x, y, static_cast<double>(depths.at(x, y)));
    }
  }
  return cells.means(least_pixels);
}

}  // namespace

std::vector<float> ViewCells::add(const intake::Keyframe& keyframe, const intake::KeyframeRasters& rasters) {
  const CameraModel& camera = keyframe.camera;
  const RigidTransform here = camera_from_strip(*keyframe.pose);
  if (!before_.empty() && before_.back().strip_id != keyframe.strip_id) before_.clear();
  const Cells places(camera);
  const std::vector<float> own = own_cells(rasters, camera);
  Cells known(camera);
  Ground ground{keyframe.strip_id, {}};
  const RigidTransform strip_from_here = inverse(here);
  for (std::size_t i = 0; i < own.size(); ++i) {
    if (!(own[i] > 0)) continue;
    const Vec2 ray = normalised_from_pixel(camera, places.centre(i));
    const double depth = 1 / static_cast<double>(own[i]);
    ground.points.push_back(strip_from_here * Vec3(depth * ray.x(), depth * ray.y(), depth));
  }
  for (const Ground& other : before_) {
    for (const Vec3& point : other.points) {
      const Vec3 seen = here * point;
      if (!(seen.z() > 0)) continue;
      const Vec2 normalised(seen.x() / seen.z(), seen.y() / seen.z());
      // Far outside the image a lens is not defined.
      if (normalised.norm() > 1.5 * (camera.width + camera.height) / camera.fx) continue;
      const Vec2 pixel = pixel_from_normalised(camera, normalised);
      known.add(pixel.x(), pixel.y(), 1 / seen.z());
    }
  }
  std::vector<float> cells = known.means(1);
  for (std::size_t i = 0; i < own.size(); ++i) {
    if (own[i] > 0) cells[i] = own[i];
  }
  before_.push_back(std::move(ground));
  if (before_.size() > keyframes_before) before_.pop_front();
  return cells;
}

}  // namespace ilp::fixes
