// A folder of images as a recorded strip.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace ilp::host {

struct StripFrame {
  std::int64_t time_ns = 0;
  std::filesystem::path file;
  std::string altitude;          ///< m above ground as written in the list, may be empty
  bool time_is_assumed = false;  ///< the folder has no list
};

/// The images that the folder's `times.txt`, `frames.txt` or `index.txt` lists (a line per frame: `time_ns name
/// [altitude_m]`, `#` begins a comment, names are relative to the file); without one, the folder's PNG, PGM, JPEG and
/// TIFF files in order of their names, in which numbers count by their value, two seconds apart; names that begin with
/// a dot are no images. Where the folder has no list and its `images/` has more images, or a list, these are the strip.
/// std::runtime_error when there is no image, or with the line that is malformed.
std::vector<StripFrame> list_strip(const std::filesystem::path& folder);

/// What a flight over these frames should know, one sentence each: times that are assumed or do not increase, files
/// that are missing or no images, sizes that differ from the first image's. Reads headers only. Empty when all is well.
/// `folder` is where the images came from; empty: where they are.
std::vector<std::string> strip_warnings(const std::vector<StripFrame>& frames,
                                        const std::filesystem::path& folder = {});

/// The index that the flight's DirectoryCamera reads. std::runtime_error for a path that a line of it cannot hold
/// (blanks, too long).
void write_strip_index(const std::filesystem::path& index, const std::vector<StripFrame>& frames);

}  // namespace ilp::host
