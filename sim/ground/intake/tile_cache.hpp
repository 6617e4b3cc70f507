// A cache for the tiles of maps, which are valid until their inputs change.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

namespace ilp::intake {

/// Position of a tile in the strip's world, counted in tiles. Tile (0, 0) has its north-west corner at the world's
/// origin; columns count to the east, rows to the south. The grid of tiles depends on the cell size only, so that later
/// data do not move tiles.
struct TilePlace {
  std::int32_t column = 0, row = 0;
  auto operator<=>(const TilePlace&) const = default;
};

/// Steps of a tile (map/tile_steps.hpp). A painted tile depends on the keyframes that touch it; a finished tile also
/// depends on the balance, and so on the whole map.
enum class TileStage : std::uint8_t { painted, finished };

struct TileKey {
  std::int64_t strip_id = 0;
  TilePlace place;
  TileStage stage = TileStage::painted;
  auto operator<=>(const TileKey&) const = default;
};

/// Keeps the last version of each tile. All functions may be called from several threads at once.
class TileCache {
 public:
  virtual ~TileCache() = default;
  /// Bytes of the tile's summary; none if the cache has no version of the tile with this digest of its inputs.
  [[nodiscard]] virtual std::optional<std::vector<std::uint8_t>> summary(const TileKey& key, std::uint64_t digest) = 0;
  /// Bytes of the tile's cells; none as above.
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
