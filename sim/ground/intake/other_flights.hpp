// Finds files of another flight in a folder by contradictions between files, so that they are not used.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "sim/ground/intake/record_file.hpp"

namespace ilp::intake {

/// The records of a file.
struct RecordFile {
  std::size_t file = 0;  ///< index in Outbox::files
  std::vector<RecordEntry> entries;
};

struct ForeignFile {
  std::size_t file = 0;
  std::string fault;
};

/// Returns the files that do not belong to the flight of the others. Files belong to one flight if they have the same
/// frozen camera, and the times of their keyframes increase with the ids. If files contradict each other, the largest
/// group of consistent files is kept. Two flights with the same camera whose keyframes interleave in time cannot be
/// distinguished.
///
/// A flight that had to begin a new store continues as another store epoch (docs/onboard.md): its camera may have been
/// calibrated again, and its clock may have been lost. Store epochs have different ids, so that their files do not
/// contradict each other.
[[nodiscard]] std::vector<ForeignFile> files_of_other_flights(const std::vector<RecordFile>& files);

}  // namespace ilp::intake
