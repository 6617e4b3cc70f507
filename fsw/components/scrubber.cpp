#include "fsw/components/scrubber.hpp"

#include <algorithm>

namespace ilp {
namespace {

// At once, however long it has been since the last step.
constexpr std::size_t most_image_bytes = std::size_t{1} << 20U;
// The checksum of a region is computed in pieces of this size, however much a step may read.
constexpr std::size_t piece_bytes = 4096;

std::uint64_t checksum_of(std::span<const std::byte> region) {
  std::uint64_t sum = 0;
  for (std::size_t at = 0; at < region.size(); at += piece_bytes) {
    sum = checksum64(region.subspan(at, std::min(piece_bytes, region.size() - at)), sum);
  }
  return sum;
}

}  // namespace

Scrubber::Scrubber(Clock& clock, const MissionParameters& mission) : clock_(clock), mission_(mission) {}

void Scrubber::watch(ImageRegions image) {
  image_ = image.first(std::min(image.size(), most_regions));
  for (std::size_t i = 0; i < image_.size(); ++i) image_sums_[i] = checksum_of(image_[i]);
}

Status Scrubber::restore() {
  stepped_ns_ = -1;
  image_cursor_ = {};
  return {};
}

std::size_t Scrubber::grant(double bytes_per_s, TimeNs elapsed, std::size_t most) const {
  const double bytes = bytes_per_s * 1e-9 * static_cast<double>(elapsed);
  return bytes < static_cast<double>(most) ? static_cast<std::size_t>(std::max(bytes, 0.0)) : most;
}

Status Scrubber::check_image(std::size_t bytes) {
  ImageCursor& at = image_cursor_;
  if (image_.empty() || image_damaged_) return {};
  for (std::size_t read = 0; read < bytes; read += piece_bytes) {
    const std::span<const std::byte> region = image_[at.region];
    const std::size_t piece = std::min(piece_bytes, region.size() - at.offset);
    at.sum = checksum64(region.subspan(at.offset, piece), at.sum);
    at.offset += piece;
    if (at.offset < region.size()) continue;
    const bool same = at.sum == image_sums_[at.region];
    const auto number = static_cast<std::int64_t>(at.region);
    at = {(at.region + 1) % image_.size(), 0, 0};
    if (same) continue;
    image_damaged_ = true;
    return {StatusCode::image_damaged, number};
  }
  return {};
}

StepResult Scrubber::step(TimeNs deadline) {
  static_cast<void>(deadline);
  const TimeNs now = clock_.now();
  const TimeNs elapsed = stepped_ns_ < 0 ? 0 : now - stepped_ns_;
  stepped_ns_ = now;
  return {check_image(grant(mission_.image_check_bytes_per_s, elapsed, most_image_bytes)), false};
}

}  // namespace ilp
