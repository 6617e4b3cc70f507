// What the command line names: text files of numbers (blank separated, a `#` line is a comment, empty lines do not
// count), images, masks and cameras.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "fsw/base/geometry.hpp"
#include "fsw/vision/twoview/two_view.hpp"
#include "sim/host/grey_photograph.hpp"
#include "sim/host/image_io.hpp"

namespace ilp::lab {

/// Line by line; every std::runtime_error names file and line and what was expected.
class NumberFile {
 public:
  /// `what` names the kind of file in messages.
  NumberFile(std::string what, const std::filesystem::path& path);
  /// The numbers of the next line, all finite; false at the end.
  bool next(std::vector<double>& numbers);
  /// The next line, which must be there and have this many numbers, `names`.
  void expect(std::size_t count, const char* names, std::vector<double>& numbers);
  [[noreturn]] void fail(const std::string& message) const;
  /// A whole number in [0, limit): an index or a count.
  [[nodiscard]] std::uint32_t whole(double number, const char* name, double limit) const;

 private:
  std::string what_;
  std::ifstream in_;
  std::string line_;
  int number_ = 0;
};

/// Lines `x_a y_a x_b y_b [score]`, px with pixel centres at integers. Refused: no match at all, more than
/// limits::max_matches.
void read_matches(const std::filesystem::path& path, PointPairs& pairs);

/// Shortest form that reads back to the same bits.
[[nodiscard]] std::string exact_text(double value);

/// std::runtime_error when it cannot be written.
void write_text(const std::filesystem::path& path, const std::string& text);

// Images are checked against each other and against the flight limits.

using GrayImage = host::Raster<std::uint8_t>;

/// Reads images of one strip as sim/fly takes them: PNG and PGM files of 8 bits as they are, other photographs in grey,
/// with one range of 16-bit values for all, and so many pixels joined as the first of them needs.
class StripImages {
 public:
  explicit StripImages(const std::vector<std::filesystem::path>& files);
  /// So many pixels, in x and in y, are one of read().
  [[nodiscard]] int binning() const { return binning_; }
  /// The flight's camera reads the file as it is.
  [[nodiscard]] bool is_plain(const std::filesystem::path& file) const { return plain_.contains(file); }
  /// std::runtime_error names the file.
  [[nodiscard]] GrayImage read(const std::filesystem::path& file) const;

 private:
  std::set<std::filesystem::path> plain_;
  host::GreyRange range_;
  int binning_ = 0;
};

/// Refuses what is larger than a camera image of the flight software may be.
[[nodiscard]] GrayImage read_camera_image(const std::string& path);
/// Refuses what is larger than a rectified image may be.
[[nodiscard]] GrayImage read_rectified_image(const std::string& path);

/// std::runtime_error naming both when the sizes differ.
void require_same_size(const GrayImage& image, const std::string& path, int width, int height,
                       const std::string& other);

/// The mask at `path`, of the image's size; an empty image for an empty path. 0 is outside, anything else inside.
[[nodiscard]] GrayImage read_mask(const std::string& path, const GrayImage& image, const std::string& image_path);

/// A camera without distortion whose principal point is the middle of the image.
[[nodiscard]] CameraModel centred_camera(int width, int height, double focal_px);

}  // namespace ilp::lab
