// What a flight may meet that the memory of places must bear: hovers, ground that changes, other worlds, damage, a
// budget that is too small, a descent down to the ground.
#include <limits>

#include "fsw/shared/place_capacity.hpp"
#include "tests/unit/places/place_memory_fixture.hpp"

namespace ilp {
namespace {

using test::PlaceMemoryTest;

constexpr std::uint32_t whole_mask = 320 * 240;

class PlaceMemoryBadInput : public PlaceMemoryTest {
 protected:
  /// What a camera sees that stands over ground far away from that of the pose.
  [[nodiscard]] const test::View& view_elsewhere(Vec3 centre, const Vec3& turn, std::uint64_t noise_seed) const {
    centre += Vec3(7000, 4000, 0);
    return view_of(test::looking_down(centre, turn), noise_seed);
  }
  [[nodiscard]] std::vector<std::int64_t> places() {
    std::vector<std::int64_t> ids;
    for (const PlaceRecord& place : test::records_of<PlaceRecord>(store)) ids.push_back(place.id);
    return ids;
  }
};

TEST_F(PlaceMemoryBadInput, AHoverFillsTheMemoryNoFurtherAndShowsNothingNew) {
  mission.places_kept = 64;
  const RigidTransform camera = test::looking_down(Vec3(0, 0, height));
  const test::View views[] = {view_of(camera, 1), view_of(camera, 2), view_of(camera, 3)};
  auto stage = memory();
  for (std::int64_t id = 1; id <= 120; ++id) {
    show(id, 1, static_cast<std::int32_t>(id - 1), views[id % 3], camera, Similarity{});
    ASSERT_TRUE(run(*stage).empty()) << id;
    erase_record<FrameRecord>(id);
    if (id == 90) stage = memory();
    // Those before are known to the chain of pairs, whose masks are not made here.
    if (id <= 8) continue;
    ASSERT_LT(new_pixels(id), 10U) << id;
    ASSERT_LE(read<PlaceRecord>(id).links, 3U) << id;
  }
  EXPECT_EQ(number_of<PlaceRecord>(), 64);
  EXPECT_EQ(places().back(), 120);
  EXPECT_EQ(number_of<TieRecord>(), 0);
  for (const LinkRecord& link : links()) EXPECT_EQ(link.verdict, LinkVerdict::linked) << link.id;
}

TEST_F(PlaceMemoryBadInput, GroundThatHasChangedWhollyIsNotKnownAgain) {
  fly_out();
  for (std::int64_t id = 7; id <= 10; ++id) {
    const Vec3 centre(step * static_cast<double>(13 - id), 5, 1.1 * height);
    const Vec3 turn(0, 0, 2);
    show(id, 2, static_cast<std::int32_t>(id - 7), view_elsewhere(centre, turn, static_cast<std::uint64_t>(id)),
         test::looking_down(centre, turn), second_);
  }
  EXPECT_TRUE(run(*memory()).empty());
  EXPECT_EQ(number_of<LinkRecord>(), 0);
  EXPECT_EQ(number_of<TieRecord>(), 0);
  for (std::int64_t id = 7; id <= 10; ++id) EXPECT_EQ(new_pixels(id), whole_mask) << id;
}

// A piece that is gone is sometimes found where it is not. All ground counts as seen: it is known by where it lies.
TEST_F(PlaceMemoryBadInput, WhereAThirdOfTheGroundHasChangedTheLinksRestOnTheOtherTwo) {
  fly_out();
  constexpr double changed_from = 90;
  std::vector<RigidTransform> cameras;
  for (std::int64_t id = 7; id <= 10; ++id) {
    const Vec3 centre(step * static_cast<double>(13 - id), 5, 1.1 * height);
    const Vec3 turn(0, 0, 2);
    cameras.push_back(test::looking_down(centre, turn));
    test::View view = view_of(cameras.back(), static_cast<std::uint64_t>(id));
    const test::View other = view_elsewhere(centre, turn, 1);
    for (std::int32_t y = 0; y < camera_.height; ++y) {
      for (std::int32_t x = 0; x < camera_.width; ++x) {
        const auto i = static_cast<std::size_t>(y * camera_.width + x);
        const Vec3 ground = test::ground_point(camera_, cameras.back(), gentle, x, y);
        if (ground.x() > changed_from) view.image.pixels[i] = other.image.pixels[i];
      }
    }
    show(id, 2, static_cast<std::int32_t>(id - 7), view, cameras.back(), second_);
  }
  EXPECT_TRUE(run(*memory()).empty());
  std::size_t all = 0;
  std::size_t on_changed = 0;
  for (const LinkRecord& link : links()) {
    EXPECT_EQ(link.verdict, LinkVerdict::linked) << link.id;
    EXPECT_NEAR(link.scale, second_unit, 0.01 * second_unit) << link.id;
    std::vector<LinkPoint> points(link.points.bytes / sizeof(LinkPoint));
    ASSERT_TRUE(read_blob<LinkRecord>(store, "points", link.id, 0,
                                      {reinterpret_cast<std::uint8_t*>(points.data()), link.points.bytes})
                    .ok());
    for (const LinkPoint& point : points) {
      const Vec3 ground = test::ground_point(camera_, cameras[static_cast<std::size_t>(link.keyframe_id - 7)], gentle,
                                             point.x / link_points_per_px, point.y / link_points_per_px);
      ++all;
      on_changed += ground.x() > changed_from + 3 ? 1U : 0U;
    }
  }
  EXPECT_GE(links().size(), 4U);
  EXPECT_GT(all, 100U);
  EXPECT_LE(on_changed, all / 20);
  EXPECT_LT(std::fabs(read<TieRecord>(2).scale * second_unit - 1), 0.01);
}

// Poses of both strips are the same numbers, and both worlds have grounds of the same kind.
TEST_F(PlaceMemoryBadInput, StripsOfTwoWorldsAreNeitherLinkedNorTied) {
  fly_out();
  for (std::int64_t id = 7; id <= 12; ++id) {
    const Vec3 centre(step * static_cast<double>(id - 6), 0, height);
    show(id, 2, static_cast<std::int32_t>(id - 7), view_elsewhere(centre, Vec3::Zero(), static_cast<std::uint64_t>(id)),
         test::looking_down(centre), Similarity{});
  }
  EXPECT_TRUE(run(*memory()).empty());
  EXPECT_EQ(number_of<PlaceRecord>(), 12);
  EXPECT_EQ(number_of<LinkRecord>(), 0);
  EXPECT_EQ(number_of<TieRecord>(), 0);
  for (std::int64_t id = 7; id <= 12; ++id) EXPECT_EQ(new_pixels(id), whole_mask) << id;
}

TEST_F(PlaceMemoryBadInput, PlacesBeyondTheirNumberAreForgotten) {
  mission.places_kept = 64;
  const RigidTransform camera = test::looking_down(Vec3(0, 0, height));
  const test::View view = view_of(camera, 1);
  const auto stage = memory();
  for (std::int64_t id = 1; id <= 80; ++id) {
    // The same image again and again.
    show(id, 1, static_cast<std::int32_t>(id - 1), view, camera, Similarity{});
    run(*stage);
  }
  EXPECT_EQ(number_of<PlaceRecord>(), 64);
  EXPECT_EQ(places().back(), 80);
  EXPECT_LT(new_pixels(80), 10U) << "nothing about it is new";
}

// The first ones, of which the vocabulary is made, and the newest stay in any case; another one without features is
// the newest.
TEST_F(PlaceMemoryBadInput, PlacesStayWithinTheirShareOfTheBudgetHoweverItChanges) {
  const RigidTransform camera = test::looking_down(Vec3(0, 0, height));
  const test::View view = view_of(camera, 1);
  mission.storage_budget_mib = 34;
  const auto capacity = static_cast<std::int64_t>(places_with_capacity(mission));
  ASSERT_GT(capacity, 50);
  const auto stage = memory();
  const auto hover = [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t id = from; id <= to; ++id) {
      show(id, 1, static_cast<std::int32_t>(id - 1), view, camera, Similarity{});
      run(*stage);
    }
  };
  hover(1, capacity + 8);
  EXPECT_EQ(number_of<PlaceRecord>(), capacity);
  mission.storage_budget_mib = 22;
  run(*stage);
  EXPECT_EQ(number_of<PlaceRecord>(), static_cast<std::int64_t>(places_with_capacity(mission)));
  mission.storage_budget_mib = 4;
  run(*stage);
  EXPECT_EQ(number_of<PlaceRecord>(), static_cast<std::int64_t>(PlaceTable::kept_for_ever) + 1);
  hover(capacity + 9, capacity + 10);
  EXPECT_EQ(number_of<PlaceRecord>(), static_cast<std::int64_t>(PlaceTable::kept_for_ever) + 2);
  EXPECT_LT(new_pixels(capacity + 10), 10U) << "what is left is recognised";
}

struct DamageOfAPlace {
  const char* name;
  void (*damage)(PlaceRecord& place);
};
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr DamageOfAPlace damages[] = {{"gone", [](PlaceRecord& p) { p.id = 0; }},
                                      {"no position", [](PlaceRecord& p) { p.centre[0] = not_a_number; }},
                                      {"no rotation", [](PlaceRecord& p) { std::fill_n(p.q_cam_from_world, 4, 0.0); }},
                                      {"far away", [](PlaceRecord& p) { p.centre[1] = 1e300; }},
                                      {"no ground", [](PlaceRecord& p) { p.ground_distance = not_a_number; }},
                                      {"few features", [](PlaceRecord& p) { p.features.bytes = 96; }},
                                      {"too many features", [](PlaceRecord& p) { p.features.bytes = 0x100000; }},
                                      {"too few cells", [](PlaceRecord& p) { p.cells.bytes = 3; }},
                                      {"no patch", [](PlaceRecord& p) { p.patches.bytes = 1; }},
                                      {"slot of another", [](PlaceRecord& p) { p.slot = 2; }},
                                      {"slot outside", [](PlaceRecord& p) { p.slot = 0x7FFFFFFF; }},
                                      {"slot below", [](PlaceRecord& p) { p.slot = -7; }},
                                      {"other strip", [](PlaceRecord& p) { p.strip_id = 2; }},
                                      {"of the future", [](PlaceRecord& p) { p.id = std::int64_t{1} << 59U; }}};

// Its pose went with the history, so that the place is all that is left of keyframe 5. Keyframe 7 meets the memory as
// it is, those after it a restarted one.
TEST_F(PlaceMemoryBadInput, WhateverIsWrongWithAPlaceCostsItselfOnly) {
  for (const auto& [name, damage] : damages) {
    SCOPED_TRACE(name);
    begin_again();
    fly_out();
    auto stage = memory();
    run(*stage);
    erase_record<PoseRecord>(5);
    PlaceRecord place = read<PlaceRecord>(5);
    damage(place);
    if (place.id != 5) erase_record<PlaceRecord>(5);
    if (place.id != 0) write(place);
    for (std::int64_t id = 7; id <= 10; ++id) {
      see(id, 2, static_cast<std::int32_t>(id - 7),
          test::looking_down(Vec3(step * static_cast<double>(13 - id), 5, 1.1 * height), Vec3(0, 0, 2)), second_,
          static_cast<std::uint64_t>(id));
      for (const Status& fault : run(*stage)) {
        // A place that says that it is of this strip contradicts its poses.
        EXPECT_TRUE(fault.is(StatusCode::loop_contradicts)) << id << ": " << status_name(fault.code);
      }
      EXPECT_GE(read<PlaceRecord>(id).links, 1U) << id;
      EXPECT_LT(new_pixels(id), 0.6 * whole_mask) << id;
      stage = memory();
    }
    EXPECT_EQ(read<TieRecord>(2).to_strip_id, 1);
    for (const LinkRecord& link : links()) {
      EXPECT_TRUE(std::isfinite(link.scale) && std::isfinite(link.closing_sigma)) << link.id;
      EXPECT_LT(link.place_id, 7) << link.id;
    }
    EXPECT_EQ(places().back(), 10) << "what leads nowhere is erased";
  }
}

// Depths and places of features that no keyframe has.
TEST_F(PlaceMemoryBadInput, FeaturesThatAreNoneAreNotCompared) {
  fly_out();
  run(*memory());
  const PlaceRecord place = read<PlaceRecord>(5);
  std::vector<std::uint8_t> bytes(place.features.bytes);
  ASSERT_TRUE(read_blob<PlaceRecord>(store, "features", 5, 0, bytes).ok());
  const auto damage = [&](std::size_t at, float value) {
    std::vector<std::uint8_t> changed = bytes;
    std::memcpy(changed.data() + at, &value, sizeof(value));
    test::in_transaction(store, [&] { ASSERT_TRUE(write_blob<PlaceRecord>(store, "features", 5, 0, changed).ok()); });
  };
  std::int64_t id = 7;
  for (const float value : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -1e30F}) {
    for (const std::size_t at : {std::size_t{0}, bytes.size() - 4}) {
      damage(at, value);
      see(id, 2, static_cast<std::int32_t>(id - 7),
          test::looking_down(Vec3(step * 5.2, 5, 1.1 * height), Vec3(0, 0, 2)), second_,
          static_cast<std::uint64_t>(id));
      const std::vector<Status> faults = run(*memory());
      EXPECT_TRUE(faults.empty());
      EXPECT_GE(read<PlaceRecord>(id).links, 1U);
      ++id;
    }
  }
  for (const LinkRecord& link : links()) EXPECT_NE(link.place_id, 5) << link.id;
}

// The ground loses its pattern on the way: the last images are nearly smooth.
TEST_F(PlaceMemoryBadInput, ADescentToAMetreEndsWithoutAFalseLinkAndTakesNothingOutOfAMask) {
  const auto level = [](double, double) { return 0.0; };
  const auto stage = memory();
  double altitude = height;
  std::vector<double> altitudes;
  for (std::int64_t id = 1; altitude >= 1; ++id, altitude *= 0.75) {
    const RigidTransform camera = test::looking_down(Vec3(0, 0, altitude), Vec3(0, 0, 0.1 * static_cast<double>(id)));
    show(id, 1, static_cast<std::int32_t>(id - 1),
         test::render_view(camera_, camera, level, 2, 1, static_cast<std::uint64_t>(id)), camera, Similarity{});
    altitudes.push_back(altitude);
    ASSERT_TRUE(run(*stage).empty()) << id;
    EXPECT_EQ(places().back(), id);
    EXPECT_EQ(read<PlaceRecord>(id).links, 0U) << "a tenth of the height of all that are compared";
    EXPECT_EQ(new_pixels(id), whole_mask) << id << ": the chain of pairs knows what is not new";
  }
  EXPECT_GE(altitudes.size(), 16U);
}

}  // namespace
}  // namespace ilp
