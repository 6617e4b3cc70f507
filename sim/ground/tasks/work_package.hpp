// The input of a task: a file (package) with everything that its work depends on. A task reads neither the catalogue
// nor the outbox, so that it can run on any machine with access to the file. Its memory does not depend on the length
// of the flight.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/map/tile_steps.hpp"

namespace ilp::tasks {

enum class WorkKind : std::uint8_t {
  quick_looks,  ///< decode keyframes and write their pictures
  tiles,        ///< paint tiles
  finish,       ///< finish painted tiles
};
[[nodiscard]] const char* name_of(WorkKind kind);
[[nodiscard]] std::optional<WorkKind> kind_of(const std::string& name);

// Keyframes in packages have only the members that map::keyframe_digest depends on.
struct QuickLookBlock {
  std::int32_t width_px = 0;
  std::vector<intake::Keyframe> keyframes;
};
struct TileBlock {
  std::int64_t strip_id = 0;
  double cell = 0;
  std::vector<map::TilePlan> tiles;
  std::vector<intake::Keyframe> keyframes;  ///< all keyframes of the tiles, in the order of the ids
};
struct FinishBlock {
  std::int64_t strip_id = 0;
  double cell = 0;
  std::vector<map::TileFinish> tiles;
  std::vector<std::vector<std::uint8_t>> painted;  ///< painted cells of each tile, serialised
};
/// A part of a package; a task has one in memory at a time.
using Block = std::variant<QuickLookBlock, TileBlock, FinishBlock>;

/// Writes a package under a temporary name; close() gives the file its name. Both functions throw std::runtime_error if
/// the file cannot be written.
class PackageWriter {
 public:
  explicit PackageWriter(std::filesystem::path file);
  void add(const Block& block);
  void close();

 private:
  std::filesystem::path file_, part_;
  std::ofstream stream_;
};

class PackageReader {
 public:
  /// Throws std::runtime_error if the file cannot be read.
  explicit PackageReader(const std::filesystem::path& file);
  /// The next block; none at the end. Throws std::runtime_error if the package is damaged.
  [[nodiscard]] std::optional<Block> next();

 private:
  std::filesystem::path file_;
  std::ifstream stream_;
};

}  // namespace ilp::tasks
