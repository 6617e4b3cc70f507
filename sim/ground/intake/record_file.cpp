#include "sim/ground/intake/record_file.hpp"

#include <cstring>
#include <string>

#include "fsw/base/crc.hpp"
#include "sim/ground/intake/ids.hpp"

namespace ilp::intake {
namespace {

constexpr std::uint8_t magic[4] = {'I', 'L', 'P', 'R'};
constexpr std::uint8_t end_mark = 255;
constexpr std::size_t header_bytes = 8, trailer_bytes = 5;

void append_u32(std::vector<std::uint8_t>& to, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) to.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  std::span<const std::uint8_t> take(std::size_t count) {
    if (count > bytes_.size() - at_) throw BadFile("an entry runs beyond the end of the file");
    const auto part = bytes_.subspan(at_, count);
    at_ += count;
    return part;
  }
  std::uint32_t number(std::size_t octets) {
    std::uint32_t value = 0;
    const auto part = take(octets);
    for (std::size_t i = 0; i < octets; ++i) value |= std::uint32_t{part[i]} << (8 * i);
    return value;
  }
  [[nodiscard]] bool at_end() const { return at_ == bytes_.size(); }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

// Sizes in field order, read off the serial form itself: the struct is not known here.
std::vector<std::uint32_t> check_record(const RecordInfo& info, std::span<const std::uint8_t> serial) {
  alignas(8) std::uint8_t record[limits::max_record_bytes] = {};
  if (!deserialize(info, serial, record).ok()) throw BadFile("record shorter than its type");
  check_numbers(info, record);
  std::vector<std::uint32_t> sizes;
  for (std::size_t f = 0; f < info.field_count; ++f) {
    if (info.fields[f].type != FieldType::blob) continue;
    Blob blob;
    std::memcpy(&blob, record + info.fields[f].offset, sizeof(blob));
    sizes.push_back(blob.bytes);
  }
  return sizes;
}

RecordEntry read_entry(Reader& reader, std::uint32_t type) {
  if (type >= static_cast<std::uint32_t>(RecordType::count)) {
    throw BadFile("record type " + std::to_string(type) + " is unknown");
  }
  RecordEntry entry;
  entry.type = static_cast<RecordType>(type);
  const RecordInfo& info = record_info(entry.type);
  const std::size_t length = reader.number(2);
  if (length != serial_bytes(info)) {
    throw BadFile(std::string("a ") + info.name + " record of " + std::to_string(length) + " bytes, " +
                  std::to_string(serial_bytes(info)) + " expected");
  }
  const auto serial = reader.take(length);
  entry.serial.assign(serial.begin(), serial.end());
  for (const std::uint32_t size : check_record(info, serial)) {
    const auto blob = reader.take(size);
    entry.blobs.emplace_back(std::vector<std::uint8_t>(blob.begin(), blob.end()));
  }
  return entry;
}

}  // namespace

std::vector<RecordEntry> parse_record_file(std::span<const std::uint8_t> file) {
  if (file.size() < sizeof(magic) || std::memcmp(file.data(), magic, sizeof(magic)) != 0) {
    throw BadFile("not a record file (does not begin with ILPR)");
  }
  if (file.size() < header_bytes + trailer_bytes) throw BadFile("truncated");
  const std::uint32_t crc = Reader(file.last(4)).number(4);
  if (crc != crc32(file.first(file.size() - 4)) || file[file.size() - trailer_bytes] != end_mark) {
    throw BadFile("checksum does not match: truncated or damaged in transfer");
  }
  const std::uint32_t version = Reader(file.subspan(4, 4)).number(4);
  if (version != static_cast<std::uint32_t>(schema_version)) {
    throw BadFile("written with record schema " + std::to_string(version) + ", this program reads " +
                  std::to_string(schema_version));
  }
  Reader reader(file.subspan(header_bytes, file.size() - header_bytes - trailer_bytes));
  std::vector<RecordEntry> entries;
  while (!reader.at_end()) entries.push_back(read_entry(reader, reader.number(1)));
  return entries;
}

std::vector<std::uint8_t> write_record_file(std::span<const RecordEntry> entries) {
  std::vector<std::uint8_t> file(magic, magic + sizeof(magic));
  append_u32(file, static_cast<std::uint32_t>(schema_version));
  for (const RecordEntry& entry : entries) {
    file.push_back(static_cast<std::uint8_t>(entry.type));
    file.push_back(static_cast<std::uint8_t>(entry.serial.size() & 0xFFU));
    file.push_back(static_cast<std::uint8_t>(entry.serial.size() >> 8U));
    file.insert(file.end(), entry.serial.begin(), entry.serial.end());
    for (const CodedFile& blob : entry.blobs) {
      const std::vector<std::uint8_t> bytes = blob.bytes();
      file.insert(file.end(), bytes.begin(), bytes.end());
    }
  }
  file.push_back(end_mark);
  append_u32(file, crc32(file));
  return file;
}

}  // namespace ilp::intake
