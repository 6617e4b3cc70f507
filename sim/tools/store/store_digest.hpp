// Digests of a store's tables that do not depend on how the stages of the flight were distributed over processes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hal/store/store.hpp"

namespace ilp::store_tool {

struct TableDigest {
  std::string table;
  std::int64_t rows = 0;
  std::int64_t damaged = 0;  ///< records and blobs that cannot be read
  std::uint64_t digest = 0;  ///< over all fields and blobs, in the order of ids
};

/// A digest per table. Tables and fields that depend on when a process ran are left out: events, statistics,
/// checkpoints, queues, and times of decisions. The same records give the same digests in every backend. Throws
/// std::runtime_error for a fault of the store.
[[nodiscard]] std::vector<TableDigest> digest_of(Store& store);

}  // namespace ilp::store_tool
