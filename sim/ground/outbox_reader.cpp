#include "sim/ground/outbox_reader.hpp"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include "fsw/base/crc.hpp"
#include "fsw/vision/codec/refinement.hpp"
#include "sim/ground/host_files.hpp"
#include "sim/ground/status_words.hpp"

namespace ilp::ground {
namespace {
namespace fs = std::filesystem;

// Larger than anything the flight software may write; a foreign file of gigabytes is not read at all.
constexpr std::uintmax_t max_file_bytes = std::uintmax_t{256} << 20U;

struct ProductName {
  std::int64_t keyframe_id = 0;
  ProductKind kind = ProductKind::image;
};

std::optional<ProductName> product_name(std::string_view name) {
  constexpr std::string_view prefix = "product-";
  if (!name.starts_with(prefix)) return std::nullopt;
  name.remove_prefix(prefix.size());
  ProductName product;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), product.keyframe_id);
  if (error != std::errc() || product.keyframe_id <= 0) return std::nullopt;
  name.remove_prefix(static_cast<std::size_t>(end - name.data()));
  if (name == "-image.jp2") return product;
  product.kind = ProductKind::depth;
  if (name == "-depth.jp2") return product;
  return std::nullopt;
}

struct Refinement {
  std::size_t file = 0;  ///< index in Outbox::files
  std::vector<std::uint8_t> bytes;
  RefinementHeader header;
  std::span<const std::uint8_t> own;  ///< in `bytes`
};

Refinement read_refinement_file(std::size_t index, std::vector<std::uint8_t> bytes) {
  Refinement refinement;
  refinement.file = index;
  refinement.bytes = std::move(bytes);
  const Status status = read_refinement(refinement.bytes, refinement.header, refinement.own);
  if (!status.ok()) throw BadFile("not a whole refinement: " + status_sentence(status));
  return refinement;
}

void read_one(const fs::path& path, std::size_t index, ReceivedFile& file, Outbox& outbox,
              std::vector<Refinement>& refinements) {
  const std::string_view name = file.name;
  const bool is_records = name.ends_with(".ilp"), is_refinement = name.ends_with(".ilr");
  const auto product = product_name(name);
  if (!is_records && !is_refinement && !product) {
    throw BadFile("foreign: neither an .ilp file nor a product or its refinement");
  }
  if (file.bytes > max_file_bytes) throw BadFile("larger than any file of the flight software");
  if (file.bytes == 0) throw BadFile("empty");
  std::vector<std::uint8_t> bytes = read_file(path);
  file.bytes = bytes.size();
  file.crc32 = crc32(bytes);
  if (is_records) {
    auto entries = parse_record_file(bytes);
    std::move(entries.begin(), entries.end(), std::back_inserter(outbox.records));
  } else if (is_refinement) {
    refinements.push_back(read_refinement_file(index, std::move(bytes)));
  } else {
    outbox.products.push_back({index, product->keyframe_id, product->kind, std::move(bytes), false});
  }
}

bool refines(const Refinement& refinement, const ReceivedProduct& product) {
  return refinement.header.product_id == product_id(product.keyframe_id, product.kind) &&
         refinement.header.shorter_bytes == product.bytes.size();
}

/// Uses one refinement of the product, the one that brings most; false when there is none.
bool refine_once(ReceivedProduct& product, std::vector<Refinement>& refinements, Outbox& outbox) {
  auto best = refinements.end();
  for (auto it = refinements.begin(); it != refinements.end(); ++it) {
    if (!refines(*it, product)) continue;
    if (best == refinements.end() || it->header.last_layer > best->header.last_layer) best = it;
  }
  if (best == refinements.end()) return false;
  std::vector<std::uint8_t> refined(best->header.bytes);
  const Status status = refine(best->header, best->own, product.bytes, refined);
  if (status.ok()) {
    product.bytes = std::move(refined);
    product.refined = true;
  } else {
    outbox.files[best->file].fault = "does not refine what came down under its product's name";
  }
  refinements.erase(best);
  return true;
}

void put_products_together(std::vector<Refinement>& refinements, Outbox& outbox) {
  for (ReceivedProduct& product : outbox.products) {
    while (refine_once(product, refinements, outbox)) {
    }
  }
  for (const Refinement& refinement : refinements) {
    const std::int64_t id = refinement.header.product_id;
    const bool passed =
        std::any_of(outbox.products.begin(), outbox.products.end(), [&](const ReceivedProduct& product) {
          return product_id(product.keyframe_id, product.kind) == id && product.bytes.size() >= refinement.header.bytes;
        });
    // The same layers came in other files too.
    if (passed) continue;
    outbox.waiting.push_back(outbox.files[refinement.file].name + ": the layers before it have not come");
  }
}

}  // namespace

Outbox read_outbox(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) throw std::runtime_error("no such folder: " + folder.string());
  std::vector<fs::path> paths;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    paths.push_back(it->path());
  }
  if (error) throw std::runtime_error("cannot list " + folder.string() + ": " + error.message());
  std::sort(paths.begin(), paths.end());

  Outbox outbox;
  std::vector<Refinement> refinements;
  for (const fs::path& path : paths) {
    ReceivedFile file;
    file.name = path.filename().string();
    if (!fs::is_regular_file(path, error)) continue;
    file.bytes = fs::file_size(path, error);
    try {
      read_one(path, outbox.files.size(), file, outbox, refinements);
    } catch (const std::exception& fault) {
      file.fault = fault.what();
    }
    outbox.files.push_back(std::move(file));
  }
  put_products_together(refinements, outbox);
  return outbox;
}

void write_acknowledgements(const Outbox& outbox, const fs::path& folder) {
  make_output_folder(folder);
  for (const ReceivedFile& file : outbox.files) {
    if (!file.fault.empty()) continue;
    write_file(folder / (file.name + ".ack"), std::to_string(file.bytes) + " " + std::to_string(file.crc32) + "\n");
  }
}

}  // namespace ilp::ground
