// Decodes a product file of the outbox: its samples and its metadata box.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "fsw/records/records.hpp"
#include "sim/host/raster.hpp"

namespace ilp::intake {

/// The lines `key=value` of a metadata box (fsw/vision/codec/metadata.hpp). Functions return none if the key is absent
/// or its value is invalid.
class Metadata {
 public:
  Metadata() = default;
  explicit Metadata(std::span<const std::uint8_t> box) : box_(box.begin(), box.end()) {}
  [[nodiscard]] std::string text(const std::string& key) const;  ///< empty if absent
  [[nodiscard]] std::optional<std::int64_t> integer(const std::string& key) const;
  /// A number that is a valid id (ids.hpp).
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

/// Decodes metadata and samples. Throws BadFile with the reason.
[[nodiscard]] Product decode_product(std::span<const std::uint8_t> file);

/// Camera and pose from the metadata of a product, which can be used without its records; none if they are not there.
[[nodiscard]] std::optional<CameraModel> camera_of(const Metadata& metadata);
[[nodiscard]] std::optional<PoseRecord> pose_record_of(const Metadata& metadata);

}  // namespace ilp::intake
