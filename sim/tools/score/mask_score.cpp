#include "sim/tools/score/mask_score.hpp"

#include <cmath>
#include <vector>

namespace ilp::score {
namespace {

struct Member {
  const intake::Keyframe* keyframe = nullptr;
  const world::TrueFrame* frame = nullptr;
};

std::vector<Member> members_of(const intake::Flight& flight, const intake::Strip& strip, TrueFrames& truth) {
  std::vector<Member> members;
  for (const std::int64_t id : strip.keyframes) {
    const intake::Keyframe& keyframe = flight.keyframes.at(id);
    if (!keyframe.posed()) continue;
    if (const world::TrueFrame* frame = truth.sampled(keyframe.name)) members.push_back({&keyframe, frame});
  }
  return members;
}

/// The frame that the keyframe was matched with; null when it was with none.
const world::TrueFrame* partner_of(const intake::Flight& flight, const intake::Keyframe& keyframe, TrueFrames& truth) {
  if (!keyframe.depth || keyframe.depth->verdict != DepthVerdict::ok) return nullptr;
  const auto partner = flight.keyframes.find(keyframe.depth->partner_id);
  return partner == flight.keyframes.end() ? nullptr : truth.sampled(partner->second.name);
}

bool claimed(const Member& earlier, const Vec3& point) {
  Vec2 pixel;
  double depth = 0;
  if (!world::sees(*earlier.frame, point) || !world::project(*earlier.frame, point, pixel, depth)) return false;
  const auto x = static_cast<std::int32_t>(std::floor(pixel.x() + 0.5));
  const auto y = static_cast<std::int32_t>(std::floor(pixel.y() + 0.5));
  const host::Raster<std::uint8_t>& mask = earlier.keyframe->mask;
  return mask.contains(x, y) && mask.at(x, y) != 0;
}

std::size_t count_double_coded(const intake::Keyframe& keyframe, const world::TrueFrame& whole,
                               std::span<const Member> earlier) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < whole.ground.size(); ++i) {
    if (keyframe.mask.samples[i] == 0) continue;
    for (auto other = earlier.rbegin(); other != earlier.rend(); ++other) {
      if (!claimed(*other, whole.ground[i])) continue;
      ++count;
      break;
    }
  }
  return count;
}

}  // namespace

void MaskScore::add(const MaskScore& other) {
  masked += other.masked;
  newly_seen += other.newly_seen;
  both += other.both;
  double_coded += other.double_coded;
  expected += other.expected;
  with_depth += other.with_depth;
}

std::map<std::int64_t, MaskScore> score_masks(const intake::Flight& flight, const intake::Strip& strip,
                                              TrueFrames& truth) {
  std::map<std::int64_t, MaskScore> scores;
  const std::vector<Member> members = members_of(flight, strip, truth);
  std::vector<world::FramePair> pairs;
  for (std::size_t k = 0; k < members.size(); ++k) {
    const intake::Keyframe& keyframe = *members[k].keyframe;
    const world::TrueFrame* partner = partner_of(flight, keyframe, truth);
    const auto whole = truth.whole(keyframe.name);
    if (whole && keyframe.mask.same_size(whole->columns, whole->rows)) {
      MaskScore& score = scores[keyframe.id];
      const host::Raster<std::uint8_t> seen = world::newly_seen_mask(*whole, partner, pairs);
      for (std::size_t i = 0; i < seen.samples.size(); ++i) {
        const bool mask = keyframe.mask.samples[i] != 0, fresh = seen.samples[i] != 0;
        score.masked += mask ? 1U : 0U;
        score.newly_seen += fresh ? 1U : 0U;
        score.both += mask && fresh ? 1U : 0U;
      }
      score.double_coded = count_double_coded(keyframe, *whole, std::span(members).first(k));
      if (k + 1 < members.size()) {
        const bool as_matched = partner == members[k + 1].frame;
        const auto due = as_matched ? seen : world::newly_seen_mask(*whole, members[k + 1].frame, pairs);
        const bool has_depth = keyframe.inverse_depth.same_size(due.width, due.height);
        for (std::size_t i = 0; i < due.samples.size(); ++i) {
          if (due.samples[i] == 0) continue;
          ++score.expected;
          score.with_depth += has_depth && keyframe.inverse_depth.samples[i] > 0 ? 1U : 0U;
        }
      }
    }
    if (partner != nullptr) pairs.push_back({members[k].frame, partner});
  }
  return scores;
}

}  // namespace ilp::score
