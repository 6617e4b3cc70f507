// What is the same in a store however the stages of its flight are spread over processes.
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

/// Left out are tables and fields that depend on when a process ran: events, statistics, checkpoints, queues, and times
/// at which something was decided or sent. The same records give the same digests in every backend. A fault of the
/// store is an exception.
[[nodiscard]] std::vector<TableDigest> digest_of(Store& store);

}  // namespace ilp::store_tool
