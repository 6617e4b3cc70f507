// What a database at rest is worth, by SQLite itself and by our checksums, and what a start would say to it. Everything
// is done with copies.
#pragma once

#include <cstdint>
#include <filesystem>

#include "fsw/base/status.hpp"
#include "tests/faults/commit_ledger.hpp"

namespace ilp::faults {

struct Inspection {
  bool done = false;
  bool valid = false;         ///< PRAGMA integrity_check says ok, and every page, record and blob has its checksum
  std::uint64_t content = 0;  ///< checksum of all records and blobs that can be read
  Status start;               ///< answer of a start that refuses what it cannot use
  int missing = 0;            ///< records of the ledger that are not there
  std::int64_t missing_type = 0, missing_id = 0;  ///< of one of them
};

/// Looks at `folder`/flight.db, to which nobody may be writing, in processes of their own.
[[nodiscard]] Inspection inspect(const std::filesystem::path& folder, const CommitLedger* ledger);

}  // namespace ilp::faults
