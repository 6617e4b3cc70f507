// Caches pieces of surface for the tiles that are being painted; a piece is made when it is first needed.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>

#include "sim/ground/map/merge.hpp"

namespace ilp::map {

/// Holds the most recently used pieces that fit into `bytes`. Several threads may call it at once.
class PieceCache {
 public:
  PieceCache(const intake::Flight& flight, std::size_t bytes) : flight_(flight), budget_(bytes) {}
  [[nodiscard]] std::shared_ptr<const SurfaceMesh> piece(std::int64_t keyframe_id, PixelRays& rays);

 private:
  struct Entry {
    std::int64_t id = 0;
    std::shared_ptr<const SurfaceMesh> surface;
  };
  [[nodiscard]] std::shared_ptr<const SurfaceMesh> held(std::int64_t keyframe_id);

  const intake::Flight& flight_;
  std::size_t budget_;
  std::mutex mutex_;
  std::list<Entry> entries_;  ///< used last first
  std::size_t held_bytes_ = 0;
};

}  // namespace ilp::map
