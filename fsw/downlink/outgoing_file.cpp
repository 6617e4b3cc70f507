#include "fsw/downlink/outgoing_file.hpp"

#include "fsw/base/crc.hpp"
#include "fsw/base/little_endian.hpp"
#include "fsw/base/text.hpp"
#include "fsw/records/serial.hpp"

namespace ilp {
namespace {
constexpr std::uint8_t end_of_entries = 255;
}  // namespace

Status OutgoingFile::begin(const char* name) {
  copy_text(name_, name);
  bytes_ = 0;
  crc_ = 0;
  lenient_ = false;
  left_out_ = 0;
  link_failed_ = false;
  return ask_link(link_.begin_file(name));
}

Status OutgoingFile::end() {
  return ask_link(link_.end_file());
}

Status OutgoingFile::ask_link(const Status& answer) {
  if (!answer.ok()) link_failed_ = true;
  return answer;
}

Result<bool> OutgoingFile::take(const Status& answer) {
  if (answer.ok()) return true;
  if (answer.is(StatusCode::not_found)) return false;
  if (!lenient_) return answer;
  ++left_out_;
  return false;
}

Status OutgoingFile::write(std::span<const std::uint8_t> bytes) {
  crc_ = crc32(bytes, crc_);
  bytes_ += static_cast<std::uint32_t>(bytes.size());
  return ask_link(link_.write(bytes));
}

Status OutgoingFile::write_u32(std::uint32_t value) {
  std::uint8_t bytes[4];
  store_little_endian(value, bytes);
  return write(bytes);
}

Status OutgoingFile::write_records_head() {
  constexpr std::uint8_t magic[] = {'I', 'L', 'P', 'R'};
  ILP_TRY(write(magic));
  return write_u32(static_cast<std::uint32_t>(schema_version));
}

Status OutgoingFile::write_records_tail() {
  ILP_TRY(write_u8(end_of_entries));
  return write_u32(crc_);
}

Status OutgoingFile::write_entry(const RecordInfo& info, const void* record) {
  const std::size_t size = serial_bytes(info);
  ILP_ASSERT(size <= chunk_bytes, size);
  ILP_TRY(write_u8(static_cast<std::uint8_t>(info.type)));
  ILP_TRY(write_u8(static_cast<std::uint8_t>(size & 0xFFU)));
  ILP_TRY(write_u8(static_cast<std::uint8_t>(size >> 8U)));
  ILP_TRY(serialize(info, record, chunk_));
  return write({chunk_, size});
}

Status OutgoingFile::write_blob_of(const RecordInfo& info, const char* field, std::int64_t id, std::uint32_t bytes) {
  for (std::size_t offset = 0; offset < bytes; offset += chunk_bytes) {
    const std::size_t size = bytes - offset < chunk_bytes ? bytes - offset : chunk_bytes;
    ILP_TRY(store_.read_blob(info, field, id, offset, {chunk_, size}));
    ILP_TRY(write({chunk_, size}));
  }
  return {};
}

}  // namespace ilp
