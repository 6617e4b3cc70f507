// What the server gives besides the state: the pictures of the maps, and the files that a run has written.
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
  bool known = false;  ///< the run's record names it
  int file = -1;       ///< to be closed by the caller; -1: it cannot be read now
  std::uint64_t bytes = 0;
};

/// Only names that were put here are found, so that no request leads to another file. May be used by several threads.
class StaticFiles {
 public:
  explicit StaticFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}
  /// Pictures of the call before are kept too: a page may just be loading them.
  void put(Pictures pictures, std::set<std::string> files);
  /// Null for an unknown path.
  [[nodiscard]] std::shared_ptr<const std::vector<std::uint8_t>> picture(const std::string& path) const;
  /// By its name below the folder. A symbolic link is not followed.
  [[nodiscard]] OpenFile open(const std::string& name) const;

 private:
  std::filesystem::path folder_;
  mutable std::mutex mutex_;
  Pictures pictures_, earlier_;
  std::set<std::string> files_;
};

}  // namespace ilp::serve
