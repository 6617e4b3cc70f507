// Results of work on images and adjustments that are kept between runs: they change the time only.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>

#include "sim/ground/intake/result_cache.hpp"
#include "tests/unit/ground/model/noisy_flight.hpp"

namespace ilp::model {
namespace {

using test::looking_down, test::NoisyFlight;

/// Grey of the ground: noise with details of a few pixels.
double grey_at(double x, double y) {
  const auto at_node = [](double i, double j) {
    const double wave = 43758.5453 * std::sin(12.9898 * i + 78.233 * j);
    return wave - std::floor(wave);
  };
  constexpr double spacing = 0.12;
  const double u = x / spacing, v = y / spacing, i = std::floor(u), j = std::floor(v), a = u - i, b = v - j;
  return 40 + 180 * ((1 - b) * ((1 - a) * at_node(i, j) + a * at_node(i + 1, j)) +
                     b * ((1 - a) * at_node(i, j + 1) + a * at_node(i + 1, j + 1)));
}

host::Raster<std::uint8_t> picture(const CameraModel& camera, const RigidTransform& pose) {
  host::Raster<std::uint8_t> image(camera.width, camera.height);
  const Vec3 centre = -(pose.rotation.transpose() * pose.translation);
  for (std::int32_t y = 0; y < camera.height; ++y) {
    for (std::int32_t x = 0; x < camera.width; ++x) {
      const Vec3 ray = pose.rotation.transpose() * Vec3((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1);
      Vec3 point = centre;
      for (int i = 0; i < 6; ++i) point = centre + (test::ground(point.x(), point.y()) - centre.z()) / ray.z() * ray;
      image.at(x, y) = static_cast<std::uint8_t>(grey_at(point.x(), point.y()));
    }
  }
  return image;
}

class Counted : public intake::MemoryResultCache {
 public:
  std::optional<std::vector<std::uint8_t>> result(std::uint64_t digest) override {
    auto found = MemoryResultCache::result(digest);
    if (found && damaged) found->resize(found->size() / 2);
    return found;
  }
  void put_result(std::uint64_t digest, const std::vector<std::uint8_t>& bytes) override {
    ++put;
    MemoryResultCache::put_result(digest, bytes);
  }
  std::atomic<std::size_t> put = 0;
  bool damaged = false;
};

/// Two strips of two images each over the same ground.
class KeptResultsTest : public ::testing::Test, protected NoisyFlight {
 protected:
  KeptResultsTest() {
    fly(1, {looking_down(0, 0, 0), looking_down(2.5, 0, 0)}, Similarity{});
    fly(2, {looking_down(2.4, 1, 3.0), looking_down(0.2, 1, 3.0)}, second_);
    link(2, 3, false);
    for (auto& [id, keyframe] : flight_.keyframes)
      keyframe.image = picture(camera_, truth_[static_cast<std::size_t>(id - 1)]);
  }
  static intake::Flight joined(intake::Flight flight, intake::ResultCache* results) {
    (void)join_strips(
        flight, [](const std::string&) {}, results);
    return flight;
  }
  static void expect_same(const intake::Flight& a, const intake::Flight& b) {
    for (const auto& [id, keyframe] : a.keyframes)
      EXPECT_EQ(std::memcmp(&*keyframe.pose, &*b.keyframes.at(id).pose, sizeof(PoseRecord)), 0) << id;
  }
};

TEST_F(KeptResultsTest, GiveTheSameModelAndAreNotComputedAgain) {
  const intake::Flight without = joined(flight_, nullptr);
  ASSERT_EQ(without.keyframes.at(3).strip_id, 1) << "the images join the strips";
  Counted results;
  expect_same(joined(flight_, &results), without);
  const std::size_t first = results.put;
  EXPECT_GE(first, 4U + 3U + 2U) << "four images, pairs that have no link, the pair of the link";
  expect_same(joined(flight_, &results), without);
  EXPECT_EQ(results.put, first) << "everything is known";
}

TEST_F(KeptResultsTest, OfAnotherImageAreOthers) {
  Counted results;
  (void)joined(flight_, &results);
  const std::size_t first = results.put;
  flight_.keyframes[3].image = picture(camera_, looking_down(30, 20, 1));
  flight_.keyframes[4].image = {};
  const intake::Flight without = joined(flight_, nullptr);
  ASSERT_EQ(without.keyframes.at(3).strip_id, 2) << "nothing joins the strips";
  expect_same(joined(flight_, &results), without);
  EXPECT_GT(results.put, first);
}

TEST_F(KeptResultsTest, ThatAreDamagedAreComputedAgain) {
  const intake::Flight without = joined(flight_, nullptr);
  Counted results;
  (void)joined(flight_, &results);
  const std::size_t first = results.put;
  results.damaged = true;
  expect_same(joined(flight_, &results), without);
  EXPECT_EQ(results.put, 2 * first);
}

TEST(KeptAdjustments, AreMadeOnceAndAgainOnlyWhereSomethingIsNew) {
  NoisyFlight flight;
  flight.fly_two_lanes();
  flight.link(5, 6);
  flight.link(4, 7);
  const auto joined = [](intake::Flight of, intake::ResultCache* results) {
    (void)join_strips(
        of, [](const std::string&) {}, results);
    return of;
  };
  const auto same = [](const intake::Flight& a, const intake::Flight& b) {
    return std::all_of(a.keyframes.begin(), a.keyframes.end(), [&](const auto& one) {
      return std::memcmp(&*one.second.pose, &*b.keyframes.at(one.first).pose, sizeof(PoseRecord)) == 0;
    });
  };
  const intake::Flight without = joined(flight.flight_, nullptr);
  Counted results;
  EXPECT_TRUE(same(joined(flight.flight_, &results), without));
  const std::size_t first = results.put;
  EXPECT_GE(first, 2U) << "no image came down: what is kept are adjustments";
  EXPECT_TRUE(same(joined(flight.flight_, &results), without));
  EXPECT_EQ(results.put, first);
  flight.flight_.keyframes[9].points.back().observations.back().x += 0.25F;
  const intake::Flight other = joined(flight.flight_, nullptr);
  EXPECT_FALSE(same(other, without));
  EXPECT_TRUE(same(joined(flight.flight_, &results), other));
  EXPECT_GT(results.put, first);
  results.damaged = true;
  EXPECT_TRUE(same(joined(flight.flight_, &results), other));
}

TEST(ListsAsBytes, AreTakenBackOrRefused) {
  std::vector<std::uint8_t> bytes;
  const std::vector<double> list = {1, 2, 3};
  const std::vector<std::uint16_t> other = {7};
  intake::append(list, bytes);
  intake::append(other, bytes);
  std::span<const std::uint8_t> rest = bytes;
  std::vector<double> taken;
  std::vector<std::uint16_t> also;
  EXPECT_TRUE(intake::take(rest, taken) && intake::take(rest, also));
  EXPECT_EQ(taken, list);
  EXPECT_EQ(also, other);
  EXPECT_TRUE(rest.empty());
  EXPECT_FALSE(intake::take(rest, taken));
  for (std::size_t size = 0; size < 4 + 3 * sizeof(double); ++size) {
    rest = std::span<const std::uint8_t>(bytes).first(size);
    EXPECT_FALSE(intake::take(rest, taken)) << size;
    EXPECT_TRUE(taken.empty());
  }
}

}  // namespace
}  // namespace ilp::model
