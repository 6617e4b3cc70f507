// Reads the flight's key files on the ground. A key seals telecommands; the first key of a file signs maps.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace ilp::host {

struct FileKey {
  std::uint16_t spi = 0;  ///< security parameter index
  std::vector<std::uint8_t> octets;
};

/// Reads the key with this SPI, or the first key for an SPI of 0. A line is `SPI KEY`: an SPI from 1 to 65535, and a
/// key of 16 to 64 octets in hexadecimal. `#` begins a comment. Throws std::runtime_error that names the file if it
/// cannot be read, if other users may read it, if it has 4 KiB or more, if a line before the key is malformed, or if
/// there is no such key.
[[nodiscard]] FileKey read_key_file(const std::filesystem::path& path, std::uint16_t spi = 0);

}  // namespace ilp::host
