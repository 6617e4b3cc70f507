// Keeps painted tiles until their inputs change.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

namespace ilp::intake {

/// The place of a tile in the strip's world depends on the size of its cells only: tile (0, 0) begins at the world's
/// origin and extends to the east and to the south. Data that arrives later moves no tile.
struct TilePlace {
  std::int32_t column = 0, row = 0;
  auto operator<=>(const TilePlace&) const = default;
};

/// A painted tile depends on the keyframes under it, a finished one also on what the whole map says of them.
enum class TileStage : std::uint8_t { painted, finished };

struct TileKey {
  std::int64_t strip_id = 0;
  TilePlace place;
  TileStage stage = TileStage::painted;
  auto operator<=>(const TileKey&) const = default;
};

/// The last version of each tile is kept. All functions may be called from several threads at once.
class TileCache {
 public:
  virtual ~TileCache() = default;
  /// None when the cache has no version of the tile with this digest of its inputs.
  [[nodiscard]] virtual std::optional<std::vector<std::uint8_t>> summary(const TileKey& key, std::uint64_t digest) = 0;
  [[nodiscard]] virtual std::optional<std::vector<std::uint8_t>> cells(const TileKey& key, std::uint64_t digest) = 0;
  virtual void put(const TileKey& key, std::uint64_t digest, std::vector<std::uint8_t> summary,
                   std::vector<std::uint8_t> cells) = 0;
};

class MemoryTileCache : public TileCache {
 public:
  std::optional<std::vector<std::uint8_t>> summary(const TileKey& key, std::uint64_t digest) override;
  std::optional<std::vector<std::uint8_t>> cells(const TileKey& key, std::uint64_t digest) override;
  void put(const TileKey& key, std::uint64_t digest, std::vector<std::uint8_t> summary,
           std::vector<std::uint8_t> cells) override;

 private:
  struct Entry {
    std::uint64_t digest = 0;
    std::vector<std::uint8_t> summary, cells;
  };
  std::mutex mutex_;
  std::map<TileKey, Entry> entries_;
};

}  // namespace ilp::intake
