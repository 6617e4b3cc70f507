// The pieces of surface that the tiles at work need, made when first asked for.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>

#include "sim/ground/map/merge.hpp"

namespace ilp::ground {

/// Holds the pieces used last, as many as fit into `bytes`. May be asked from several threads at once.
class PieceCache {
 public:
  PieceCache(const Flight& flight, std::size_t bytes) : flight_(flight), budget_(bytes) {}
  [[nodiscard]] std::shared_ptr<const SurfaceMesh> piece(std::int64_t keyframe_id, PixelRays& rays);

 private:
  struct Entry {
    std::int64_t id = 0;
    std::shared_ptr<const SurfaceMesh> surface;
  };
  [[nodiscard]] std::shared_ptr<const SurfaceMesh> held(std::int64_t keyframe_id);

  const Flight& flight_;
  std::size_t budget_;
  std::mutex mutex_;
  std::list<Entry> entries_;  ///< used last first
  std::size_t held_bytes_ = 0;
};

}  // namespace ilp::ground
