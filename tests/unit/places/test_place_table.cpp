// What the memory of places forgets, and which places it expects in an image.
#include "fsw/places/place_table.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

namespace ilp {
namespace {

constexpr double height = 10;

RememberedPlace looking_down(std::int64_t id, std::int64_t strip, double x, double y = 0, double z = height) {
  RememberedPlace place{.keyframe_id = id, .strip_id = strip};
  // Half a turn about x: the optical axis points down.
  place.q_cam_from_world[0] = 0;
  place.q_cam_from_world[1] = 1;
  place.centre[0] = static_cast<float>(x);
  place.centre[1] = static_cast<float>(y);
  place.centre[2] = static_cast<float>(z);
  place.ground_distance = static_cast<float>(z);
  return place;
}

Similarity camera_above(double x, double y, double z) {
  Mat3 down;
  down << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  return {down, -(down * Vec3(x, y, z)), 1};
}

class PlaceTableTest : public testing::Test {
 protected:
  PlaceTableTest() {
    camera_.width = 640;
    camera_.height = 480;
    camera_.fx = camera_.fy = 480;
    camera_.cx = 320;
    camera_.cy = 240;
  }
  /// As the stage does it.
  void remember(const RememberedPlace& place) {
    std::size_t slot = 0;
    while (slot < limits::max_places && table_->at(slot).keyframe_id != 0) ++slot;
    if (slot == limits::max_places) {
      slot = table_->least_needed();
      ASSERT_LT(slot, limits::max_places);
      table_->remove(slot);
    }
    ASSERT_TRUE(table_->add(slot, place));
  }
  std::vector<std::int64_t> kept() const {
    std::vector<std::int64_t> ids;
    for (std::size_t slot = 0; slot < limits::max_places; ++slot) {
      if (table_->at(slot).keyframe_id != 0) ids.push_back(table_->at(slot).keyframe_id);
    }
    std::sort(ids.begin(), ids.end());
    return ids;
  }
  std::vector<std::int64_t> near(std::int64_t strip, std::int64_t through, const Similarity& camera, double distance) {
    NearPlaces found;
    table_->find_near(strip, through, camera, distance, 1, camera_, found);
    std::vector<std::int64_t> ids;
    for (const NearPlace& place : found) ids.push_back(table_->at(place.slot).keyframe_id);
    return ids;
  }

  CameraModel camera_;
  std::unique_ptr<PlaceTable> table_ = std::make_unique<PlaceTable>();
};

// Neighbours overlap by 82 %: one in two suffices to recognise all ground.
TEST_F(PlaceTableTest, TenThousandKeyframesAreForgottenEvenly) {
  for (std::int64_t id = 1; id <= 10'000; ++id) remember(looking_down(id, 1, 1.5 * static_cast<double>(id)));
  const std::vector<std::int64_t> ids = kept();
  ASSERT_EQ(ids.size(), limits::max_places);
  EXPECT_EQ(ids.back(), 10'000) << "the newest is kept";
  for (std::size_t i = 0; i < PlaceTable::kept_for_ever; ++i) {
    EXPECT_EQ(table_->at(i).keyframe_id, static_cast<std::int64_t>(i + 1));
  }
  std::int64_t widest = 0;
  for (std::size_t i = 1; i < ids.size(); ++i) widest = std::max(widest, ids[i] - ids[i - 1]);
  EXPECT_LE(widest, 4) << "10 000 / 4096 = 2.4 on average";
}

TEST_F(PlaceTableTest, GroundThatWasLinkedToEarlierGroundIsForgottenFirst) {
  for (std::int64_t id = 1; id <= static_cast<std::int64_t>(limits::max_places); ++id) {
    RememberedPlace place = looking_down(id, 1, 1.5 * static_cast<double>(id));
    place.seen_again = id == 2000;
    remember(place);
  }
  EXPECT_EQ(table_->at(table_->least_needed()).keyframe_id, 2000);
}

TEST_F(PlaceTableTest, AHoverIsForgottenBeforeAFlight) {
  const auto flown = static_cast<std::int64_t>(limits::max_places) / 2;
  for (std::int64_t id = 1; id <= flown; ++id) remember(looking_down(id, 1, 1.5 * static_cast<double>(id)));
  for (std::int64_t id = flown + 1; id <= 3 * flown; ++id)
    remember(looking_down(id, 1, 1.5 * static_cast<double>(flown), 0.001 * static_cast<double>(id % 7)));
  std::int64_t of_flight = 0;
  for (const std::int64_t id : kept()) of_flight += id <= flown ? 1 : 0;
  EXPECT_EQ(of_flight, flown);
}

TEST_F(PlaceTableTest, OrderOfSlotsDoesNotMatter) {
  ASSERT_TRUE(table_->add(100, looking_down(1, 1, 0)));
  ASSERT_TRUE(table_->add(50, looking_down(2, 1, 1.5)));
  ASSERT_TRUE(table_->add(200, looking_down(3, 1, 3)));
  ASSERT_TRUE(table_->add(40, looking_down(4, 1, 30)));
  EXPECT_EQ(table_->least_needed(), 50U) << "its neighbours are 3 apart, the others have none on both sides so near";
  EXPECT_FALSE(table_->add(60, looking_down(3, 1, 9))) << "keyframes are added in order";
  EXPECT_FALSE(table_->add(40, looking_down(5, 1, 9))) << "the slot is taken";
  EXPECT_FALSE(table_->add(limits::max_places, looking_down(5, 1, 9)));
}

TEST_F(PlaceTableTest, NearPlacesAreThoseThatShowTheSameGround) {
  for (std::int64_t id = 1; id <= 40; ++id) remember(looking_down(id, 1, 1.5 * static_cast<double>(id)));
  remember(looking_down(41, 2, 15));
  // The image is 13.3 by 10 wide at the ground: half the shorter side is 5.
  const std::vector<std::int64_t> ids = near(1, 40, camera_above(15, 0, height), height);
  EXPECT_EQ(ids, (std::vector<std::int64_t>{10, 9, 11, 8, 12, 7, 13}));
  EXPECT_TRUE(near(1, 6, camera_above(15, 0, height), height).empty());
  EXPECT_EQ(near(2, 41, camera_above(15, 0, height), height), (std::vector<std::int64_t>{41}));
  EXPECT_TRUE(near(1, 40, camera_above(15, 0, 25), 25).empty()) << "2.5 times as high";
}

TEST_F(PlaceTableTest, NearPlacesAreFoundInAnotherUnit) {
  for (std::int64_t id = 1; id <= 40; ++id) remember(looking_down(id, 1, 1.5 * static_cast<double>(id)));
  Similarity camera = camera_above(15, 0, height);
  camera.scale = 7;
  camera.translation *= 7;
  EXPECT_EQ(near(1, 40, camera, 7 * height), near(1, 40, camera_above(15, 0, height), height));
}

TEST_F(PlaceTableTest, AKeyframeWithoutPlaceIsNeverNear) {
  RememberedPlace lost = looking_down(1, 1, 15);
  lost.ground_distance = 0;
  remember(lost);
  remember(looking_down(2, 1, 15));
  EXPECT_EQ(near(1, 2, camera_above(15, 0, height), height), (std::vector<std::int64_t>{2}));
}

}  // namespace
}  // namespace ilp
