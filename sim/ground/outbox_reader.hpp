// What came down: every file of an outbox folder, checked one by one.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "sim/ground/record_file.hpp"

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

/// Any subset of the files, in any order, in any state: a bad file is listed with its fault and otherwise left out.
/// Products are put together from their first file and what refines it. Throws std::runtime_error only when the folder
/// itself cannot be read.
[[nodiscard]] Outbox read_outbox(const std::filesystem::path& folder);

/// NAME.ack for every file that is held complete; a file in part or damaged must come again. Throws when the folder
/// cannot be written.
void write_acknowledgements(const Outbox& outbox, const std::filesystem::path& folder);

}  // namespace ilp::ground
