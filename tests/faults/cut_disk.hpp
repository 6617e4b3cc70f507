// What a power cut leaves of the files of a flight: what was synchronised is there; of anything else, sector by sector,
// the old or the new octets. Names change when their folder is synchronised.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "fsw/base/rng.hpp"
#include "tests/faults/system_calls.hpp"

namespace ilp::faults {

/// How much of what was not synchronised is lost.
enum class Loss : std::uint8_t { all, parts, nothing };

class CutDisk final : public DiskWatch {
 public:
  /// All that is in `folder`/flight.db* is on the disk.
  explicit CutDisk(const std::filesystem::path& folder);

  void opened(const std::filesystem::path& path, int file) override;
  void wrote(int file, std::int64_t at, std::size_t bytes) override;
  /// Where it fails, what was written before and is not written again never reaches the disk, though a later
  /// synchronisation succeeds: that is what Linux does.
  void synchronised(int file, bool done) override;
  void synchronised_folder() override;
  void unlinks(const std::filesystem::path& path) override;
  void renamed(const std::filesystem::path& from, const std::filesystem::path& to) override;

  /// Makes the folder what the cut leaves, in new files. Call it once, at the end of the process.
  void cut(Loss loss, Rng& rng);

 private:
  using Octets = std::vector<std::uint8_t>;
  using Names = std::map<std::string, std::uint64_t>;  ///< inode of each
  struct File {
    Octets durable;
    std::set<std::size_t> dropped;  ///< sectors that a failed synchronisation has lost
    Octets last;                    ///< content when its name was removed
    bool removed = false;
  };
  File& of(int file);
  [[nodiscard]] Octets present(std::uint64_t inode) const;

  std::filesystem::path folder_;
  std::map<std::uint64_t, File> files_;
  std::vector<Names> names_;  ///< since the folder was synchronised; the last are those in force
};

}  // namespace ilp::faults
