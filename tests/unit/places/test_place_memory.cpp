// The memory of places over analytic ground that is flown over twice: links, ties, masks, restarts and damage.
#include "fsw/places/place_memory.hpp"

#include <memory>
#include <numeric>

#include "fsw/vision/terrain/mask_coding.hpp"
#include "tests/unit/shared/component_fixture.hpp"
#include "tests/unit/vision/stereo/analytic_scene.hpp"

namespace ilp {
namespace {

constexpr double height = 100;
constexpr double step = 20;           // of an image that shows 105 of the ground
constexpr double second_unit = 0.25;  // metres are units of the first strip; the second one's are four metres long

double gentle(double x, double y) {
  return 3 * std::sin(x / 17) * std::cos(y / 13);
}

class PlaceMemoryTest : public test::ComponentTest {
 protected:
  PlaceMemoryTest() {
    camera_ = test::distorting_camera();
    write(camera_record(camera_));
  }

  /// A keyframe with depth everywhere and all of its image new. Its strip's world is turned, moved and in another unit.
  void see(std::int64_t id, std::int64_t strip, std::int32_t index, const RigidTransform& cam_from_ground,
           const Similarity& strip_from_ground, std::uint64_t noise_seed) {
    const test::View view = test::render_view(camera_, cam_from_ground, gentle, 2, 1, noise_seed);
    KeyframeRecord keyframe;
    keyframe.id = keyframe.frame_id = id;
    keyframe.strip_id = strip;
    keyframe.index = index;
    write(keyframe);
    write_frame(id, view.image);
    const Similarity cam_from_strip = compose(Similarity{Mat3::Identity(), Vec3::Zero(), strip_from_ground.scale},
                                              compose(similarity_from(cam_from_ground), inverse(strip_from_ground)));
    RigidTransform rigid{cam_from_strip.rotation, cam_from_strip.translation};
    const Pose pose = pose_from(rigid);
    PoseRecord posed;
    posed.id = id;
    posed.strip_id = strip;
    posed.state = PoseState::final;
    std::copy_n(pose.q_cam_from_world, 4, posed.q_cam_from_world);
    std::copy_n(pose.centre, 3, posed.centre);
    write(posed);
    write_depth(id, strip, view, strip_from_ground.scale);
  }

  void write_depth(std::int64_t id, std::int64_t strip, const test::View& view, double unit) {
    const std::size_t area = view.depth.size();
    std::vector<float> inverse(area);
    for (std::size_t i = 0; i < area; ++i) inverse[i] = static_cast<float>(1 / (unit * view.depth[i]));
    std::vector<float> sigma(area);
    for (std::size_t i = 0; i < area; ++i) sigma[i] = 0.002F * inverse[i];
    const ImageView<const float> inverse_view(inverse.data(), camera_.width, camera_.height);
    const ImageView<const float> sigma_view(sigma.data(), camera_.width, camera_.height);
    const auto cells = std::make_unique<SeenCells>();
    const auto depths = std::make_unique<CellDepths>();
    ASSERT_TRUE(seen_cells(inverse_view, sigma_view, camera_.fx, 16, *cells).ok());
    ASSERT_TRUE(cell_depths(inverse_view, sigma_view, 16, *depths).ok());
    const std::size_t count = static_cast<std::size_t>(cells->columns) * static_cast<std::size_t>(cells->rows);
    std::vector<std::uint8_t> bytes(cells->quality.begin(),
                                    cells->quality.begin() + static_cast<std::ptrdiff_t>(count));
    const auto* depth_bytes = reinterpret_cast<const std::uint8_t*>(depths->data());
    bytes.insert(bytes.end(), depth_bytes, depth_bytes + count * sizeof(float));
    std::vector<std::uint8_t> mask(area, 255);
    std::vector<std::uint8_t> coded(max_mask_bytes(area));
    std::size_t coded_bytes = 0;
    ASSERT_TRUE(
        encode_mask({mask.data(), camera_.width, camera_.height}, coded.data(), coded.size(), coded_bytes).ok());
    coded.resize(coded_bytes);
    DepthRecord depth;
    depth.id = id;
    depth.strip_id = strip;
    depth.width = camera_.width;
    depth.height = camera_.height;
    depth.newly_seen = static_cast<std::uint32_t>(area);
    depth.mask.bytes = static_cast<std::uint32_t>(coded.size());
    depth.cells.bytes = static_cast<std::uint32_t>(bytes.size());
    write(depth, "mask", coded);
    Transaction transaction(store);
    ASSERT_TRUE(transaction.begin().ok());
    ASSERT_TRUE(write_blob<DepthRecord>(store, "cells", id, 0, bytes).ok());
    ASSERT_TRUE(transaction.commit().ok());
  }

  /// Keyframes 1 to 6 fly along x; 7 to 10 fly back over them, turned by 2 rad, as a strip with its own world.
  void fly_out() {
    for (std::int64_t id = 1; id <= 6; ++id) {
      see(id, 1, static_cast<std::int32_t>(id - 1), test::looking_down(Vec3(step * static_cast<double>(id), 0, height)),
          Similarity{}, static_cast<std::uint64_t>(id));
    }
  }
  void fly_back() {
    for (std::int64_t id = 7; id <= 10; ++id) {
      see(id, 2, static_cast<std::int32_t>(id - 7),
          test::looking_down(Vec3(step * static_cast<double>(13 - id), 5, 1.1 * height), Vec3(0, 0, 2)), second_,
          static_cast<std::uint64_t>(id));
    }
  }

  std::unique_ptr<PlaceMemory> memory() {
    auto stage = std::make_unique<PlaceMemory>(store, mission, *harris_, *scratch_);
    EXPECT_TRUE(restored(stage->restore()));
    return stage;
  }
  std::vector<LinkRecord> links() {
    std::vector<LinkRecord> all;
    LinkRecord link;
    while (next(store, link.id, link).ok()) all.push_back(link);
    return all;
  }
  std::vector<std::uint8_t> mask_of(std::int64_t id) {
    const DepthRecord depth = read<DepthRecord>(id);
    std::vector<std::uint8_t> coded(depth.mask.bytes);
    EXPECT_TRUE(read_blob<DepthRecord>(store, "mask", id, 0, coded).ok());
    std::vector<std::uint8_t> mask(static_cast<std::size_t>(depth.width * depth.height));
    EXPECT_TRUE(decode_mask(coded.data(), coded.size(), {mask.data(), depth.width, depth.height}).ok());
    return mask;
  }
  std::uint32_t new_pixels(std::int64_t id) {
    std::uint32_t count = 0;
    for (const std::uint8_t pixel : mask_of(id)) count += pixel != 0 ? 1 : 0;
    return count;
  }

  CameraModel camera_;
  /// From the first strip's world, which is the ground's.
  Similarity second_{rotation_from_vector(Vec3(0.1, -0.2, 0.7)), Vec3(3, 1, -2), second_unit};
  std::unique_ptr<HarrisWorkspace> harris_ = std::make_unique<HarrisWorkspace>();
  std::unique_ptr<PlaceScratch> scratch_ = std::make_unique<PlaceScratch>();
};

TEST_F(PlaceMemoryTest, GroundOfAnEarlierStripIsKnownAgainAndTheStripsAreTied) {
  fly_out();
  fly_back();
  const auto stage = memory();
  EXPECT_TRUE(run(*stage).empty());
  EXPECT_EQ(number_of<PlaceRecord>(), 10);
  EXPECT_EQ(read<PlaceRecord>(6).links, 0U) << "neighbours in a strip are not compared";
  for (std::int64_t id = 7; id <= 10; ++id) {
    EXPECT_GE(read<PlaceRecord>(id).links, 2U) << id;
    const DepthRecord depth = read<DepthRecord>(id);
    EXPECT_EQ(depth.newly_seen, new_pixels(id));
    EXPECT_LT(depth.newly_seen, 0.45 * 320 * 240) << id;
    EXPECT_EQ(depth.newly_seen + read<PlaceRecord>(id).known_before, 320U * 240U);
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

TEST_F(PlaceMemoryTest, ARestartKnowsTheSamePlacesAgain) {
  fly_out();
  run(*memory());
  fly_back();
  run(*memory());
  const std::vector<LinkRecord> after_restart = links();
  const std::vector<std::uint8_t> mask = mask_of(9);

  std::destroy_at(&store);
  std::construct_at(&store, region);
  write(camera_record(camera_));
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

// Keyframe 13 comes back to the ground of the first three, whose features are lost. Those between saw other ground.
TEST_F(PlaceMemoryTest, WithoutALinkThePosesOfTheStripSayWhatIsKnownIfTheirErrorsAreSmall) {
  const auto state_errors = [&](std::int64_t id, double sigma) {
    PoseRecord pose = read<PoseRecord>(id);
    for (const int element : {9, 14, 20}) pose.covariance[element] = sigma * sigma;
    write(pose);
  };
  const auto new_share = [&](double sigma) {
    std::destroy_at(&store);
    std::construct_at(&store, region);
    write(camera_record(camera_));
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

TEST_F(PlaceMemoryTest, PlacesBeyondTheirNumberAreForgotten) {
  mission.places_kept = 64;
  see(1, 1, 0, test::looking_down(Vec3(0, 0, height)), Similarity{}, 1);
  run(*memory());
  const auto stage = memory();
  for (std::int64_t id = 2; id <= 80; ++id) {
    // The same image again and again.
    see(id, 1, static_cast<std::int32_t>(id - 1), test::looking_down(Vec3(0, 0, height)), Similarity{}, 1);
    run(*stage);
  }
  EXPECT_EQ(number_of<PlaceRecord>(), 64);
  PlaceRecord newest;
  ASSERT_TRUE(last(store, newest).ok());
  EXPECT_EQ(newest.id, 80);
  EXPECT_LT(new_pixels(80), 10U) << "nothing about it is new";
}

}  // namespace
}  // namespace ilp
