#include "sim/ground/map/piece_cache.hpp"

#include <algorithm>

#include "sim/ground/intake/keyframe_rasters.hpp"

namespace ilp::map {
namespace {

std::size_t bytes_of(const SurfaceMesh& mesh) {
  return mesh.vertices.size() * sizeof(mesh.vertices[0]) + mesh.faces.size() * sizeof(mesh.faces[0]);
}

}  // namespace

std::shared_ptr<const SurfaceMesh> PieceCache::held(std::int64_t keyframe_id) {
  const auto found =
      std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) { return entry.id == keyframe_id; });
  if (found == entries_.end()) return nullptr;
  entries_.splice(entries_.begin(), entries_, found);
  return found->surface;
}

std::shared_ptr<const SurfaceMesh> PieceCache::piece(std::int64_t keyframe_id, PixelRays& rays) {
  {
    const std::lock_guard lock(mutex_);
    if (auto surface = held(keyframe_id)) return surface;
  }
  const intake::Keyframe& keyframe = flight_.keyframes.at(keyframe_id);
  const intake::DecodedProducts decoded = intake::decode_products(keyframe);
  auto surface = std::make_shared<const SurfaceMesh>(keyframe_surface(keyframe, decoded.rasters, {}, rays));
  const std::lock_guard lock(mutex_);
  // Another thread may have been faster.
  if (auto theirs = held(keyframe_id)) return theirs;
  entries_.push_front({keyframe_id, surface});
  held_bytes_ += bytes_of(*surface);
  while (held_bytes_ > budget_ && entries_.size() > 1) {
    held_bytes_ -= bytes_of(*entries_.back().surface);
    entries_.pop_back();
  }
  return surface;
}

}  // namespace ilp::map
