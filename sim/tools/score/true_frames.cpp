#include "sim/tools/score/true_frames.hpp"

namespace ilp::score {

std::optional<sim::TrueFrame> TrueFrames::load(const std::string& name, std::int32_t stride) const {
  const ground::ReferencePose* pose = reference_.pose(name);
  if (pose == nullptr) return std::nullopt;
  const ground::Raster<float> depth = reference_.depth(name);
  if (depth.empty() || !depth.same_size(camera_.width, camera_.height)) return std::nullopt;
  return sim::true_frame(camera_, pose->cam_from_world, pose->centre, depth.view(), stride);
}

const sim::TrueFrame* TrueFrames::sampled(const std::string& name) {
  const auto known = sampled_.find(name);
  if (known != sampled_.end()) return known->second.get();
  auto frame = load(name, sim::sample_stride(camera_));
  auto& kept = sampled_[name];
  if (frame) kept = std::make_unique<sim::TrueFrame>(std::move(*frame));
  return kept.get();
}

std::optional<sim::TrueFrame> TrueFrames::whole(const std::string& name) const {
  return load(name, 1);
}

}  // namespace ilp::score
