// Does the work of one package.
#pragma once

#include <cstddef>
#include <filesystem>

namespace ilp::tasks {

struct WorkParams {
  std::size_t threads = 1;                           ///< 0: one per core
  std::size_t chunk_bytes = std::size_t{96} << 20U;  ///< memory for surface patches; each tile needs some MiB more
};

struct WorkDone {
  std::size_t items = 0;   ///< number of keyframes or tiles of the package
  std::size_t before = 0;  ///< of these, number whose results an earlier attempt has written
};

/// Does the work of a package. Writes the results into the work folder of `out`, and the pictures of keyframes where a
/// run of the ground writes them. Throws std::runtime_error if the package is damaged or a result cannot be written.
WorkDone do_work(const std::filesystem::path& package, const std::filesystem::path& out, const WorkParams& params);

}  // namespace ilp::tasks
