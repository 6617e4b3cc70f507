// The files of the server besides the state: pictures of maps, and the files that a run has written.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "sim/ground/serve/live_items.hpp"

namespace ilp::serve {

struct OpenFile {
  bool known = false;  ///< the file belongs to the run's results
  int file = -1;       ///< file descriptor, to be closed by the caller; -1: the file cannot be read
  std::uint64_t bytes = 0;
};

/// Finds only names that were put, so that no request can read another file. May be used by several threads.
class StaticFiles {
 public:
  explicit StaticFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}
  /// Replaces pictures and names of files. Pictures of the call before can still be read, because a page may be loading
  /// them.
  void put(Pictures pictures, std::set<std::string> files);
  /// Null for an unknown path.
  [[nodiscard]] std::shared_ptr<const std::vector<std::uint8_t>> picture(const std::string& path) const;
  /// Opens a file by its name relative to the folder. Does not follow symbolic links.
  [[nodiscard]] OpenFile open(const std::string& name) const;

 private:
  std::filesystem::path folder_;
  mutable std::mutex mutex_;
  Pictures pictures_, earlier_;
  std::set<std::string> files_;
};

}  // namespace ilp::serve
