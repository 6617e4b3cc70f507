#include "tests/faults/results.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <stdexcept>
#include <vector>

#include "fsw/base/checksum.hpp"
#include "fsw/base/crc.hpp"
#include "fsw/vision/codec/refinement.hpp"
#include "hal/store/record_bytes.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"
#include "sim/ground/intake/record_file.hpp"

namespace ilp::faults {
namespace fs = std::filesystem;
namespace {

using RecordPlace = std::array<std::byte, limits::max_record_bytes>;

/// Tables that describe the software's own boots, or of the order in which files went, not of the flight. Products
/// count on the ground: when their records go depends on when they were confirmed.
bool is_table_of_results(RecordType type) {
  for (const RecordType other :
       {RecordType::event, RecordType::component, RecordType::timing, RecordType::start, RecordType::checkpoint,
        RecordType::commanding, RecordType::storage, RecordType::downlink, RecordType::transfer, RecordType::product,
        RecordType::identity}) {
    if (type == other) return false;
  }
  return true;
}

std::uint32_t digest_of_fields(const RecordInfo& info, const void* record) {
  std::uint32_t digest = 0;
  for (std::size_t f = 0; f < info.field_count; ++f) {
    const FieldInfo& field = info.fields[f];
    if (field.type == FieldType::blob || !is_result(info.type, field)) continue;
    const std::size_t bytes = element_bytes(field.type) * field.count;
    digest = crc32({static_cast<const std::uint8_t*>(record) + field.offset, bytes}, digest);
  }
  return digest;
}

template <typename Visit>
void for_each_type(Visit visit) {
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    visit(record_info(static_cast<RecordType>(t)));
  }
}

std::uint64_t bit_of(RecordType type) {
  return std::uint64_t{1} << static_cast<unsigned>(type);
}

/// Events of every database of the folder, those in quarantine included.
void add_events(Store& store, std::set<std::uint16_t>& events) {
  EventRecord event;
  for (std::int64_t id = 0; next(store, id, event).ok(); id = event.id) events.insert(event.code);
}

/// Digest of the results that a file of records carries. The CRC of the whole file would not do: for every file that
/// ends with its own CRC it is the same.
std::uint64_t digest_of_records(const std::vector<std::uint8_t>& file) {
  std::uint64_t digest = 0;
  for (const intake::RecordEntry& entry : intake::parse_record_file(file)) {
    // Products and the strip say how far the flight was when the file went.
    if (!is_table_of_results(entry.type) || entry.type == RecordType::strip) continue;
    const RecordInfo& info = record_info(entry.type);
    alignas(8) RecordPlace record{};
    if (!deserialize(info, entry.serial, record.data()).ok()) throw intake::BadFile("a record is too short");
    const std::uint32_t fields = digest_of_fields(info, record.data());
    digest = checksum64(memory_of(fields), digest);
    for (const intake::CodedFile& blob : entry.blobs) {
      const std::vector<std::uint8_t> bytes = blob.bytes();
      digest = checksum64(std::as_bytes(std::span(bytes)), digest);
    }
  }
  return digest;
}

std::uint64_t digest_of_file(const std::string& name, const std::vector<std::uint8_t>& file) {
  try {
    if (name.find(".ilp") != std::string::npos) return digest_of_records(file);
  } catch (const intake::BadFile&) {
    // It is reported as bytes that differ from those of the undisturbed flight.
  }
  return checksum64(std::as_bytes(std::span(file)));
}

/// Puts what a refinement brings into the product that it refines. False for any other file, and where the product is
/// not the one.
bool refines_its_product(const std::string& name, const std::vector<std::uint8_t>& file, GroundFiles& files) {
  RefinementHeader header;
  std::span<const std::uint8_t> own;
  if (name.rfind("refine-", 0) != 0 || !read_refinement(file, header, own).ok()) return false;
  // refine-000001-image-2-2.ilr refines product-000001-image.jp2.
  const std::string subject = name.substr(std::strlen("refine-"));
  const auto product = files.find("product-" + subject.substr(0, subject.find('-', subject.find('-') + 1)) + ".jp2");
  if (product == files.end()) return false;
  std::vector<std::uint8_t> refined(header.bytes);
  if (!refine(header, own, product->second, refined).ok()) return false;
  product->second = std::move(refined);
  return true;
}

void note(Difference& difference, std::uint64_t& kind, std::uint64_t bit, const char* what, const std::string& name) {
  kind |= bit;
  if (difference.items++ == 0) std::snprintf(difference.first, sizeof(difference.first), "%s %s", what, name.c_str());
}

std::string name_of(const RecordKey& key) {
  return std::string(record_info(key.first).name) + " " + std::to_string(key.second);
}

}  // namespace

bool is_result(RecordType type, const FieldInfo& field) {
  if (!is_table_of_results(type)) return false;
  // The time of a command to end a strip is no result; the frame that the record names is.
  return type != RecordType::command || std::strcmp(field.name, "time_ns") != 0;
}

Status digest_of(Store& store, const RecordInfo& info, std::int64_t id, Digest& digest) {
  alignas(8) RecordPlace record{};
  ILP_TRY(store.get(info, id, record.data()));
  digest = {};
  digest.fields = digest_of_fields(info, record.data());
  Status status;
  for_each_blob(info, [&](const FieldInfo& field, std::size_t index) {
    std::vector<std::uint8_t> bytes(blob_bytes(record.data(), field));
    if (bytes.empty() || !status.ok()) return;
    status = store.read_blob(info, field.name, id, 0, bytes);
    digest.blobs[index] = std::max(crc32(bytes), 1U);
  });
  return status;
}

bool Digest::same(RecordType type, const Digest& other) const {
  if (fields != other.fields) return false;
  // What is no longer needed is released now or later.
  constexpr RecordMask of_needed_bytes =
      mask_of(RecordType::frame, RecordType::depth, RecordType::mask, RecordType::structure);
  const bool released = (mask_of(type) & of_needed_bytes) != 0;
  for (std::size_t i = 0; i < blobs.size(); ++i) {
    const bool one_is_gone = blobs[i] == 0 || other.blobs[i] == 0;
    if (blobs[i] != other.blobs[i] && !(released && one_is_gone)) return false;
  }
  return true;
}

Results results_of(Store& store) {
  Results results;
  for_each_type([&](const RecordInfo& info) {
    if (!is_table_of_results(info.type)) return;
    alignas(8) RecordPlace record{};
    Status status;
    for (std::int64_t id = 0; (status = store.next(info, id, record.data())).ok();) {
      id = id_of(record.data());
      status = digest_of(store, info, id, results.records[{info.type, id}]);
      if (!status.ok()) break;
    }
    if (!status.is(StatusCode::not_found)) throw std::runtime_error(std::string("cannot read ") + info.name);
  });
  add_events(store, results.events);
  return results;
}

GroundFiles files_of(const fs::path& folder) {
  GroundFiles files;
  for (const auto& entry : fs::directory_iterator(folder / "outbox")) {
    if (entry.path().extension() == ".part") continue;
    std::ifstream in(entry.path(), std::ios::binary);
    files[entry.path().filename().string()] = {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  }
  return files;
}

std::map<std::string, std::uint64_t> results_of(GroundFiles files) {
  // In the order of their names the refinements of a product follow each other.
  for (auto file = files.begin(); file != files.end();) {
    file = refines_its_product(file->first, file->second, files) ? files.erase(file) : std::next(file);
  }
  std::map<std::string, std::uint64_t> results;
  for (const auto& [name, bytes] : files) {
    if (name.rfind("events-", 0) != 0) results[name] = digest_of_file(name, bytes);
  }
  return results;
}

Results results_of(const fs::path& folder) {
  SqliteStore store;
  if (!store.open_read_only((folder / "flight.db").c_str()).ok()) throw std::runtime_error("cannot open the database");
  Results results = results_of(store);
  results.files = results_of(files_of(folder));
  return results;
}

std::string names_of(std::uint64_t tables) {
  std::string names;
  const auto add = [&names](const char* name) { names += (names.empty() ? "" : ", ") + std::string(name); };
  for_each_type([&](const RecordInfo& info) {
    if ((tables & bit_of(info.type)) != 0) add(info.name);
  });
  if ((tables >> ground_files & 1U) != 0) add("files on the ground");
  return names;
}

Difference compare(const Results& expected, const std::set<RecordKey>& before, Store& store, const GroundFiles& files,
                   std::set<std::uint16_t>& events) {
  Difference difference;
  for (const auto& [key, digest] : expected.records) {
    Digest found;
    const Status status = digest_of(store, record_info(key.first), key.second, found);
    const std::uint64_t bit = bit_of(key.first);
    if (status.is(StatusCode::not_found)) {
      note(difference, difference.missing, bit, "missing", name_of(key));
      if (before.count(key) != 0) difference.gone |= bit;
    } else if (!status.ok()) {
      note(difference, difference.reported, bit, "unreadable", name_of(key));
    } else if (!found.same(key.first, digest)) {
      note(difference, difference.changed, bit, "changed", name_of(key));
      if (before.count(key) != 0) difference.altered |= bit;
    }
  }
  for_each_type([&](const RecordInfo& info) {
    if (!is_table_of_results(info.type)) return;
    alignas(8) RecordPlace record{};
    for (std::int64_t id = 0; store.next(info, id, record.data()).ok();) {
      id = id_of(record.data());
      const RecordKey key{info.type, id};
      if (expected.records.count(key) == 0)
        note(difference, difference.extra, bit_of(info.type), "extra", name_of(key));
    }
  });
  constexpr std::uint64_t bit = std::uint64_t{1} << ground_files;
  const std::map<std::string, std::uint64_t> results = results_of(files);
  for (const auto& [name, digest] : expected.files) {
    const auto found = results.find(name);
    if (found == results.end()) {
      note(difference, difference.missing, bit, "missing", name);
    } else if (found->second != digest) {
      note(difference, difference.changed, bit, "changed", name);
    }
  }
  for (const auto& file : results) {
    if (expected.files.count(file.first) == 0) note(difference, difference.extra, bit, "extra", file.first);
  }
  // What counts as confirmed is on the ground.
  DownlinkRecord sent;
  for (std::int64_t id = 0; next(store, id, sent).ok(); id = sent.id) {
    const auto held = files.find(sent.name);
    const bool reported = std::strncmp(sent.name, "events-", 7) == 0;
    if (reported || sent.acknowledged_ns == 0 || (held != files.end() && crc32(held->second) == sent.crc32)) continue;
    note(difference, difference.changed, bit_of(RecordType::downlink), "falsely confirmed", sent.name);
    difference.altered |= bit_of(RecordType::downlink);
  }
  add_events(store, events);
  return difference;
}

}  // namespace ilp::faults
