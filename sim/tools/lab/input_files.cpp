#include "sim/tools/lab/input_files.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <system_error>

#include "cfg/limits.hpp"
#include "sim/host/files.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::lab {
namespace {

constexpr const char* blanks = " \t\r\n\v\f";

bool parse_number(const std::string& word, double& value) {
  const char* const end = word.data() + word.size();
  const char* begin = word.data();
  if (*begin == '+') ++begin;
  const auto [rest, error] = std::from_chars(begin, end, value);
  return error == std::errc() && rest == end && std::isfinite(value);
}

GrayImage read_within(const std::string& path, int max_width, int max_height, const char* limit_names) {
  const host::PhotographFacts size = host::read_photograph_facts(path);
  if (size.width > max_width || size.height > max_height) {
    throw std::runtime_error(path + ": " + host::size_text(size.width, size.height) +
                             " pixels, the limit of the flight software is " + host::size_text(max_width, max_height) +
                             " (" + limit_names + " of the profile " + limits::profile + ")");
  }
  if (host::is_png_or_pgm(path) && !size.deep) return host::read_gray(path);
  return host::grey_of(host::read_photograph(path), 1, size.deep ? host::grey_range({path}) : host::GreyRange{});
}

}  // namespace

NumberFile::NumberFile(std::string what, const std::filesystem::path& path)
    : what_(std::move(what) + " " + path.string()), in_(path) {
  std::error_code ignored;
  if (!in_ || std::filesystem::is_directory(path, ignored))
    throw std::runtime_error(what_ + " cannot be read: check the path");
}

bool NumberFile::next(std::vector<double>& numbers) {
  while (std::getline(in_, line_)) {
    ++number_;
    std::size_t at = line_.find_first_not_of(blanks);
    if (at == std::string::npos || line_[at] == '#') continue;
    numbers.clear();
    while (at != std::string::npos) {
      const std::size_t end = std::min(line_.find_first_of(blanks, at), line_.size());
      const std::string word = line_.substr(at, end - at);
      double value = 0;
      if (!parse_number(word, value)) fail("'" + word.substr(0, 40) + "' is not a finite number");
      numbers.push_back(value);
      at = line_.find_first_not_of(blanks, end);
    }
    return true;
  }
  return false;
}

void NumberFile::expect(std::size_t count, const char* names, std::vector<double>& numbers) {
  if (!next(numbers)) {
    throw std::runtime_error(what_ + " ends after line " + std::to_string(number_) + ": expected " + names);
  }
  if (numbers.size() != count) {
    fail("expected " + std::to_string(count) + " numbers (" + names + "), found " + std::to_string(numbers.size()));
  }
}

void NumberFile::fail(const std::string& message) const {
  throw std::runtime_error(what_ + ", line " + std::to_string(number_) + ": " + message);
}

std::uint32_t NumberFile::whole(double number, const char* name, double limit) const {
  if (!(number >= 0 && number < limit && number == std::floor(number))) {
    fail(std::string(name) + " " + exact_text(number) + " is not a whole number from 0 to " + exact_text(limit - 1));
  }
  return static_cast<std::uint32_t>(number);
}

void read_matches(const std::filesystem::path& path, PointPairs& pairs) {
  pairs.clear();
  NumberFile file("match file", path);
  std::vector<double> numbers;
  while (file.next(numbers)) {
    if (numbers.size() != 4 && numbers.size() != 5) {
      file.fail("expected x_a y_a x_b y_b [score], found " + std::to_string(numbers.size()) + " numbers");
    }
    const float quality = numbers.size() == 5 ? static_cast<float>(numbers[4]) : 0.0F;
    if (!pairs.push_back({numbers[0], numbers[1], numbers[2], numbers[3], quality})) {
      file.fail("more than " + std::to_string(limits::max_matches) +
                " matches, the limit of the flight software (limits::max_matches in cfg/limits.hpp)");
    }
  }
  if (pairs.empty()) throw std::runtime_error("match file " + path.string() + " holds no match");
}

std::string exact_text(double value) {
  char buffer[40];
  return {buffer, std::to_chars(buffer, buffer + sizeof(buffer), value).ptr};
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary);
  if (!(out << text).flush())
    throw std::runtime_error(path.string() + " cannot be written: " + host::write_failure(errno));
}

StripImages::StripImages(const std::vector<std::filesystem::path>& files) {
  std::vector<std::filesystem::path> deep;
  for (const std::filesystem::path& file : files) {
    try {
      const host::PhotographFacts facts = host::read_photograph_facts(file);
      if (binning_ == 0) binning_ = host::binning_for(facts.width, facts.height);
      if (facts.deep) deep.push_back(file);
      if (binning_ == 1 && !facts.deep && host::is_png_or_pgm(file)) plain_.insert(file);
    } catch (const std::exception&) {
      continue;  // named when it is read
    }
  }
  binning_ = std::max(binning_, 1);
  if (!deep.empty()) range_ = host::grey_range(deep);
}

GrayImage StripImages::read(const std::filesystem::path& file) const {
  if (is_plain(file)) return host::read_gray(file);
  return host::grey_of(host::read_photograph(file), binning_, range_);
}

GrayImage read_camera_image(const std::string& path) {
  return read_within(path, limits::max_image_width, limits::max_image_height,
                     "limits::max_image_width, limits::max_image_height");
}

GrayImage read_rectified_image(const std::string& path) {
  return read_within(path, limits::max_rectified_width, limits::max_rectified_height,
                     "limits::max_rectified_width, limits::max_rectified_height");
}

void require_same_size(const GrayImage& image, const std::string& path, int width, int height,
                       const std::string& other) {
  if (image.width == width && image.height == height) return;
  throw std::runtime_error(path + " has " + host::size_text(image.width, image.height) + " pixels, " + other + " has " +
                           host::size_text(width, height));
}

GrayImage read_mask(const std::string& path, const GrayImage& image, const std::string& image_path) {
  if (path.empty()) return {};
  GrayImage mask = read_camera_image(path);
  require_same_size(mask, path, image.width, image.height, image_path);
  return mask;
}

CameraModel centred_camera(int width, int height, double focal_px) {
  CameraModel camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = focal_px;
  camera.cx = 0.5 * (width - 1);
  camera.cy = 0.5 * (height - 1);
  return camera;
}

}  // namespace ilp::lab
