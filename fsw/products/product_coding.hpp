// The coding of one product: a job of the worker (hal/worker/worker.hpp), because OpenJPEG cannot be interrupted.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "cfg/limits.hpp"
#include "fsw/records/records.hpp"
#include "fsw/vision/codec/jpeg2000.hpp"

namespace ilp {

/// What the file says about itself, written before it is coded.
struct ProductBox {
  std::array<std::uint8_t, limits::max_metadata_bytes> bytes;
  std::size_t size = 0;

  [[nodiscard]] std::span<const std::uint8_t> view() const { return std::span(bytes).first(size); }
};

enum class CodecLibrary : std::uint8_t { untried, as_tested, other };

/// All memory of the job. What it reads is in it, so that the records and parameters may change meanwhile.
struct ProductCoding {
  /// The order. Quality layers, sizes, checksum, and the scheme if an exact region takes too many bytes, are the
  /// result.
  ProductRecord product;
  Jpeg2000Params params;
  bool region = false;        ///< the mask is used as region of interest
  double depth_error_px = 0;  ///< layers that are finer are left off; 0: none
  double px_per_code = 0;     ///< of a depth map
  std::int32_t width = 0, height = 0;
  ProductBox box, box_if_lossy;  ///< the second one for an exact region that takes too many bytes
  std::array<std::uint16_t, limits::max_image_pixels> samples;  ///< codes of depth; or an image, in its first half
  std::array<std::uint8_t, limits::max_image_pixels> mask;

  /// Found out by the first job. With a library that does not work as in the tests everything is coded without a
  /// region.
  CodecLibrary library = CodecLibrary::untried;
  Status status;  ///< of the result
  Jpeg2000Workspace jpeg2000;

  [[nodiscard]] ImageView<std::uint16_t> codes() { return {samples.data(), width, height}; }
  [[nodiscard]] ImageView<std::uint8_t> image() {
    return {reinterpret_cast<std::uint8_t*>(samples.data()), width, height};
  }
  [[nodiscard]] ImageView<std::uint8_t> newly_seen() { return {mask.data(), width, height}; }
  /// `product.bytes` bytes are the result.
  [[nodiscard]] std::span<std::uint8_t> file() { return jpeg2000.place_of_file(); }
};

/// The function of the job; `coding` is a ProductCoding. It codes the product, measures the quality of each layer, and
/// writes it into the file.
void code_product(void* coding);

}  // namespace ilp
