#include "sim/ground/intake/tile_cache.hpp"

namespace ilp::intake {

std::optional<std::vector<std::uint8_t>> MemoryTileCache::summary(const TileKey& key, std::uint64_t digest) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(key);
  return found == entries_.end() || found->second.digest != digest ? std::nullopt
                                                                   : std::optional(found->second.summary);
}

std::optional<std::vector<std::uint8_t>> MemoryTileCache::cells(const TileKey& key, std::uint64_t digest) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(key);
  return found == entries_.end() || found->second.digest != digest ? std::nullopt : std::optional(found->second.cells);
}

void MemoryTileCache::put(const TileKey& key, std::uint64_t digest, std::vector<std::uint8_t> summary,
                          std::vector<std::uint8_t> cells) {
  const std::lock_guard lock(mutex_);
  entries_[key] = {digest, std::move(summary), std::move(cells)};
}

}  // namespace ilp::intake
