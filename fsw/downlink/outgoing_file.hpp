// A file being written to the link, with its size and checksum (docs/outbox.md).
#pragma once

#include "fsw/base/result.hpp"
#include "fsw/executive/stage_component.hpp"
#include "hal/link/link.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// link_failed() distinguishes a refusal of the link from a record that cannot be read. A `lenient` file omits records
/// that cannot be read, and counts them.
class OutgoingFile {
 public:
  /// The tables that the downlink may read.
  using Tables = StoreView<StoreAccess{.reads = stage_access(ComponentId::downlink).readable()}>;

  OutgoingFile(Tables store, Link& link) : store_(store), link_(link) {}

  /// The file is not lenient at first.
  Status begin(const char* name);
  Status write(std::span<const std::uint8_t> bytes);
  /// The head of a file of records.
  Status write_records_head();
  /// Writes a record in its serial form, with the sizes of its blobs. The blobs that are not empty must follow.
  Status write_entry(const RecordInfo& info, const void* record);
  /// The first `bytes` of a blob.
  Status write_blob_of(const RecordInfo& info, const char* field, std::int64_t id, std::uint32_t bytes);
  /// The end of a file of records, checksum included.
  Status write_records_tail();
  Status write_u32(std::uint32_t value);
  Status end();

  template <typename Record>
  Status write_record(const Record& record) {
    return write_entry(record_info<Record>(), &record);
  }
  /// Does nothing when the record does not exist.
  template <typename Record>
  Status write_if_present(std::int64_t id) {
    Record record;
    ILP_TAKE(const bool found, take(get(store_, id, record)));
    return found ? write_record(record) : Status{};
  }
  template <typename Record>
  Status write_newest() {
    Record record;
    ILP_TAKE(const bool found, take(last(store_, record)));
    return found ? write_record(record) : Status{};
  }
  /// Evaluates the store's answer for a record: a fault, unless the file omits the record.
  Result<bool> take(const Status& answer);

  void be_lenient() { lenient_ = true; }
  [[nodiscard]] std::int64_t left_out() const { return left_out_; }
  [[nodiscard]] bool link_failed() const { return link_failed_; }

  [[nodiscard]] const char* name() const { return name_; }
  [[nodiscard]] std::uint32_t bytes() const { return bytes_; }
  [[nodiscard]] std::uint32_t crc() const { return crc_; }

 private:
  static constexpr std::size_t chunk_bytes = 4096;

  Status ask_link(const Status& answer);
  Status write_u8(std::uint8_t value) { return write({&value, 1}); }

  Tables store_;
  Link& link_;
  char name_[32] = {};
  std::uint32_t bytes_ = 0;
  std::uint32_t crc_ = 0;
  bool lenient_ = false;
  bool link_failed_ = false;
  std::int64_t left_out_ = 0;
  std::uint8_t chunk_[chunk_bytes] = {};
};

}  // namespace ilp
