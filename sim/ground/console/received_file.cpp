#include "sim/ground/console/received_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <system_error>
#include <vector>

namespace ilp::console {
namespace {
namespace fs = std::filesystem;

bool write_all(int file, std::span<const std::uint8_t> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

// The file must be on the disk itself, because the flight deletes what the ground confirms.
bool write_through(const fs::path& path, std::span<const std::uint8_t> bytes) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file < 0) return false;
  const bool good = write_all(file, bytes) && ::fsync(file) == 0;
  return ::close(file) == 0 && good;
}

bool sync_folder(const fs::path& folder) {
  const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) return false;
  const bool good = ::fsync(file) == 0;
  return ::close(file) == 0 && good;
}

bool holds(const fs::path& path, std::span<const std::uint8_t> bytes) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return false;
  std::ifstream in(path, std::ios::binary);
  const std::vector<char> content{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  return std::equal(content.begin(), content.end(), bytes.begin(), bytes.end(),
                    [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
}

bool plain(const std::string& name) {
  return !name.empty() && name[0] != '.' && name.find('/') == std::string::npos &&
         std::all_of(name.begin(), name.end(), [](char c) { return c > ' ' && c < 127; });
}

}  // namespace

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || ::access(folder.c_str(), W_OK) != 0) {
    throw std::runtime_error("the folder " + folder.string() + " cannot be written");
  }
}

void replace_file(const fs::path& path, std::span<const std::uint8_t> bytes) {
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  const std::string part = path.string() + ".part";
  if (!write_through(part, bytes) || ::rename(part.c_str(), path.c_str()) != 0 || !sync_folder(folder)) {
    throw std::runtime_error(path.string() + " cannot be written: " + std::strerror(errno));
  }
}

std::string keep_file(const fs::path& folder, const std::string& name, std::span<const std::uint8_t> bytes) {
  if (!plain(name)) return "its name is no plain file name";
  const fs::path path = folder / name;
  std::error_code error;
  if (fs::exists(path, error)) {
    return holds(path, bytes) ? "" : path.string() + " is there already with other content: name another folder";
  }
  const fs::path part = folder / ("." + name + ".part");
  const bool written = write_through(part, bytes);
  if (!written || ::rename(part.c_str(), path.c_str()) != 0 || !sync_folder(folder)) {
    return path.string() + " cannot be written: " + std::strerror(errno);
  }
  return "";
}

}  // namespace ilp::console
