// Writes a file to the link, and computes its size and CRC (docs/outbox.md).
#pragma once

#include "fsw/base/result.hpp"
#include "fsw/executive/stage_component.hpp"
#include "hal/link/link.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// link_failed() reports whether a fault came from the link; otherwise it came from the store. A lenient file omits
/// records that cannot be read, and counts them.
class OutgoingFile {
 public:
  /// The tables that the downlink may read.
  using Tables = StoreView<StoreAccess{.reads = stage_access(ComponentId::downlink).readable()}>;

  OutgoingFile(Tables store, Link& link) : store_(store), link_(link) {}

  /// Begins a file, which is not lenient.
  Status begin(const char* name);
  Status write(std::span<const std::uint8_t> bytes);
  /// Writes the head of a file of records.
  Status write_records_head();
  /// Writes a record in its serial form, with the sizes of its blobs. The caller must then write the blobs that are not
  /// empty.
  Status write_entry(const RecordInfo& info, const void* record);
  /// Writes the first `bytes` bytes of a blob.
  Status write_blob_of(const RecordInfo& info, const char* field, std::int64_t id, std::uint32_t bytes);
  /// Writes the end of a file of records, with the CRC.
  Status write_records_tail();
  Status write_u32(std::uint32_t value);
  Status end();

  template <typename Record>
  Status write_record(const Record& record) {
    return write_entry(record_info<Record>(), &record);
  }
  /// Writes the record of this id; does nothing if it does not exist.
  template <typename Record>
  Status write_if_present(std::int64_t id) {
    Record record;
    ILP_TAKE(const bool found, take(get(store_, id, record)));
    return found ? write_record(record) : Status{};
  }
  /// Writes the record with the largest id; does nothing if there is none.
  template <typename Record>
  Status write_newest() {
    Record record;
    ILP_TAKE(const bool found, take(last(store_, record)));
    return found ? write_record(record) : Status{};
  }
  /// Interprets the status of reading a record: true if it was read, false if it does not exist or the file omits it,
  /// otherwise the fault.
  Result<bool> take(const Status& answer);

  void be_lenient() { lenient_ = true; }
  /// Number of records that were omitted.
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
