#include "sim/ground/intake/outbox_reader.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include "fsw/base/crc.hpp"
#include "sim/ground/intake/ids.hpp"
#include "sim/ground/intake/product.hpp"
#include "sim/host/files.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::intake {
namespace {
namespace fs = std::filesystem;

enum class FileKind { records, refinement, product };

FileKind kind_of(std::string_view name) {
  if (name.ends_with(".ilp")) return FileKind::records;
  if (name.ends_with(".ilr")) return FileKind::refinement;
  if (product_named(name)) return FileKind::product;
  throw BadFile("foreign: neither an .ilp file nor a product or its refinement");
}

void check_size(std::uintmax_t bytes) {
  if (bytes > max_file_bytes) throw BadFile("larger than any file of the flight software");
  if (bytes == 0) throw BadFile("empty");
}

RefinementHeader checked_refinement(std::span<const std::uint8_t> bytes, std::span<const std::uint8_t>& own) {
  RefinementHeader header;
  const Status status = read_refinement(bytes, header, own);
  if (!status.ok()) throw BadFile("not a whole refinement: " + host::status_sentence(status));
  if (!product_of(header.product_id)) {
    throw BadFile("refines product " + std::to_string(header.product_id) + ": no flight has such a number");
  }
  return header;
}

/// What the flight says of a product that it has coded.
std::map<std::int64_t, ProductRecord> product_records(const std::vector<RecordEntry>& entries) {
  std::map<std::int64_t, ProductRecord> records;
  for (const RecordEntry& entry : entries) {
    if (entry.type != RecordType::product) continue;
    const auto record = record_of<ProductRecord>(entry);
    records[record.id] = record;
  }
  return records;
}

/// 2: the record proves it; 1: it has the length on record for its number of layers, or there is no record; 0: neither.
int standing(const ReceivedProduct& product, std::uint32_t crc, const std::map<std::int64_t, ProductRecord>& records) {
  const auto found = records.find(product_id(product.keyframe_id, product.kind));
  if (found == records.end()) return 1;
  const ProductRecord& record = found->second;
  if (record.bytes == product.bytes.size()) return record.crc32 == crc ? 2 : 0;
  const auto* end = record.layer_bytes + std::min<std::size_t>(record.layers, limits::max_quality_layers);
  return std::find(record.layer_bytes, end, product.bytes.size()) == end ? 0 : 1;
}

}  // namespace

void check_file(std::string_view name, std::span<const std::uint8_t> bytes) {
  const FileKind kind = kind_of(name);
  check_size(bytes.size());
  std::span<const std::uint8_t> own;
  if (kind == FileKind::records) (void)parse_record_file(bytes);
  if (kind == FileKind::refinement) (void)checked_refinement(bytes, own);
  if (kind == FileKind::product) (void)read_product_header(bytes);
}

void OutboxBuilder::add(const std::string& name, std::vector<std::uint8_t> bytes) {
  const std::size_t index = outbox_.files.size();
  ReceivedFile& file = outbox_.files.emplace_back();
  file.name = name;
  file.bytes = bytes.size();
  try {
    const FileKind kind = kind_of(name);
    check_size(bytes.size());
    file.crc32 = crc32(bytes);
    if (kind == FileKind::records) {
      record_files_.push_back({index, parse_record_file(bytes)});
      if (spool_) put_away(record_files_.back());
    } else if (kind == FileKind::refinement) {
      add_refinement(index, std::move(bytes));
    } else {
      const auto product = product_named(name);
      outbox_.products.push_back({index, product->keyframe_id, product->kind, std::move(bytes), false});
      if (spool_) outbox_.products.back().bytes.put_away(spool_);
    }
  } catch (const BadFile& fault) {
    outbox_.files[index].fault = fault.what();
  }
}

void OutboxBuilder::put_away(RecordFile& records) const {
  for (RecordEntry& entry : records.entries) {
    for (CodedFile& blob : entry.blobs) blob.put_away(spool_);
  }
}

void OutboxBuilder::add_refinement(std::size_t file, std::vector<std::uint8_t> bytes) {
  Refinement refinement;
  refinement.file = file;
  refinement.bytes = std::move(bytes);
  refinement.header = checked_refinement(refinement.bytes, refinement.own);
  refinements_.push_back(std::move(refinement));
}

void OutboxBuilder::choose_versions() {
  const auto records = product_records(outbox_.records);
  const auto better = [&](const ReceivedProduct& a, const ReceivedProduct& b) {
    const std::uint32_t crc_a = outbox_.files[a.file].crc32, crc_b = outbox_.files[b.file].crc32;
    const int standing_a = standing(a, crc_a, records), standing_b = standing(b, crc_b, records);
    if (standing_a != standing_b) return standing_a > standing_b;
    return a.bytes.size() != b.bytes.size() ? a.bytes.size() > b.bytes.size() : crc_a < crc_b;
  };
  std::vector<ReceivedProduct> chosen;
  std::map<std::int64_t, std::size_t> places;
  for (ReceivedProduct& product : outbox_.products) {
    const auto [place, is_first] = places.emplace(product_id(product.keyframe_id, product.kind), chosen.size());
    if (is_first) {
      chosen.push_back(std::move(product));
      continue;
    }
    if (better(product, chosen[place->second])) std::swap(product, chosen[place->second]);
    outbox_.files[product.file].fault = "another version of this file is used";
  }
  outbox_.products = std::move(chosen);
}

/// Uses one of the product's refinements, the one that brings most, for layers that the product does not have; false
/// when there is none. Layers only grow, so that a product takes a few refinements at most, whatever their headers say.
bool OutboxBuilder::refine_once(std::vector<std::uint8_t>& product, int& layers,
                                std::span<Refinement* const> refinements) {
  Refinement* best = nullptr;
  for (Refinement* refinement : refinements) {
    const RefinementHeader& header = refinement->header;
    if (refinement->done || header.shorter_bytes != product.size() || header.first_layer <= layers) continue;
    if (best == nullptr || header.last_layer > best->header.last_layer) best = refinement;
  }
  if (best == nullptr) return false;
  best->done = true;
  std::vector<std::uint8_t> refined(best->header.bytes);
  if (best->header.bytes <= max_file_bytes && refine(best->header, best->own, product, refined).ok()) {
    product = std::move(refined);
    layers = best->header.last_layer;
  } else {
    outbox_.files[best->file].fault = "does not refine what came down under its product's name";
  }
  return true;
}

void OutboxBuilder::refine_product(ReceivedProduct& product, std::span<Refinement* const> refinements) {
  std::vector<std::uint8_t> bytes = product.bytes.bytes();
  int layers = 1;
  while (refine_once(bytes, layers, refinements)) {
  }
  for (Refinement* refinement : refinements) {
    if (bytes.size() >= refinement->header.bytes) refinement->done = true;
  }
  if (layers == 1) return;
  product.bytes = std::move(bytes);
  if (spool_) product.bytes.put_away(spool_);
  product.refined = true;
}

void OutboxBuilder::put_products_together() {
  std::map<std::int64_t, std::vector<Refinement*>> of_product;
  for (Refinement& refinement : refinements_) of_product[refinement.header.product_id].push_back(&refinement);
  for (ReceivedProduct& product : outbox_.products) {
    const auto found = of_product.find(product_id(product.keyframe_id, product.kind));
    if (found != of_product.end()) refine_product(product, found->second);
  }
  for (const Refinement& refinement : refinements_) {
    if (refinement.done) continue;
    outbox_.waiting.push_back(outbox_.files[refinement.file].name + ": the layers before it have not come");
  }
}

void OutboxBuilder::take_records() {
  for (ForeignFile& foreign : files_of_other_flights(record_files_)) {
    outbox_.files[foreign.file].fault = std::move(foreign.fault);
  }
  for (RecordFile& records : record_files_) {
    if (!outbox_.files[records.file].fault.empty()) continue;
    std::move(records.entries.begin(), records.entries.end(), std::back_inserter(outbox_.records));
  }
}

Outbox OutboxBuilder::finish() {
  take_records();
  choose_versions();
  put_products_together();
  return std::move(outbox_);
}

std::vector<fs::path> files_of(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error))
    throw std::runtime_error("no such folder: " + folder.string() +
                             "; name the outbox of a flight, or the folder in which its files arrive");
  std::vector<fs::path> paths;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code ignored;
    if (it->is_regular_file(ignored)) paths.push_back(it->path());
  }
  if (error) throw std::runtime_error("cannot list " + folder.string() + ": " + error.message());
  std::sort(paths.begin(), paths.end());
  return paths;
}

Outbox read_outbox(const fs::path& folder) {
  OutboxBuilder builder;
  for (const fs::path& path : files_of(folder)) {
    const std::string name = path.filename().string();
    ReceivedFile file;
    file.name = name;
    std::error_code error;
    file.bytes = fs::file_size(path, error);
    try {
      (void)kind_of(name);
      check_size(file.bytes);
      builder.add(name, host::read_file(path));
    } catch (const std::exception& fault) {
      file.fault = fault.what();
      builder.add_fault(std::move(file));
    }
  }
  return builder.finish();
}

std::map<std::string, std::string> acknowledgements_of(const Outbox& outbox) {
  std::map<std::string, std::string> acknowledgements;
  for (const ReceivedFile& file : outbox.files) {
    if (!file.fault.empty()) continue;
    acknowledgements[file.name + ".ack"] = std::to_string(file.bytes) + " " + std::to_string(file.crc32) + "\n";
  }
  return acknowledgements;
}

void write_acknowledgements(const std::map<std::string, std::string>& acknowledgements, const fs::path& folder) {
  host::make_output_folder(folder);
  for (const auto& [name, content] : acknowledgements) host::update_file(folder / name, content);
}

}  // namespace ilp::intake
