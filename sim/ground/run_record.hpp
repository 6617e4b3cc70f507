// What a run has left, so that the next run knows what has changed since: a digest of all that the results follow from,
// and the state of every file of them. It is the file results.txt in the folder of the results.
#pragma once

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <map>
#include <string>
#include <vector>

#include "sim/ground/ground_run.hpp"
#include "sim/host/files.hpp"

namespace ilp::ground {

struct ResultFile {
  host::FileState state;
  std::uint64_t content = 0;  ///< digest; 0 for the catalogue, which checks its content itself
};

struct RunRecord {
  std::uint64_t inputs = 0;                 ///< digest_of_inputs when the run began; 0: there was no whole run
  std::string outbox;                       ///< folder of the downlink; empty: not known
  std::vector<std::string> said;            ///< lines for the user
  std::map<std::string, ResultFile> files;  ///< by their names below the folder
  std::map<std::string, std::string> acknowledgements;  ///< content by name, of a run that wrote them
};

/// Of the options, the program itself and its version of GDAL, and name, size and times of all files that the options
/// name, in the outbox too. Where the results lie and whether they begin afresh is left out.
[[nodiscard]] std::uint64_t digest_of_inputs(const GroundOptions& options);

/// An empty record where there is none, or where it is damaged.
[[nodiscard]] RunRecord read_record(const std::filesystem::path& out);
/// Throws std::runtime_error when it cannot be written.
void write_record(const RunRecord& record, const std::filesystem::path& out);
/// How a record names the downlink.
[[nodiscard]] std::string name_of_outbox(const std::filesystem::path& outbox);
void forget_record(const std::filesystem::path& out);

/// The record of a run that ends now. Files that have not changed since `before` are not read again.
[[nodiscard]] RunRecord record_of(const std::filesystem::path& out, const std::vector<std::string>& files,
                                  const RunRecord& before);

/// Removes files that are not as the record says from the folder and from the record, with a line for each: they are
/// made again. A file whose times alone have changed, as in a copy of the folder, is kept and the record corrected.
/// `thoroughly`: the content of every file is read. False when anything was not as recorded.
bool keep_valid_files(const std::filesystem::path& out, bool thoroughly, RunRecord& record, std::ostream& messages);

}  // namespace ilp::ground
