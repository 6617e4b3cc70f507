#include "sim/tools/score/true_frames.hpp"

namespace ilp::score {

std::optional<world::TrueFrame> TrueFrames::load(const std::string& name, std::int32_t stride) const {
  const report::ReferencePose* pose = reference_.pose(name);
  if (pose == nullptr) return std::nullopt;
  const host::Raster<float> depth = reference_.depth(name);
  if (depth.empty() || !depth.same_size(camera_.width, camera_.height)) return std::nullopt;
  return world::true_frame(camera_, pose->cam_from_world, pose->centre, depth.view(), stride);
}

const world::TrueFrame* TrueFrames::sampled(const std::string& name) {
  const auto known = sampled_.find(name);
  if (known != sampled_.end()) return known->second.get();
  auto frame = load(name, world::sample_stride(camera_));
  auto& kept = sampled_[name];
  if (frame) kept = std::make_unique<world::TrueFrame>(std::move(*frame));
  return kept.get();
}

std::optional<world::TrueFrame> TrueFrames::whole(const std::string& name) const {
  return load(name, 1);
}

std::vector<KeyframeTruth> keyframes_with_truth(const intake::Flight& flight, TrueFrames& truth) {
  std::vector<KeyframeTruth> known;
  for (const auto& [id, keyframe] : flight.keyframes) {
    if (const world::TrueFrame* frame = truth.sampled(keyframe.name)) known.push_back({&keyframe, frame});
  }
  return known;
}

}  // namespace ilp::score
