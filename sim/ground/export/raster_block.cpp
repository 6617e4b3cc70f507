#include "sim/ground/export/raster_block.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <new>
#include <stdexcept>

#include "sim/ground/intake/result_cache.hpp"
#include "sim/ground/map/damaged_catalogue.hpp"

namespace ilp::exports {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t side = cloud_block_side, half = side / 2;
constexpr int level_of_files = 6, level_of_halves = 1;

Bytes deflated(const Bytes& plain, int level) {
  uLongf size = compressBound(plain.size());
  Bytes packed(size);
  if (compress2(packed.data(), &size, plain.data(), plain.size(), level) != Z_OK) throw std::bad_alloc();
  packed.resize(size);
  return packed;
}

template <typename T>
Bytes plain_bytes(const std::vector<T>& samples) {
  Bytes bytes(samples.size() * sizeof(T));
  std::memcpy(bytes.data(), samples.data(), bytes.size());
  return bytes;
}

/// Horizontal differences (TIFF 6.0, 14).
template <typename T>
Bytes predicted(std::vector<T> samples) {
  for (std::size_t row = 0; row < side; ++row) {
    T* const first = samples.data() + row * side;
    for (std::size_t x = side - 1; x > 0; --x) first[x] = static_cast<T>(first[x] - first[x - 1]);
  }
  return plain_bytes(samples);
}

/// Differences between octets, the most significant ones of a row first (TIFF technical note 3).
Bytes predicted(const std::vector<float>& samples) {
  constexpr std::size_t octets = sizeof(float);
  const Bytes plain = plain_bytes(samples);
  Bytes out(plain.size());
  for (std::size_t row = 0; row < side; ++row) {
    const std::uint8_t* const from = plain.data() + row * side * octets;
    std::uint8_t* const to = out.data() + row * side * octets;
    for (std::size_t x = 0; x < side; ++x) {
      for (std::size_t octet = 0; octet < octets; ++octet)
        to[(octets - 1 - octet) * side + x] = from[x * octets + octet];
    }
    for (std::size_t i = side * octets - 1; i > 0; --i) to[i] = static_cast<std::uint8_t>(to[i] - to[i - 1]);
  }
  return out;
}

template <typename Sample>
SampleStatistics statistics_of(const std::vector<typename Sample::Type>& samples) {
  SampleStatistics s;
  double sum = 0;
  for (const auto sample : samples) {
    if (!Sample::has_value(sample)) continue;
    const auto value = static_cast<double>(sample);
    s.least = s.count == 0 ? value : std::min(s.least, value);
    s.most = s.count == 0 ? value : std::max(s.most, value);
    sum += value;
    ++s.count;
  }
  if (s.count == 0) return s;
  s.mean = sum / static_cast<double>(s.count);
  for (const auto sample : samples) {
    const double distance = static_cast<double>(sample) - s.mean;
    if (Sample::has_value(sample)) s.squares += distance * distance;
  }
  return s;
}

template <typename Sample>
typename Sample::Type of_four(const std::array<typename Sample::Type, 4>& samples) {
  double sum = 0;
  int count = 0;
  for (const auto sample : samples) {
    if (!Sample::has_value(sample)) continue;
    if (!Sample::averaged) return sample;
    sum += static_cast<double>(sample);
    ++count;
  }
  if (count == 0) return Sample::nothing;
  const double mean = sum / count;
  return static_cast<typename Sample::Type>(std::is_integral_v<typename Sample::Type> ? std::floor(mean + 0.5) : mean);
}

template <typename Sample>
std::vector<typename Sample::Type> halved(const std::vector<typename Sample::Type>& samples) {
  std::vector<typename Sample::Type> out(half * half);
  for (std::size_t y = 0; y < half; ++y) {
    for (std::size_t x = 0; x < half; ++x) {
      const std::size_t i = 2 * y * side + 2 * x;
      out[y * half + x] = of_four<Sample>({samples[i], samples[i + 1], samples[i + side], samples[i + side + 1]});
    }
  }
  return out;
}

}  // namespace

void SampleStatistics::add(const SampleStatistics& other) {
  if (other.count == 0) return;
  if (count == 0) {
    *this = other;
    return;
  }
  const auto a = static_cast<double>(count), b = static_cast<double>(other.count);
  const double apart = other.mean - mean;
  squares += other.squares + apart * apart * a * b / (a + b);
  mean += apart * b / (a + b);
  least = std::min(least, other.least);
  most = std::max(most, other.most);
  count += other.count;
}

template <typename Sample>
RasterBlock raster_block(const std::vector<typename Sample::Type>& samples) {
  if (samples.size() != block_samples) throw std::logic_error("a block of another size");
  RasterBlock block;
  block.statistics = statistics_of<Sample>(samples);
  if (block.statistics.count == 0) return block;
  block.coded = deflated(predicted(samples), level_of_files);
  block.halved = deflated(plain_bytes(halved<Sample>(samples)), level_of_halves);
  return block;
}

template <typename Sample>
void put_halved(std::span<const std::uint8_t> packed, std::int32_t right, std::int32_t down,
                std::vector<typename Sample::Type>& samples) {
  std::vector<typename Sample::Type> plain(half * half);
  uLongf size = plain.size() * sizeof(typename Sample::Type);
  const uLongf expected = size;
  if (uncompress(reinterpret_cast<Bytef*>(plain.data()), &size, packed.data(), packed.size()) != Z_OK ||
      size != expected) {
    throw map::DamagedCatalogue("a block of the map cannot be read back");
  }
  const std::size_t first = static_cast<std::size_t>(down) * half * side + static_cast<std::size_t>(right) * half;
  for (std::size_t y = 0; y < half; ++y) std::copy_n(plain.data() + y * half, half, samples.data() + first + y * side);
}

template RasterBlock raster_block<HeightSample>(const std::vector<float>&);
template RasterBlock raster_block<CountSample>(const std::vector<std::uint16_t>&);
template RasterBlock raster_block<GreySample>(const std::vector<std::uint8_t>&);
template void put_halved<HeightSample>(std::span<const std::uint8_t>, std::int32_t, std::int32_t, std::vector<float>&);
template void put_halved<CountSample>(std::span<const std::uint8_t>, std::int32_t, std::int32_t,
                                      std::vector<std::uint16_t>&);
template void put_halved<GreySample>(std::span<const std::uint8_t>, std::int32_t, std::int32_t,
                                     std::vector<std::uint8_t>&);

Bytes bytes_of(const RasterBlock& block) {
  const SampleStatistics& s = block.statistics;
  Bytes bytes;
  intake::append(std::vector<double>{static_cast<double>(s.count), s.least, s.most, s.mean, s.squares}, bytes);
  intake::append(block.coded, bytes);
  intake::append(block.halved, bytes);
  return bytes;
}

std::optional<RasterBlock> raster_block_from(std::span<const std::uint8_t> bytes) {
  std::vector<double> s;
  RasterBlock block;
  if (!intake::take(bytes, s) || s.size() != 5 || !intake::take(bytes, block.coded) ||
      !intake::take(bytes, block.halved) || !bytes.empty()) {
    return std::nullopt;
  }
  block.statistics = {static_cast<std::uint64_t>(s[0]), s[1], s[2], s[3], s[4]};
  return block;
}

}  // namespace ilp::exports
