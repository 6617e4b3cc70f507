// Does the work of one package.
#pragma once

#include <cstddef>
#include <filesystem>

namespace ilp::tasks {

struct WorkParams {
  std::size_t threads = 1;                           ///< 0: one per core
  std::size_t chunk_bytes = std::size_t{96} << 20U;  ///< memory for pieces of surface; a tile needs some MiB
};

struct WorkDone {
  std::size_t items = 0;   ///< keyframes or tiles of the package
  std::size_t before = 0;  ///< of them, whose result an earlier try has left
};

/// Leaves the results below the work folder of `out`, and the pictures of keyframes where a run of the ground writes
/// them. Throws std::runtime_error when the package is damaged or a result cannot be written.
WorkDone do_work(const std::filesystem::path& package, const std::filesystem::path& out, const WorkParams& params);

}  // namespace ilp::tasks
