#include "sim/host/key_file.hpp"

#include <array>
#include <cerrno>
#include <sstream>
#include <stdexcept>
#include <string>

#include "fsw/packets/authentication.hpp"
#include "hal/posix/private_file.hpp"
#include "sim/host/files.hpp"

namespace ilp::host {
namespace {

std::string text_of(const std::string& path) {
  std::array<std::uint8_t, 4096> text{};
  std::size_t size = 0;
  const Status status = read_private_file(path.c_str(), text, size);
  if (status.is(StatusCode::file_not_private)) {
    throw std::runtime_error("others may read the file of keys " + path + ": run chmod 600 " + path);
  }
  if (!status.ok()) {
    const int error = status.is(StatusCode::not_found) ? ENOENT : static_cast<int>(status.a);
    throw std::runtime_error("cannot read the file of keys " + path + ": " + read_failure(error));
  }
  if (size == text.size()) throw std::runtime_error(path + ": a file of keys has less than 4 KiB");
  return {reinterpret_cast<const char*>(text.data()), size};
}

bool is_key(const std::string& hex) {
  return hex.size() % 2 == 0 && hex.size() >= 2 * min_key_bytes && hex.size() <= 2 * max_key_bytes &&
         hex.find_first_not_of("0123456789abcdefABCDEF") == std::string::npos;
}

std::vector<std::uint8_t> octets_of(const std::string& hex) {
  std::vector<std::uint8_t> octets;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    octets.push_back(static_cast<std::uint8_t>(std::stoul(hex.substr(i, 2), nullptr, 16)));
  }
  return octets;
}

}  // namespace

FileKey read_key_file(const std::filesystem::path& path, std::uint16_t spi) {
  std::istringstream in(text_of(path.string()));
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line.substr(0, line.find('#')));
    words >> std::ws;
    if (words.eof()) continue;
    FileKey key;
    std::string hex, more;
    if (!(words >> key.spi >> hex) || words >> more || key.spi == 0 || !is_key(hex)) {
      throw std::runtime_error(path.string() + ": a line is an SPI and 16 to 64 octets in hexadecimal");
    }
    if (spi != 0 && key.spi != spi) continue;
    key.octets = octets_of(hex);
    return key;
  }
  throw std::runtime_error(path.string() + " has no key" + (spi != 0 ? " of SPI " + std::to_string(spi) : ""));
}

}  // namespace ilp::host
