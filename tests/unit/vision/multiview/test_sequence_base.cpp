// Keyframes that are matched with an older one than the newest.
#include <gtest/gtest.h>

#include <memory>

#include "tests/unit/vision/multiview/sequence_run.hpp"

namespace ilp {
namespace {

using test::SyntheticStrip;

constexpr std::size_t poor = 5;  ///< index of a keyframe with few matches

/// From corner of keyframe k - 2 to corner of keyframe k, by way of the one between; -1: there is none.
std::vector<int> through_the_one_between(const SyntheticStrip& strip, std::size_t k) {
  std::vector<int> between(strip.keyframes[k - 2].corners.size(), -1), there(between);
  for (const Match& m : strip.keyframes[k - 1].matches) between[m.a] = m.b;
  std::vector<int> next(strip.keyframes[k - 1].corners.size(), -1);
  for (const Match& m : strip.keyframes[k].matches) next[m.a] = m.b;
  for (std::size_t i = 0; i < between.size(); ++i) {
    if (between[i] >= 0) there[i] = next[static_cast<std::size_t>(between[i])];
  }
  return there;
}

/// Matches of keyframe k with the base of keyframe k - 2, which is known by the positions of its corners.
Matches matches_to_base(const SyntheticStrip& strip, std::size_t k, const std::vector<int>& there,
                        const Corners& base) {
  const Corners& older = strip.keyframes[k - 2].corners;
  Matches matches;
  for (std::size_t i = 0; i < base.size(); ++i) {
    for (std::size_t j = 0; j < older.size(); ++j) {
      const bool same = std::hypot(base[i].x - older[j].x, base[i].y - older[j].y) < 0.02F;
      if (!same || there[j] < 0) continue;
      const auto b = static_cast<std::uint16_t>(there[j]);
      const Corner& corner = strip.keyframes[k].corners[b];
      (void)matches.push_back({static_cast<std::uint16_t>(i), b, 0.9F, corner.x, corner.y});
      break;
    }
  }
  return matches;
}

class OlderKeyframe : public ::testing::Test {
 protected:
  OlderKeyframe() {
    scene_.keyframes = 12;
    scene_.wrong = 0;
    scene_.noise_px = 0.1;
    strip_ = std::make_unique<SyntheticStrip>(scene_);
    there_ = through_the_one_between(*strip_, poor + 1);
    // 40 matches remain, which are enough for a pose.
    Matches few;
    for (std::size_t i = 0; i < 40; ++i) (void)few.push_back(strip_->keyframes[poor].matches[7 * i]);
    strip_->keyframes[poor].matches = few;
    strip_->keyframes[poor + 1].matches.clear();
    EXPECT_TRUE(sequence_.begin_strip(strip_->camera, {}).ok());
  }

  SequenceReport add(std::size_t k) {
    const test::StripKeyframe& frame = strip_->keyframes[k];
    SequenceReport report;
    EXPECT_TRUE(
        sequence_.add_keyframe(static_cast<std::int64_t>(100 + k), frame.corners, frame.matches, k, report).ok());
    collect(sequence_, out_);
    return report;
  }
  SequenceReport add_on_the_one_before(std::size_t k, const Matches& matches) {
    EXPECT_TRUE(
        sequence_.begin_keyframe_on(1, static_cast<std::int64_t>(100 + k), strip_->keyframes[k].corners, matches, k)
            .ok());
    while (!sequence_.idle()) EXPECT_TRUE(sequence_.step().ok());
    collect(sequence_, out_);
    return sequence_.report();
  }
  /// The keyframe after the poor one does not match it.
  Corners base_after_the_poor_one() {
    for (std::size_t k = 0; k <= poor; ++k) EXPECT_LE(add(k).verdict, SequenceVerdict::waiting) << k;
    EXPECT_EQ(add(poor + 1).verdict, SequenceVerdict::too_few_matches);
    EXPECT_TRUE(sequence_.can_go_back_to(1));
    Corners base;
    sequence_.corners_of(1, base);
    return base;
  }

  test::StripScene scene_;
  std::unique_ptr<SyntheticStrip> strip_;
  std::vector<int> there_;
  Sequence sequence_{test::sequence_state, test::sequence_workspace};
  test::Collected out_;
};

TEST_F(OlderKeyframe, ItsTracksGoOnAcrossTheNewestOneAndAllPosesAreTrue) {
  const Matches matches = matches_to_base(*strip_, poor + 1, there_, base_after_the_poor_one());
  ASSERT_GT(matches.size(), 150U);
  const SequenceReport report = add_on_the_one_before(poor + 1, matches);
  EXPECT_EQ(report.verdict, SequenceVerdict::ok);
  EXPECT_GT(report.resection_inliers, 150U);
  for (std::size_t k = poor + 2; k < strip_->keyframes.size(); ++k) EXPECT_EQ(add(k).verdict, SequenceVerdict::ok) << k;
  test::end(sequence_);
  collect(sequence_, out_);
  ASSERT_EQ(out_.cameras.size(), strip_->keyframes.size());
  EXPECT_LT(test::worst_error_percent(*strip_, out_), 0.3);

  std::size_t across = 0;
  for (const FinalPoint& point : out_.points) {
    bool before = false, at = false, after = false;
    for (const FinalObservation& seen : point.observations) {
      before = before || seen.keyframe_id == 100 + poor - 1;
      at = at || seen.keyframe_id == 100 + poor;
      after = after || seen.keyframe_id == 100 + poor + 1;
      // An observation that there is not would be far off.
      const auto k = static_cast<std::size_t>(seen.keyframe_id - 100);
      const Vec2 real = pixel_from_ideal(strip_->camera, Vec2(seen.x, seen.y));
      double nearest = 1e9;
      for (const Corner& c : strip_->keyframes[k].corners) {
        nearest = std::min(nearest, std::hypot(real.x() - c.x, real.y() - c.y));
      }
      EXPECT_LT(nearest, 0.02);
    }
    across += before && !at && after ? 1 : 0;
  }
  EXPECT_GT(across, 100U);
}

TEST_F(OlderKeyframe, FewPointsAreNoRelation) {
  const Matches all = matches_to_base(*strip_, poor + 1, there_, base_after_the_poor_one());
  for (const std::size_t count : {30U, 60U}) {
    Matches some;
    for (std::size_t i = 0; i < count; ++i) (void)some.push_back(all[i * all.size() / count]);
    const SequenceReport report = add_on_the_one_before(poor + 1, some);
    EXPECT_EQ(report.known_points, count);
    EXPECT_EQ(report.verdict, count == 30 ? SequenceVerdict::resection_failed : SequenceVerdict::ok);
  }
}

}  // namespace
}  // namespace ilp
