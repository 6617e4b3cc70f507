// Pairs of final poses to depths and masks, over analytic terrain: what a keyframe without pose, a pair without depth
// and bad images cost.
#include <algorithm>
#include <memory>
#include <set>

#include "fsw/products/depth_access.hpp"
#include "fsw/terrain/dense_matcher.hpp"
#include "tests/support/failing_store.hpp"
#include "tests/support/level_plane.hpp"
#include "tests/unit/shared/component_fixture.hpp"
#include "tests/unit/vision/stereo/analytic_scene.hpp"

namespace ilp {
namespace {

constexpr double height = 100;

double gentle(double x, double y) {
  return 3 * std::sin(x / 17) * std::cos(y / 13);
}

class DenseMatcherTest : public test::ComponentTest {
 protected:
  DenseMatcherTest() {
    camera_ = test::distorting_camera();
    camera_.k1 = camera_.k2 = camera_.p1 = camera_.p2 = 0;
    write(camera_record(camera_));
  }

  /// One keyframe per place, all in one strip that has ended.
  void fly(const std::vector<Vec3>& places) {
    for (const Vec3& place : places) {
      const auto id = static_cast<std::int64_t>(views_.size()) + 1;
      views_.push_back(
          test::render_view(camera_, test::looking_down(place), gentle, 2, 1, static_cast<std::uint64_t>(id)));
      KeyframeRecord keyframe{.id = id, .frame_id = id, .strip_id = 1};
      if (id > 1) test::put_level_plane(views_[static_cast<std::size_t>(id - 2)], views_.back(), keyframe);
      write(keyframe);
      write_image(id);
      PoseRecord pose{.id = id, .strip_id = 1, .state = PoseState::final};
      const Pose p = pose_from(views_.back().cam_from_world);
      for (int i = 0; i < 4; ++i) pose.q_cam_from_world[i] = p.q_cam_from_world[i];
      for (int i = 0; i < 3; ++i) pose.centre[i] = p.centre[i];
      pose.min_depth = place.z() - 5;
      pose.max_depth = place.z() + 5;
      write(pose);
    }
    StripRecord strip;
    strip.id = 1;
    strip.first_keyframe_id = 1;
    strip.last_keyframe_id = static_cast<std::int64_t>(views_.size());
    strip.end = StripEnd::end_of_flight;
    write(strip);
  }

  /// Ground with from < x < to as `grey_of(grey, noise)` paints it, in both of two images.
  template <typename Paint>
  void repaint(double from, double to, Paint grey_of) {
    for (std::int64_t id = 1; id <= 2; ++id) {
      test::View& view = views_[static_cast<std::size_t>(id - 1)];
      auto& pixels = view.image.pixels;
      const auto width = static_cast<std::size_t>(camera_.width);
      Rng noise(static_cast<std::uint64_t>(id));
      for (std::size_t i = 0; i < pixels.size(); ++i) {
        const Vec3 ground = test::ground_point(camera_, view.cam_from_world, gentle, static_cast<double>(i % width),
                                               static_cast<double>(i / width));
        if (ground.x() > from && ground.x() < to) pixels[i] = static_cast<std::uint8_t>(grey_of(pixels[i], noise));
      }
      write_image(id);
    }
  }

  void write_image(std::int64_t id) { write_frame(id, views_[static_cast<std::size_t>(id - 1)].image); }

  void fail_pose(std::int64_t id) {
    PoseRecord pose = read<PoseRecord>(id);
    pose.state = PoseState::failed;
    write(pose);
  }

  std::vector<Status> match() {
    const auto matcher = std::make_unique<DenseMatcher>(store, mission);
    EXPECT_TRUE(matcher->restore().ok());
    return run(*matcher, 100000);
  }

  /// The bytes of all depths, errors and masks.
  std::vector<std::uint8_t> all_depths() {
    std::vector<std::uint8_t> all;
    for (std::int64_t id = 1; id <= static_cast<std::int64_t>(views_.size()); ++id) {
      const auto record = read<DepthRecord>(id);
      for (const auto& [name, size] : {std::pair("values", record.values.bytes), std::pair("sigma", record.sigma.bytes),
                                       std::pair("cells", record.cells.bytes)}) {
        std::vector<std::uint8_t> bytes(size);
        EXPECT_TRUE(size == 0 || read_blob<DepthRecord>(store, name, id, 0, bytes).ok());
        all.insert(all.end(), bytes.begin(), bytes.end());
      }
      const std::vector<std::uint8_t> code = mask_code(id);
      all.insert(all.end(), code.begin(), code.end());
    }
    return all;
  }

  std::vector<std::uint8_t> mask_code(std::int64_t id) {
    const auto record = read<MaskRecord>(id);
    EXPECT_EQ(record.scope, MaskScope::strip);
    std::vector<std::uint8_t> bytes(record.code.bytes);
    EXPECT_TRUE(read_blob<MaskRecord>(store, "code", id, 0, bytes).ok());
    return bytes;
  }

  std::vector<std::uint8_t> mask_of(std::int64_t id) {
    const std::vector<std::uint8_t> bytes = mask_code(id);
    std::vector<std::uint8_t> mask(views_[0].image.pixels.size());
    EXPECT_TRUE(decode_mask(bytes.data(), bytes.size(), {mask.data(), camera_.width, camera_.height}).ok());
    return mask;
  }

  /// Share of the image.
  double masked(std::int64_t id) {
    const auto mask = mask_of(id);
    return static_cast<double>(std::count(mask.begin(), mask.end(), 255)) / static_cast<double>(mask.size());
  }

  /// Share of the ground in the masks of keyframes `ids` that an earlier mask of them has already.
  double sent_twice(const std::vector<std::int64_t>& ids) {
    double all = 0, twice = 0;
    std::vector<std::pair<const test::View*, std::vector<std::uint8_t>>> earlier;
    for (const std::int64_t id : ids) {
      const test::View& view = views_[static_cast<std::size_t>(id - 1)];
      auto mask = mask_of(id);
      for (std::int32_t y = 0; y < camera_.height; ++y) {
        for (std::int32_t x = 0; x < camera_.width; ++x) {
          if (mask[static_cast<std::size_t>(y * camera_.width + x)] == 0) continue;
          all += 1;
          const Vec3 ground = test::ground_point(camera_, view.cam_from_world, gentle, x, y);
          for (const auto& [other, other_mask] : earlier) {
            const Vec2 p = test::pixel_of(camera_, other->cam_from_world, ground);
            if (!test::inside(camera_, p)) continue;
            const auto u = static_cast<std::int32_t>(p.x() + 0.5), v = static_cast<std::int32_t>(p.y() + 0.5);
            if (other_mask[static_cast<std::size_t>(v * camera_.width + u)] == 0) continue;
            twice += 1;
            break;
          }
        }
      }
      earlier.emplace_back(&view, std::move(mask));
    }
    return twice / all;
  }

  /// Shares of the pixels in columns [begin, end): with depth, and of these with an error of more than 2 %.
  struct Depths {
    double valid = 0, wrong = 0;
  };
  Depths depths(std::int64_t id, std::int32_t begin, std::int32_t end) {
    const auto record = read<DepthRecord>(id);
    if (record.values.bytes == 0) return {};
    std::vector<std::uint8_t> bytes(record.values.bytes);
    EXPECT_TRUE(read_blob<DepthRecord>(store, "values", id, 0, bytes).ok());
    double pixels = 0, valid = 0, wrong = 0;
    for (std::int32_t y = 0; y < camera_.height; ++y) {
      for (std::int32_t x = begin; x < end; ++x) {
        const auto i = static_cast<std::size_t>(y * camera_.width + x);
        pixels += 1;
        const unsigned code = bytes[2 * i] | static_cast<unsigned>(bytes[2 * i + 1]) << 8U;
        if (code == 0) continue;
        valid += 1;
        const double depth = 1 / (record.offset + record.step * code);
        wrong += std::fabs(depth / views_[static_cast<std::size_t>(id - 1)].depth[i] - 1) > 0.02 ? 1 : 0;
      }
    }
    return {valid / pixels, valid > 0 ? wrong / valid : 0};
  }

  /// Median relative error.
  double depth_error(std::int64_t id) {
    const auto record = read<DepthRecord>(id);
    std::vector<std::uint8_t> bytes(record.values.bytes);
    EXPECT_TRUE(read_blob<DepthRecord>(store, "values", id, 0, bytes).ok());
    std::vector<double> errors;
    for (std::size_t i = 0; 2 * i < bytes.size(); ++i) {
      const unsigned code = bytes[2 * i] | static_cast<unsigned>(bytes[2 * i + 1]) << 8U;
      const double depth = 1 / (record.offset + record.step * code);
      if (code != 0) errors.push_back(std::fabs(depth / views_[static_cast<std::size_t>(id - 1)].depth[i] - 1));
    }
    EXPECT_FALSE(errors.empty());
    std::sort(errors.begin(), errors.end());
    return errors.empty() ? 0 : errors[errors.size() / 2];
  }

  /// As if no pair had been matched yet.
  void forget_depths() {
    EXPECT_EQ(number_of<MaskRecord>(), number_of<DepthRecord>());
    test::erase_records<DepthRecord, MaskRecord, CheckpointRecord>(store);
  }

  CameraModel camera_;
  std::vector<test::View> views_;
};

std::vector<Vec3> line(int count) {
  std::vector<Vec3> places;
  for (int i = 0; i < count; ++i) places.emplace_back(20.0 * i, 0, height);
  return places;
}

std::vector<Vec3> descent(int count) {
  std::vector<Vec3> places;
  for (int i = 0; i < count; ++i) places.emplace_back(0, 0, height - 12.0 * i);
  return places;
}

TEST_F(DenseMatcherTest, AStripCoversEveryPlaceOnce) {
  fly(line(5));
  EXPECT_TRUE(match().empty());
  EXPECT_LT(sent_twice({1, 2, 3, 4, 5}), 0.02);
  for (std::int64_t id = 1; id <= 4; ++id) {
    EXPECT_EQ(read<DepthRecord>(id).verdict, DepthVerdict::ok);
    EXPECT_LT(depths(id, 0, camera_.width).wrong, 0.01);
  }
}

TEST_F(DenseMatcherTest, LevelKeyframesAreMatchedWithTheNextOneAsSoonAsItIsFinal) {
  fly(line(5));
  auto later = read<PoseRecord>(3);
  later.state = PoseState::provisional;
  write(later);
  match();
  EXPECT_EQ(read<DepthRecord>(1).partner_id, 2);
  EXPECT_EQ(number_of<DepthRecord>(), 1);
  later.state = PoseState::final;
  write(later);
  match();
  for (std::int64_t id = 1; id <= 4; ++id) EXPECT_EQ(read<DepthRecord>(id).partner_id, id + 1);
}

TEST_F(DenseMatcherTest, WhereTheNextKeyframeShowsLittleParallaxAFartherOneIsThePartnerAndTheErrorIsSmaller) {
  // Steps of 2 % of the height, across the view: 6 px of parallax for the next one.
  std::vector<Vec3> places;
  for (int i = 0; i < 8; ++i) places.emplace_back(2.0 * i, 0, height);
  fly(places);
  auto later = read<PoseRecord>(5);
  later.state = PoseState::provisional;
  write(later);
  match();
  EXPECT_EQ(number_of<DepthRecord>(), 0) << "the choice waits for four final poses";
  later.state = PoseState::final;
  write(later);
  match();
  EXPECT_EQ(read<DepthRecord>(1).partner_id, 5);
  EXPECT_EQ(read<DepthRecord>(7).partner_id, 8) << "the strip has ended";
  mission.partner_reach = 1;
  const double far = depth_error(1);
  forget_depths();
  match();
  EXPECT_EQ(read<DepthRecord>(1).partner_id, 2);
  EXPECT_LT(far, 0.4 * depth_error(1));
}

TEST_F(DenseMatcherTest, PairsThatShareAThirdToAHalfOfTheirGroundHaveDepthInAllOfIt) {
  const double width = height * camera_.width / camera_.fx;
  for (const double overlap : {0.3, 0.42, 0.55}) {
    views_.clear();
    const double step = (1 - overlap) * width;
    fly({{0, 0, height}, {step, 0, height}, {2 * step, 0, height}});
    forget_depths();
    EXPECT_TRUE(match().empty()) << overlap;
    const auto record = read<DepthRecord>(1);
    EXPECT_EQ(record.verdict, DepthVerdict::ok) << overlap;
    EXPECT_EQ(record.partner_id, 2);
    const double share = static_cast<double>(record.valid) / (camera_.width * camera_.height);
    EXPECT_NEAR(share, overlap, 0.05);
    EXPECT_NEAR(masked(1), share, 1e-9);
    const auto common = static_cast<std::int32_t>((1 - overlap) * camera_.width) + 10;
    std::printf("overlap %.2f: depth in %.3f of the image, %.3f of the common ground, median error %.3f %%\n", overlap,
                share, depths(1, common, camera_.width - 5).valid, 100 * depth_error(1));
    EXPECT_GT(depths(1, common, camera_.width - 5).valid, 0.9) << overlap;
    EXPECT_LT(depths(1, 0, camera_.width).wrong, 0.02) << overlap;
    EXPECT_LT(sent_twice({1, 2}), 0.02);
  }
}

TEST_F(DenseMatcherTest, WhereADescentEndsItsLastKeyframesClaimWhatTheySeeALittleFiner) {
  // In all the height shrinks by 1.66 only.
  std::vector<Vec3> places;
  for (int i = 0; i < 8; ++i) places.emplace_back(0, 0, height * std::pow(0.93, i));
  fly(places);
  EXPECT_TRUE(match().empty());
  EXPECT_LT(masked(2), 0.2) << "the ground about the epipole";
  for (const std::int64_t id : {3, 4}) EXPECT_LT(masked(id), 0.05) << id;
  EXPECT_EQ(read<DepthRecord>(5).partner_id, 8);
  EXPECT_GT(masked(5) + masked(6) + masked(7), 0.3);
}

TEST_F(DenseMatcherTest, ARestartWhileThePartnerIsChosenChangesNothing) {
  fly(descent(7));
  match();
  std::vector<DepthRecord> wanted;
  std::vector<std::uint32_t> newly_seen;
  for (std::int64_t id = 1; id <= 7; ++id) wanted.push_back(read<DepthRecord>(id));
  for (const DepthRecord& depth : wanted) newly_seen.push_back(read<MaskRecord>(depth.id).newly_seen);
  EXPECT_GT(wanted[1].partner_id, 3);
  forget_depths();
  // Poses become final one by one, and the software restarts after each.
  for (std::int64_t final_id = 1; final_id <= 7; ++final_id) {
    for (std::int64_t id = 1; id <= 7; ++id) {
      auto pose = read<PoseRecord>(id);
      pose.state = id <= final_id ? PoseState::final : PoseState::provisional;
      write(pose);
    }
    match();
  }
  for (const DepthRecord& depth : wanted) {
    const auto found = read<DepthRecord>(depth.id);
    EXPECT_EQ(found.partner_id, depth.partner_id) << depth.id;
    EXPECT_EQ(read<MaskRecord>(depth.id).newly_seen, newly_seen[static_cast<std::size_t>(depth.id - 1)]) << depth.id;
    EXPECT_EQ(found.valid, depth.valid) << depth.id;
  }
}

TEST_F(DenseMatcherTest, IfAFartherPartnerGivesNoDepthTheNextOneIsTaken) {
  std::vector<Vec3> places;
  for (int i = 0; i < 5; ++i) places.emplace_back(2.0 * i, 0, height);
  fly(places);
  // Its image shows nothing.
  auto& blank = views_[4].image.pixels;
  std::fill(blank.begin(), blank.end(), std::uint8_t{128});
  write_image(5);
  match();
  EXPECT_EQ(read<DepthRecord>(1).verdict, DepthVerdict::ok);
  EXPECT_EQ(read<DepthRecord>(1).partner_id, 2);
}

TEST_F(DenseMatcherTest, GroundThatIsSeenBadlyIsNotSentAndALaterKeyframeClaimsIt) {
  // Straight down, then aside: the second pair shows the ground about the epipole of the first one well.
  fly({{0, 0, height}, {0, 0, height - 12}, {18, 0, height - 12}});
  mission.partner_reach = 1;
  match();
  const std::vector<std::uint8_t> all = mask_of(1);
  const double claimed = masked(2);
  forget_depths();
  mission.largest_depth_sigma = 0.006;
  match();
  const std::vector<std::uint8_t> well = mask_of(1);
  std::size_t dropped = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_LE(well[i], all[i]);
    dropped += all[i] != well[i] ? 1U : 0U;
  }
  const auto record = read<DepthRecord>(1);
  EXPECT_GT(static_cast<double>(dropped), 0.05 * static_cast<double>(all.size()));
  EXPECT_EQ(read<MaskRecord>(1).newly_seen, record.valid);
  std::vector<std::uint8_t> sigma(record.sigma.bytes);
  ASSERT_TRUE(read_blob<DepthRecord>(store, "sigma", 1, 0, sigma).ok());
  EXPECT_EQ(record.valid, sigma.size() - static_cast<std::size_t>(std::count(sigma.begin(), sigma.end(), 0)));
  EXPECT_GT(masked(2), claimed + 0.02) << "the ground about the epipole is nobody's yet";
  EXPECT_LT(sent_twice({1, 2}), 0.02);
}

TEST_F(DenseMatcherTest, AKeyframeWithoutPoseCostsNoneOfTheCoverage) {
  fly(line(5));
  fail_pose(3);
  EXPECT_TRUE(match().empty());
  EXPECT_EQ(read<DepthRecord>(2).partner_id, 4);
  EXPECT_EQ(read<DepthRecord>(3).verdict, DepthVerdict::no_partner);
  // All of its ground is in other masks.
  EXPECT_LT(masked(3), 0.02);
  // What keyframes 2 and 4 share is known, which is three fifths.
  EXPECT_NEAR(masked(4), 0.38, 0.04);
  EXPECT_LT(sent_twice({1, 2, 3, 4, 5}), 0.02);
}

TEST_F(DenseMatcherTest, AKeyframeWithoutPoseAfterTheFirstOfADescentSendsOnlyWhatNoOtherHas) {
  mission.partner_reach = 1;  // the end of the strip is so near that its keyframes would claim ground again
  fly(descent(4));
  fail_pose(2);
  EXPECT_TRUE(match().empty());
  EXPECT_EQ(read<DepthRecord>(1).partner_id, 3);
  // The first has depth for what the third sees; around that the second is all there is.
  const double rim = 1 - std::pow((height - 24) / (height - 12), 2);
  EXPECT_NEAR(masked(2), rim, 0.03);
  EXPECT_LT(masked(3), 0.05);
  EXPECT_LT(sent_twice({1, 2, 3, 4}), 0.02);
}

TEST_F(DenseMatcherTest, PosesThatContradictTheImagesAreRefusedAndWhatWasReconstructedBeforeIsNotSentAgain) {
  fly(line(5));
  // Off by two pixels about the baseline.
  for (std::int64_t id = 4; id <= 5; ++id) {
    PoseRecord pose = read<PoseRecord>(id);
    const Mat3 turned = rotation_from_vector(Vec3(2.0 / camera_.fy, 0, 0)) *
                        views_[static_cast<std::size_t>(id - 1)].cam_from_world.rotation;
    quaternion_from_rotation(turned, pose.q_cam_from_world);
    write(pose);
  }
  const std::vector<Status> faults = match();
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].code, StatusCode::rectification_impossible);
  EXPECT_EQ(faults[0].a, 3);
  EXPECT_EQ(faults[0].b, 7) << "poses that contradict the images";
  const auto refused = read<DepthRecord>(3);
  EXPECT_EQ(refused.verdict, DepthVerdict::rectification_impossible);
  EXPECT_EQ(refused.values.bytes, 0U);
  // Its image goes down where no earlier pair has the ground; the next keyframe knows what those have.
  EXPECT_NEAR(masked(3), 0.21, 0.04);
  EXPECT_EQ(read<DepthRecord>(4).verdict, DepthVerdict::ok);
  EXPECT_LT(sent_twice({1, 2, 4, 5}), 0.02);
}

TEST_F(DenseMatcherTest, AnImageHalfInShadowHasDepthWhereItIsLitAndNothingWrongInTheDark) {
  mission.largest_depth_sigma = 1;  // what matches, however well
  fly(line(2));
  // Cast by something far to the right: black but for the light of the sky, and the noise of the sensor.
  repaint(10, 1e9, [](std::uint8_t grey, Rng& noise) { return 4 + grey / 64U + noise.below(3); });
  EXPECT_TRUE(match().empty());
  const std::int32_t edge = static_cast<std::int32_t>(camera_.cx + 10 * camera_.fx / height);
  const Depths lit = depths(1, 70, edge - 8), dark = depths(1, edge + 8, camera_.width);
  EXPECT_GT(lit.valid, 0.97);
  EXPECT_LT(lit.wrong, 0.01);
  EXPECT_LT(dark.valid * dark.wrong, 0.02) << dark.valid << " valid, " << dark.wrong << " of it wrong";
}

TEST_F(DenseMatcherTest, BlankWaterOrSkyHasNoDepthAndTheShoreBesideItHas) {
  mission.largest_depth_sigma = 1;  // what matches, however well
  fly(line(2));
  repaint(10, 1e9, [](std::uint8_t, Rng& noise) { return 199 + noise.below(3); });
  EXPECT_TRUE(match().empty());
  const std::int32_t edge = static_cast<std::int32_t>(camera_.cx + 10 * camera_.fx / height);
  const Depths land = depths(1, 70, edge - 8), blank = depths(1, edge + 8, camera_.width);
  EXPECT_GT(land.valid, 0.97);
  EXPECT_LT(land.wrong, 0.01);
  EXPECT_LT(blank.valid, 0.01);
}

TEST_F(DenseMatcherTest, SmoothGroundBetweenRoughOneIsSupportedAndFlagged) {
  fly(line(2));
  repaint(10, 18, [](std::uint8_t grey, Rng&) { return 128 + (grey - 128) / 48; });
  EXPECT_TRUE(match().empty());
  const std::int32_t edge = static_cast<std::int32_t>(camera_.cx + 10 * camera_.fx / height);
  const Depths smooth = depths(1, edge + 4, static_cast<std::int32_t>(camera_.cx + 18 * camera_.fx / height) - 4);
  EXPECT_GT(smooth.valid, 0.75);  // none of it is matched by windows
  EXPECT_LT(smooth.wrong, 0.01);
  const auto record = read<DepthRecord>(1);
  std::vector<std::uint8_t> sigma(record.sigma.bytes);
  ASSERT_TRUE(read_blob<DepthRecord>(store, "sigma", 1, 0, sigma).ok());
  EXPECT_GT(record.supported, 1000U);
  EXPECT_EQ(record.supported, std::count_if(sigma.begin(), sigma.end(), [](auto code) { return code >= 128; }));
}

TEST_F(DenseMatcherTest, GroundNearerThanTheDisparitiesReachIsCutOffAndSaidSoAndTheRestHasDepth) {
  fly({{0, 0, height}, {60, 0, height}});
  PoseRecord pose = read<PoseRecord>(1);
  pose.min_depth = 20;
  write(pose);
  const std::vector<Status> faults = match();
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].code, StatusCode::disparity_range_exceeded);
  EXPECT_EQ(read<DepthRecord>(1).verdict, DepthVerdict::ok);
  const Depths seen_by_both = depths(1, 200, camera_.width);
  EXPECT_GT(seen_by_both.valid, 0.95);
  EXPECT_LT(seen_by_both.wrong, 0.01);
}

TEST_F(DenseMatcherTest, AStripGoesOnAfterARestartAsIfThereHadBeenNone) {
  fly(line(5));
  fail_pose(3);
  const auto first = std::make_unique<DenseMatcher>(store, mission);
  ASSERT_TRUE(first->restore().ok());
  while (number_of<DepthRecord>() < 2) ASSERT_TRUE(first->step().status.ok());
  EXPECT_TRUE(match().empty());
  EXPECT_LT(masked(3), 0.02);
  EXPECT_LT(sent_twice({1, 2, 3, 4, 5}), 0.02);
}

TEST_F(DenseMatcherTest, TheMissionChoosesTheMatcherAndEitherFindsTheGround) {
  fly(line(2));
  std::vector<std::vector<std::uint8_t>> values;
  for (const StereoMatcherChoice choice : {StereoMatcherChoice::semi_global, StereoMatcherChoice::ordered_scanline}) {
    mission.matcher = choice;
    EXPECT_TRUE(match().empty());
    EXPECT_GT(depths(1, 80, camera_.width - 10).valid, 0.95);
    EXPECT_LT(depths(1, 0, camera_.width).wrong, 0.01);
    values.emplace_back(read<DepthRecord>(1).values.bytes);
    EXPECT_TRUE(read_blob<DepthRecord>(store, "values", 1, 0, values.back()).ok());
    forget_depths();
  }
  EXPECT_NE(values[0], values[1]);
}

TEST_F(DenseMatcherTest, AKeyframeOfAReducedLevelIsMatchedAtHalfTheResolution) {
  fly(line(4));
  for (const std::int64_t id : {std::int64_t{2}, std::int64_t{3}}) {
    auto keyframe = read<KeyframeRecord>(id);
    keyframe.degraded = static_cast<std::uint8_t>(id - 1);
    write(keyframe);
  }
  // What the level is by now is of no matter, and neither is a restart in the middle.
  TimingRecord timing{.degraded = 1};
  write(timing);
  const auto first = std::make_unique<DenseMatcher>(store, mission);
  ASSERT_TRUE(first->restore().ok());
  while (number_of<DepthRecord>() < 2) ASSERT_TRUE(first->step().status.ok());
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(first->step().status.ok());
  timing.degraded = 0;
  write(timing);
  EXPECT_TRUE(match().empty());
  const double full = read<DepthRecord>(1).disparity_per_inverse_depth_px;
  EXPECT_NEAR(read<DepthRecord>(2).disparity_per_inverse_depth_px / full, 1, 0.01);
  EXPECT_NEAR(read<DepthRecord>(3).disparity_per_inverse_depth_px / full, 0.5, 0.01);
  EXPECT_GT(read<DepthRecord>(3).valid, read<DepthRecord>(2).valid * 9 / 10);
  EXPECT_LT(depths(3, 0, camera_.width).wrong, 0.03);
}

TEST_F(DenseMatcherTest, ADescentAtAReducedLevelHasDepthToo) {
  fly(descent(2));
  auto keyframe = read<KeyframeRecord>(1);
  keyframe.degraded = 2;
  write(keyframe);
  EXPECT_TRUE(match().empty());
  EXPECT_EQ(read<DepthRecord>(1).verdict, DepthVerdict::ok);
  EXPECT_GT(depths(1, 0, camera_.width).valid, 0.3);
  EXPECT_LT(depths(1, 0, camera_.width).wrong, 0.2) << "little parallax near the epipole";
}

TEST_F(DenseMatcherTest, AReadThatFailsOnceCostsNoDepth) {
  fly(line(3));
  test::FailingStore failing(store);
  std::set<std::int64_t> failed;
  failing.judge_by([&](const test::FailingStore::Call& call) {
    const bool read = call.kind == test::StoreCall::read_blob && call.type == RecordType::frame;
    return read && failed.insert(call.id).second ? Status{StatusCode::store_error, 10} : Status{};
  });
  const auto matcher = std::make_unique<DenseMatcher>(failing, mission);
  ASSERT_TRUE(matcher->restore().ok());
  run(*matcher, 100000);
  EXPECT_EQ(failed.size(), 3U);
  for (std::int64_t id = 1; id <= 2; ++id) EXPECT_EQ(read<DepthRecord>(id).verdict, DepthVerdict::ok) << id;
  EXPECT_LT(sent_twice({1, 2, 3}), 0.02);
}

TEST_F(DenseMatcherTest, APairThatCanNeverBeReadGetsItsVerdictAndTheNextOneItsDepth) {
  fly(line(4));
  test::FailingStore failing(store);
  std::uint32_t tried = 0;
  failing.judge_by([&](const test::FailingStore::Call& call) {
    const bool hit = call.kind == test::StoreCall::read_blob && call.type == RecordType::frame && call.id == 1;
    tried += hit ? 1 : 0;
    return hit ? Status{StatusCode::store_error, 10} : Status{};
  });
  const auto matcher = std::make_unique<DenseMatcher>(failing, mission);
  ASSERT_TRUE(matcher->restore().ok());
  const std::vector<Status> reported = run(*matcher, 100000);
  EXPECT_EQ(tried, most_read_attempts);
  EXPECT_EQ(reported.back().code, StatusCode::input_given_up);
  EXPECT_EQ(read<DepthRecord>(1).verdict, DepthVerdict::too_few_valid);
  EXPECT_EQ(masked(1), 1.0) << "its image is not lost";
  EXPECT_EQ(read<DepthRecord>(2).verdict, DepthVerdict::ok);
}

TEST_F(DenseMatcherTest, WhatIsOnRecordIsNotMadeAgainBehindADamagedCheckpoint) {
  fly(line(4));
  EXPECT_TRUE(match().empty());
  std::vector<DepthRecord> wanted;
  const std::vector<std::uint8_t> all = all_depths();
  for (std::int64_t id = 1; id <= 4; ++id) wanted.push_back(read<DepthRecord>(id));
  // Its products are made: nothing is left to make it again from.
  for (std::int64_t id = 1; id <= 4; ++id) {
    auto frame = read<FrameRecord>(id);
    frame.image.bytes = 0;
    write(frame);
  }
  for (const bool newer_only : {true, false}) {
    damage_checkpoints(newer_only);
    const auto matcher = std::make_unique<DenseMatcher>(store, mission);
    EXPECT_EQ(matcher->restore().code, newer_only ? StatusCode::checkpoint_older : StatusCode::checkpoint_lost);
    run(*matcher, 1000);
    for (const DepthRecord& depth : wanted) {
      EXPECT_EQ(read<DepthRecord>(depth.id).verdict, depth.verdict);
    }
    EXPECT_EQ(all_depths(), all);
  }
}

}  // namespace
}  // namespace ilp
