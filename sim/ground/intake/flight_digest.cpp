#include "sim/ground/intake/flight_digest.hpp"

#include <cstdio>
#include <cstring>
#include <memory>

#include "fsw/base/crc.hpp"
#include "fsw/records/serial.hpp"
#include "hal/store/record_bytes.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::intake {
namespace {

std::string digits(std::uint32_t value) {
  char text[16];
  std::snprintf(text, sizeof(text), "%08x", value);
  return text;
}

std::string digest_of_text(const std::string& text) {
  return digits(crc32({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}));
}

// What is computed once for a flight, a frame or a strip.
constexpr RecordType tables[] = {RecordType::camera,           RecordType::frame, RecordType::capture,
                                 RecordType::overlap,          RecordType::strip, RecordType::calibration,
                                 RecordType::calibration_check};

/// Continues `crc` over the record's fields, without the sizes of its blobs.
std::uint32_t digest_of(const RecordInfo& info, std::uint8_t* record, std::uint32_t crc) {
  drop_blobs(info, record);
  std::vector<std::uint8_t> serial(serial_bytes(info));
  host::require(serialize(info, record, serial), "record");
  return crc32(serial, crc);
}

template <typename Record>
std::string digest_of(Record record) {
  return digits(digest_of(record_info<Record>(), reinterpret_cast<std::uint8_t*>(&record), 0));
}

class Digest {
 public:
  explicit Digest(const std::filesystem::path& database) : name_(database.string()) {
    host::require(store_->open_read_only(database.c_str()), name_);
  }

  std::vector<std::string> lines() {
    std::vector<std::string> lines;
    std::string computed;
    std::string products;
    KeyframeRecord keyframe;
    Status found;
    for (found = next(*store_, 0, keyframe); found.ok(); found = next(*store_, keyframe.id, keyframe)) {
      const std::string parts = computed_parts(keyframe);
      const std::string coded =
          product(product_id(keyframe.id, ProductKind::depth)) + product(product_id(keyframe.id, ProductKind::image));
      lines.push_back(parts + " |" + coded);
      computed += parts;
      products += coded;
    }
    if (!found.is(StatusCode::not_found)) host::require(found, name_);
    lines.push_back("all " + std::to_string(lines.size()) + " keyframes " + digest_of_text(computed) + ", products " +
                    digest_of_text(products));
    for (const RecordType type : tables) lines.push_back(table(record_info(type)));
    return lines;
  }

 private:
  template <typename Record>
  bool read(std::int64_t id, Record& record) {
    const Status found = get(*store_, id, record);
    if (!found.ok() && !found.is(StatusCode::not_found)) host::require(found, name_);
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
    host::require(read_blob<ProductRecord>(*store_, "data", id, 0, data), name_);
    if (data.size() == record.bytes && crc32(data) != record.crc32) return " damaged";
    record.state = ProductState::stored;
    record.layers_sent = record.layers_held = 0;
    return " " + digest_of(record);
  }

  std::string table(const RecordInfo& info) {
    alignas(8) std::uint8_t record[limits::max_record_bytes] = {};
    std::uint32_t crc = 0;
    std::int64_t rows = 0;
    std::int64_t id = 0;
    Status found;
    for (found = store_->next(info, id, record); found.ok(); found = store_->next(info, id, record)) {
      id = id_of(record);
      crc = digest_of(info, record, crc);
      ++rows;
    }
    if (!found.is(StatusCode::not_found)) host::require(found, name_);
    return std::string("table ") + info.name + " " + std::to_string(rows) + " rows " + digits(crc);
  }

  std::string computed_parts(const KeyframeRecord& keyframe) {
    const std::int64_t id = keyframe.id;
    return "keyframe " + std::to_string(id) + " frame " + std::to_string(keyframe.frame_id) + " time_ns " +
           std::to_string(keyframe.time_ns) + " | " + digest_of(keyframe) + part<PoseRecord>(id) +
           part<StructureRecord>(id) + part<DepthRecord>(id) + part<RichnessRecord>(id);
  }

  std::string name_;
  std::unique_ptr<SqliteStore> store_ = std::make_unique<SqliteStore>();
};

}  // namespace

std::vector<std::string> flight_digest(const std::filesystem::path& database) {
  return Digest(database).lines();
}

}  // namespace ilp::intake
