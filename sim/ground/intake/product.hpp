// A product file of the outbox: samples and what its metadata box says.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fsw/records/records.hpp"
#include "sim/host/raster.hpp"

namespace ilp::intake {

/// The lines `key=value` of a metadata box (fsw/vision/codec/metadata.hpp), as values that may be absent.
class Metadata {
 public:
  Metadata() = default;
  explicit Metadata(std::span<const std::uint8_t> box) : box_(box.begin(), box.end()) {}
  [[nodiscard]] std::string text(const std::string& key) const;  ///< empty when absent
  [[nodiscard]] std::optional<std::int64_t> integer(const std::string& key) const;
  /// A number in the range of ids.
  [[nodiscard]] std::optional<std::int64_t> id(const std::string& key) const;
  [[nodiscard]] std::optional<double> number(const std::string& key) const;
  /// Exactly `count` finite numbers; none otherwise.
  [[nodiscard]] std::optional<std::vector<double>> numbers(const std::string& key, std::size_t count) const;

 private:
  std::vector<std::uint8_t> box_;
};

struct ProductHeader {
  Metadata metadata;
  int layers = 0;
  std::int32_t width = 0, height = 0;
};

/// Reads metadata and size of a product without decoding its samples. Throws BadFile with the reason.
[[nodiscard]] ProductHeader read_product_header(std::span<const std::uint8_t> file);

struct Product {
  Metadata metadata;
  int layers = 0;
  host::Raster<std::int32_t> samples;
};

/// Throws BadFile with the reason.
[[nodiscard]] Product decode_product(std::span<const std::uint8_t> file);

/// Camera and pose that a product carries, so that it stands alone when its records were lost.
[[nodiscard]] std::optional<CameraModel> camera_of(const Metadata& metadata);
[[nodiscard]] std::optional<PoseRecord> pose_record_of(const Metadata& metadata);

}  // namespace ilp::intake
