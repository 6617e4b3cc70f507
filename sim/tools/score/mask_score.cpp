#include "sim/tools/score/mask_score.hpp"

#include <cmath>
#include <vector>

namespace ilp::score {
namespace {

/// The next posed keyframe of the same strip.
const world::TrueFrame* next_in_strip(std::span<const KeyframeTruth> members, std::size_t k) {
  for (std::size_t next = k + 1; next < members.size(); ++next) {
    const intake::Keyframe& keyframe = *members[next].keyframe;
    if (keyframe.posed() && keyframe.strip_id == members[k].keyframe->strip_id) return members[next].frame;
  }
  return nullptr;
}

/// The frame that the keyframe was matched with; null when it was with none.
const world::TrueFrame* partner_of(const intake::Flight& flight, const intake::Keyframe& keyframe, TrueFrames& truth) {
  if (!keyframe.depth || keyframe.depth->verdict != DepthVerdict::ok) return nullptr;
  const auto partner = flight.keyframes.find(keyframe.depth->partner_id);
  return partner == flight.keyframes.end() ? nullptr : truth.sampled(partner->second.name);
}

bool claimed(const KeyframeTruth& earlier, const Vec3& point) {
  Vec2 pixel;
  double depth = 0;
  if (!world::sees(*earlier.frame, point) || !world::project(*earlier.frame, point, pixel, depth)) return false;
  const auto x = static_cast<std::int32_t>(std::floor(pixel.x() + 0.5));
  const auto y = static_cast<std::int32_t>(std::floor(pixel.y() + 0.5));
  const host::Raster<std::uint8_t>& mask = earlier.keyframe->mask;
  return mask.contains(x, y) && mask.at(x, y) != 0;
}

std::size_t count_double_coded(const intake::Keyframe& keyframe, const world::TrueFrame& whole,
                               std::span<const KeyframeTruth> earlier) {
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

bool is_set(const host::Raster<std::uint8_t>& mask, std::size_t i) {
  return mask.samples[i] != 0;
}

/// `fresh`: what no earlier pair has seen.
void count_bytes(const intake::Keyframe& keyframe, const host::Raster<std::uint8_t>& fresh, MaskScore& score) {
  for (const ProductKind kind : {ProductKind::image, ProductKind::depth}) {
    if (const auto& product = keyframe.product(kind)) score.bytes += product->bytes;
  }
  const bool masked = keyframe.mask.same_size(fresh.width, fresh.height);
  std::size_t sent = 0, sent_again = 0, again = 0;
  for (std::size_t i = 0; i < fresh.samples.size(); ++i) {
    const bool known = !is_set(fresh, i);
    again += known ? 1U : 0U;
    if (masked && !is_set(keyframe.mask, i)) continue;
    ++sent;
    sent_again += known ? 1U : 0U;
  }
  // What is sent beside an empty mask shows the whole image.
  const auto part = static_cast<double>(sent > 0 ? sent_again : again);
  score.bytes_again =
      static_cast<double>(score.bytes) * part / static_cast<double>(sent > 0 ? sent : fresh.samples.size());
}

host::Raster<std::uint8_t> also_seen_by(const world::TrueFrame* partner, const world::TrueFrame& whole,
                                        host::Raster<std::uint8_t> fresh) {
  if (partner == nullptr) return fresh;
  for (std::size_t i = 0; i < fresh.samples.size(); ++i) {
    if (is_set(fresh, i) && !world::sees(*partner, whole.ground[i])) fresh.samples[i] = 0;
  }
  return fresh;
}

void count_pixels(const intake::Keyframe& keyframe, const host::Raster<std::uint8_t>& seen, MaskScore& score) {
  for (std::size_t i = 0; i < seen.samples.size(); ++i) {
    const bool mask = is_set(keyframe.mask, i), fresh = is_set(seen, i);
    score.masked += mask ? 1U : 0U;
    score.newly_seen += fresh ? 1U : 0U;
    score.both += mask && fresh ? 1U : 0U;
  }
}

void count_depths(const intake::Keyframe& keyframe, const host::Raster<std::uint8_t>& due, MaskScore& score) {
  const bool has_depth = keyframe.inverse_depth.same_size(due.width, due.height);
  for (std::size_t i = 0; i < due.samples.size(); ++i) {
    if (!is_set(due, i)) continue;
    ++score.expected;
    score.with_depth += has_depth && keyframe.inverse_depth.samples[i] > 0 ? 1U : 0U;
  }
}

}  // namespace

void MaskScore::add(const MaskScore& other) {
  masked += other.masked;
  newly_seen += other.newly_seen;
  both += other.both;
  bytes += other.bytes;
  bytes_again += other.bytes_again;
  double_coded += other.double_coded;
  expected += other.expected;
  with_depth += other.with_depth;
}

std::map<std::int64_t, MaskScore> score_masks(const intake::Flight& flight, TrueFrames& truth) {
  std::map<std::int64_t, MaskScore> scores;
  const std::vector<KeyframeTruth> members = keyframes_with_truth(flight, truth);
  std::vector<world::FramePair> pairs;
  for (std::size_t k = 0; k < members.size(); ++k) {
    const intake::Keyframe& keyframe = *members[k].keyframe;
    const world::TrueFrame* partner = partner_of(flight, keyframe, truth);
    const auto whole = truth.whole(keyframe.name);
    const bool masked = whole && keyframe.posed() && keyframe.mask.same_size(whole->columns, whole->rows);
    const bool sent = keyframe.product(ProductKind::image) || keyframe.product(ProductKind::depth);
    if (whole && (masked || sent)) {
      MaskScore& score = scores[keyframe.id];
      const auto fresh = world::newly_seen_mask(*whole, nullptr, pairs, finer_sampling);
      count_bytes(keyframe, fresh, score);
      if (masked) {
        count_pixels(keyframe, also_seen_by(partner, *whole, fresh), score);
        score.double_coded = count_double_coded(keyframe, *whole, std::span(members).first(k));
        if (const world::TrueFrame* next = next_in_strip(members, k)) {
          count_depths(keyframe, also_seen_by(next, *whole, fresh), score);
        }
      }
    }
    if (partner != nullptr && keyframe.posed()) pairs.push_back({members[k].frame, partner});
  }
  return scores;
}

}  // namespace ilp::score
