#include "bsp/flight/mission_file.hpp"

#include <array>
#include <cstdio>

namespace ilp {

Status read_mission_file(const char* path, MissionParameters& mission, MissionEntry& fault) {
  fault = {};
  std::FILE* const file = std::fopen(path, "r");
  if (file == nullptr) return StatusCode::not_found;
  MissionText text(mission);
  std::array<std::uint8_t, 4096> piece{};
  std::size_t bytes = piece.size();
  // Bounded by the file.
  while (bytes == piece.size()) {
    bytes = std::fread(piece.data(), 1, piece.size(), file);
    text.add(std::span(piece).first(bytes));
  }
  const bool failed = std::ferror(file) != 0;
  static_cast<void>(std::fclose(file));
  if (failed) return StatusCode::io_error;
  const Status status = text.finish(mission);
  fault = text.fault();
  return status;
}

}  // namespace ilp
