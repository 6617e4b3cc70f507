// Codes one product as a job of the worker (hal/worker/worker.hpp), because OpenJPEG cannot be interrupted.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/records/records.hpp"
#include "fsw/vision/codec/jpeg2000.hpp"

namespace ilp {

/// The metadata box of the file, written before the coding.
struct ProductBox {
  std::array<std::uint8_t, limits::max_metadata_bytes> bytes;
  std::size_t size = 0;

  [[nodiscard]] std::span<const std::uint8_t> view() const { return std::span(bytes).first(size); }
};

/// Whether the installed OpenJPEG works as the tested one.
enum class CodecLibrary : std::uint8_t { untried, as_tested, other };

/// All memory of the job. It has copies of all input, so that records and parameters may change meanwhile.
struct ProductCoding {
  /// The order. The job sets quality layers, sizes and checksum, and changes the scheme if a lossless region takes too
  /// many bytes.
  ProductRecord product;
  Jpeg2000Params params;
  bool region = false;        ///< the mask is used as region of interest
  double depth_error_px = 0;  ///< layers after the first one with at most this largest error are left out; 0: none
  double px_per_code = 0;     ///< disparity in px per code of a depth map
  std::int32_t width = 0, height = 0;
  ProductBox box, box_if_lossy;  ///< box_if_lossy is used if a lossless region takes too many bytes
  std::array<std::uint16_t, limits::max_image_pixels> samples;  ///< codes of depth; or 8-bit pixels, in the first half
  std::array<std::uint8_t, limits::max_image_pixels> mask;

  /// Determined by the first job. If the library is not `as_tested`, everything is coded without a region.
  CodecLibrary library = CodecLibrary::untried;
  Status status;  ///< status of the result
  Jpeg2000Workspace jpeg2000;

  [[nodiscard]] ImageView<std::uint16_t> codes() { return {samples.data(), width, height}; }
  [[nodiscard]] ImageView<std::uint8_t> image() {
    return {reinterpret_cast<std::uint8_t*>(samples.data()), width, height};
  }
  [[nodiscard]] ImageView<std::uint8_t> newly_seen() { return {mask.data(), width, height}; }
  /// The result: its first `product.bytes` bytes are the file.
  [[nodiscard]] std::span<std::uint8_t> file() { return jpeg2000.place_of_file(); }
};

/// The function of the job; `coding` points to a ProductCoding. Codes the product, measures the quality of each layer,
/// and writes the quality into the file.
void code_product(void* coding);

}  // namespace ilp
