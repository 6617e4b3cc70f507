#include "sim/ground/export/cloud_tiff.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <ostream>
#include <stdexcept>
#include <string_view>

namespace ilp::exports {
namespace {

static_assert(std::endian::native == std::endian::little);

using Bytes = std::vector<std::uint8_t>;

enum Tag : std::uint16_t {
  new_subfile_type = 254,
  image_width = 256,
  image_length = 257,
  tile_offsets = 324,
  tile_byte_counts = 325,
};
enum Type : std::uint16_t { type_short = 3, type_long = 4, type_long8 = 16 };

/// That an overview has from the raster: how its samples are stored, and the value for nothing.
constexpr std::array<std::uint16_t, 10> shared_tags = {258, 259, 262, 277, 284, 317, 322, 323, 339, 42113};

/// Where readers look for the order of the file (GDAL, "Cloud Optimized GeoTIFF", header ghost area).
constexpr std::string_view layout =
    "GDAL_STRUCTURAL_METADATA_SIZE=000140 bytes\nLAYOUT=IFDS_BEFORE_DATA\nBLOCK_ORDER=ROW_MAJOR\n"
    "BLOCK_LEADER=SIZE_AS_UINT4\nBLOCK_TRAILER=LAST_4_BYTES_REPEATED\nKNOWN_INCOMPATIBLE_EDITION=NO\n ";
constexpr std::size_t leader_bytes = 4, trailer_bytes = 4;

struct Field {
  std::uint16_t tag = 0, type = 0;
  std::uint64_t count = 0;
  Bytes value;
};

template <typename T>
void append(T value, Bytes& to) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(&value);
  to.insert(to.end(), bytes, bytes + sizeof(T));
}

template <typename T>
T number_at(std::span<const std::uint8_t> file, std::size_t at) {
  if (at + sizeof(T) > file.size()) throw std::runtime_error("the head of a raster is cut off");
  T value;
  std::memcpy(&value, file.data() + at, sizeof(T));
  return value;
}

std::size_t size_of(std::uint16_t type) {
  constexpr std::array<std::size_t, 19> sizes = {0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8};
  if (type >= sizes.size() || sizes[type] == 0) throw std::runtime_error("the head of a raster has an unknown type");
  return sizes[type];
}

/// Of a classic TIFF file, its first directory.
std::vector<Field> fields_of(std::span<const std::uint8_t> head) {
  if (number_at<std::uint32_t>(head, 0) != 0x002A4949) throw std::runtime_error("the head of a raster is no TIFF");
  std::size_t at = number_at<std::uint32_t>(head, 4);
  std::vector<Field> fields(number_at<std::uint16_t>(head, at));
  at += 2;
  for (Field& field : fields) {
    field.tag = number_at<std::uint16_t>(head, at);
    field.type = number_at<std::uint16_t>(head, at + 2);
    field.count = number_at<std::uint32_t>(head, at + 4);
    const std::size_t bytes = size_of(field.type) * field.count;
    const std::size_t from = bytes <= 4 ? at + 8 : number_at<std::uint32_t>(head, at + 8);
    if (from + bytes > head.size()) throw std::runtime_error("the head of a raster is cut off");
    field.value.assign(head.begin() + static_cast<std::ptrdiff_t>(from),
                       head.begin() + static_cast<std::ptrdiff_t>(from + bytes));
    at += 12;
  }
  return fields;
}

Field number_field(std::uint16_t tag, std::uint32_t value) {
  Field field{tag, type_long, 1, {}};
  append(value, field.value);
  return field;
}

/// A file of two sizes of numbers: classic up to 4 GiB, BigTIFF beyond.
struct Format {
  bool big = false;

  [[nodiscard]] std::size_t header_bytes() const { return big ? 16 : 8; }
  [[nodiscard]] std::size_t inline_bytes() const { return big ? 8 : 4; }
  [[nodiscard]] std::size_t directory_bytes(std::size_t fields) const {
    return big ? 8 + 20 * fields + 8 : 2 + 12 * fields + 4;
  }
  void append_place(std::uint64_t value, Bytes& to) const {
    if (big) {
      append(value, to);
    } else {
      append(static_cast<std::uint32_t>(value), to);
    }
  }
};

using Directory = std::vector<Field>;

/// Offsets have room, and no values yet.
Directory directory_of(const std::vector<Field>& head, const CloudLevel& level, bool is_overview,
                       const Format& format) {
  Directory directory;
  for (const Field& field : head) {
    const bool replaced = field.tag == new_subfile_type || field.tag == image_width || field.tag == image_length ||
                          field.tag == tile_offsets || field.tag == tile_byte_counts;
    const bool shared = std::find(shared_tags.begin(), shared_tags.end(), field.tag) != shared_tags.end();
    if (!replaced && (!is_overview || shared)) directory.push_back(field);
  }
  if (is_overview) directory.push_back(number_field(new_subfile_type, 1));
  directory.push_back(number_field(image_width, static_cast<std::uint32_t>(level.columns)));
  directory.push_back(number_field(image_length, static_cast<std::uint32_t>(level.rows)));
  Field counts{tile_byte_counts, type_long, level.blocks(), {}};
  for (const std::uint32_t bytes : level.block_bytes) append(bytes, counts.value);
  directory.push_back(std::move(counts));
  directory.push_back({tile_offsets, format.big ? type_long8 : type_long, level.blocks(),
                       Bytes(level.blocks() * format.inline_bytes(), 0)});
  std::sort(directory.begin(), directory.end(), [](const Field& a, const Field& b) { return a.tag < b.tag; });
  return directory;
}

std::size_t even(std::size_t bytes) {
  return bytes + bytes % 2;
}

std::size_t bytes_of(const Directory& directory, const Format& format) {
  std::size_t bytes = format.directory_bytes(directory.size());
  for (const Field& field : directory) {
    if (field.value.size() > format.inline_bytes()) bytes += even(field.value.size());
  }
  return even(bytes);
}

void append_directory(const Directory& directory, bool is_last, const Format& format, Bytes& file) {
  const std::size_t begin = file.size(), end = begin + bytes_of(directory, format);
  std::size_t values_at = begin + format.directory_bytes(directory.size());
  Bytes values;
  if (format.big) {
    append(std::uint64_t{directory.size()}, file);
  } else {
    append(static_cast<std::uint16_t>(directory.size()), file);
  }
  for (const Field& field : directory) {
    append(field.tag, file);
    append(field.type, file);
    format.append_place(field.count, file);
    if (field.value.size() <= format.inline_bytes()) {
      file.insert(file.end(), field.value.begin(), field.value.end());
      file.resize(file.size() + format.inline_bytes() - field.value.size(), 0);
    } else {
      format.append_place(values_at + values.size(), file);
      values.insert(values.end(), field.value.begin(), field.value.end());
      values.resize(even(values.size()), 0);
    }
  }
  format.append_place(is_last ? 0 : end, file);
  file.insert(file.end(), values.begin(), values.end());
  file.resize(end, 0);
}

std::uint64_t data_bytes(const std::vector<CloudLevel>& levels) {
  std::uint64_t bytes = 0;
  for (const CloudLevel& level : levels) {
    for (const std::uint32_t block : level.block_bytes) bytes += block > 0 ? leader_bytes + block + trailer_bytes : 0;
  }
  return bytes;
}

/// The smallest overview comes first; `next` is where its first block begins.
void state_offsets(const std::vector<CloudLevel>& levels, std::uint64_t next, const Format& format,
                   std::vector<Directory>& directories) {
  for (std::size_t level = levels.size(); level-- > 0;) {
    const auto offsets = std::find_if(directories[level].begin(), directories[level].end(),
                                      [](const Field& field) { return field.tag == tile_offsets; });
    offsets->value.clear();
    for (const std::uint32_t bytes : levels[level].block_bytes) {
      format.append_place(bytes > 0 ? next + leader_bytes : 0, offsets->value);
      if (bytes > 0) next += leader_bytes + bytes + trailer_bytes;
    }
  }
}

Bytes beginning_of(std::span<const std::uint8_t> head, const std::vector<CloudLevel>& levels, CloudFormat wanted) {
  const std::vector<Field> fields = fields_of(head);
  constexpr std::uint64_t capacity_for_directories = std::uint64_t{1} << 28U, most = std::uint64_t{1} << 32U;
  const Format format{wanted == CloudFormat::big || data_bytes(levels) + capacity_for_directories > most};
  std::vector<Directory> directories;
  std::size_t size = even(format.header_bytes() + layout.size());
  for (std::size_t level = 0; level < levels.size(); ++level) {
    directories.push_back(directory_of(fields, levels[level], level > 0, format));
    size += bytes_of(directories.back(), format);
  }
  state_offsets(levels, size, format, directories);
  Bytes file;
  append(std::uint16_t{0x4949}, file);
  append(static_cast<std::uint16_t>(format.big ? 43 : 42), file);
  if (format.big) append(std::uint32_t{8}, file);
  format.append_place(even(format.header_bytes() + layout.size()), file);
  file.insert(file.end(), layout.begin(), layout.end());
  file.resize(even(file.size()), 0);
  for (std::size_t level = 0; level < levels.size(); ++level)
    append_directory(directories[level], level + 1 == levels.size(), format, file);
  return file;
}

void put(std::span<const std::uint8_t> bytes, std::ostream& out) {
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace

std::vector<CloudLevel> cloud_levels(std::int32_t columns, std::int32_t rows) {
  std::vector<CloudLevel> levels;
  while (true) {
    CloudLevel& level = levels.emplace_back();
    level.columns = columns;
    level.rows = rows;
    level.block_bytes.resize(level.blocks(), 0);
    if (level.blocks() <= 1) return levels;
    columns = (columns + 1) / 2;
    rows = (rows + 1) / 2;
  }
}

void write_cloud_tiff(std::span<const std::uint8_t> head, const std::vector<CloudLevel>& levels,
                      const CloudBlock& block, std::ostream& out, CloudFormat format) {
  put(beginning_of(head, levels, format), out);
  for (std::size_t level = levels.size(); level-- > 0;) {
    for (std::size_t number = 0; number < levels[level].blocks(); ++number) {
      const std::uint32_t expected = levels[level].block_bytes[number];
      if (expected == 0) continue;
      const Bytes bytes = block(level, number);
      if (bytes.size() != expected || expected < trailer_bytes) throw std::runtime_error("a block of another size");
      Bytes leader;
      append(expected, leader);
      put(leader, out);
      put(bytes, out);
      put(std::span(bytes).last(trailer_bytes), out);
    }
  }
}

}  // namespace ilp::exports
