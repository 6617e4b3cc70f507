// What a task is given: a file with all that its work depends on. A task reads neither the catalogue nor the outbox, so
// that it may run on any machine that sees the file, and so that it needs as much memory for a long flight as for a
// short one.
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

/// Of a keyframe, packages hold what map::keyframe_digest depends on.
struct QuickLookBlock {
  std::int32_t width_px = 0;
  std::vector<intake::Keyframe> keyframes;
};
struct TileBlock {
  std::int64_t strip_id = 0;
  double cell = 0;
  std::vector<map::TilePlan> tiles;
  std::vector<intake::Keyframe> keyframes;  ///< of the tiles, by id
};
struct FinishBlock {
  std::int64_t strip_id = 0;
  double cell = 0;
  std::vector<map::TileFinish> tiles;
  std::vector<std::vector<std::uint8_t>> painted;  ///< cells of each, as painted
};
/// A task holds one block of its package at a time.
using Block = std::variant<QuickLookBlock, TileBlock, FinishBlock>;

/// The file has its name from `close` on only. Both functions throw std::runtime_error when it cannot be written.
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
  /// Throws std::runtime_error when the file cannot be read.
  explicit PackageReader(const std::filesystem::path& file);
  /// None at the end. Throws std::runtime_error when the package is damaged.
  [[nodiscard]] std::optional<Block> next();

 private:
  std::filesystem::path file_;
  std::ifstream stream_;
};

}  // namespace ilp::tasks
