// Files of two flights in one folder: told by what contradicts, and left out.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "sim/ground/intake/record_file.hpp"

namespace ilp::ground {

struct RecordFile {
  std::size_t file = 0;  ///< index in Outbox::files
  std::vector<RecordEntry> entries;
};

struct ForeignFile {
  std::size_t file = 0;
  std::string fault;
};

/// Of one flight is what has one frozen camera and keyframes whose times do not fall as their ids rise. Where files
/// contradict each other, the most that agree stand. Two flights with one camera whose keyframes happen to interleave
/// in time are not told apart.
///
/// A flight that had to begin a new store goes on as another life, with numbers of its own (docs/onboard.md): its
/// camera may be found again and its clock may have been lost. Lives are told apart by their numbers and contradict
/// nobody.
[[nodiscard]] std::vector<ForeignFile> files_of_other_flights(const std::vector<RecordFile>& files);

}  // namespace ilp::ground
