// Finds files of another flight in a folder by their contradictions, so that they are left out.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "sim/ground/intake/record_file.hpp"

namespace ilp::intake {

struct RecordFile {
  std::size_t file = 0;  ///< index in Outbox::files
  std::vector<RecordEntry> entries;
};

struct ForeignFile {
  std::size_t file = 0;
  std::string fault;
};

/// Files belong to one flight if they have the same frozen camera, and the times of their keyframes rise with the ids.
/// Where files contradict each other, the largest group of files that agree is kept. Two flights with the same camera
/// whose keyframes interleave in time cannot be told apart.
///
/// A flight that had to begin a new store goes on as another store epoch, with numbers of its own (docs/onboard.md):
/// its camera may be calibrated again and its clock may have been lost. Store epochs have different numbers, so their
/// files do not contradict each other.
[[nodiscard]] std::vector<ForeignFile> files_of_other_flights(const std::vector<RecordFile>& files);

}  // namespace ilp::intake
