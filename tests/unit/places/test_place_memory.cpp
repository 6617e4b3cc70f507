// The memory of places over analytic ground that is flown over twice: links, ties, masks, restarts and damage.
#include "tests/support/failing_store.hpp"
#include "tests/unit/places/place_memory_fixture.hpp"

namespace ilp {
namespace {

using test::PlaceMemoryTest;

TEST_F(PlaceMemoryTest, GroundOfAnEarlierStripIsKnownAgainAndTheStripsAreTied) {
  fly_out();
  fly_back();
  const auto stage = memory();
  EXPECT_TRUE(run(*stage).empty());
  EXPECT_EQ(number_of<PlaceRecord>(), 10);
  EXPECT_EQ(read<PlaceRecord>(6).links, 0U) << "neighbours in a strip are not compared";
  for (std::int64_t id = 7; id <= 10; ++id) {
    EXPECT_GE(read<PlaceRecord>(id).links, 2U) << id;
    const MaskRecord mask = read<MaskRecord>(id);
    EXPECT_EQ(mask.newly_seen, new_pixels(id));
    EXPECT_LT(mask.newly_seen, 0.45 * 320 * 240) << id;
    EXPECT_EQ(mask.newly_seen + read<PlaceRecord>(id).known_before, 320U * 240U);
  }
  for (const LinkRecord& link : links()) {
    EXPECT_EQ(link.verdict, LinkVerdict::linked);
    EXPECT_NEAR(link.scale, second_unit, 0.01 * second_unit);
    EXPECT_EQ(link.strip_id, 2);
    EXPECT_EQ(link.place_strip_id, 1);
  }
  const TieRecord tie = read<TieRecord>(2);
  EXPECT_EQ(tie.to_strip_id, 1);
  const SimilarityStep error = step_between(inverse(second_), similarity_of(tie));
  EXPECT_LT(std::fabs(error(6)), 0.002);
  const Vec3 ground(80, 0, 0);
  EXPECT_LT((similarity_of(tie) * (second_ * ground) - ground).norm(), 0.003 * height);
}

// The chain of pairs says little about them: they are linked with their neighbours as well.
TEST_F(PlaceMemoryTest, KeyframesThatShareLittleAreComparedWithTheirNeighbours) {
  overlap_ = 0.5;
  fly_out();
  EXPECT_TRUE(run(*memory()).empty());
  EXPECT_EQ(number_of<TieRecord>(), 0);
  for (std::int64_t id = 2; id <= 6; ++id) {
    EXPECT_GE(read<PlaceRecord>(id).links, std::min<std::uint32_t>(static_cast<std::uint32_t>(id - 1), 3)) << id;
    EXPECT_EQ(new_pixels(id), 320U * 240U) << "the coverage of the strip decides on its own ground";
  }
  for (const LinkRecord& link : links()) {
    EXPECT_EQ(link.verdict, LinkVerdict::linked);
    EXPECT_LT(link.closing_error, 0.003);
  }
}

// What is taken out of a mask was seen before, and what was never seen stays in it if it is 7 px wide along x and y: a
// square of 4 px fits into it.
TEST_F(PlaceMemoryTest, OnlyGroundThatWasSeenLeavesTheMask) {
  fly_out();
  fly_back();
  run(*memory());
  const std::vector<std::uint8_t> mask = mask_of(8);
  const RigidTransform camera = test::looking_down(Vec3(step * 5, 5, 1.1 * height), Vec3(0, 0, 2));
  const auto seen = [&](int x, int y) {
    const Vec3 ground = test::ground_point(camera_, camera, gentle, x, y);
    for (int id = 1; id <= 6; ++id) {
      const Vec2 there = test::pixel_of(camera_, test::looking_down(Vec3(step * id, 0, height)), ground);
      if (there.x() > -0.5 && there.y() > -0.5 && there.x() < 319.5 && there.y() < 239.5) return true;
    }
    return false;
  };
  int wrong = 0;
  int taken = 0;
  for (int y = 0; y < camera_.height; y += 4) {
    for (int x = 0; x < camera_.width; x += 4) {
      if (mask[static_cast<std::size_t>(y * camera_.width + x)] != 0) continue;
      ++taken;
      wrong += seen(x, y) || seen(x - 3, y) || seen(x + 3, y) || seen(x, y - 3) || seen(x, y + 3) ? 0 : 1;
    }
  }
  EXPECT_GT(taken, 2000);
  EXPECT_EQ(wrong, 0);
}

TEST_F(PlaceMemoryTest, OffEachKeyframeGetsABarePlaceAndKeepsItsMask) {
  mission.place_memory = false;
  fly_out();
  fly_back();
  EXPECT_TRUE(run(*memory()).empty());
  EXPECT_EQ(number_of<PlaceRecord>(), 1) << "the newest says how far the stage has come";
  EXPECT_EQ(read<PlaceRecord>(10).features.bytes, 0U);
  EXPECT_EQ(number_of<LinkRecord>(), 0);
  EXPECT_EQ(new_pixels(8), 320U * 240U);
}

TEST_F(PlaceMemoryTest, AMaskIsFinalWithItsPlaceWhetherItLosesGroundOrNot) {
  for (const bool remembering : {true, false}) {
    SCOPED_TRACE(remembering);
    const std::int64_t first = remembering ? 1 : 7;
    mission.place_memory = remembering;
    if (remembering) {
      fly_out();
    } else {
      fly_back();
    }
    EXPECT_EQ(read<MaskRecord>(first).scope, MaskScope::strip);
    const std::vector<std::uint8_t> before = mask_of(first);
    const DepthRecord depth = read<DepthRecord>(first);
    run(*memory());
    for (std::int64_t id = first; id < first + 4; ++id) EXPECT_EQ(read<MaskRecord>(id).scope, MaskScope::flight) << id;
    EXPECT_EQ(mask_of(first), before) << "nothing was known";
    EXPECT_EQ(read<DepthRecord>(first).cells.bytes, depth.cells.bytes) << "the depth record is another stage's";
  }
}

TEST_F(PlaceMemoryTest, NobodyWaitsForAMaskThatCannotBeRead) {
  fly_out();
  test::FailingStore failing(store);
  failing.judge_by([&](const test::FailingStore::Call& call) {
    const bool hit = call.kind == test::StoreCall::get && call.type == RecordType::mask && call.id == 3;
    return hit ? Status{StatusCode::store_error, 10} : Status{};
  });
  const auto stage = std::make_unique<PlaceMemory>(failing, mission, test::step_memory<PlaceMemory>());
  EXPECT_TRUE(restored(stage->restore()));
  PlaceRecord last_place;
  for (int i = 0; i < 2000 && !get(store, 6, last_place).ok(); ++i) stage->step();
  EXPECT_EQ(read<MaskRecord>(3).scope, MaskScope::flight);
  EXPECT_EQ(read<MaskRecord>(3).code.bytes, 0U) << "the whole image counts as new";
  EXPECT_NE(read<MaskRecord>(4).code.bytes, 0U);
}

TEST_F(PlaceMemoryTest, ARestartKnowsTheSamePlacesAgain) {
  fly_out();
  run(*memory());
  fly_back();
  run(*memory());
  const std::vector<LinkRecord> after_restart = links();
  const std::vector<std::uint8_t> mask = mask_of(9);

  begin_again();
  fly_out();
  fly_back();
  run(*memory());
  const std::vector<LinkRecord> at_once = links();
  ASSERT_EQ(after_restart.size(), at_once.size());
  for (std::size_t i = 0; i < at_once.size(); ++i)
    EXPECT_EQ(std::memcmp(&at_once[i], &after_restart[i], sizeof(LinkRecord)), 0);
  EXPECT_EQ(mask, mask_of(9));
}

TEST_F(PlaceMemoryTest, ADamagedPlaceIsNotKnownAgainAndTheOthersAre) {
  fly_out();
  run(*memory());
  PlaceRecord place = read<PlaceRecord>(5);
  place.features.bytes = 12;
  write(place);
  fly_back();
  run(*memory());
  EXPECT_FALSE(links().empty());
  for (const LinkRecord& link : links()) EXPECT_NE(link.place_id, 5);
}

TEST_F(PlaceMemoryTest, AnImageThatCannotBeReadCostsItsPlaceOnly) {
  fly_out();
  fly_back();
  FrameRecord frame = read<FrameRecord>(8);
  frame.image.bytes = 0;
  write(frame);
  run(*memory());
  EXPECT_EQ(read<PlaceRecord>(10).links > 0, true);
  EXPECT_EQ(new_pixels(8), 320U * 240U);
  PlaceRecord gone;
  EXPECT_TRUE(get(store, 8, gone).is(StatusCode::not_found)) << "a bare place goes with the next one";
}

TEST_F(PlaceMemoryTest, AKeyframeWithoutPoseIsLinkedByItsImage) {
  fly_out();
  fly_back();
  PoseRecord pose = read<PoseRecord>(9);
  pose.state = PoseState::failed;
  write(pose);
  DepthRecord depth = read<DepthRecord>(9);
  depth.verdict = DepthVerdict::no_partner;
  depth.cells.bytes = 0;
  write(depth);
  run(*memory());
  const LinkRecord link = read<LinkRecord>(link_id(9, 0));
  EXPECT_EQ(link.verdict, LinkVerdict::images_only);
  EXPECT_LT(new_pixels(9), 0.6 * 320 * 240);
}

TEST_F(PlaceMemoryTest, AMoreDetailedViewClaimsItsGround) {
  fly_out();
  for (std::int64_t id = 7; id <= 8; ++id) {
    see(id, 2, static_cast<std::int32_t>(id - 7),
        test::looking_down(Vec3(step * static_cast<double>(id - 4), 0, 0.78 * height)), Similarity{},
        static_cast<std::uint64_t>(id));
  }
  mission.claim_ratio = 1.2;
  run(*memory());
  EXPECT_GE(read<PlaceRecord>(8).links, 1U);
  EXPECT_EQ(new_pixels(8), 320U * 240U);
}

// Of a keyframe that is so near the chain of pairs knows the ground, as far as the images between show it.
TEST_F(PlaceMemoryTest, InACurveGroundComesBackAndOnAStraightStripNothingChanges) {
  for (std::int64_t id = 1; id <= 4; ++id) {
    const auto turn = 0.15 * static_cast<double>(id);
    const Vec3 centre(step * static_cast<double>(id), 0, height);
    see(id, 1, static_cast<std::int32_t>(id - 1), test::looking_down(centre), Similarity{}, 1);
    see(id + 4, 2, static_cast<std::int32_t>(id - 1), test::looking_down(centre + Vec3(0, 5000, 0), Vec3(0, 0, turn)),
        second_, 1);
  }
  run(*memory());
  EXPECT_EQ(number_of<LinkRecord>(), 0);
  for (std::int64_t id = 1; id <= 6; ++id) EXPECT_EQ(new_pixels(id), 320U * 240U) << id;
  EXPECT_LT(new_pixels(7), 0.5 * 320 * 240);
  EXPECT_LT(new_pixels(8), 0.5 * 320 * 240);
}

TEST_F(PlaceMemoryTest, AKeyframeThatIsNotKnownAgainKnowsItsGroundByTheLinkOfOneJustBefore) {
  const auto fly = [&](bool unlike, bool linked_before) {
    begin_again();
    fly_out();
    const RigidTransform back = test::looking_down(Vec3(4 * step, 5, 1.1 * height), Vec3(0, 0, 2));
    const Vec3 before = linked_before ? Vec3(5 * step, 5, 1.1 * height) : Vec3(5 * step, 500, 1.1 * height);
    see(7, 2, 0, test::looking_down(before, Vec3(0, 0, 2)), second_, 7);
    test::View view = view_of(back, 8);
    if (unlike) view.image = view_of(test::looking_down(Vec3(900, 700, height)), 8).image;
    show(8, 2, 1, view, back, second_);
    run(*memory());
    EXPECT_EQ(read<PlaceRecord>(7).links > 0, linked_before);
    EXPECT_EQ(read<PlaceRecord>(8).links > 0, !unlike);
    return new_pixels(8) / (320.0 * 240.0);
  };
  const double by_its_own_link = fly(false, true);
  EXPECT_LT(by_its_own_link, 0.45);
  const double by_the_one_before = fly(true, true);
  EXPECT_GE(by_the_one_before, by_its_own_link - 0.002) << "errors of the link make a border";
  EXPECT_LT(by_the_one_before, by_its_own_link + 0.05);
  EXPECT_EQ(fly(true, false), 1) << "nothing leads to the first strip";
}

// The third keyframe stands farther from the first one than the second does, so that it may lie on a straight strip.
TEST_F(PlaceMemoryTest, BehindABendGroundComesBackThatTheKeyframeBeforeDoesNotShow) {
  const auto new_share = [&](const Vec3& third) {
    begin_again();
    see(1, 1, 0, test::looking_down(Vec3(0, 0, height)), Similarity{}, 1);
    see(2, 1, 1, test::looking_down(Vec3(40, 0, height)), Similarity{}, 2);
    see(3, 1, 2, test::looking_down(third), Similarity{}, 3);
    run(*memory());
    EXPECT_EQ(number_of<LinkRecord>(), 0);
    return new_pixels(3) / (320.0 * 240.0);
  };
  // Of 105 x 79 m the images have 80 x 39 m in common.
  EXPECT_NEAR(new_share(Vec3(25, 40, height)), 1 - 80 * 39 / (105.0 * 79), 0.05);
  EXPECT_EQ(new_share(Vec3(80, 0, height)), 1);
  EXPECT_EQ(new_share(Vec3(75, 20, height)), 1) << "a bend of 30 degrees";
}

// Keyframe 13 comes back to the ground of the first three, whose features are lost. Those between saw other ground.
TEST_F(PlaceMemoryTest, WithoutALinkThePosesOfTheStripSayWhatIsKnownIfTheirErrorsAreSmall) {
  const auto state_errors = [&](std::int64_t id, double sigma) {
    PoseRecord pose = read<PoseRecord>(id);
    for (const int element : {9, 14, 20}) pose.covariance[element] = sigma * sigma;
    write(pose);
  };
  const auto new_share = [&](double sigma) {
    begin_again();
    for (std::int64_t id = 1; id <= 3; ++id) {
      see(id, 1, static_cast<std::int32_t>(id - 1), test::looking_down(Vec3(step * static_cast<double>(id), 0, height)),
          Similarity{}, 1);
      if (id > 1) state_errors(id, sigma);
    }
    run(*memory());
    for (std::int64_t id = 1; id <= 3; ++id) {
      PlaceRecord place = read<PlaceRecord>(id);
      place.features.bytes = 12;
      write(place);
    }
    see(13, 1, 12, test::looking_down(Vec3(2 * step, 5, height), Vec3(0, 0, 1.5)), Similarity{}, 1);
    state_errors(13, sigma);
    run(*memory());
    EXPECT_EQ(number_of<LinkRecord>(), 0);
    return new_pixels(13) / (320.0 * 240.0);
  };
  EXPECT_LT(new_share(0.1), 0.3) << "a quarter was never seen";
  EXPECT_EQ(new_share(3), 1) << "an error of 30 px";
  EXPECT_EQ(new_share(0), 1) << "not stated";
}

}  // namespace
}  // namespace ilp
