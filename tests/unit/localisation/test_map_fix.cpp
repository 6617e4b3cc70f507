// The stage that localises keyframes on a map, over analytic ground and its map.
#include "fsw/localisation/map_fix.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "fsw/base/math.hpp"
#include "fsw/shared/local_plane.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"
#include "tests/support/step_memory.hpp"
#include "tests/unit/hal/expect_status.hpp"
#include "tests/unit/localisation/analytic_map.hpp"
#include "tests/unit/shared/component_fixture.hpp"

namespace ilp {
namespace {

using test::AnalyticMap;
using test::looking_down;

/// Every test flies over the same map.
AnalyticMap& shared_map() {
  static AnalyticMap map;
  return map;
}

class MapFixTest : public test::ComponentTest, protected test::PlaceFlight {
 protected:
  MapFixTest() : PlaceFlight(store) {
    write_camera();
    mission.use_map = mission.use_navigation = true;
    mission.body = Body::mars;
    mission.map_sun_given = true;
    mission.map_sun_azimuth_rad = AnalyticMap::sun_azimuth;
    mission.map_sun_elevation_rad = AnalyticMap::sun_elevation;
  }

  static RigidTransform pose_of(std::int64_t id) {
    const auto n = static_cast<double>(id);
    return looking_down(Vec3(20 * n, 3 * n, 100), Vec3(0.02, -0.03, 0.3 + 0.01 * n));
  }
  static Vec3 centre_of(std::int64_t id) { return test::centre_of(pose_of(id)); }

  /// A keyframe of a strip whose world is turned, moved and four metres long in a unit.
  void fly(std::int64_t id) {
    see(id, 1, static_cast<std::int32_t>(id - 1), pose_of(id), second_, static_cast<std::uint64_t>(id));
    auto pose = read<PoseRecord>(id);
    // The lowest ground is 3 m below the mean.
    pose.ground_distance = (100 - gentle(centre_of(id).x(), centre_of(id).y())) * second_unit;
    pose.ground_distance_sigma = 0.01 * pose.ground_distance;
    write(pose);
  }
  /// What the vehicle says of it; its position may be off, and state another error.
  void measure(std::int64_t id, const Vec3& off_m = Vec3::Zero(), double sigma_m = 4) {
    NavigationRecord measured{.id = id};
    const Vec3 place = centre_of(id) + off_m;
    const BodyPlace at = place_from_plane(Body::mars, origin, {place.x(), place.y(), 0});
    measured.longitude_deg = at.longitude_deg;
    measured.latitude_deg = at.latitude_deg;
    measured.horizontal_sigma_m = sigma_m;
    measured.height_m = 100 - gentle(centre_of(id).x(), centre_of(id).y());
    measured.height_sigma_m = 1;
    quaternion_from_rotation(pose_of(id).rotation, measured.q_cam_from_level);
    measured.tilt_sigma_rad = measured.heading_sigma_rad = 0.009;
    write(measured);
  }
  std::unique_ptr<MapFix> make(MapSource* source) {
    auto stage = std::make_unique<MapFix>(store, mission, test::step_memory<MapFix>(), source);
    EXPECT_TRUE(restored(stage->restore()));
    return stage;
  }
  /// Distance of the fix's ground from that of the true optical axis, m.
  static double ground_error(const FixRecord& fix) {
    const RigidTransform ground_from_cam = inverse(pose_of(fix.id));
    Vec3 at = ground_from_cam * Vec3(0, 0, 100);
    const Vec3 centre = centre_of(fix.id), way = (at - centre) / 100;
    for (int i = 0; i < 50; ++i) at += way * ((gentle(at.x(), at.y()) - at.z()) / way.z());
    return std::hypot(fix.ground_m[0] - at.x(), fix.ground_m[1] - at.y());
  }
  static double place_error(const FixRecord& fix) {
    const Vec3 centre = centre_of(fix.id);
    return std::hypot(fix.place_m[0] - centre.x(), fix.place_m[1] - centre.y());
  }

  BodyPlace origin{2.4 * 180 / pi, 0.3 * 180 / pi, 0};
};

TEST_F(MapFixTest, AFlightWithoutAMapIsLeftAlone) {
  mission.use_map = false;
  fly(1);
  EXPECT_TRUE(run(*make(nullptr)).empty());
  EXPECT_EQ(number_of<FixRecord>(), 0);
  EXPECT_EQ(number_of<CheckpointRecord>(), 0);
}

TEST_F(MapFixTest, AKeyframeWithoutAMapGetsARecordThatSaysSo) {
  fly(1);
  measure(1);
  EXPECT_TRUE(run(*make(nullptr)).empty());
  const auto fix = read<FixRecord>(1);
  EXPECT_EQ(fix.map_id, 0);
  EXPECT_EQ(fix.verdict, MapVerdict::no_map);
  EXPECT_EQ(fix.state, FixState::none);
}

TEST_F(MapFixTest, TheVehicleLeadsToTheFirstFixAndFixesToTheOthers) {
  for (std::int64_t id = 1; id <= 6; ++id) fly(id);
  measure(1, Vec3(5, -4, 0));
  MemoryMapSource source = shared_map().source();
  EXPECT_TRUE(run(*make(&source)).empty());
  for (std::int64_t id = 1; id <= 6; ++id) {
    const auto fix = read<FixRecord>(id);
    ASSERT_EQ(fix.verdict, MapVerdict::fixed) << id;
    EXPECT_EQ(fix.state, FixState::accepted);
    EXPECT_EQ(fix.prior, id == 1 ? FixPrior::vehicle : FixPrior::fixes);
    EXPECT_EQ(fix.map_id, 77);
    EXPECT_LT(ground_error(fix), 0.8 * fix.pixel_m);
    EXPECT_GT(fix.ground_covariance[0], 0);
    EXPECT_LT(place_error(fix), 4 * fix.place_sigma_m);
    EXPECT_LT(place_error(fix), 2.5);
    EXPECT_EQ(fix.newest_fix_id, id);
    EXPECT_GT(fix.points.bytes, 0U);
    EXPECT_EQ(fix.points.bytes % sizeof(FixPoint), 0U);
    const BodyPlace ground = place_from_plane(Body::mars, origin, fix.ground_m);
    EXPECT_NEAR(fix.longitude_deg, ground.longitude_deg, 1e-12);
    EXPECT_NEAR(fix.latitude_deg, ground.latitude_deg, 1e-12);
  }
}

/// At any heading, and without anything of the vehicle.
TEST_F(MapFixTest, WithoutAPriorTheWholeMapIsSearchedAndTwoKeyframesThatAgreeMakeTheStart) {
  AnalyticMap map(Body::mars, 0.5);
  for (std::int64_t id = 1; id <= 6; ++id) fly(id);
  MemoryMapSource source = map.source();
  const std::vector<Status> reported = run(*make(&source));
  std::int64_t first = 0;
  for (std::int64_t id = 1; id <= 6; ++id) {
    const auto fix = read<FixRecord>(id);
    if (fix.verdict != MapVerdict::fixed) continue;
    EXPECT_LT(ground_error(fix), 1.5 * fix.pixel_m) << id;
    if (first == 0) {
      first = id;
      EXPECT_EQ(fix.prior, FixPrior::search);
      EXPECT_EQ(fix.state, FixState::unconfirmed);
    } else {
      EXPECT_EQ(fix.state, FixState::accepted) << id;
      EXPECT_EQ(fix.prior, FixPrior::fixes) << id;
    }
  }
  EXPECT_GE(first, 1);
  EXPECT_LE(first, 3);
  ASSERT_EQ(reported.size(), 1U);
  EXPECT_STATUS(reported[0], place_found);
  EXPECT_EQ(reported[0].a, first + 1);
  EXPECT_LT(place_error(read<FixRecord>(6)), 4);
}

/// Files of the tiles that have not come.
TEST_F(MapFixTest, AMapWithoutTilesGivesNoStart) {
  AnalyticMap map;
  for (std::vector<std::uint8_t>& file : map.files) file.clear();
  for (std::int64_t id = 1; id <= 3; ++id) fly(id);
  MemoryMapSource source = map.source();
  run(*make(&source));
  for (std::int64_t id = 1; id <= 3; ++id) {
    EXPECT_EQ(read<FixRecord>(id).prior, FixPrior::none);
    EXPECT_EQ(read<FixRecord>(id).verdict, MapVerdict::no_map);
    EXPECT_EQ(read<FixRecord>(id).place_sigma_m, 0);
  }
}

TEST_F(MapFixTest, DamagedTilesAreToldInAStartWithoutAPriorToo) {
  AnalyticMap map;
  for (std::vector<std::uint8_t>& file : map.files) file[file.size() / 2] ^= 1;
  fly(1);
  MemoryMapSource source = map.source();
  const std::vector<Status> reported = run(*make(&source));
  ASSERT_EQ(reported.size(), 1U);
  EXPECT_STATUS(reported[0], map_tile_unusable);
  EXPECT_EQ(reported[0].b, static_cast<std::int64_t>(StatusCode::record_damaged));
  EXPECT_EQ(read<FixRecord>(1).verdict, MapVerdict::no_map);
}

/// One tile that is there can show another ground.
TEST_F(MapFixTest, AStartWithOneTileOfOtherGroundHasAMapAndNoAgreement) {
  AnalyticMap map;
  fly(1);
  for (std::size_t i = 1; i < map.files.size(); ++i) map.files[i].clear();
  MemoryMapSource source = map.source();
  run(*make(&source));
  EXPECT_EQ(read<FixRecord>(1).verdict, MapVerdict::no_agreement);
}

TEST_F(MapFixTest, AFixFarFromThePriorCountsOnceTheNextAgrees) {
  for (std::int64_t id = 1; id <= 3; ++id) {
    fly(id);
    measure(id, Vec3(11, 9, 0), 0.5);
  }
  MemoryMapSource source = shared_map().source();
  run(*make(&source));
  EXPECT_EQ(read<FixRecord>(1).verdict, MapVerdict::fixed);
  EXPECT_EQ(read<FixRecord>(1).state, FixState::unconfirmed);
  EXPECT_GT(read<FixRecord>(1).shift_sigmas, 4);
  EXPECT_EQ(read<FixRecord>(1).place_sigma_m, 0) << "nothing counts yet";
  EXPECT_EQ(read<FixRecord>(2).state, FixState::accepted);
  EXPECT_EQ(read<FixRecord>(3).state, FixState::accepted);
  EXPECT_LT(place_error(read<FixRecord>(3)), 2.5);
}

TEST_F(MapFixTest, GroundOutsideWhatIsSearchedIsNoFix) {
  for (std::int64_t id = 1; id <= 4; ++id) {
    fly(id);
    measure(id, Vec3(0, 70, 0), 2);
  }
  MemoryMapSource source = shared_map().source();
  run(*make(&source));
  for (std::int64_t id = 1; id <= 4; ++id) EXPECT_NE(read<FixRecord>(id).verdict, MapVerdict::fixed);
}

TEST_F(MapFixTest, BeyondTheMapThereIsNone) {
  fly(1);
  measure(1, Vec3(5000, 0, 0));
  MemoryMapSource source = shared_map().source();
  EXPECT_TRUE(run(*make(&source)).empty());
  EXPECT_EQ(read<FixRecord>(1).verdict, MapVerdict::no_map);
  EXPECT_EQ(read<FixRecord>(1).map_id, 77);
}

TEST_F(MapFixTest, AMapOfAnotherBodyIsRefusedOnce) {
  AnalyticMap other(Body::moon);
  MemoryMapSource source = other.source();
  for (std::int64_t id = 1; id <= 2; ++id) {
    fly(id);
    measure(id);
  }
  const std::vector<Status> reported = run(*make(&source));
  ASSERT_EQ(reported.size(), 1U);
  EXPECT_STATUS(reported[0], map_other_body);
  EXPECT_EQ(read<FixRecord>(2).map_id, 0);
}

TEST_F(MapFixTest, ADamagedDirectoryIsRefusedAndADamagedTileIsAHole) {
  AnalyticMap map;
  map.directory_bytes[map.directory_bytes.size() / 2] ^= 1;
  fly(1);
  measure(1);
  MemoryMapSource source = map.source();
  std::vector<Status> reported = run(*make(&source));
  ASSERT_EQ(reported.size(), 1U);
  EXPECT_STATUS(reported[0], map_refused);
  map.directory_bytes[map.directory_bytes.size() / 2] ^= 1;

  for (std::vector<std::uint8_t>& file : map.files) file[file.size() / 2] ^= 1;
  fly(2);
  measure(2);
  source = map.source();
  reported = run(*make(&source));
  ASSERT_EQ(reported.size(), 1U);
  EXPECT_STATUS(reported[0], map_tile_unusable);
  EXPECT_EQ(read<FixRecord>(2).verdict, MapVerdict::no_map);
}

TEST_F(MapFixTest, AMapThatTakesThePlaceOfAnotherServesTheNextKeyframe) {
  AnalyticMap coarser(Body::mars, 1.6);
  MemoryMapSource source = shared_map().source();
  const auto stage = make(&source);
  fly(1);
  measure(1);
  run(*stage);
  const auto before = read<FixRecord>(1);
  source = coarser.source();
  fly(2);
  measure(2);
  run(*stage);
  const auto after = read<FixRecord>(2);
  ASSERT_EQ(before.verdict, MapVerdict::fixed);
  ASSERT_EQ(after.verdict, MapVerdict::fixed);
  EXPECT_LT(before.pixel_m, 1.5) << "that of the finer map";
  EXPECT_DOUBLE_EQ(after.pixel_m, 1.6);
  EXPECT_LT(ground_error(after), after.pixel_m);
}

TEST_F(MapFixTest, OneOfSoManyKeyframesIsRegistered) {
  mission.map_every_keyframes = 3;
  for (std::int64_t id = 1; id <= 5; ++id) {
    fly(id);
    measure(id);
  }
  MemoryMapSource source = shared_map().source();
  EXPECT_TRUE(run(*make(&source)).empty());
  for (std::int64_t id = 1; id <= 5; ++id) {
    const auto fix = read<FixRecord>(id);
    EXPECT_EQ(fix.verdict == MapVerdict::fixed, id % 3 == 1) << id;
    EXPECT_GT(fix.place_sigma_m, 0) << "known all the same";
    EXPECT_LT(place_error(fix), 3);
    EXPECT_EQ(fix.newest_fix_id, id < 4 ? 1 : 4);
  }
}

TEST_F(MapFixTest, AStopAfterAnyStepChangesNothing) {
  for (std::int64_t id = 1; id <= 3; ++id) fly(id);
  measure(1, Vec3(5, -4, 0));
  MemoryMapSource source = shared_map().source();
  EXPECT_TRUE(run(*make(&source)).empty());
  std::vector<FixRecord> whole;
  for (std::int64_t id = 1; id <= 3; ++id) whole.push_back(read<FixRecord>(id));

  std::destroy_at(&store);
  std::construct_at(&store, region);
  write_camera();
  for (std::int64_t id = 1; id <= 3; ++id) fly(id);
  measure(1, Vec3(5, -4, 0));
  // Boots of one step more each, until one is long enough for a keyframe.
  int boot = 0;
  while (number_of<FixRecord>() < 3 && boot < 400) {
    const auto stage = make(&source);
    ++boot;
    for (int i = 0; i < boot % 97; ++i) EXPECT_TRUE(stage->step().status.ok());
  }
  for (const FixRecord& fix : whole) {
    const auto again = read<FixRecord>(fix.id);
    EXPECT_EQ(again.verdict, fix.verdict);
    EXPECT_EQ(again.state, fix.state);
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(again.ground_m[i], fix.ground_m[i]);
      EXPECT_EQ(again.centre_m[i], fix.centre_m[i]);
      EXPECT_EQ(again.place_m[i], fix.place_m[i]);
    }
    for (int i = 0; i < 21; ++i) EXPECT_EQ(again.covariance[i], fix.covariance[i]);
  }
}

}  // namespace
}  // namespace ilp
