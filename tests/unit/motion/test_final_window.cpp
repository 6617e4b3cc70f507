// The window of final poses and their points that a camera is checked and found with.
#include "fsw/motion/final_window.hpp"

#include <cstring>
#include <memory>
#include <vector>

#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/multiview/sequence.hpp"
#include "tests/unit/shared/component_fixture.hpp"

namespace ilp {
namespace {

const CameraModel lens{320, 240, 275, 275, 159.5, 119.5, -0.08, 0.01, 0.0004, -0.0003};

/// Keyframes 1 to 6, points seen by some of them, written as structure and motion writes them.
class FinalWindowTest : public test::ComponentTest {
 protected:
  struct Point {
    Vec3 position;
    std::vector<std::int64_t> seen_by;
  };
  FinalWindowTest() {
    for (std::int64_t id = 1; id <= 6; ++id) {
      PoseRecord pose{.id = id, .strip_id = 1, .state = PoseState::final};
      pose.centre[0] = 0.2 * static_cast<double>(id);
      write(pose);
    }
  }
  static Vec2 ideal(const Point& point, std::int64_t keyframe_id) {
    const double x = point.position.x() - 0.2 * static_cast<double>(keyframe_id);
    return {lens.fx * x / point.position.z() + lens.cx, lens.fy * point.position.y() / point.position.z() + lens.cy};
  }
  void write_structure(std::int64_t id, const std::vector<Point>& points) {
    std::vector<std::uint8_t> bytes;
    const auto append = [&bytes](const auto& part) {
      const auto* const from = reinterpret_cast<const std::uint8_t*>(&part);
      bytes.insert(bytes.end(), from, from + sizeof(part));
    };
    for (const Point& point : points) {
      append(StructurePoint{{point.position.x(), point.position.y(), point.position.z()},
                            0.1F,
                            static_cast<std::uint32_t>(point.seen_by.size())});
      for (const std::int64_t keyframe : point.seen_by) {
        const Vec2 pixel = pixel_from_ideal(lens, ideal(point, keyframe));
        append(StructureObservation{keyframe, static_cast<float>(pixel.x()), static_cast<float>(pixel.y())});
      }
    }
    StructureRecord structure{.id = id, .strip_id = 1, .count = static_cast<std::uint32_t>(points.size())};
    structure.points.bytes = static_cast<std::uint32_t>(bytes.size());
    write(structure, "points", bytes);
  }

  std::unique_ptr<BundleProblem> window = std::make_unique<BundleProblem>();
};

TEST_F(FinalWindowTest, HasThePointsThatTwoOfItsKeyframesSeeInIdealPixels) {
  // More than one piece of 4 KiB.
  std::vector<Point> points;
  for (int i = 0; i < 90; ++i) points.push_back({Vec3(0.3 + 0.01 * i, 0.2 - 0.005 * i, 2 + 0.01 * i), {1, 2, 3, 4}});
  write_structure(4, points);
  write_structure(5, {{Vec3(0.5, 0.1, 2), {4, 5}}, {Vec3(0.6, 0.1, 2), {2, 5}}});
  write_structure(6, {{Vec3(0.7, 0, 2), {2, 3, 6}}});
  const std::int64_t ids[] = {2, 3, 5};
  ASSERT_TRUE(load_final_window(store, lens, ids, 5, *window).ok());
  ASSERT_EQ(window->cameras.size(), 3U);
  EXPECT_DOUBLE_EQ(window->cameras[2].pose.centre[0], 1.0);
  EXPECT_DOUBLE_EQ(window->cameras[0].fx, lens.fx);
  ASSERT_EQ(window->points.size(), 91U) << "not the point of keyframes 4 and 5, nor what came behind keyframe 5";
  EXPECT_DOUBLE_EQ(window->points[90].position[0], 0.6);
  ASSERT_EQ(window->observations.size(), 90U * 2 + 2);
  for (const BundleObservation& o : window->observations) {
    const Point& point = o.point < 90 ? points[o.point] : Point{Vec3(0.6, 0.1, 2), {}};
    const Vec2 expected = ideal(point, ids[o.camera]);
    EXPECT_NEAR(o.x, expected.x(), 1e-4);
    EXPECT_NEAR(o.y, expected.y(), 1e-4);
  }
}

TEST_F(FinalWindowTest, AStructureThatEndsWithinAPointIsAFault) {
  std::vector<std::uint8_t> bytes(sizeof(StructurePoint));
  const StructurePoint head{{0, 0, 1}, 0, 3};
  std::memcpy(bytes.data(), &head, sizeof(head));
  StructureRecord structure{.id = 3};
  structure.points.bytes = static_cast<std::uint32_t>(bytes.size());
  write(structure, "points", bytes);
  const std::int64_t ids[] = {1, 2, 3};
  EXPECT_TRUE(load_final_window(store, lens, ids, 3, *window).is(StatusCode::truncated));
}

}  // namespace
}  // namespace ilp
