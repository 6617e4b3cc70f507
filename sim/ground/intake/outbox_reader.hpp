// Reads an outbox folder, checks every downlinked file, and assembles records and products.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fsw/vision/codec/refinement.hpp"
#include "sim/ground/intake/coded_file.hpp"
#include "sim/ground/intake/other_flights.hpp"

namespace ilp::intake {

struct ReceivedFile {
  std::string name;
  std::uint64_t bytes = 0;
  std::uint32_t crc32 = 0;
  std::string fault;  ///< why the file is not used; empty: it is used
};

struct ReceivedProduct {
  std::size_t file = 0;  ///< index in Outbox::files
  std::int64_t keyframe_id = 0;
  ProductKind kind = ProductKind::image;
  CodedFile bytes;       ///< the file, with all refinements that could be used
  bool refined = false;  ///< `bytes` contains refinements
};

struct Outbox {
  std::vector<ReceivedFile> files;  ///< in the order in which they were added
  std::vector<RecordEntry> records;
  std::vector<ReceivedProduct> products;
  std::vector<std::string> waiting;  ///< in words: refinements that cannot be used because earlier layers are missing
};

/// Checks that the content of a file matches its name, without decoding it. Throws BadFile.
void check_file(std::string_view name, std::span<const std::uint8_t> bytes);

/// The flight software writes no file as large as this.
inline constexpr std::uintmax_t max_file_bytes = std::uintmax_t{256} << 20U;

/// Assembles an outbox from its files, in any order. A bad file is listed with its fault and not used. A file may come
/// in several versions. Of a product, the version that matches size and checksum of its record is used, else one whose
/// size is that of some of its layers, else the longest. Of record files, which have their own checksum, all versions
/// are used.
class OutboxBuilder {
 public:
  /// Products and blobs of records are moved into the spool; null: they stay in memory.
  explicit OutboxBuilder(std::shared_ptr<Spool> spool = nullptr) : spool_(std::move(spool)) {}
  void add(const std::string& name, std::vector<std::uint8_t> bytes);
  /// Lists a file that is missing or cannot be used.
  void add_fault(ReceivedFile file) { outbox_.files.push_back(std::move(file)); }
  [[nodiscard]] Outbox finish();

 private:
  struct Refinement {
    std::size_t file = 0;  ///< index in Outbox::files
    std::vector<std::uint8_t> bytes;
    RefinementHeader header;
    std::span<const std::uint8_t> own;  ///< in `bytes`
    bool done = false;                  ///< used, found invalid, or not needed because other files have its layers
  };
  void put_away(RecordFile& records) const;
  void add_refinement(std::size_t file, std::vector<std::uint8_t> bytes);
  void choose_versions();
  [[nodiscard]] bool refine_once(std::vector<std::uint8_t>& product, int& layers,
                                 std::span<Refinement* const> refinements);
  void refine_product(ReceivedProduct& product, std::span<Refinement* const> refinements);
  void put_products_together();

  void take_records();

  std::shared_ptr<Spool> spool_;
  Outbox outbox_;
  std::vector<RecordFile> record_files_;
  std::vector<Refinement> refinements_;
};

/// Reads a folder that may hold any subset of an outbox's files, in any state. Throws std::runtime_error only if the
/// folder itself cannot be read.
[[nodiscard]] Outbox read_outbox(const std::filesystem::path& folder);

/// The regular files of a folder, sorted by name. Throws std::runtime_error if the folder cannot be read.
[[nodiscard]] std::vector<std::filesystem::path> files_of(const std::filesystem::path& folder);

/// The acknowledgement of every file without a fault; key: NAME.ack; value: its content. The others must come again.
[[nodiscard]] std::map<std::string, std::string> acknowledgements_of(const Outbox& outbox);
/// Writes the acknowledgements as files. Throws std::runtime_error if the folder cannot be written.
void write_acknowledgements(const std::map<std::string, std::string>& acknowledgements,
                            const std::filesystem::path& folder);

}  // namespace ilp::intake
