// A small flight over a tilted plane, written as an outbox with the flight's own serial forms and encoder. What is true
// of it is computed here from the plane alone.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "fsw/base/time.hpp"
#include "fsw/records/records.hpp"
#include "fsw/vision/geometry/types.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp::test {

struct SyntheticView {
  std::int64_t keyframe_id = 0;
  std::int64_t strip_id = 1;
  std::string name;
  Mat3 cam_from_world = Mat3::Identity();
  Vec3 centre = Vec3::Zero();
};

struct SyntheticFlight {
  CameraModel camera;
  std::vector<SyntheticView> views;
  std::vector<Vec3> points;  ///< on the plane
  TimeNs begins_ns = 0;
};

/// World plane: z = 0.06 x - 0.04 y + 1.
[[nodiscard]] double plane_height(double x, double y);
[[nodiscard]] double plane_grey(double x, double y);

/// Five views in an arc, 10 above the plane, 80 % overlap, tilted by a few degrees, all of strip 1.
[[nodiscard]] SyntheticFlight make_flight(bool distorted);

/// COLMAP's projection, written from its documentation: pixel centres at 0.5.
[[nodiscard]] Vec2 colmap_pixel(const CameraModel& camera, const Mat3& cam_from_world, const Vec3& translation,
                                const Vec3& world);

/// Depth z of the plane at a pixel of an undistorted view.
[[nodiscard]] double plane_depth(const SyntheticFlight& flight, const SyntheticView& view, int x, int y);
/// First view: all but a border; later ones: what the view before did not see.
[[nodiscard]] bool newly_seen(const SyntheticFlight& flight, std::size_t view, int x, int y);

/// records-*.ilp, product-*.jp2 and events-000001.ilp. Products only for undistorted flights.
void write_outbox(const SyntheticFlight& flight, const std::filesystem::path& folder);

/// poses.txt and depth/NAME.pfm in a world that is `scale * rotation * world + translation`.
void write_truth(const SyntheticFlight& flight, const std::filesystem::path& folder, double scale, const Mat3& rotation,
                 const Vec3& translation);

}  // namespace ilp::test
