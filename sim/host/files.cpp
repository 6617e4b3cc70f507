#include "sim/host/files.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <system_error>

namespace ilp::host {
namespace fs = std::filesystem;

std::string write_failure(int cause) {
  if (cause == ENOSPC || cause == EDQUOT) return "the disk is full: make room, or name a folder on another disk";
  if (cause == EACCES || cause == EPERM || cause == EROFS) return "no permission to write there: name another folder";
  return (cause != 0 ? std::strerror(cause) : std::string("it failed")) +
         "; check the folder's permissions and free space";
}

std::vector<std::uint8_t> read_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file.is_open() || file.bad()) throw std::runtime_error("cannot read " + path.string());
  return bytes;
}

void write_file(const fs::path& path, std::span<const std::uint8_t> bytes) {
  fs::path temporary = path;
  temporary += ".part";
  {
    std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file) {
      const int cause = errno;
      std::error_code ignored;
      fs::remove(temporary, ignored);
      throw std::runtime_error("cannot write " + path.string() + ": " + write_failure(cause));
    }
  }
  std::error_code error;
  fs::rename(temporary, path, error);
  if (error) throw std::runtime_error("cannot write " + path.string() + ": " + error.message());
}

void write_file(const fs::path& path, std::string_view text) {
  write_file(path, std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

void make_output_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error || !fs::is_directory(folder)) {
    throw std::runtime_error("cannot create the output folder " + folder.string() +
                             (error ? ": " + error.message() : std::string(": something else has this name")));
  }
  const fs::path probe = folder / ".ilp-ground-probe";
  errno = 0;
  const bool writable = (std::ofstream(probe) << "probe").flush().good();
  const int cause = errno;
  fs::remove(probe, error);
  if (!writable)
    throw std::runtime_error("cannot write into the folder " + folder.string() + ": " + write_failure(cause));
}

std::string safe_name(std::string_view name) {
  const std::size_t slash = name.find_last_of("/\\");
  if (slash != std::string_view::npos) name.remove_prefix(slash + 1);
  constexpr std::string_view kept = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-+@";
  std::string safe;
  for (const char c : name.substr(0, 128)) safe += kept.find(c) == std::string_view::npos ? '_' : c;
  const bool only_dots = std::all_of(safe.begin(), safe.end(), [](char c) { return c == '.'; });
  return only_dots ? std::string() : safe;
}

std::string stem(std::string_view name) {
  const std::size_t dot = name.rfind('.');
  return std::string(dot == std::string_view::npos || dot == 0 ? name : name.substr(0, dot));
}

std::string six_digits(std::int64_t number) {
  std::string digits = std::to_string(number);
  if (digits.size() < 6) digits.insert(0, 6 - digits.size(), '0');
  return digits;
}

}  // namespace ilp::host
