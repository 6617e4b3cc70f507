#include "hal/maps/directory_map_source.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "hal/posix/file.hpp"

namespace ilp {
namespace {

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
  // The name of a file and a slash follow.
  if (folder_.overflow() || folder_.size() + max_map_file_name + 1 > limits::max_path_bytes) {
    folder_.clear();
    return {StatusCode::capacity_exceeded, 0, static_cast<std::int64_t>(limits::max_path_bytes)};
  }
  return {};
}

Status DirectoryMapSource::read_file(const char* name, std::span<std::uint8_t> bytes, std::size_t& size) const {
  size = 0;
  if (folder_.size() == 0) return StatusCode::not_found;
  FixedText<limits::max_path_bytes> path;
  path.add(folder_.c_str()).add('/').add(name);
  // A pipe without a writer must not hold up the flight.
  const int file = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) return errno == ENOENT ? Status{StatusCode::not_found} : io_failure();
  const Status status = read_whole(file, bytes, size);
  ::close(file);
  if (!status.ok()) size = 0;
  return status;
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
