// Reads an outbox folder and checks every file that came down.
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
  std::string fault;  ///< why it was skipped; empty when it is used
};

struct ReceivedProduct {
  std::size_t file = 0;  ///< index in Outbox::files
  std::int64_t keyframe_id = 0;
  ProductKind kind = ProductKind::image;
  CodedFile bytes;       ///< with all refinements that came
  bool refined = false;  ///< more than the file of its name
};

struct Outbox {
  std::vector<ReceivedFile> files;  ///< by name
  std::vector<RecordEntry> records;
  std::vector<ReceivedProduct> products;
  std::vector<std::string> waiting;  ///< refinements that cannot be used yet, in words: what they refine is missing
};

/// Checks that the content of a file matches its name, without decoding it. Throws BadFile.
void check_file(std::string_view name, std::span<const std::uint8_t> bytes);

/// The flight software writes no file as large as this.
inline constexpr std::uintmax_t max_file_bytes = std::uintmax_t{256} << 20U;

/// Assembles an outbox from its files, in any order. A bad file is listed with its fault and not used. Several versions
/// of a file may come: of a product, the version that matches the checksum on record is used, else the longest; of
/// record files, which carry their own checksum, all versions are used.
class OutboxBuilder {
 public:
  /// Products and blobs of records are put away in the spool, where there is one.
  explicit OutboxBuilder(std::shared_ptr<Spool> spool = nullptr) : spool_(std::move(spool)) {}
  void add(const std::string& name, std::vector<std::uint8_t> bytes);
  /// Lists a file that is gone or cannot be used.
  void add_fault(ReceivedFile file) { outbox_.files.push_back(std::move(file)); }
  [[nodiscard]] Outbox finish();

 private:
  struct Refinement {
    std::size_t file = 0;  ///< index in Outbox::files
    std::vector<std::uint8_t> bytes;
    RefinementHeader header;
    std::span<const std::uint8_t> own;  ///< in `bytes`
    bool done = false;                  ///< used, found wrong, or its layers came in other files too
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

/// The folder may hold any subset of the files, in any state. Products are assembled from their first file and its
/// refinements. Throws std::runtime_error only when the folder itself cannot be read.
[[nodiscard]] Outbox read_outbox(const std::filesystem::path& folder);

/// The regular files of a folder, by name. Throws std::runtime_error.
[[nodiscard]] std::vector<std::filesystem::path> files_of(const std::filesystem::path& folder);

/// NAME.ack with its content for every complete file; a damaged or partial file must come again.
[[nodiscard]] std::map<std::string, std::string> acknowledgements_of(const Outbox& outbox);
/// Writes them. Throws when the folder cannot be written.
void write_acknowledgements(const std::map<std::string, std::string>& acknowledgements,
                            const std::filesystem::path& folder);

}  // namespace ilp::intake
