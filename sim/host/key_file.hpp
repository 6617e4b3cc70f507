// Files of keys as the flight has them: telecommands are sealed with a key, maps are signed with the first one.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace ilp::host {

struct FileKey {
  std::uint16_t spi = 0;  ///< security parameter index
  std::vector<std::uint8_t> octets;
};

/// The key of this SPI; 0: the first one of the file. Its lines are `SPI KEY`, the SPI from 1 to 65535, the key in
/// hexadecimal; `#` begins a comment. std::runtime_error names the file and says what is wrong: others may read it, it
/// has more than 4 KiB, a line before the key is no key, or there is no such key.
[[nodiscard]] FileKey read_key_file(const std::filesystem::path& path, std::uint16_t spi = 0);

}  // namespace ilp::host
