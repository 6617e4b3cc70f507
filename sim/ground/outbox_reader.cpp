#include "sim/ground/outbox_reader.hpp"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include "fsw/base/crc.hpp"
#include "sim/ground/host_files.hpp"

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

void read_one(const fs::path& path, std::size_t index, ReceivedFile& file, Outbox& outbox) {
  const std::string_view name = file.name;
  const bool is_records = name.ends_with(".ilp");
  const auto product = product_name(name);
  if (!is_records && !product) throw BadFile("foreign: neither an .ilp file nor a product");
  if (file.bytes > max_file_bytes) throw BadFile("larger than any file of the flight software");
  if (file.bytes == 0) throw BadFile("empty");
  std::vector<std::uint8_t> bytes = read_file(path);
  file.bytes = bytes.size();
  file.crc32 = crc32(bytes);
  if (is_records) {
    auto entries = parse_record_file(bytes);
    std::move(entries.begin(), entries.end(), std::back_inserter(outbox.records));
  } else {
    outbox.products.push_back({index, product->keyframe_id, product->kind, std::move(bytes)});
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
  for (const fs::path& path : paths) {
    ReceivedFile file;
    file.name = path.filename().string();
    if (!fs::is_regular_file(path, error)) continue;
    file.bytes = fs::file_size(path, error);
    try {
      read_one(path, outbox.files.size(), file, outbox);
    } catch (const std::exception& fault) {
      file.fault = fault.what();
    }
    outbox.files.push_back(std::move(file));
  }
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
