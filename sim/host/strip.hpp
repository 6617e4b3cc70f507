// Lists the images of a folder as a recorded strip, and writes the index that the flight reads.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace ilp::host {

struct StripFrame {
  std::int64_t time_ns = 0;
  std::filesystem::path file;
  std::string altitude;          ///< m above ground, the text in the list; empty if not listed
  bool time_is_assumed = false;  ///< true if the folder has no list
};

/// Reads the folder's list of images: the first of `times.txt`, `frames.txt` and `index.txt`. A line is `time_ns name
/// [altitude_m]` with a name relative to the list; `#` begins a comment. A folder without a list gives its PNG, PGM,
/// JPEG and TIFF files two seconds apart, ordered by name with numbers in names ordered by value; files whose names
/// begin with a dot are ignored. If a folder without a list has a subfolder `images` with a list or with more images,
/// the strip is read from the subfolder. Throws std::runtime_error if there is no image, or for a malformed line.
std::vector<StripFrame> list_strip(const std::filesystem::path& folder);

/// Warnings for the user, one sentence each: times that are assumed or do not increase, files that are missing or no
/// images, sizes that differ from the first image's. Reads image headers only. `folder` is named as the source of the
/// images; if empty, the folder of the first image.
std::vector<std::string> strip_warnings(const std::vector<StripFrame>& frames,
                                        const std::filesystem::path& folder = {});

/// Writes the index that the flight's DirectoryCamera reads. Throws std::runtime_error for a path with blanks or a path
/// that is too long, and if the file cannot be written.
void write_strip_index(const std::filesystem::path& index, const std::vector<StripFrame>& frames);

}  // namespace ilp::host
