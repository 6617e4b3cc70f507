#include "sim/host/files.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <system_error>

#include "sim/host/digest.hpp"

namespace ilp::host {
namespace fs = std::filesystem;

std::string write_failure(int cause) {
  if (cause == ENOSPC || cause == EDQUOT) return "the disk is full: free space, or name a folder on another disk";
  if (cause == EACCES || cause == EPERM || cause == EROFS) return "no permission to write there: name another folder";
  return (cause != 0 ? std::strerror(cause) : std::string("it failed")) +
         "; check the folder's permissions and free space";
}

std::string read_failure(int cause) {
  if (cause == ENOENT || cause == ENOTDIR) return "there is no such file; check the path";
  if (cause == EACCES || cause == EPERM) return "no permission to read it; change that with chmod or chown";
  if (cause == EISDIR) return "it is a folder; name a file in it";
  return (cause != 0 ? std::strerror(cause) : std::string("it failed")) + "; check the path";
}

std::vector<std::uint8_t> read_file(const fs::path& path) {
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file.is_open() || file.bad())
    throw std::runtime_error("cannot read " + path.string() + ": " + read_failure(errno));
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

namespace {

/// Calls `take(bytes)` for one piece of the file after the other, until it returns false. False when the file cannot be
/// read.
template <typename Take>
bool for_each_chunk(const fs::path& path, Take take) {
  std::ifstream file(path, std::ios::binary);
  std::vector<std::uint8_t> chunk(std::size_t{1} << 20U);
  while (file) {
    file.read(reinterpret_cast<char*>(chunk.data()), static_cast<std::streamsize>(chunk.size()));
    if (file.gcount() > 0 && !take(std::span<const std::uint8_t>(chunk).first(static_cast<std::size_t>(file.gcount()))))
      break;
  }
  return file.is_open() && !file.bad();
}

bool holds(const fs::path& path, std::span<const std::uint8_t> bytes) {
  std::error_code error;
  if (fs::file_size(path, error) != bytes.size() || error) return false;
  std::size_t at = 0;
  bool same = true;
  const bool read = for_each_chunk(path, [&](std::span<const std::uint8_t> chunk) {
    same = at + chunk.size() <= bytes.size() &&
           std::equal(chunk.begin(), chunk.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
    at += chunk.size();
    return same;
  });
  return read && same && at == bytes.size();
}

bool same_content(const fs::path& a, const fs::path& b) {
  std::error_code error_a, error_b;
  if (fs::file_size(a, error_a) != fs::file_size(b, error_b) || error_a || error_b) return false;
  std::ifstream other(b, std::ios::binary);
  std::vector<std::uint8_t> theirs(std::size_t{1} << 20U);
  bool same = true;
  const bool read = for_each_chunk(a, [&](std::span<const std::uint8_t> chunk) {
    other.read(reinterpret_cast<char*>(theirs.data()), static_cast<std::streamsize>(chunk.size()));
    same = static_cast<std::size_t>(other.gcount()) == chunk.size() &&
           std::equal(chunk.begin(), chunk.end(), theirs.begin());
    return same;
  });
  return read && same;
}

}  // namespace

void update_file(const fs::path& path, std::span<const std::uint8_t> bytes) {
  if (!holds(path, bytes)) write_file(path, bytes);
}

void update_file(const fs::path& path, std::string_view text) {
  update_file(path, std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

void update_file(const fs::path& path, const std::function<void(std::ostream&)>& write) {
  fs::path temporary = path;
  temporary += ".part";
  try {
    std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
    write(file);
    file.close();
    if (!file) throw std::runtime_error("cannot write " + path.string() + ": " + write_failure(errno));
    move_into_place(temporary, path);
  } catch (const std::runtime_error& fault) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    const std::string what = fault.what();
    throw std::runtime_error(what.find(path.string()) == std::string::npos ? path.string() + ": " + what : what);
  } catch (...) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    throw;
  }
}

void move_into_place(const fs::path& part, const fs::path& whole) {
  std::error_code error;
  if (same_content(part, whole)) {
    fs::remove(part, error);
    return;
  }
  fs::rename(part, whole, error);
  if (error) throw std::runtime_error("cannot write " + whole.string() + ": " + error.message());
}

std::optional<FileState> state_of(const fs::path& path) {
  struct stat found {};
  if (::stat(path.c_str(), &found) != 0 || !S_ISREG(found.st_mode)) return std::nullopt;
  const auto nanoseconds = [](const timespec& at) { return std::int64_t{at.tv_sec} * 1000000000 + at.tv_nsec; };
  return FileState{static_cast<std::uint64_t>(found.st_size), nanoseconds(found.st_mtim), nanoseconds(found.st_ctim)};
}

std::optional<std::uint64_t> content_digest(const fs::path& path) {
  std::uint64_t state = digest("");
  const auto take = [&](std::span<const std::uint8_t> chunk) {
    for (; chunk.size() >= sizeof(std::uint64_t); chunk = chunk.subspan(sizeof(std::uint64_t))) {
      std::uint64_t word = 0;
      std::memcpy(&word, chunk.data(), sizeof(word));
      state = (state ^ word) * 0x100000001b3U;
      state ^= state >> 32U;
    }
    state = digest({reinterpret_cast<const char*>(chunk.data()), chunk.size()}, state);
    return true;
  };
  return for_each_chunk(path, take) ? std::optional(state) : std::nullopt;
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

std::string image_key(std::string_view file_name) {
  const std::size_t slash = file_name.find_last_of("/\\");
  if (slash != std::string_view::npos) file_name.remove_prefix(slash + 1);
  const std::string name = stem(file_name);
  std::string key = name;
  std::replace_if(
      key.begin(), key.end(), [](char c) { return c == ' ' || c == '\t'; }, '_');
  if (key == safe_name(key) && key.size() <= longest_image_key) return key;
  const std::string digits = digest_text(digest(name)).substr(0, 8);
  return safe_name(key).substr(0, longest_image_key - 1 - digits.size()) + "-" + digits;
}

std::string six_digits(std::int64_t number) {
  std::string digits = std::to_string(number);
  if (digits.size() < 6) digits.insert(0, 6 - digits.size(), '0');
  return digits;
}

}  // namespace ilp::host
