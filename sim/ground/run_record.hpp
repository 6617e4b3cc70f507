// The record of a run, from which the next run finds out what has changed: a digest of the inputs, and the state of
// every result file. It is stored as results.txt in the folder of the results.
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
  std::uint64_t content = 0;  ///< digest of the content; 0 for the catalogue, which checks its content itself
};

struct RunRecord {
  std::uint64_t inputs = 0;                 ///< digest_of_inputs when the run began; 0: no run has ended
  std::string outbox;                       ///< folder of the downlink; empty: not known
  std::vector<std::string> said;            ///< lines that the run printed for the user
  std::map<std::string, ResultFile> files;  ///< key: name relative to the folder of the results
  /// Content of each acknowledgement; key: its file name. Empty if the run wrote none.
  std::map<std::string, std::string> acknowledgements;
};

/// Digest of the options, the program file, the version of GDAL, and name, size and times of all files that the options
/// name, those of the outbox included. `out`, `afresh` and `check` are left out.
[[nodiscard]] std::uint64_t digest_of_inputs(const GroundOptions& options);

/// Reads the record; returns an empty one if the file is missing or damaged.
[[nodiscard]] RunRecord read_record(const std::filesystem::path& out);
/// Throws std::runtime_error if the file cannot be written.
void write_record(const RunRecord& record, const std::filesystem::path& out);
/// The canonical absolute path, as RunRecord::outbox has it.
[[nodiscard]] std::string name_of_outbox(const std::filesystem::path& outbox);
/// Deletes the file of the record.
void forget_record(const std::filesystem::path& out);

/// The record of the result files `files`, with `inputs`, `outbox`, `said` and `acknowledgements` left empty. A file
/// whose state is that of `before` is not read again. Missing files are left out.
[[nodiscard]] RunRecord record_of(const std::filesystem::path& out, const std::vector<std::string>& files,
                                  const RunRecord& before);

/// Compares the result files with the record. Removes a file that differs from the folder and from the record, and
/// writes a line about it to `messages`: the run makes it again. The catalogue is removed from the record only. Keeps a
/// file of which only the times have changed, as in a copy of the folder, and corrects the record. `thoroughly`: read
/// the content of every file. Returns false if a file differed or was missing.
bool keep_valid_files(const std::filesystem::path& out, bool thoroughly, RunRecord& record, std::ostream& messages);

}  // namespace ilp::ground
