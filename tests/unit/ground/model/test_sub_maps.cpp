// Flights of so many keyframes that they are adjusted in sub-maps.

#include "sim/ground/model/sub_map_plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "sim/ground/intake/result_cache.hpp"
#include "sim/ground/model/link_sightings.hpp"
#include "sim/ground/model/model.hpp"
#include "tests/unit/ground/model/noisy_flight.hpp"

namespace ilp::model {
namespace {

using test::looking_down, test::NoisyFlight;

JoinedFlight join_with(intake::Flight& flight, intake::ResultCache* results) {
  return join_strips(
      flight, [](const std::string&) {}, results);
}

bool same_poses(const intake::Flight& a, const intake::Flight& b) {
  return std::all_of(a.keyframes.begin(), a.keyframes.end(), [&](const auto& one) {
    return std::memcmp(&*one.second.pose, &*b.keyframes.at(one.first).pose, sizeof(PoseRecord)) == 0;
  });
}

/// Lanes of 50 keyframes over one field, with poses that drift.
NoisyFlight long_flight(int lanes = 6) {
  NoisyFlight flight;
  flight.fly_lanes(lanes, 50);
  flight.drift_in_scale();
  return flight;
}

Scene linked_scene(const intake::Flight& flight) {
  Scene scene = scene_of(flight);
  add_link_sightings(flight, scene);
  return scene;
}

/// Joins it, and expects that what was adjusted are its sub-maps, and not the model as a whole afterwards.
JoinedFlight join_in_sub_maps(intake::Flight& flight) {
  const Scene scene = linked_scene(flight);
  const std::size_t plans = plan_sub_maps(scene, std::vector<std::uint8_t>(scene.views.size(), 1)).size();
  intake::MemoryResultCache results;
  JoinedFlight joined = join_with(flight, &results);
  EXPECT_EQ(results.size(), plans);
  return joined;
}

TEST(SubMapPlans, AreOfBoundedSizeHaveEveryViewAndShareNoTrack) {
  const NoisyFlight flight = long_flight(12);
  const Scene scene = linked_scene(flight.flight_);
  const std::vector<SubMapPlan> plans = plan_sub_maps(scene, std::vector<std::uint8_t>(scene.views.size(), 1));
  EXPECT_GE(plans.size(), scene.views.size() / 100);
  std::vector<std::size_t> of_track(scene.tracks.size(), 0), of_view(scene.views.size(), 0);
  for (const SubMapPlan& plan : plans) {
    EXPECT_LE(plan.views.size(), 160U);
    for (const std::uint32_t v : plan.views) ++of_view[v];
    for (const std::size_t t : plan.tracks) ++of_track[t];
  }
  EXPECT_EQ(*std::min_element(of_view.begin(), of_view.end()), 1U);
  EXPECT_EQ(*std::max_element(of_track.begin(), of_track.end()), 1U);
  const auto left_out = std::count(of_track.begin(), of_track.end(), 0U);
  EXPECT_LT(static_cast<double>(left_out), 0.05 * static_cast<double>(of_track.size()));
}

TEST(ModelRefusals, StayWithTheirSightingsWhereTracksGrow) {
  Scene scene;
  scene.views.resize(3);
  for (int t = 0; t < 2; ++t) scene.tracks.push_back({false, 0, Vec3::Zero(), {{0, 1, 2}, {1, 3, 4}}});
  Model model;
  grow(scene, model);
  model.refuse(1, 0, true);
  scene.tracks[0].seen.push_back({2, 5, 6});
  scene.tracks.push_back(scene.tracks[1]);
  grow(scene, model);
  EXPECT_TRUE(model.refuses(1, 0));
  for (const auto& [track, sightings] : {std::pair(0U, 3U), {2U, 2U}}) {
    for (std::size_t s = 0; s < sightings; ++s) EXPECT_FALSE(model.refuses(track, s)) << track << " " << s;
  }
  EXPECT_FALSE(model.refuses(1, 1));
}

TEST(SubMaps, StandInOneModelThatIsNearTheTruth) {
  NoisyFlight flight = long_flight();
  const double before = flight.rms_error(flight.flight_);
  ASSERT_GT(before, 0.005);
  const JoinedFlight joined = join_in_sub_maps(flight.flight_);
  ASSERT_EQ(joined.models.size(), 1U);
  EXPECT_EQ(joined.models[0].members.size(), 300U);
  EXPECT_LT(joined.models[0].median_error_px, 0.06);
  // The whole adjustment of such flights has 0.0002 to 0.0004.
  EXPECT_LT(flight.rms_error(flight.flight_), 0.0005);
  for (const ClosedLink& link : joined.models[0].links) EXPECT_LT(link.after_px, 0.3);
}

// The first adjustments of a sub-map end early and see few points. Where lanes have drifted apart by a tenth of an
// image they still lead to the minimum, which a flight without drift has from the start.
TEST(SubMaps, ThatHaveDriftedFarStandWhereThoseDoThatHaveNot) {
  NoisyFlight still, drifting;
  for (NoisyFlight* flight : {&still, &drifting}) flight->fly_lanes(6, 50);
  drifting.drift([](std::int64_t id) {
    const double creep = 0.02 * std::sin(0.065 * static_cast<double>(id));
    return Similarity{rotation_from_vector(Vec3(0, 0, creep)), Vec3::Zero(), 1 + creep};
  });
  ASSERT_GT(drifting.rms_error(drifting.flight_), 0.05);
  for (NoisyFlight* flight : {&still, &drifting}) ASSERT_EQ(join_in_sub_maps(flight->flight_).models.size(), 1U);
  EXPECT_LT(drifting.rms_error(drifting.flight_), 1.02 * still.rms_error(still.flight_));
}

// Twice round a circle: in every sub-map the second round stands beside the first one, and the chain of sub-maps
// closes.
TEST(SubMaps, CloseALoop) {
  constexpr int round = 140;
  NoisyFlight flight;
  std::vector<RigidTransform> circle;
  for (int i = 0; i < 2 * round; ++i) {
    const double angle = 2 * 3.14159265358979 * i / round;
    circle.push_back(looking_down(55 * std::cos(angle), 55 * std::sin(angle), angle));
  }
  flight.fly(1, circle, Similarity{});
  for (std::int64_t id = round + 1; id <= 2 * round; ++id) flight.link(id - round, id);
  flight.drift([](std::int64_t id) {
    const double creep = 0.0002 * static_cast<double>(id - 1);
    return Similarity{rotation_from_vector(Vec3(0, 0, 0.3 * creep)), Vec3::Zero(), 1 + creep};
  });
  const auto gap = [&]() {
    double largest = 0;
    for (std::int64_t id = round + 1; id <= 2 * round; ++id) {
      const double(&a)[3] = flight.flight_.keyframes[id - round].pose->centre;
      const double(&b)[3] = flight.flight_.keyframes[id].pose->centre;
      largest = std::max(largest, (Vec3(a[0], a[1], a[2]) - Vec3(b[0], b[1], b[2])).norm() / test::flying_height);
    }
    return largest;
  };
  ASSERT_GT(gap(), 0.1);
  ASSERT_GT(flight.rms_error(flight.flight_), 0.05);
  ASSERT_EQ(join_in_sub_maps(flight.flight_).models.size(), 1U);
  EXPECT_LT(gap(), 0.003) << "after a round the camera is where it was";
  EXPECT_LT(flight.rms_error(flight.flight_), 0.01);
}

TEST(SubMaps, HaveStripsOfDifferentWorldsInOneModel) {
  NoisyFlight flight;
  flight.fly_strips(6, 45);
  const JoinedFlight joined = join_in_sub_maps(flight.flight_);
  ASSERT_EQ(joined.models.size(), 1U);
  EXPECT_EQ(joined.models[0].members.size(), 270U);
  EXPECT_EQ(joined.models[0].strip_id, 1);
  EXPECT_LT(flight.rms_error(flight.flight_), 0.001);
}

TEST(SubMaps, AreAdjustedAgainOnlyWhereAKeyframeIsNew) {
  NoisyFlight flight = long_flight(12);
  intake::Flight alone = flight.flight_, before = flight.without_last(), after = flight.flight_;
  intake::MemoryResultCache fresh, results;
  (void)join_with(alone, &fresh);
  (void)join_with(before, &results);
  const std::size_t kept = results.size();
  ASSERT_GE(kept, 7U);
  (void)join_with(after, &results);
  EXPECT_GE(results.size(), kept + 1);
  EXPECT_LE(results.size(), kept + 2) << "of " << fresh.size() << " sub-maps few see the last keyframe";
  EXPECT_TRUE(same_poses(after, alone)) << "the bytes are those of one run over all";
  EXPECT_FALSE(same_poses(before, alone)) << "what is new moves the others a little";
}

// What came down earlier, and in which parts, changes the time only.
TEST(SubMaps, DoNotDependOnTheRunsBefore) {
  const NoisyFlight flight = long_flight();
  intake::Flight alone = flight.flight_;
  (void)join_with(alone, nullptr);
  intake::MemoryResultCache results;
  intake::Flight late = flight.flight_;
  std::erase_if(late.links, [](const LinkRecord& link) { return link.keyframe_id % 3 == 0; });
  intake::Flight early = flight.without_last();
  for (intake::Flight* part : {&late, &early}) (void)join_with(*part, &results);
  for (int run = 0; run < 2; ++run) {
    intake::Flight all = flight.flight_;
    (void)join_with(all, &results);
    EXPECT_TRUE(same_poses(all, alone));
  }
}

class HalfKept : public intake::MemoryResultCache {
 public:
  std::optional<std::vector<std::uint8_t>> result(std::uint64_t digest) override {
    auto found = MemoryResultCache::result(digest);
    if (found) found->resize(found->size() / 2);
    return found;
  }
};

TEST(SubMaps, ThatAreDamagedAreAdjustedAgain) {
  const NoisyFlight flight = long_flight();
  intake::Flight alone = flight.flight_, again = flight.flight_, first = flight.flight_;
  (void)join_with(alone, nullptr);
  HalfKept results;
  (void)join_with(first, &results);
  (void)join_with(again, &results);
  EXPECT_TRUE(same_poses(again, alone));
}

}  // namespace
}  // namespace ilp::model
