// A chain of keyframes in which one is a bad image, or the ground changes: which keyframes have poses, and how exact
// these are.
#include <cmath>

#include "tests/support/alignment.hpp"
#include "tests/unit/motion/structure_fixture.hpp"

namespace ilp {
namespace {

using test::height;
using test::keyframes;
using test::step_m;
using test::views;
using Views = std::vector<test::View>;

constexpr std::int64_t bad = 5;

Vec3 place(std::int64_t id) {
  return {step_m * static_cast<double>(id - 1), 0.5 * static_cast<double>(id % 3), height};
}

void blank(test::Image& image) {
  std::fill(image.pixels.begin(), image.pixels.end(), std::uint8_t{128});
}

/// A mean over 31 px along the flight.
void blur(test::Image& image) {
  constexpr std::int32_t reach = 15;
  const test::Image sharp = image;
  const std::int32_t width = image.view().width, rows = image.view().height;
  for (std::int32_t y = 0; y < rows; ++y) {
    for (std::int32_t x = 0; x < width; ++x) {
      int sum = 0;
      for (std::int32_t k = -reach; k <= reach; ++k) sum += sharp.view().at(std::clamp(x + k, 0, width - 1), y);
      image.view().at(x, y) = static_cast<std::uint8_t>(sum / (2 * reach + 1));
    }
  }
}

/// A cloud with a texture of its own leaves the left part of the image.
void cloud_behind(test::Image& image, std::int32_t percent) {
  const std::int32_t width = image.view().width;
  for (std::int32_t y = 0; y < image.view().height; ++y) {
    for (std::int32_t x = width * percent / 100; x < width; ++x) {
      const double grey = 150 + 0.6 * (test::fractal_texture(x, y, 3, 77) - 128);
      image.view().at(x, y) = static_cast<std::uint8_t>(std::clamp(grey, 0.0, 255.0));
    }
  }
}

/// The next keyframe sees a strip of the ground that is left.
void cloud(test::Image& image) {
  cloud_behind(image, 22);
}

/// The views, of which one has another image.
template <void (*spoil)(test::Image&)>
const Views& with_bad_image() {
  static const Views seen = [] {
    Views made = views();
    spoil(made[bad - 1].image);
    return made;
  }();
  return seen;
}

/// A cloud leaves 30 % of a keyframe, and the wide step after it leads past this ground.
const Views& with_a_wide_step() {
  static const Views seen = [] {
    Views made = views();
    cloud_behind(made[bad - 1].image, 30);
    for (std::int64_t id = bad + 1; id <= keyframes; ++id) {
      made[static_cast<std::size_t>(id - 1)] =
          test::render_view(test::distorting_camera(), test::looking_down(place(id) + Vec3(20, 0, 0)), test::rugged, 2,
                            1, static_cast<std::uint64_t>(id));
    }
    return made;
  }();
  return seen;
}

class BrokenChain : public test::StructureFixture {
 protected:
  explicit BrokenChain(const Views& seen) : StructureFixture(seen) {}

  void fly() { run_to_the_end(); }
  /// Worst error of the centres in per cent of the track, without that of the bad keyframe.
  [[nodiscard]] double worst_error_percent() {
    std::vector<Eigen::Vector3d> found, truth;
    for (std::int64_t id = 1; id <= keyframes; ++id) {
      if (id == bad || state(id) != PoseState::final) continue;
      const auto pose = read<PoseRecord>(id);
      found.emplace_back(pose.centre[0], pose.centre[1], pose.centre[2]);
      truth.push_back(test::centre_of(seen_[static_cast<std::size_t>(id - 1)].cam_from_world));
    }
    return 100 * test::alignment_errors(found, truth).worst / (truth.back() - truth.front()).norm();
  }
  void expect_all_but_the_bad_one() {
    for (std::int64_t id = 1; id <= keyframes; ++id) {
      if (id == bad) continue;
      EXPECT_EQ(state(id), PoseState::final) << id;
    }
    EXPECT_EQ(strip_ends_commanded(), 0);
    // Without a bad image it is 0.023 %.
    EXPECT_LT(worst_error_percent(), 0.035);
  }
};

class UnbrokenChain : public BrokenChain {
 protected:
  UnbrokenChain() : BrokenChain(views()) {}
};
class BlankKeyframe : public BrokenChain {
 protected:
  BlankKeyframe() : BrokenChain(with_bad_image<blank>()) {}
};
class BlurredKeyframe : public BrokenChain {
 protected:
  BlurredKeyframe() : BrokenChain(with_bad_image<blur>()) {}
};
class KeyframeWithoutRelation : public BrokenChain {
 protected:
  KeyframeWithoutRelation() : BrokenChain(with_a_wide_step()) {}
};
class CloudyKeyframe : public BrokenChain {
 protected:
  CloudyKeyframe() : BrokenChain(with_bad_image<cloud>()) {}
};

TEST_F(UnbrokenChain, IsTheMeasureOfTheOthers) {
  fly();
  expect_all_but_the_bad_one();
}

TEST_F(BlankKeyframe, DoesNotEndTheStripAndThePosesAfterItAreAsExact) {
  fly();
  EXPECT_EQ(state(bad), PoseState::failed);
  expect_all_but_the_bad_one();
}

TEST_F(BlurredKeyframe, DoesNotEndTheStripAndThePosesAfterItAreAsExact) {
  fly();
  expect_all_but_the_bad_one();
}

TEST_F(KeyframeWithoutRelation, TheOneAfterItIsRelatedToTheOneBefore) {
  fly();
  EXPECT_EQ(state(bad), PoseState::final);
  expect_all_but_the_bad_one();
  EXPECT_EQ(read<PoseRecord>(bad + 1).verdict, PoseVerdict::ok);
}

TEST_F(CloudyKeyframe, WhereTheNextOneDoesNotMatchItTheNextOneIsRelatedToTheOneBefore) {
  fly();
  EXPECT_EQ(state(bad), PoseState::final) << "it is related by the ground beside the cloud";
  expect_all_but_the_bad_one();
}

TEST_F(CloudyKeyframe, RestartedInTheMiddleOfEveryKeyframeItLeavesTheSameRecords) {
  const Result wanted = undisturbed();
  fly_in_short_boots();
  EXPECT_EQ(result(), wanted);
}

TEST_F(CloudyKeyframe, WhereTheOneBeforeCannotBeReadAnyMoreTheNextOlderOneServes) {
  test::ExecutedComponent run(*component, store);
  ASSERT_TRUE(run.start().ok());
  run_until(run, store, bad);
  release_image(bad - 1);
  ASSERT_TRUE(run.run());
  expect_all_but_the_bad_one();
}

TEST_F(CloudyKeyframe, AReadOfAnImageMayFail) {
  const Result wanted = undisturbed();
  std::int64_t reads = 0;
  failing.judge_by([&](const test::FailingStore::Call& call) {
    const bool read = call.type == RecordType::frame && call.kind == test::StoreCall::read_blob;
    return read && ++reads % 5 == 0 ? Status{StatusCode::store_error, 10} : Status{};
  });
  fly();
  EXPECT_GE(reads, 10) << "more than one failed";
  EXPECT_EQ(result(), wanted);
}

/// Crests that look alike, over ground that is the same nowhere.
test::View over_dunes(const Vec3& centre, std::uint64_t seed) {
  const auto crests = [](double x, double y) { return 2 * std::sin(0.45 * x + std::sin(y / 25)); };
  const CameraModel camera = test::distorting_camera();
  test::View view{camera, test::looking_down(centre), test::Image(camera.width, camera.height), {}};
  for (std::int32_t y = 0; y < camera.height; ++y) {
    for (std::int32_t x = 0; x < camera.width; ++x) {
      const Vec3 ground = test::ground_point(camera, view.cam_from_world, crests, x, y);
      const double shade = 70 * std::cos(0.45 * ground.x() + std::sin(ground.y() / 25));
      const double grain = 0.35 * (test::fractal_texture(2 * ground.x(), 2 * ground.y(), 3, seed) - 128);
      view.image.view().at(x, y) = static_cast<std::uint8_t>(std::clamp(128.5 + shade + grain, 0.0, 255.0));
    }
  }
  return view;
}

/// From the fifth keyframe on the ground is another one, and nothing says so.
const Views& other_ground() {
  static const Views seen = [] {
    Views made = views();
    for (std::int64_t id = bad; id <= keyframes; ++id) {
      const auto at = static_cast<std::size_t>(id - 1);
      const test::View there =
          test::render_view(test::distorting_camera(), test::looking_down(place(id) + Vec3(5000, 3000, 0)),
                            test::rugged, 2, 1, static_cast<std::uint64_t>(id));
      made[at].image = there.image;
    }
    return made;
  }();
  return seen;
}
const Views& other_dunes() {
  static const Views seen = [] {
    Views made;
    for (std::int64_t id = 1; id <= keyframes; ++id) made.push_back(over_dunes(place(id), id < bad ? 11 : 12));
    return made;
  }();
  return seen;
}

class OtherGround : public BrokenChain {
 protected:
  OtherGround() : BrokenChain(other_ground()) {}
};
class OtherDunes : public BrokenChain {
 protected:
  OtherDunes() : BrokenChain(other_dunes()) {}
};

TEST_F(OtherGround, EndsTheStripAndHasNoPose) {
  fly();
  for (std::int64_t id = 1; id <= keyframes; ++id) {
    EXPECT_EQ(state(id), id < bad ? PoseState::final : PoseState::failed) << id;
  }
  EXPECT_EQ(strip_ends_commanded(), 1);
}

TEST_F(OtherGround, WhereTheOldestOneCannotBeReadTheStateIsNotTakenForDamaged) {
  test::ExecutedComponent run(*component, store);
  ASSERT_TRUE(run.start().ok());
  run_until(run, store, bad - 1);
  // The bad one is tried against the newest posed keyframe, the one before, and this one.
  release_image(bad - 3);
  ASSERT_TRUE(run.run());
  for (std::int64_t id = 1; id <= keyframes; ++id) {
    EXPECT_EQ(state(id), id < bad ? PoseState::final : PoseState::failed) << id;
  }
  EXPECT_TRUE(test::events_of(store, StatusCode::memory_damaged).empty());
}

TEST_F(OtherDunes, EndTheStripAndHaveNoPose) {
  fly();
  for (std::int64_t id = 1; id <= keyframes; ++id) {
    EXPECT_EQ(state(id), id < bad ? PoseState::final : PoseState::failed) << id;
  }
  EXPECT_EQ(strip_ends_commanded(), 1);
}

}  // namespace
}  // namespace ilp
