// What came down: every file of an outbox folder, checked one by one.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fsw/vision/codec/refinement.hpp"
#include "sim/ground/intake/other_flights.hpp"

namespace ilp::ground {

struct ReceivedFile {
  std::string name;
  std::uint64_t bytes = 0;
  std::uint32_t crc32 = 0;
  std::string fault;  ///< why it was skipped; empty when it is used
};

struct ReceivedProduct {
  std::size_t file = 0;  ///< index in Outbox::files
  std::int64_t keyframe_id = 0;
  ProductKind kind = ProductKind::image;
  std::vector<std::uint8_t> bytes;  ///< with all refinements that came
  bool refined = false;             ///< more than the file of its name
};

struct Outbox {
  std::vector<ReceivedFile> files;  ///< by name
  std::vector<RecordEntry> records;
  std::vector<ReceivedProduct> products;
  std::vector<std::string> waiting;  ///< refinements that cannot be used yet, in words: what they refine is missing
};

/// Whether a file is what its name says, as far as it tells by itself: nothing is decoded. Throws BadFile.
void check_file(std::string_view name, std::span<const std::uint8_t> bytes);

/// Larger than anything the flight software may write.
inline constexpr std::uintmax_t max_file_bytes = std::uintmax_t{256} << 20U;

/// Puts an outbox together from its files, in any order. A bad file is listed with its fault and otherwise left out.
/// Several versions of a file may come: of a product the one that its record proves is used, else the longest; of
/// record files, each of which proves itself, all.
class OutboxBuilder {
 public:
  void add(const std::string& name, std::vector<std::uint8_t> bytes);
  /// A file that is not there any more, or not worth keeping.
  void add_fault(ReceivedFile file) { outbox_.files.push_back(std::move(file)); }
  [[nodiscard]] Outbox finish();

 private:
  struct Refinement {
    std::size_t file = 0;  ///< index in Outbox::files
    std::vector<std::uint8_t> bytes;
    RefinementHeader header;
    std::span<const std::uint8_t> own;  ///< in `bytes`
  };
  void add_refinement(std::size_t file, std::vector<std::uint8_t> bytes);
  void choose_versions();
  [[nodiscard]] bool refine_once(ReceivedProduct& product);
  void put_products_together();

  void take_records();

  Outbox outbox_;
  std::vector<RecordFile> record_files_;
  std::vector<Refinement> refinements_;
};

/// Any subset of the files, in any order, in any state. Products are put together from their first file and what
/// refines it. Throws std::runtime_error only when the folder itself cannot be read.
[[nodiscard]] Outbox read_outbox(const std::filesystem::path& folder);

/// The regular files of a folder, by name. Throws std::runtime_error.
[[nodiscard]] std::vector<std::filesystem::path> files_of(const std::filesystem::path& folder);

/// NAME.ack for every file that is held complete; a file in part or damaged must come again. Throws when the folder
/// cannot be written.
void write_acknowledgements(const Outbox& outbox, const std::filesystem::path& folder);

}  // namespace ilp::ground
