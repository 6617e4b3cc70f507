// Reference poses from camera text files, true depths from PFM files.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "sim/ground/report/accuracy.hpp"

namespace ilp::report {

/// Poses as sim/host/reference_cameras.hpp reads them. Names match with or without their extension. Depths are
/// FOLDER/NAME.pfm.
class ReferenceFiles final : public Reference {
 public:
  /// `depth_folder` may be empty. Throws std::runtime_error as read_reference_cameras, and for names that differ only
  /// in their extension.
  ReferenceFiles(const std::filesystem::path& poses, std::filesystem::path depth_folder);
  [[nodiscard]] const ReferencePose* pose(const std::string& name) const override;
  [[nodiscard]] host::Raster<float> depth(const std::string& name) const override;

 private:
  std::map<std::string, ReferencePose> poses_;  ///< by name without extension
  std::filesystem::path depth_folder_;
};

}  // namespace ilp::report
