#include "sim/tools/store/store_digest.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "fsw/records/records.hpp"
#include "hal/store/checksums.hpp"
#include "hal/store/record_bytes.hpp"
#include "sim/host/digest.hpp"

namespace ilp::store_tool {
namespace {

using enum RecordType;

// What processes say of themselves, the state of their work, and what is on its way to the ground.
constexpr RecordMask left_out =
    mask_of(downlink, storage, event, component, checkpoint, transfer, commanding, start, timing, node);

struct Field {
  RecordType type;
  const char* name;
};
// Times of decisions.
constexpr Field left_out_fields[] = {{capture, "issued_ns"}, {command, "time_ns"}, {setting, "set_ns"}};

bool is_left_out(RecordType type, const FieldInfo& field) {
  return std::any_of(std::begin(left_out_fields), std::end(left_out_fields),
                     [&](const Field& one) { return one.type == type && std::strcmp(one.name, field.name) == 0; });
}

template <typename Number>
std::uint64_t add(Number number, std::uint64_t state) {
  return host::digest({reinterpret_cast<const char*>(&number), sizeof(number)}, state);
}

class TableReader {
 public:
  TableReader(Store& store, RecordType type) : store_(store), info_(record_info(type)) { result_.table = info_.name; }

  TableDigest read() {
    std::int64_t after = std::numeric_limits<std::int64_t>::min();
    result_.digest = host::digest({});
    while (true) {
      const Status status = store_.next(info_, after, record_.data());
      if (status.is(StatusCode::not_found)) return result_;
      if (!status.ok() && !status.is(StatusCode::record_damaged)) fail(status);
      after = status.ok() ? id_of(record_.data()) : status.a;
      ++result_.rows;
      if (status.ok()) {
        add_record();
      } else {
        ++result_.damaged;
      }
    }
  }

 private:
  [[noreturn]] void fail(const Status& status) const {
    throw std::runtime_error(std::string("table ") + info_.name + ": " + status_name(status.code));
  }

  void add_record() {
    const std::int64_t id = id_of(record_.data());
    for_each_blob(info_, [&](const FieldInfo& field, std::size_t) { add_blob(field, id); });
    for (std::size_t f = 0; f < info_.field_count; ++f) {
      const FieldInfo& field = info_.fields[f];
      if (!is_left_out(info_.type, field)) continue;
      std::memset(record_.data() + field.offset, 0, field.count * element_bytes(field.type));
    }
    // The checksum is the same in every backend.
    result_.digest = add(record_checksum(info_, record_.data()), result_.digest);
  }

  void add_blob(const FieldInfo& field, std::int64_t id) {
    bytes_.resize(blob_bytes(record_.data(), field));
    if (bytes_.empty()) return;
    const Status status = store_.read_blob(info_, field.name, id, 0, bytes_);
    if (status.is(StatusCode::record_damaged)) {
      ++result_.damaged;
      return;
    }
    if (!status.ok()) fail(status);
    result_.digest = host::digest({reinterpret_cast<const char*>(bytes_.data()), bytes_.size()}, result_.digest);
  }

  Store& store_;
  const RecordInfo& info_;
  TableDigest result_;
  alignas(8) std::array<std::uint8_t, limits::max_record_bytes> record_{};
  std::vector<std::uint8_t> bytes_;
};

}  // namespace

std::vector<TableDigest> digest_of(Store& store) {
  std::vector<TableDigest> digests;
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    const auto type = static_cast<RecordType>(t);
    if ((left_out & mask_of(type)) == 0) digests.push_back(TableReader(store, type).read());
  }
  return digests;
}

}  // namespace ilp::store_tool
