#include "bsp/flight/mission_file.hpp"

#include <array>
#include <cstdio>

namespace ilp {

Status read_mission_file(const char* path, MissionParameters& mission, MissionEntry& fault) {
  fault = {};
  std::FILE* const file = std::fopen(path, "r");
  if (file == nullptr) return StatusCode::not_found;
  MissionText text(mission);
  std::array<std::uint8_t, 4096> chunk{};
  std::size_t bytes = chunk.size();
  // Bounded by the file.
  while (bytes == chunk.size()) {
    bytes = std::fread(chunk.data(), 1, chunk.size(), file);
    text.add(std::span(chunk).first(bytes));
  }
  const bool failed = std::ferror(file) != 0;
  static_cast<void>(std::fclose(file));
  if (failed) return StatusCode::io_error;
  const Status status = text.finish(mission);
  fault = text.fault();
  return status;
}

}  // namespace ilp
