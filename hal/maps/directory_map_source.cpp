#include "hal/maps/directory_map_source.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

#include "hal/posix/file.hpp"

namespace ilp {
namespace {

constexpr char part_end[] = ".part";

Status io_failure() {
  return {StatusCode::io_error, errno};
}

/// Reads the whole of an open file.
Status read_whole(int file, std::span<std::uint8_t> bytes, std::size_t& size) {
  struct stat facts {};
  if (::fstat(file, &facts) != 0) return io_failure();
  if (!S_ISREG(facts.st_mode)) return {StatusCode::io_error, EINVAL};
  if (facts.st_size > static_cast<off_t>(bytes.size())) {
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(facts.st_size),
            static_cast<std::int64_t>(bytes.size())};
  }
  return read_some(file, bytes, size);
}

}  // namespace

MapFileName map_tile_name(const MapTilePlace& place) {
  MapFileName name;
  name.add("tile-").add(std::int64_t{place.layer}).add('-').add(std::int64_t{place.row}, 4).add('-');
  name.add(std::int64_t{place.column}, 4).add(".ilpt");
  return name;
}

Status DirectoryMapSource::open(const char* folder) {
  folder_.clear();
  folder_.add(folder);
  // The name of a file, a slash and the end of a file that is being written follow.
  if (folder_.overflow() || folder_.size() + max_map_file_name + 1 + sizeof(part_end) > limits::max_path_bytes) {
    folder_.clear();
    return {StatusCode::capacity_exceeded, 0, static_cast<std::int64_t>(limits::max_path_bytes)};
  }
  return {};
}

DirectoryMapSource::Path DirectoryMapSource::path_of(const char* name, const char* end) const {
  Path path;
  path.add(folder_.c_str()).add('/').add(name).add(end);
  return path;
}

Status DirectoryMapSource::read_file(const char* name, std::span<std::uint8_t> bytes, std::size_t& size) const {
  size = 0;
  if (folder_.size() == 0) return StatusCode::not_found;
  const Path path = path_of(name);
  // A pipe without a writer must not hold up the flight.
  const int file = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) return errno == ENOENT ? Status{StatusCode::not_found} : io_failure();
  const Status status = read_whole(file, bytes, size);
  ::close(file);
  if (!status.ok()) size = 0;
  return status;
}

Status DirectoryMapSource::write_file(const char* name, std::span<const std::uint8_t> bytes) const {
  if (folder_.size() == 0) return StatusCode::not_found;
  if (::mkdir(folder_.c_str(), 0755) != 0 && errno != EEXIST) return io_failure();
  const Path whole = path_of(name), part = path_of(name, part_end);
  const int file = ::open(part.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file < 0) return io_failure();
  Status status = write_all(file, bytes);
  if (status.ok() && ::fsync(file) != 0) status = io_failure();
  ::close(file);
  if (status.ok() && std::rename(part.c_str(), whole.c_str()) != 0) status = io_failure();
  if (status.ok()) return synchronise_folder_of(whole.c_str());
  ::unlink(part.c_str());
  return status;
}

Status DirectoryMapSource::write_directory(std::span<const std::uint8_t> bytes) {
  return write_file(map_directory_name, bytes);
}

Status DirectoryMapSource::write_tile(const MapTilePlace& place, std::span<const std::uint8_t> bytes) {
  return write_file(map_tile_name(place).c_str(), bytes);
}

Status DirectoryMapSource::erase_tile(const MapTilePlace& place) {
  if (folder_.size() == 0) return StatusCode::not_found;
  return ::unlink(path_of(map_tile_name(place).c_str()).c_str()) == 0 || errno == ENOENT ? Status{} : io_failure();
}

std::uint64_t DirectoryMapSource::directory_mark() const {
  struct stat facts {};
  if (folder_.size() == 0 || ::stat(path_of(map_directory_name).c_str(), &facts) != 0) return 0;
  // A file that replaces another one has another inode, or another time where the number is used again.
  const std::uint64_t changed_ns = static_cast<std::uint64_t>(facts.st_mtim.tv_sec) * 1000000000U +
                                   static_cast<std::uint64_t>(facts.st_mtim.tv_nsec);
  return (static_cast<std::uint64_t>(facts.st_ino) * 0x9E3779B97F4A7C15U) ^ changed_ns;
}

bool DirectoryMapSource::has_directory() const {
  std::uint8_t first = 0;
  std::size_t size = 0;
  const Status status = read_file(map_directory_name, {&first, 1}, size);
  return status.ok() || status.is(StatusCode::capacity_exceeded);
}

Status DirectoryMapSource::read_directory(std::span<std::uint8_t> bytes, std::size_t& size) {
  return read_file(map_directory_name, bytes, size);
}

Status DirectoryMapSource::read_tile(const MapTilePlace& place, std::span<std::uint8_t> bytes, std::size_t& size) {
  return read_file(map_tile_name(place).c_str(), bytes, size);
}

}  // namespace ilp
