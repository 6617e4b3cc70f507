// Reads the input files of the subcommands: text files of numbers, images and masks. Numbers are separated by blanks;
// lines that begin with `#` and empty lines are skipped.
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

/// Reads a text file of numbers line by line. Throws std::runtime_error that names file and line, and what was
/// expected.
class NumberFile {
 public:
  /// `what` names the kind of file in messages.
  NumberFile(std::string what, const std::filesystem::path& path);
  /// Reads the numbers of the next line, which must be finite; false at the end of the file.
  bool next(std::vector<double>& numbers);
  /// Reads the next line, which must exist and have `count` numbers. `names` describes them in messages.
  void expect(std::size_t count, const char* names, std::vector<double>& numbers);
  /// Throws std::runtime_error with file, line and message.
  [[noreturn]] void fail(const std::string& message) const;
  /// Checks that a number is an integer in [0, limit), and returns it.
  [[nodiscard]] std::uint32_t whole(double number, const char* name, double limit) const;

 private:
  std::string what_;
  std::ifstream in_;
  std::string line_;
  int number_ = 0;
};

/// Reads matches from lines `x_a y_a x_b y_b [score]`, in px with pixel centres at integers. Throws std::runtime_error
/// also for a file without matches, and for more than limits::max_matches.
void read_matches(const std::filesystem::path& path, PointPairs& pairs);

/// The shortest text that reads back as the same bits.
[[nodiscard]] std::string exact_text(double value);

/// Writes a file. Throws std::runtime_error if this is impossible.
void write_text(const std::filesystem::path& path, const std::string& text);

// Reads images, and checks them against each other and against the limits of the flight.

using GrayImage = host::Raster<std::uint8_t>;

/// Reads the images of a strip as sim/fly does: 8-bit PNG and PGM files unchanged, other photographs as grey images
/// with a common range of 16-bit values. The first readable image determines the binning of all.
class StripImages {
 public:
  explicit StripImages(const std::vector<std::filesystem::path>& files);
  /// Number of pixels, in x and in y, that become one pixel of read().
  [[nodiscard]] int binning() const { return binning_; }
  /// Whether the flight's camera reads the file unchanged.
  [[nodiscard]] bool is_plain(const std::filesystem::path& file) const { return plain_.contains(file); }
  /// Reads an image of the strip. Throws std::runtime_error that names the file.
  [[nodiscard]] GrayImage read(const std::filesystem::path& file) const;

 private:
  std::set<std::filesystem::path> plain_;
  host::GreyRange range_;
  int binning_ = 0;
};

/// Reads an image as 8-bit grey. Throws std::runtime_error if it is larger than a camera image of the flight software
/// may be.
[[nodiscard]] GrayImage read_camera_image(const std::string& path);
/// As read_camera_image, with the limits of a rectified image.
[[nodiscard]] GrayImage read_rectified_image(const std::string& path);

/// Throws std::runtime_error that names `path` and `other` unless the image has `width` x `height` pixels, the size of
/// `other`.
void require_same_size(const GrayImage& image, const std::string& path, int width, int height,
                       const std::string& other);

/// Reads the mask at `path`, which must have the image's size; an empty image for an empty path. Pixels are inside the
/// mask unless they are 0.
[[nodiscard]] GrayImage read_mask(const std::string& path, const GrayImage& image, const std::string& image_path);

/// A camera without distortion whose principal point is the middle of the image.
[[nodiscard]] CameraModel centred_camera(int width, int height, double focal_px);

}  // namespace ilp::lab
