#include "sim/tools/store/keyframe_digest.hpp"

#include <cstdio>

#include "fsw/base/crc.hpp"
#include "fsw/records/records.hpp"
#include "fsw/records/serial.hpp"
#include "hal/store/record_bytes.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::store_tool {
namespace {

std::string digits(std::uint32_t value) {
  char text[16];
  std::snprintf(text, sizeof(text), "%08x", value);
  return text;
}

std::string digest_of_text(const std::string& text) {
  return digits(crc32({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}));
}

/// Of the record's fields, without the sizes of its blobs.
template <typename Record>
std::string digest_of(Record record) {
  const RecordInfo& info = record_info<Record>();
  drop_blobs(info, &record);
  std::vector<std::uint8_t> serial(serial_bytes(info));
  host::require(serialize(info, reinterpret_cast<const std::uint8_t*>(&record), serial), "record");
  return digits(crc32(serial));
}

class KeyframeReader {
 public:
  explicit KeyframeReader(Store& store) : store_(store) {}

  std::vector<std::string> lines() {
    std::vector<std::string> lines;
    std::string computed;
    std::string products;
    KeyframeRecord keyframe;
    Status found;
    for (found = next(store_, 0, keyframe); found.ok(); found = next(store_, keyframe.id, keyframe)) {
      const std::string parts = computed_parts(keyframe);
      const std::string coded =
          product(product_id(keyframe.id, ProductKind::depth)) + product(product_id(keyframe.id, ProductKind::image));
      lines.push_back(parts + " |" + coded);
      computed += parts;
      products += coded;
    }
    if (!found.is(StatusCode::not_found)) host::require(found, "table keyframe");
    lines.push_back("all " + std::to_string(lines.size()) + " keyframes " + digest_of_text(computed) + ", products " +
                    digest_of_text(products));
    return lines;
  }

 private:
  template <typename Record>
  bool read(std::int64_t id, Record& record) {
    const Status found = get(store_, id, record);
    if (!found.ok() && !found.is(StatusCode::not_found)) host::require(found, record_info<Record>().name);
    return found.ok();
  }

  template <typename Record>
  std::string part(std::int64_t id) {
    Record record;
    return read(id, record) ? " " + digest_of(record) : " -";
  }

  std::string product(std::int64_t id) {
    ProductRecord record;
    if (!read(id, record)) return " -";
    std::vector<std::uint8_t> data(record.data.bytes);
    host::require(read_blob<ProductRecord>(store_, "data", id, 0, data), "table product");
    if (data.size() == record.bytes && crc32(data) != record.crc32) return " damaged";
    record.state = ProductState::stored;
    record.layers_sent = record.layers_held = 0;
    return " " + digest_of(record);
  }

  std::string computed_parts(const KeyframeRecord& keyframe) {
    const std::int64_t id = keyframe.id;
    return "keyframe " + std::to_string(id) + " frame " + std::to_string(keyframe.frame_id) + " time_ns " +
           std::to_string(keyframe.time_ns) + " | " + digest_of(keyframe) + part<PoseRecord>(id) +
           part<StructureRecord>(id) + part<DepthRecord>(id) + part<MaskRecord>(id) + part<RichnessRecord>(id);
  }

  Store& store_;
};

}  // namespace

std::vector<std::string> keyframe_lines(Store& store) {
  return KeyframeReader(store).lines();
}

}  // namespace ilp::store_tool
